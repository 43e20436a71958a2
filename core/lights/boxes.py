# SPDX-License-Identifier: GPL-3.0-or-later
"""Which of many lamps rays may cross: a scene of boxes around the lamps, asked through Embree.

Lamps whose boxes overlap share one, so boxes are apart, and a ray meets them one after the other: in at one face, out
at another. A ray that starts in a box meets the face where it leaves.
"""

from __future__ import annotations

import numpy as np

from ..accel import Accel
from ..geometry import Geometry

_MARGIN = 1e-4  # around a box, as a share of its diagonal
_FAR_MARGIN = 1e-6  # the same as a share of the largest coordinate
_FACES = np.array([(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])
_TRIANGLES = np.concatenate([_FACES[:, (0, 1, 2)], _FACES[:, (0, 2, 3)]])


class LampBoxes:
    """Boxes around lamps.

    Parameters
    ----------
    low, high : (3, n)
        Corners of each lamp's bounding box.
    """

    def __init__(self, low, high):
        low, high = np.asarray(low, np.float64), np.asarray(high, np.float64)
        largest = max(np.abs(low).max(), np.abs(high).max())
        margin = _MARGIN * np.linalg.norm(high - low, axis=0) + _FAR_MARGIN * largest
        low, high = low - margin, high + margin
        group = _groups(low, high)
        count = int(group.max()) + 1
        self._member = np.argsort(group, kind="stable")
        self._size = np.bincount(group, minlength=count)
        self._start = np.cumsum(self._size) - self._size
        self._step = 0.5 * float(margin.min())
        box_low, box_high = _around(low, high, group, count)
        pick = np.array([(i & 1, i >> 1 & 1, i >> 2) for i in range(8)])
        corners = np.where(pick[:, None], box_high.T, box_low.T)  # corner, box, xyz
        triangles = corners[_TRIANGLES].transpose(2, 0, 1, 3).reshape(-1, 3, 3)
        self._accel = Accel(Geometry.from_arrays(triangles))

    def candidates(self, o, d, tmin, tmax, arena):
        """Lamps in the boxes that rays meet after `tmin` and that begin before `tmax`.

        Parameters
        ----------
        o, d : (3, N)
        tmin : (N,) or 0.0
        tmax : (N,)

        Yields
        ------
        lanes : (n,) int
            Each once.
        lamp : (n,) int
            A lamp that the lane may cross; no pair of lane and lamp comes twice.
        """
        lanes, last = np.arange(o.shape[1]), np.full(o.shape[1], -1)
        start = np.zeros(lanes.size, np.float32) + tmin
        for _ in range(2 * self._size.size + 2):
            at, along = arena.empty((3, lanes.size)), arena.take(d, lanes)
            np.add(np.multiply(along, start, out=at), arena.take(o, lanes), out=at)
            hits = self._accel.intersect(at, along, None, arena)
            met = np.flatnonzero(hits.prim >= 0)
            lanes, group, before = lanes[met], hits.prim[met] // len(_TRIANGLES), last[met]
            fresh = np.flatnonzero(group != before)
            yield from self._members(lanes[fresh], group[fresh])
            face = start[met] + hits.t[met]
            goes = np.flatnonzero(face < tmax[lanes])
            if goes.size == 0:
                return
            lanes, last = lanes[goes], group[goes]
            start = face[goes] * np.float32(1 + 1e-6) + np.float32(self._step)

    def _members(self, lanes, group):
        """Every lamp of each lane's group."""
        for k in range(int(self._size.max())):
            own = np.flatnonzero(self._size[group] > k)
            if own.size == 0:
                return
            lanes, group = lanes[own], group[own]
            yield lanes, self._member[self._start[group] + k]


def _around(low, high, group, count):
    """Boxes (3, count) around the boxes of each group."""
    box_low, box_high = np.full((3, count), np.inf), np.full((3, count), -np.inf)
    for i in range(3):
        np.minimum.at(box_low[i], group, low[i])
        np.maximum.at(box_high[i], group, high[i])
    return box_low, box_high


def _groups(low, high):
    """Numbers (n,) of groups of boxes, such that boxes around different groups do not overlap."""
    group = np.arange(low.shape[1])
    while True:
        count = int(group.max()) + 1
        joined = _joined(*_around(low, high, group, count))
        _, joined = np.unique(joined, return_inverse=True)
        group = joined[group]
        if int(group.max()) + 1 == count:
            return group


def _joined(low, high):
    """For each box the number of a box that stands for it and all that it overlaps, (n,)."""
    order = np.argsort(low[0])
    low, high = low[:, order], high[:, order]
    end = np.searchsorted(low[0], high[0], side="right")
    head = list(range(order.size))

    def find(i):
        while head[i] != i:
            head[i] = head[head[i]]
            i = head[i]
        return i

    for i in range(order.size):
        rest = slice(i + 1, end[i])
        meets = (low[1:, rest] <= high[1:, i : i + 1]).all(axis=0) & (high[1:, rest] >= low[1:, i : i + 1]).all(axis=0)
        for j in np.flatnonzero(meets).tolist():
            head[find(i + 1 + j)] = find(i)
    out = np.zeros(order.size, np.intp)
    out[order] = [find(i) for i in range(order.size)]
    return out
