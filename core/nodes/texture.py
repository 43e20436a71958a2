# SPDX-License-Identifier: GPL-3.0-or-later
"""What procedural textures share: where they are looked up."""

from __future__ import annotations

import numpy as np

from ..vecmath import lanes
from .coordinates import lookup_generated


def grey(fac):
    """A factor (N,) as a colour (3, N), without a copy."""
    return np.broadcast_to(fac, (3, fac.size))


def vector_of(context, inputs):
    """The texture's coordinates, (3, N) or (3, 1); generated ones where nothing is linked."""
    return inputs["vector"] if "vector" in inputs else lookup_generated(context)


def scaled(vector, scale, arena):
    """`vector` (D, N) times `scale` (N,)."""
    with np.errstate(over="ignore", invalid="ignore"):
        return np.multiply(vector, scale, out=arena.empty((vector.shape[0], lanes(vector, scale))))
