# SPDX-License-Identifier: GPL-3.0-or-later
"""What procedural textures share: where they are looked up, and outputs that are computed when asked for."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..vecmath import lanes
from .coordinates import lookup_generated


class Outputs(Mapping):
    """Outputs of an operation, each computed the first time it is read: a noise's colour costs three times its factor.

    Parameters
    ----------
    makers : mapping of str to callable
        ``maker() -> array`` of each output.
    """

    def __init__(self, **makers):
        self._makers = makers
        self._values = {}

    def __getitem__(self, name):
        if name not in self._values:
            self._values[name] = self._makers[name]()
        return self._values[name]

    def __iter__(self):
        return iter(self._makers)

    def __len__(self):
        return len(self._makers)


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
