# SPDX-License-Identifier: GPL-3.0-or-later
"""The mapping that each texture node of Blender has inside: vectors times a matrix.

Source: Cycles (`scene/shader_nodes.cpp`), which takes no account of its limits.
"""

from __future__ import annotations

import numpy as np

from ..vecmath import dot, normalize
from . import spaces
from .base import Operation
from .coordinates import lookup_generated, lookup_uv

# Coordinates that a texture has by default, for where nothing is linked.
_DEFAULTS = {
    "uv": lambda context: lookup_uv(context, ""),
    "generated": lookup_generated,
    "position": spaces.world_position,
}


def _texture_mapping(context, inputs, properties):
    arena = context.arena
    vector = inputs["vector"] if "vector" in inputs else _DEFAULTS[properties["coordinates"]](context)
    out = arena.empty((3, context.count))
    vector = np.broadcast_to(vector, out.shape)
    with np.errstate(over="ignore", invalid="ignore"):
        for total, axis, offset in zip(out, "xyz", inputs["offset"], strict=True):
            np.add(dot(inputs[axis], vector, arena, out=total), offset, out=total)
    return {"vector": normalize(out, arena, out=out) if properties.get("normalize") else out}


OPERATIONS = {
    "texture_mapping": Operation(
        _texture_mapping,
        # Rows of the matrix, and its last column.
        {"vector": None, "x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0), "offset": (0.0,) * 3},
        foldable=False,
    )
}
