# SPDX-License-Identifier: GPL-3.0-or-later
"""Texture coordinates."""

from __future__ import annotations

import numpy as np

from ..interaction import uv_at
from .base import Operation

_OTHERS = ("generated", "normal", "object", "camera", "window", "reflection")
_NOT_OF_WORLDS = ("uv", "camera", "window", "reflection")


def lookup_uv(context, name):
    """UV map `name` of the lanes, (3, N) with a zero third row; "" is each mesh's active map. A world's are zero."""
    out = context.arena.zeros((3, context.count))
    s = context.surface
    if s is not None:
        out[:2] = uv_at(context.geometry, name, s.prim, s.u, s.v, context.arena)
    return out


def _uv_map(context, inputs, properties):
    return {"uv": lookup_uv(context, properties.get("uv_map", ""))}


def _tex_coord(context, inputs, properties):
    uv = lookup_uv(context, "")
    return dict.fromkeys(("uv", *_OTHERS), uv)


def _world_coordinates(context, inputs, properties):
    d = context.direction
    inward = np.negative(d, out=context.arena.empty(d.shape))
    return {"generated": d, "object": d, "normal": inward} | dict.fromkeys(_NOT_OF_WORLDS, d)


OPERATIONS = {
    "uv_map": Operation(_uv_map, foldable=False),
    "tex_coord": Operation(
        _tex_coord,
        foldable=False,
        unsupported={name: f"texture coordinate '{name}' is not supported; the UV map is used" for name in _OTHERS},
    ),
    "world_coordinates": Operation(
        _world_coordinates,
        foldable=False,
        unsupported={
            name: f"texture coordinate '{name}' is not supported in a world; the direction is used"
            for name in _NOT_OF_WORLDS
        },
    ),
}
