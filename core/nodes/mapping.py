# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Mapping node: vectors moved, turned and scaled.

Source: Blender manual, "Mapping Node"; rotations are about X, then Y, then Z. Where a scale is 0, a division by it
gives 0.
"""

from __future__ import annotations

import numpy as np

from ..vecmath import normalize
from .base import Operation


def _mapping(context, inputs, properties):
    arena = context.arena
    vector, location, scale = inputs["vector"], inputs["location"], inputs["scale"]
    kind = properties.get("vector_type", "POINT")
    matrix = rotation_matrix(inputs["rotation"])
    if kind == "TEXTURE":
        # The inverse of what POINT does.
        return {"vector": _quotient(turned(matrix.swapaxes(0, 1), vector - location, arena), scale)}
    if kind == "NORMAL":
        out = turned(matrix, _quotient(vector, scale), arena)
        return {"vector": normalize(out, arena, out=out)}
    out = turned(matrix, vector * scale, arena)
    return {"vector": out + location if kind == "POINT" else out}


def rotation_matrix(angles):
    """Matrices (3, 3, N) that turn by `angles` (3, N), rad, about X, then Y, then Z."""
    (a, b, c), (d, e, f) = np.cos(angles), np.sin(angles)  # of X, Y, Z
    return np.array(
        [
            [b * c, d * e * c - a * f, a * e * c + d * f],
            [b * f, d * e * f + a * c, a * e * f - d * c],
            [-e, d * b, a * b],
        ]
    )


def turned(matrix, vector, arena):
    """Product of matrices (3, 3, N) or (3, 3, 1) and vectors (3, N) or (3, 1)."""
    out = arena.zeros((3, max(matrix.shape[-1], vector.shape[-1])))
    with arena.frame():
        t = arena.empty(out.shape[-1])
        for total, row in zip(out, matrix, strict=True):
            for factor, component in zip(row, vector, strict=True):
                np.multiply(factor, component, out=t)
                np.add(total, t, out=total)
    return out


def _quotient(a, b):
    return np.divide(a, b, out=np.zeros(np.broadcast_shapes(a.shape, b.shape), np.float32), where=b != 0)


OPERATIONS = {
    "mapping": Operation(
        _mapping,
        {"vector": (0.0,) * 3, "location": (0.0,) * 3, "rotation": (0.0,) * 3, "scale": (1.0,) * 3},
    ),
}
