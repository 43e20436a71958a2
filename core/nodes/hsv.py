# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Hue/Saturation/Value node.

Source: Blender manual, "Hue/Saturation/Value Node"; Cycles, `kernel/svm/hsv.h`.
"""

from __future__ import annotations

import numpy as np

from ..vecmath import lanes
from .arithmetic import lerp, saturate
from .base import Operation
from .color_space import hsv_to_rgb, rgb_to_hsv


def _hue_saturation(context, inputs, properties):
    """Hue turned by ``hue`` - 1/2, saturation and value scaled; nothing is below 0."""
    color, fac = inputs["color"], inputs["fac"]
    n = lanes(*inputs.values())
    with np.errstate(all="ignore"):
        hsv = np.broadcast_to(rgb_to_hsv(color), (3, n)).copy()
        h, s, v = hsv
        np.add(h, inputs["hue"] + np.float32(0.5), out=h)
        np.subtract(h, np.floor(h), out=h)
        saturate(np.multiply(s, inputs["saturation"], out=s), s)
        np.multiply(v, inputs["value"], out=v)
        out = lerp(color, hsv_to_rgb(hsv), fac, context.arena.empty((3, n)))
        return {"color": np.maximum(out, 0, out=out)}


OPERATIONS = {
    "hue_saturation": Operation(
        _hue_saturation, {"hue": 0.5, "saturation": 1.0, "value": 1.0, "fac": 1.0, "color": (0.8, 0.8, 0.8)}
    ),
}
