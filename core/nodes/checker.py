# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Checker Texture."""

from __future__ import annotations

import numpy as np

from .base import Operation
from .coordinates import lookup_uv


def _checker(context, inputs, properties):
    """Color 1 where the integer parts of the scaled coordinates have an odd sum."""
    arena, n = context.arena, context.count
    vector = inputs["vector"] if "vector" in inputs else lookup_uv(context, "")
    fac = arena.zeros(n)
    with arena.frame():
        t = arena.empty(n)
        for row in vector:
            # The nudge is Blender's own: it keeps cell borders at integers off the border.
            np.multiply(row, inputs["scale"], out=t)
            np.add(t, 1e-6, out=t)
            np.multiply(t, 0.999999, out=t)
            np.floor(t, out=t)
            np.add(fac, t, out=fac)
        np.mod(fac, 2.0, out=fac)
    color = arena.empty((3, n))
    np.subtract(inputs["color1"], inputs["color2"], out=color)
    np.multiply(color, fac, out=color)
    np.add(color, inputs["color2"], out=color)
    return {"color": color, "fac": fac}


OPERATIONS = {
    "checker": Operation(
        _checker,
        {"vector": None, "color1": (0.8, 0.8, 0.8), "color2": (0.2, 0.2, 0.2), "scale": 5.0},
        foldable=False,
        unsupported={"vector": "a checker texture without coordinates is generated in Blender; the UV map is used"},
    ),
}
