# SPDX-License-Identifier: GPL-3.0-or-later
"""Choice from a finite set."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

BELOW_ONE = float(np.nextafter(np.float32(1), np.float32(0)))


class Choice(NamedTuple):
    """index (N,) intp; pmf (N,) its probability; u (N,) in [0, 1), what is left of the number that chose."""

    index: np.ndarray
    pmf: np.ndarray
    u: np.ndarray


class DiscreteDistribution:
    """Numbers 0..n-1 chosen with probability proportional to `weights`, in constant time.

    The unit interval is cut into n bins; bin i keeps i below its threshold and gives the rest to one alias.
    Probabilities are right to 2⁻²⁴, the step of the numbers that choose. Source: Vose, "A Linear Algorithm for
    Generating Random Numbers with a Given Distribution", IEEE TSE 17(9), 1991.

    Parameters
    ----------
    weights : (n,) array_like
        Non-negative and finite, not all zero. Entries of weight 0 are never chosen.

    Attributes
    ----------
    pmf : (n,) float32

    Raises
    ------
    ValueError
        If there is nothing to choose from.
    """

    def __init__(self, weights):
        weights = np.asarray(weights, np.float64)
        total = weights.sum()
        if not (weights.size and np.isfinite(total) and total > 0 and (weights >= 0).all()):
            raise ValueError("a distribution needs finite, non-negative weights and one above 0")
        probabilities = weights / total
        self.pmf = probabilities.astype(np.float32)
        self._threshold, self._alias = _alias_table(probabilities)

    def sample(self, u, arena):
        """Choose by `u` (N,) float32 in [0, 1)."""
        n, size = u.shape[-1], self.pmf.size
        index, rest = arena.empty(n, np.intp), arena.empty(n)
        np.multiply(u, float(size), out=rest)
        np.minimum(rest, float(np.nextafter(np.float32(size), np.float32(0))), out=rest)
        np.floor(rest, out=rest)
        np.copyto(index, rest, casting="unsafe")
        with arena.frame():
            bin_start, start, width = arena.empty(n), arena.zeros(n), arena.take(self._threshold, index)
            np.copyto(bin_start, rest)
            np.multiply(u, float(size), out=rest)
            np.subtract(rest, bin_start, out=rest)
            moved = np.greater_equal(rest, width, out=arena.empty(n, bool))
            np.copyto(start, width, where=moved)
            np.subtract(1.0, width, out=width, where=moved)
            np.copyto(index, arena.take(self._alias, index), where=moved)
            np.subtract(rest, start, out=rest)
            np.maximum(width, 1e-30, out=width)
            np.divide(rest, width, out=rest)
            np.clip(rest, 0.0, BELOW_ONE, out=rest)
        return Choice(index, arena.take(self.pmf, index), rest)


class Distribution2D:
    """Cells of a grid chosen with probability proportional to `weights`, and points in them: the row first.

    The cumulative distributions are inverted, so that well spread numbers give well spread points. A guide table tells
    between which cells to search: Chen and Asau, "On Generating Random Variates from an Empirical Distribution", AIIE
    Transactions 6(2), 1974. Thresholds are multiples of 2⁻²⁴, the step of the numbers that choose, so that `pmf` is
    exactly what is drawn; what is less likely than half a step in its row is never drawn.

    Parameters
    ----------
    weights : (R, C) array_like
        Non-negative and finite, not all zero.

    Attributes
    ----------
    pmf : (R, C) float32
        Probabilities of the cells.

    Raises
    ------
    ValueError
        If there is nothing to choose from.
    """

    def __init__(self, weights):
        weights = np.asarray(weights, np.float64)
        of_row = weights.sum(axis=1)
        if not (np.isfinite(of_row.sum()) and of_row.sum() > 0 and (weights >= 0).all()):
            raise ValueError("a distribution needs finite, non-negative weights and one above 0")
        self._rows = _Inverse(of_row[None])
        self._columns = _Inverse(np.where(of_row[:, None] > 0, weights, 1.0))
        self.pmf = self._rows.pmf.reshape(-1, 1) * self._columns.pmf

    def sample(self, u0, u1, arena):
        """Row, column (N,) intp, and the place in the cell, two (N,) in [0, 1), by `u0`, `u1` (N,) in [0, 1)."""
        row, y = self._rows.sample(None, u0, arena)
        column, x = self._columns.sample(row, u1, arena)
        return row, column, y, x


class _Inverse:
    """Cumulative distributions of the rows of `weights` (R, n), inverted; `pmf` (R, n) is exact."""

    def __init__(self, weights):
        rows, self._size = weights.shape
        cdf = np.cumsum(weights, axis=1)
        cdf = np.concatenate((np.zeros((rows, 1)), cdf / cdf[:, -1:]), axis=1)
        cdf = np.rint(cdf * 2.0**24) * 2.0**-24
        self.pmf = np.diff(cdf).astype(np.float32)
        self._cdf = cdf.astype(np.float32).reshape(-1)
        self._bins = 1 << max(self._size - 1, 1).bit_length()
        starts = np.arange(self._bins + 1) / self._bins
        found = [np.searchsorted(row, starts, side="right") - 1 for row in cdf]
        self._guide = (
            np.minimum(found, self._size - 1).astype(np.int16 if self._size < 1 << 15 else np.int32).reshape(-1)
        )

    def sample(self, row, u, arena):
        """Entry (N,) intp of distribution `row` (N,) (None: the only one), and the place in it (N,) in [0, 1)."""
        n = u.size
        low, place = arena.empty(n, np.intp), arena.empty(n)
        with arena.frame():
            first = 0
            high, at, t = arena.empty(n, np.intp), arena.empty(n, np.intp), arena.empty(n)
            np.multiply(u, float(self._bins), out=t)
            np.copyto(at, t, casting="unsafe")
            if row is not None:
                np.add(at, np.multiply(row, self._bins + 1, out=low), out=at)
                first = np.multiply(row, self._size + 1, out=arena.empty(n, np.intp))
            np.copyto(low, arena.take(self._guide, at))
            np.add(at, 1, out=at)
            np.copyto(high, arena.take(self._guide, at))
            np.add(low, first, out=low)
            np.add(high, first, out=high)
            self._bisect(low, high, u, arena)
            start = arena.take(self._cdf, low)
            np.add(low, 1, out=at)
            end = arena.take(self._cdf, at)
            np.subtract(end, start, out=end)
            np.subtract(u, start, out=place)
            np.divide(place, end, out=place)
            np.minimum(place, BELOW_ONE, out=place)
            np.subtract(low, first, out=low)
        return low, place

    def _bisect(self, low, high, u, arena):
        """Raise `low` (N,) to the last place up to `high` where the distribution does not exceed `u`."""
        lanes = np.flatnonzero(low < high)
        while lanes.size:
            a, b = low[lanes], high[lanes]
            middle = (a + b + 1) >> 1
            below = self._cdf[middle] <= u[lanes]
            a, b = np.where(below, middle, a), np.where(below, b, middle - 1)
            low[lanes], high[lanes] = a, b
            lanes = lanes[a < b]


def _alias_table(probabilities):
    """Vose's thresholds (n,) float32 and aliases (n,) intp."""
    size = probabilities.size
    share = (probabilities * size).tolist()
    alias = list(range(size))
    threshold = [1.0] * size
    small = [i for i, s in enumerate(share) if s < 1.0]
    large = [i for i, s in enumerate(share) if s >= 1.0]
    while small and large:
        poor, rich = small.pop(), large[-1]
        threshold[poor], alias[poor] = share[poor], rich
        share[rich] -= 1.0 - share[poor]
        if share[rich] < 1.0:
            small.append(large.pop())
    likeliest = int(np.argmax(probabilities))
    for i in small:  # rounding left these short of 1; a weight of 0 must not profit from it
        if probabilities[i] == 0.0:
            threshold[i], alias[i] = 0.0, likeliest
    return np.array(threshold, np.float32), np.array(alias, np.intp)
