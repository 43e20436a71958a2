# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair: tubes around Catmull-Rom splines, cut into segments.

Source: Catmull and Rom, "A Class of Local Interpolating Splines", 1974; Embree's documentation of
``RTC_GEOMETRY_TYPE_ROUND_CATMULL_ROM_CURVE`` for the tables' layout.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .vecmath import dot, normalize

# Weights of a segment's four control points as polynomials of u, by ascending power.
POSITION = np.float32([(0, -0.5, 1, -0.5), (1, 0, -2.5, 1.5), (0, 0.5, 2, -1.5), (0, 0, -0.5, 0.5)])
_DERIVATIVE = np.float32([(-0.5, 2, -1.5, 0), (0, -5, 4.5, 0), (0.5, 4, -4.5, 0), (0, -1, 1.5, 0)])

INDEX_PADDING = 8  # numbers that follow the index: Embree may read beyond its end

# A ray that starts no farther beyond an open end starts at it: shares of the radius and of the coordinates.
_END_SLACK, _END_COORDINATE_SLACK = np.float32(1e-3), np.float32(2.0**-20)


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
    follows : (C,) bool
        Whether a segment begins where the one before ends.
    """

    vertices: np.ndarray
    index: np.ndarray
    follows: np.ndarray

    @property
    def count(self):
        """C."""
        return self.index.size

    def part(self, kept):
        """The segments `kept` (C,) bool alone, or None."""
        if not kept.any():
            return None
        index, follows = self.index[kept], self.follows & np.append(False, kept[:-1])
        padded = np.append(index, np.zeros(INDEX_PADDING, np.uint32))[: index.size]
        return Strands(self.vertices, padded, follows[kept])

    def at(self, segment, u, arena):
        """Centre and radius (4, N) of the tubes where `u` (N,) runs along the segments `segment` (N,)."""
        return self._blended(POSITION, segment, u, arena)

    def along(self, segment, u, arena):
        """Unit vectors (3, N) from root to tip; zero where all control points are one."""
        out = self._blended(_DERIVATIVE, segment, u, arena)[:3]
        return normalize(out, arena, out=out)

    def entered(self, segment, o, d, t, arena):
        """Whether rays came into a strand by one of its ends, which are open.

        Parameters
        ----------
        segment : (N,)
            Where they met the strand from inside, at `t` (N,) in units of |d|.
        o, d : (3, N)
            `d` may be (3, 1).

        Returns
        -------
        (N,) bool
        """
        run = np.searchsorted(self._runs, segment, side="right")
        root, tip = self._runs[run - 1], self._runs[run] - 1
        found = np.zeros(segment.size, bool)
        with arena.frame():
            slack = _END_COORDINATE_SLACK * np.abs(o).max(axis=0)
            for end, u, outward in ((root, 0, -1), (tip, 1, 1)):
                u = np.full(segment.size, u, np.float32)
                disc, n = self.at(end, u, arena), self.along(end, u, arena) * np.float32(outward)
                away = o - disc[:3]
                height, rate = dot(away, n, arena), -dot(np.broadcast_to(d, o.shape), n, arena)
                inward = (height > disc[3] * _END_SLACK + slack) & (height < t * rate)
                away += d * (height / np.where(inward, rate, np.float32(1)))
                found |= inward & (dot(away, away, arena) <= np.square(disc[3]))
        return found

    @cached_property
    def _runs(self):
        """Number of the first segment of each strand, or of each piece where some were left out, and C."""
        return np.append(np.flatnonzero(~self.follows), self.count)

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
