# SPDX-License-Identifier: GPL-3.0-or-later
"""Choice of a light by what it may contribute at a point, among few or many.

Lights are the leaves of a balanced binary tree. Of a node is known its power P, centre c, mean squared distance s² of
its lights from there, and m, the mean of the axes of its one-sided lights (0 for those that shine all around). At p a
node's importance is P g/(|p - c|² + s²), with g = 1 - |m| + 4 max(m·w, 0) + 2 |m| s/d + a floor: four times the cosine
is what a one-sided Lambert emitter shines along w beyond one that shines all around. The topmost nodes are weighed all
at once; below them one child is chosen at each level. Both steps can be repeated for a given light, so the probability
of the choice is exact at any point.

Source: Conty and Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting", HPG 2018; PBRT, 4th ed.,
12.6.3. The importance is smooth, so it needs no bounds.
"""

from __future__ import annotations

import numpy as np

from ..sampling.distributions import BELOW_ONE, Choice

_TOP = 16  # nodes weighed at once; a level below costs as much as five of them
_FAINTEST = 1e-18  # share of the brightest light's power; keeps importances above float32's smallest
_FLOOR = 0.05  # of g
_CLOSE = 1e-12  # of the squared extent of all lights, below which distances make no difference
_X, _S2, _POWER, _AXIS, _AROUND, _EDGE = slice(0, 3), 3, 4, slice(5, 8), 8, 9  # a node's columns
_COLUMNS, _COLUMNS_WITH_AXIS = 5, 10


class LightTree:
    """Lights chosen by their importance at a point.

    Parameters
    ----------
    center : (3, n)
    spread : (n,)
    axis : (3, n)
        As in `Bounds`, zero for lights that shine all around.
    power : (n,)
        Lights of power 0 are never chosen; not all are.
    """

    def __init__(self, center, spread, axis, power):
        center, spread, axis = (np.asarray(a, np.float64) for a in (center, spread, axis))
        power = np.asarray(power, np.float64) / np.max(power)
        power = np.where(power > 0, np.maximum(power, _FAINTEST), 0.0)
        leaf, depth = _balanced(center)
        self._columns = _COLUMNS_WITH_AXIS if axis.any() else _COLUMNS
        levels = _levels(leaf, depth, center, spread, axis, power)
        top = min(depth, _TOP.bit_length() - 1) if depth > 1 else 0  # of two lights the one root pair is enough
        self._top = levels[top][: self._columns].T.tolist()
        self._top_rows = np.ascontiguousarray(levels[top][: self._columns].T, np.float32)
        self._pairs = [
            np.ascontiguousarray(nodes[: self._columns].T, np.float32).reshape(-1, 2 * self._columns)
            for nodes in levels[top + 1 :]
        ]
        self._leaf = leaf.astype(np.int32)
        self._light = np.zeros(1 << depth, np.int32)
        self._light[leaf] = np.arange(leaf.size)

    def sample(self, p, u, arena):
        """Choose a light at each of `p` (3, N) by `u` (N,) in [0, 1): a `Choice`."""
        n = p.shape[-1]
        index, pmf, rest = arena.empty(n, np.int32), arena.empty(n), arena.empty(n)
        with arena.frame():
            self._choose_top(p, u, index, pmf, rest, arena)
            for pairs in self._pairs:
                with arena.frame():
                    _descend(pairs, p, index, pmf, rest, arena)
            if self._pairs:
                np.clip(rest, 0.0, BELOW_ONE, out=rest)
        return Choice(arena.take(self._light, index), pmf, rest)

    def pmf(self, index, p, arena):
        """Probability (N,) with which `sample` chooses the lights `index`, one or (N,), at `p` (3, N)."""
        n = p.shape[-1]
        pmf = arena.empty(n)
        leaf = self._leaf[index]
        with arena.frame():
            total, weight = arena.zeros(n), arena.empty(n)
            for node in self._top:
                np.add(total, _importance(node, p, weight, arena), out=total)
            rows = self._top_rows[leaf >> len(self._pairs)]
            np.divide(_importance(rows.T, p, weight, arena), total, out=pmf)
            for level, pairs in enumerate(self._pairs):
                with arena.frame():
                    below = len(self._pairs) - level
                    node = leaf >> below
                    right = np.asarray((leaf >> (below - 1)) & 1, np.float32)
                    share = _left_share(pairs[node].T, p, arena)
                    np.multiply(pmf, np.abs(np.subtract(right, share, out=share), out=share), out=pmf)
        return pmf

    def _choose_top(self, p, u, index, pmf, rest, arena):
        """Write each lane's topmost node, its probability and what is left of `u`."""
        n, count = u.size, len(self._top)
        index.fill(0)
        if count == 1:
            pmf.fill(1)
            np.copyto(rest, u)
            return
        sums = arena.empty((count + 1, n))
        sums[0] = 0
        with arena.frame():
            weight = arena.empty(n)
            for k, node in enumerate(self._top):
                np.add(sums[k], _importance(node, p, weight, arena), out=sums[k + 1])
        total = sums[count]
        x = np.multiply(u, total, out=arena.empty(n))
        last = np.nextafter(np.float32(1), np.float32(0))
        np.minimum(x, np.multiply(total, last, out=rest), out=x)
        for k in range(1, count):
            np.add(index, np.greater_equal(x, sums[k]), out=index)
        place = np.multiply(index, n, out=arena.empty(n, np.intp))
        np.add(place, np.arange(n), out=place)
        low = np.take(sums.reshape(-1), place, out=arena.empty(n), mode="clip")
        np.add(place, n, out=place)
        np.take(sums.reshape(-1), place, out=pmf, mode="clip")
        np.subtract(pmf, low, out=pmf)
        np.subtract(x, low, out=rest)
        np.divide(rest, pmf, out=rest)
        np.divide(pmf, total, out=pmf)


