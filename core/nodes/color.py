# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's small colour nodes: Invert, Gamma, Brightness/Contrast, RGB to BW.

Source: Blender manual, "Color Nodes"; Cycles, `kernel/svm/invert.h`, `gamma.h`, `brightness.h`.
"""

from __future__ import annotations

import numpy as np

from ..vecmath import lanes
from .arithmetic import lerp
from .base import Operation
from .convert import luminance_in, to_dimension


def _invert(context, inputs, properties):
    color, fac = inputs["color"], inputs["fac"]
    with np.errstate(all="ignore"):
        out = np.subtract(1, color, out=context.arena.empty((3, lanes(color, fac))))
        return {"color": lerp(color, out, fac, out)}


def _gamma(context, inputs, properties):
    """Channels above 0 to the power of gamma; gamma 0 gives white."""
    color, gamma = inputs["color"], inputs["gamma"]
    out = context.arena.empty((3, lanes(color, gamma)))
    with np.errstate(all="ignore"):
        np.power(color, gamma, out=out)
    np.copyto(out, color, where=~(color > 0))
    np.copyto(out, 1, where=gamma == 0)
    return {"color": out}


def _bright_contrast(context, inputs, properties):
    """Channels scaled by 1 + contrast about 1/2, plus ``bright``; nothing is below 0."""
    color, contrast = inputs["color"], inputs["contrast"]
    with np.errstate(all="ignore"):
        shift = inputs["bright"] - contrast * np.float32(0.5)
        out = np.multiply(color, contrast + np.float32(1), out=context.arena.empty((3, lanes(color, shift))))
        np.add(out, shift, out=out)
        return {"color": np.fmax(out, 0, out=out)}


def _rgb_to_bw(context, inputs, properties):
    luminance = luminance_in(properties.get("working_space"))
    with np.errstate(all="ignore"):
        return {"val": to_dimension(inputs["color"], 1, context.arena, luminance=luminance)}


OPERATIONS = {
    "invert": Operation(_invert, {"fac": 1.0, "color": (0.0, 0.0, 0.0)}),
    "gamma": Operation(_gamma, {"color": (1.0, 1.0, 1.0), "gamma": 1.0}),
    "bright_contrast": Operation(_bright_contrast, {"color": (1.0, 1.0, 1.0), "bright": 0.0, "contrast": 0.0}),
    "rgb_to_bw": Operation(_rgb_to_bw, {"color": (0.5, 0.5, 0.5)}),
}
