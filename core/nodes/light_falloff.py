# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Light Falloff node: a strength that makes up for a light's loss by distance.

Source: Blender manual, "Light Falloff Node"; Cycles, `kernel/svm/light_path.h`.
"""

from __future__ import annotations

import numpy as np

from .base import Operation
from .light_path import ray_length


def _light_falloff(context, inputs, properties):
    distance = ray_length(context)
    with np.errstate(all="ignore"):
        square = distance * distance
        is_near = np.isfinite(square)  # at infinity nothing is lost by distance
        near = square / (inputs["smooth"] + square)
        strength = inputs["strength"] * np.where((inputs["smooth"] > 0) & is_near, near, np.float32(1))
        linear, constant = (strength * np.where(is_near, v, np.float32(1)) for v in (distance, square))
        return {"quadratic": strength, "linear": linear, "constant": constant}


OPERATIONS = {"light_falloff": Operation(_light_falloff, {"strength": 100.0, "smooth": 0.0}, foldable=False)}
