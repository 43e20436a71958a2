# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Image Texture: a picture on a surface's coordinates.

As in Cycles, colours are times alpha where the Alpha output is not linked, and divided by it where it is. Source:
Cycles (`kernel/svm/image.h`, `scene/shader_nodes.cpp`).
"""

from __future__ import annotations

import numpy as np

from . import spaces
from .base import Operation
from .coordinates import lookup_uv
from .image_loader import load
from .projections import box, box_weights, sphere, tube

_PROJECTIONS = {"FLAT": lambda vector, arena: vector[:2], "SPHERE": sphere, "TUBE": tube}
_FIRST_TILE = 1001
_OPAQUE = np.ones(1, np.float32)


def _prepare(properties, diagnostics, place):
    """Read the image."""
    image, projection = properties.get("image"), properties.get("projection", "FLAT")
    if projection == "BOX" and image is not None and image.tiles:
        image = image.tiles.get(_FIRST_TILE)  # a box' sides have coordinates of their own
    return {
        "texels": load(image, diagnostics, place),
        "projection": projection,
        "blend": float(properties.get("projection_blend", 0.0)),
        "interpolation": properties.get("interpolation", "Linear"),
        "extension": properties.get("extension", "REPEAT"),
        "alpha": "alpha" in properties.get("linked", ()),
    }


def _image(context, inputs, properties):
    arena = context.arena
    vector = inputs["vector"] if "vector" in inputs else lookup_uv(context, "")
    vector = np.broadcast_to(vector, (3, context.count))
    out = arena.empty((4 if properties["alpha"] else 3, context.count))
    with arena.frame(), np.errstate(over="ignore", invalid="ignore"):
        if properties["projection"] == "BOX":
            _box(context, vector, properties, out)
        else:
            u, v = _PROJECTIONS[properties["projection"]](vector, arena)
            _sample(u, v, properties, arena, out)
    return {"color": out[:3], "alpha": out[3] if properties["alpha"] else _OPAQUE}


def _box(context, vector, properties, out):
    """Write the sides of a box, blended where the surface turns from one to the next, to `out`."""
    arena = context.arena
    normal = spaces.normal_to_object(context, spaces.shading_normal(context))
    weights = box_weights(normal, properties["blend"], arena)
    out.fill(0)
    for (u, v), weight in zip(box(vector, normal, arena), weights, strict=True):
        lanes = np.flatnonzero(weight > 0)
        if lanes.size == 0:
            continue
        with arena.frame():
            side = arena.empty((len(out), lanes.size))
            _sample(arena.take(u, lanes), arena.take(v, lanes), properties, arena, side)
            np.multiply(side, arena.take(weight, lanes), out=side)
            out[:, lanes] += side


def _sample(u, v, properties, arena, out):
    interpolation, extension, alpha = properties["interpolation"], properties["extension"], properties["alpha"]
    properties["texels"].sample(u, v, interpolation, extension, arena, out, unassociate=alpha)


OPERATIONS = {"image": Operation(_image, {"vector": None}, foldable=False, prepare=_prepare)}
