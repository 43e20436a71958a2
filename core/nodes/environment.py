# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Environment Texture: a picture of all directions.

As in Cycles, the picture repeats in both ways, and colours are interpolated as stored, times alpha.
"""

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np

from . import spaces
from .base import Operation
from .image_loader import load
from .projections import equirectangular, mirror_ball

COLUMNS, ROWS = 1024, 512  # of what light sampling sees of a picture

_PROJECTIONS = {"EQUIRECTANGULAR": equirectangular, "MIRROR_BALL": mirror_ball}
_FIRST_TILE = 1001

_averaged = WeakKeyDictionary()


def _prepare(properties, diagnostics, place):
    """Read the picture."""
    image = properties.get("image")
    if image is not None and image.tiles:
        image = image.tiles.get(_FIRST_TILE)
    texels = load(image, diagnostics, place)
    if texels not in _averaged:
        _averaged[texels] = texels.averaged(COLUMNS, ROWS)
    return {
        "texels": texels,
        "averaged": _averaged[texels],
        "projection": properties.get("projection", "EQUIRECTANGULAR"),
        "interpolation": properties.get("interpolation", "Linear"),
    }


def _environment(context, inputs, properties):
    arena = context.arena
    color = arena.empty((3, context.count))
    with arena.frame(), np.errstate(over="ignore", invalid="ignore"):
        vector = inputs["vector"] if "vector" in inputs else spaces.world_position(context)
        vector = np.broadcast_to(vector, (3, context.count))
        u, v = _PROJECTIONS[properties["projection"]](vector, arena)
        texels = properties["averaged" if context.averaged else "texels"]
        texels.sample(u, v, properties["interpolation"], "REPEAT", arena, color)
    return {"color": color}


OPERATIONS = {
    "environment": Operation(_environment, {"vector": None}, foldable=False, prepare=_prepare),
}
