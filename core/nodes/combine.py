# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Combine and Separate nodes: three numbers and a vector or a colour, by RGB, HSV or HSL.

Source: Blender manual, "Combine Color Node"; Cycles, `kernel/svm/sepcomb_color.h`.
"""

from __future__ import annotations

import numpy as np

from ..vecmath import lanes
from . import color_space
from .base import Operation

_TO_RGB = {"HSV": color_space.hsv_to_rgb, "HSL": color_space.hsl_to_rgb}
_FROM_RGB = {"HSV": color_space.rgb_to_hsv, "HSL": color_space.rgb_to_hsl}


def _stacked(inputs, names, arena):
    out = arena.empty((3, lanes(*inputs.values())))
    for row, name in zip(out, names, strict=True):
        np.copyto(row, inputs[name])
    return out


def _combine_xyz(context, inputs, properties):
    return {"vector": _stacked(inputs, "xyz", context.arena)}


def _separate_xyz(context, inputs, properties):
    return dict(zip("xyz", inputs["vector"], strict=True))


def _combine_color(context, inputs, properties):
    color = _stacked(inputs, ("red", "green", "blue"), context.arena)
    convert = _TO_RGB.get(properties.get("mode"))
    with np.errstate(all="ignore"):
        return {"color": convert(color) if convert else color}


def _separate_color(context, inputs, properties):
    convert = _FROM_RGB.get(properties.get("mode"))
    with np.errstate(all="ignore"):
        parts = convert(inputs["color"]) if convert else inputs["color"]
    return dict(zip(("red", "green", "blue"), parts, strict=True))


OPERATIONS = {
    "combine_xyz": Operation(_combine_xyz, {"x": 0.0, "y": 0.0, "z": 0.0}),
    "separate_xyz": Operation(_separate_xyz, {"vector": (0.0, 0.0, 0.0)}),
    # In the modes HSV and HSL, red, green and blue are the names of hue, saturation and value or lightness.
    "combine_color": Operation(_combine_color, {"red": 0.0, "green": 0.0, "blue": 0.0}),
    "separate_color": Operation(_separate_color, {"color": (0.8, 0.8, 0.8)}),
}
