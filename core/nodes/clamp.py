# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Clamp node.

Source: Blender manual, "Clamp Node".
"""

from __future__ import annotations

import numpy as np

from ..vecmath import lanes
from .base import Operation


def _clamp(context, inputs, properties):
    """The value between two others; in RANGE these may stand in either order."""
    value, low, high = inputs["value"], inputs["min"], inputs["max"]
    if properties.get("clamp_type", "MINMAX") == "RANGE":
        low, high = np.minimum(low, high), np.maximum(low, high)
    out = np.maximum(value, low, out=context.arena.empty(lanes(value, low, high)))
    return {"result": np.minimum(out, high, out=out)}


OPERATIONS = {"clamp_range": Operation(_clamp, {"value": 1.0, "min": 0.0, "max": 1.0})}
