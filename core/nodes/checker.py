# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Checker Texture."""

from __future__ import annotations

import numpy as np

from ..vecmath import lanes
from .base import Operation
from .texture import scaled, vector_of


def _checker(context, inputs, properties):
    """Fac is 1, and the colour the first one, where the integer parts of the scaled coordinates have an odd sum."""
    arena, color1, color2 = context.arena, inputs["color1"], inputs["color2"]
    p = scaled(vector_of(context, inputs), inputs["scale"], arena)
    n = lanes(p, color1, color2)
    color, fac = arena.empty((3, n)), arena.zeros(n)
    with arena.frame(), np.errstate(invalid="ignore", over="ignore"):
        # The nudge is Blender's own: it keeps cell borders at integers off the border.
        np.add(p, 1e-6, out=p)
        np.multiply(p, 0.999999, out=p)
        for row in np.floor(p, out=p):
            np.add(fac, row, out=fac)
        is_odd = np.equal(np.mod(fac, 2.0, out=fac), 1, out=arena.empty(n, np.bool_))
        np.copyto(fac, is_odd)
        # The colours' bits are chosen, so that each is exactly what was put in.
        mask = arena.empty(n, np.int32)
        np.negative(is_odd, out=mask, dtype=np.int32)
        bits = color.view(np.int32)
        np.bitwise_and(np.bitwise_xor(color1.view(np.int32), color2.view(np.int32)), mask, out=bits)
        np.bitwise_xor(bits, color2.view(np.int32), out=bits)
    return {"color": color, "fac": fac}


OPERATIONS = {
    "checker": Operation(
        _checker,
        {"vector": None, "color1": (0.8, 0.8, 0.8), "color2": (0.2, 0.2, 0.2), "scale": 5.0},
        foldable=False,
    ),
}
