# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair: tubes around Catmull-Rom splines, cut into segments.

Source: Catmull and Rom, "A Class of Local Interpolating Splines", 1974; Embree's documentation of
``RTC_GEOMETRY_TYPE_ROUND_CATMULL_ROM_CURVE`` for the tables' layout.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .vecmath import normalize

# Weights of a segment's four control points as polynomials of u, by ascending power.
_POSITION = np.float32([(0, -0.5, 1, -0.5), (1, 0, -2.5, 1.5), (0, 0.5, 2, -1.5), (0, 0, -0.5, 0.5)])
_DERIVATIVE = np.float32([(-0.5, 2, -1.5, 0), (0, -5, 4.5, 0), (0.5, 4, -4.5, 0), (0, -1, 1.5, 0)])

INDEX_PADDING = 8  # numbers that follow the index: Embree may read beyond its end


@dataclass(frozen=True, eq=False)
class Strands:
    """C segments, as Embree reads them.

    Parameters
    ----------
    vertices : (V, 4) float32
        Control points and radii. The first and the last of each strand stand twice, so that it ends there.
    index : (C,) uint32
        First of the four control points of each segment, which runs from the second (u = 0) to the third (u = 1).
        Padding follows in memory.
    """

    vertices: np.ndarray
    index: np.ndarray

    @property
    def count(self):
        """C."""
        return self.index.size

    def part(self, kept):
        """The segments `kept` (C,) bool alone, or None."""
        if not kept.any():
            return None
        index = self.index[kept]
        return Strands(self.vertices, np.append(index, np.zeros(INDEX_PADDING, np.uint32))[: index.size])

    def at(self, segment, u, arena):
        """Centre and radius (4, N) of the tubes where `u` (N,) runs along the segments `segment` (N,)."""
        return self._blended(_POSITION, segment, u, arena)

    def along(self, segment, u, arena):
        """Unit vectors (3, N) from root to tip; zero where all control points are one."""
        out = self._blended(_DERIVATIVE, segment, u, arena)[:3]
        return normalize(out, arena, out=out)

    def _blended(self, weights, segment, u, arena):
        out = arena.zeros((4, u.size))
        with arena.frame():
            first, weight, rows = arena.take(self.index, segment), arena.empty(u.size), arena.empty((u.size, 4))
            for a, b, c, d in weights.tolist():
                np.multiply(u, d, out=weight)
                for lower in (c, b):
                    np.add(weight, lower, out=weight)
                    np.multiply(weight, u, out=weight)
                np.add(weight, a, out=weight)
                np.take(self.vertices, first, axis=0, out=rows, mode="clip")
                np.add(first, np.uint32(1), out=first)
                np.multiply(rows, weight[:, None], out=rows)
                np.add(out, rows.T, out=out)
        return out
