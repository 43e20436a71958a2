# SPDX-License-Identifier: GPL-3.0-or-later
"""Choice from a finite set."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

_BELOW_ONE = float(np.nextafter(np.float32(1), np.float32(0)))


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
            np.clip(rest, 0.0, _BELOW_ONE, out=rest)
        return Choice(index, arena.take(self.pmf, index), rest)


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
