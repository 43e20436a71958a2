# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Vector Transform node: between the spaces of the world, the object and the camera.

Source: Blender manual, "Vector Transform Node"; Cycles, `kernel/svm/vector_transform.h`.
"""

from __future__ import annotations

import numpy as np

from ..spaces import transform_direction, transform_normal, transform_point
from ..vecmath import normalize
from .base import Operation
from .spaces import of_object, view_of


def _vector_transform(context, inputs, properties):
    """The vector as a point, a direction or a unit normal of another space, by way of the world."""
    v, arena = inputs["vector"], context.arena
    kind = properties.get("vector_type", "VECTOR")
    start, end = properties.get("convert_from", "WORLD"), properties.get("convert_to", "WORLD")
    if start == end:
        return {"vector": v}
    origin = np.zeros((3, 1), np.float32)
    if kind == "POINT" and context.geometry is not None:  # whose matrices take points relative to its origin
        origin = context.geometry.origin.astype(np.float32).reshape(3, 1)
    with np.errstate(all="ignore"):
        if start == "WORLD":
            v = v - origin
        for matrix, inverse in _steps(context, start, end):
            if kind == "NORMAL":
                v = transform_normal(inverse, v, arena)
                normalize(v, arena, out=v)
            else:
                v = (transform_point if kind == "POINT" else transform_direction)(matrix, v, arena)
        return {"vector": v + origin if end == "WORLD" else v}


def _steps(context, start, end):
    """[(matrix, its inverse)] that lead from a space to the world and on to another; a world has no object."""
    steps = []
    if start != "WORLD":
        steps += [matrices[::-1] for matrices in _into(context, start)]
    return steps + (_into(context, end) if end != "WORLD" else [])


def _into(context, space):
    """[(matrix, its inverse)] from the world into a space."""
    if space == "CAMERA":
        view = view_of(context)
        return [(view.to_camera, view.to_world)]
    if context.geometry is None:
        return []
    objects = context.geometry.objects
    return [(of_object(context, objects.to_object), of_object(context, objects.to_world))]


OPERATIONS = {"vector_transform": Operation(_vector_transform, {"vector": (0.5, 0.5, 0.5)}, foldable=False)}
