# SPDX-License-Identifier: GPL-3.0-or-later
"""UDIM tiles: a picture for each unit square of the coordinates."""

from __future__ import annotations

import numpy as np

_FIRST, _COLUMNS = 1001, 10  # number of the tile at 0, 0; tiles in a row
_FAR = 1e6


class Tiles:
    """Texels by tile.

    Parameters
    ----------
    texels : mapping of int to Texels
        By the tile's number.
    missing : (4,) sequence of float
        Colour and alpha where there is no tile.
    """

    def __init__(self, texels, missing):
        self._texels = dict(texels)
        self._missing = missing

    @property
    def nbytes(self):
        """Memory of all tiles."""
        return sum(texels.nbytes for texels in self._texels.values())

    def sample(self, x, y, interpolation, extension, arena, out, unassociate=False):
        """As `Texels.sample`. A tile goes on in its own picture: coordinates just below 0 are those of the first."""
        for row, value in zip(out, self._missing, strict=False):
            row.fill(value)
        with arena.frame():
            column, line = _whole(x, arena), _whole(y, arena)
            number = arena.empty(x.size)
            np.multiply(line, float(_COLUMNS), out=number)
            np.add(number, column, out=number)
            number[(column < 0) | (column >= _COLUMNS) | (line < 0)] = -1
            for tile, texels in self._texels.items():
                lanes = np.flatnonzero(number == tile - _FIRST)
                if lanes.size:
                    with arena.frame():
                        part = arena.empty((len(out), lanes.size))
                        u, v = (a[lanes] - b[lanes] for a, b in ((x, column), (y, line)))
                        texels.sample(u, v, interpolation, extension, arena, part, unassociate)
                        out[:, lanes] = part


def _whole(coordinate, arena):
    """The whole part, towards 0; -1e6 of what is no number."""
    out = np.fmax(coordinate, -_FAR, out=arena.empty(coordinate.size))
    np.fmin(out, _FAR, out=out)
    return np.trunc(out, out=out)
