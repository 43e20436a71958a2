# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Vector Rotate node: one operation for each kind of axis.

Source: Blender manual, "Vector Rotate Node"; Rodrigues' formula.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from ..vecmath import cross, dot, lanes, normalize
from .base import Operation
from .mapping import rotation_matrix, turned


def _about(vector, axis, angle, arena):
    """`vector` turned about the unit `axis` by `angle`, rad."""
    cosine, sine = np.cos(angle), np.sin(angle)
    out = np.multiply(cross(axis, vector, arena), sine, out=arena.empty((3, lanes(vector, axis, angle))))
    np.add(out, vector * cosine, out=out)
    return np.add(out, axis * (dot(axis, vector, arena) * (1 - cosine)), out=out)


def _about_axis(axis, context, inputs, properties):
    """About ``axis``, an input where `axis` is None; about none where that has no length."""
    angle = -inputs["angle"] if properties.get("invert") else inputs["angle"]
    with np.errstate(all="ignore"):
        if axis is None:
            axis = inputs["axis"]
            angle = angle * axis.any(axis=0)
            axis = normalize(axis, context.arena)
        out = _about(inputs["vector"] - inputs["center"], axis, angle, context.arena)
        return {"vector": np.add(out, inputs["center"], out=out)}


def _by_euler_angles(context, inputs, properties):
    with np.errstate(all="ignore"):
        matrix = rotation_matrix(inputs["rotation"])
        if properties.get("invert"):
            matrix = matrix.swapaxes(0, 1)
        return {"vector": turned(matrix, inputs["vector"] - inputs["center"], context.arena) + inputs["center"]}


_VECTOR = {"vector": (0.0, 0.0, 0.0), "center": (0.0, 0.0, 0.0)}

OPERATIONS = {
    f"vector_rotate_{name}_axis": Operation(
        partial(_about_axis, np.array(axis, np.float32).reshape(3, 1)), _VECTOR | {"angle": 0.0}
    )
    for name, axis in (("x", (1, 0, 0)), ("y", (0, 1, 0)), ("z", (0, 0, 1)))
} | {
    "vector_rotate_axis_angle": Operation(
        partial(_about_axis, None), _VECTOR | {"axis": (0.0, 0.0, 1.0), "angle": 0.0}
    ),
    "vector_rotate_euler_xyz": Operation(_by_euler_angles, _VECTOR | {"rotation": (0.0, 0.0, 0.0)}),
}