def _descend(pairs, p, index, pmf, rest, arena):
    """Go from nodes `index` to one of their children, in place."""
    n = index.size
    if len(pairs) == 1:
        columns = pairs[0].tolist()
    else:
        columns = np.take(pairs, index, axis=0, out=arena.empty((n, pairs.shape[1])), mode="clip").T
    share = _left_share(columns, p, arena)
    np.minimum(rest, BELOW_ONE, out=rest)  # a share of 1 must not be left
    right = np.greater_equal(rest, share, out=arena.empty(n, bool))
    np.add(index, index, out=index)
    np.add(index, right, out=index)
    one = arena.empty(n)
    np.copyto(one, right)
    np.subtract(rest, np.multiply(one, share, out=arena.empty(n)), out=rest)
    np.abs(np.subtract(one, share, out=share), out=share)
    np.divide(rest, share, out=rest)
    np.multiply(pmf, share, out=pmf)


def _left_share(columns, p, arena):
    """The first child's share of both children's importance, (N,); `columns` are those of one and of the other."""
    n = p.shape[-1]
    share, other = arena.empty(n), arena.empty(n)
    half = len(columns) // 2
    _importance(columns[:half], p, share, arena)
    _importance(columns[half:], p, other, arena)
    np.add(share, other, out=other)
    return np.divide(share, other, out=share)


def _importance(node, p, out, arena):
    """Write the importance at `p` (3, N) of nodes, whose columns are numbers or (N,)."""
    with arena.frame():
        x, t = arena.empty(p.shape), arena.empty(p.shape[-1])
        for i in range(3):
            np.subtract(p[i], node[i], out=x[i])
        np.multiply(x[0], x[0], out=out)
        for i in (1, 2):
            np.add(out, np.multiply(x[i], x[i], out=t), out=out)
        np.add(out, node[_S2], out=out)
        if len(node) == _COLUMNS:
            return np.divide(node[_POWER], out, out=out)
        axis = node[_AXIS]
        facing = np.multiply(x[0], axis[0], out=x[0])
        for i in (1, 2):
            np.add(facing, np.multiply(x[i], axis[i], out=t), out=facing)
        np.add(facing, np.abs(facing, out=t), out=facing)  # twice max(facing, 0), faster
        np.add(facing, node[_EDGE], out=facing)
        np.divide(facing, np.sqrt(out, out=t), out=facing)
        np.add(facing, node[_AROUND], out=facing)
        np.multiply(facing, node[_POWER], out=facing)
        return np.divide(facing, out, out=out)


# -- building ----------------------------------------------------------------------------------------------------------


def _balanced(center):
    """Leaf numbers (n,) of a tree split at the medians of the longest sides, and the tree's depth."""
    n = center.shape[1]
    depth = (n - 1).bit_length()
    order, size = np.arange(n), np.array([n])
    for _ in range(depth):
        start, placed = np.cumsum(size) - size, center[:, order]
        low = np.minimum.reduceat(placed, start, axis=1)
        side = np.maximum.reduceat(placed, start, axis=1) - low
        axis, node = np.argmax(side, axis=0), np.repeat(np.arange(size.size), size)
        low, side = (np.take_along_axis(a, axis[None], axis=0)[0] for a in (low, np.maximum(side, 1e-300)))
        share = (placed[axis[node], np.arange(n)] - low[node]) / side[node]
        order = order[np.argsort(2 * node + share, kind="stable")]
        size = np.stack([size - size // 2, size // 2], axis=1).reshape(-1)
    leaf = np.zeros(n, np.intp)
    leaf[order] = np.flatnonzero(size)
    return leaf, depth


def _levels(leaf, depth, center, spread, axis, power):
    """For each level the columns of its nodes, (10, 2^level)."""
    span = center.max(axis=1) - center.min(axis=1)
    closest = _CLOSE * (span @ span + spread.max()) + 1e-24
    nodes = np.zeros((8, 1 << depth))
    nodes[_S2] = closest  # leaves without a light have importance 0, not 0/0
    nodes[:, leaf] = np.concatenate([center, [spread + closest, power], axis])
    levels = [_columns(nodes)]
    for _ in range(depth):
        nodes = _parents(nodes[:, 0::2], nodes[:, 1::2])
        levels.append(_columns(nodes))
    return levels[::-1]


def _parents(a, b):
    """Means of pairs of nodes, rows centre, s², P and m."""
    power = a[_POWER] + b[_POWER]
    share = b[_POWER] / np.where(power > 0, power, 1.0)
    out = a + (b - a) * share
    for child, part in ((a, 1.0 - share), (b, share)):
        out[_S2] += part * ((child[_X] - out[_X]) ** 2).sum(axis=0)
    out[_POWER] = power
    return out


def _columns(nodes):
    length = np.sqrt((nodes[_AXIS] ** 2).sum(axis=0))
    around, edge = 1.0 - length + _FLOOR, 2.0 * length * np.sqrt(nodes[_S2])
    return np.concatenate([nodes[: _AXIS.start], 2.0 * nodes[_AXIS], [around, edge]])
