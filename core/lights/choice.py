# SPDX-License-Identifier: GPL-3.0-or-later
"""How one of several lights is chosen.

A choice has ``sample(p, u, arena) -> Choice`` and ``pmf(index, p, arena) -> (N,) or (1,)``, where `p` (3, N) are the
points that are lit and `index`, one number or (N,), counts all lights, kind after kind.
"""

from __future__ import annotations

import numpy as np

from ..sampling.distributions import BELOW_ONE, Choice, DiscreteDistribution
from .tree import LightTree


class PowerChoice:
    """By `importance` (count,), the same everywhere."""

    def __init__(self, importance):
        self._distribution = DiscreteDistribution(importance)

    def sample(self, p, u, arena):
        """Choose by `u` (N,) in [0, 1)."""
        return self._distribution.sample(u, arena)

    def pmf(self, index, p, arena):
        """Probability of the choice of `index`."""
        return np.atleast_1d(self._distribution.pmf[index])


class NearChoice:
    """Lights at a finite distance, `local` (n,), by what they may contribute at the point."""

    def __init__(self, kinds, local):
        self._light = np.asarray(local, np.int32)
        self._all = local.size == local[-1] + 1  # none at infinity before them
        self._place = np.zeros(int(local[-1]) + 1, np.int32)  # among `local`
        self._place[local] = np.arange(local.size)
        self.first = int(local[0])
        self._tree = LightTree(*_bounds_of(kinds))

    def sample(self, p, u, arena):
        """Choose at `p` by `u` (N,) in [0, 1)."""
        choice = self._tree.sample(p, u, arena)
        return choice if self._all else choice._replace(index=arena.take(self._light, choice.index))

    def pmf(self, index, p, arena):
        """Probability of the choice of `index`."""
        return self._tree.pmf(index if self._all else self._place[index], p, arena)


class SharedChoice:
    """Lights at infinity take a fixed share, the others the rest.

    Parameters
    ----------
    importance : (count,)
    near : NearChoice
        Of the lights where `local` (count,) bool holds.
    """

    def __init__(self, importance, near, local):
        self._near, self._local = near, local
        self._far = PowerChoice(np.where(local, 0.0, importance))
        self._share = float(importance[local].sum() / importance.sum())

    def sample(self, p, u, arena):
        """Choose at `p` by `u` (N,) in [0, 1)."""
        n, share = u.size, self._share
        out = Choice(arena.empty(n, np.intp), arena.empty(n), arena.empty(n))
        with arena.frame():
            near = u < share
            parts = ((near, self._near, 0.0, share), (~near, self._far, share, 1.0 - share))
            for chosen, choice, start, width in parts:
                lanes = np.flatnonzero(chosen)
                if lanes.size == 0:
                    continue
                own = np.divide(arena.take(u, lanes) - np.float32(start), width)
                part = choice.sample(arena.take(p, lanes), np.clip(own, 0.0, BELOW_ONE, out=own), arena)
                for whole, values in zip(out, part, strict=True):
                    whole[lanes] = values
                out.pmf[lanes] *= np.float32(width)
        return out

    def pmf(self, index, p, arena):
        """Probability of the choice of `index`."""
        local = self._local[index]
        far = (1.0 - self._share) * self._far.pmf(index, p, arena)
        if not np.any(local):
            return far.astype(np.float32)
        near = self._share * self._near.pmf(np.where(local, index, self._near.first), p, arena)
        return np.where(local, near, far).astype(np.float32)


def choice_of(kinds, importance):
    """The choice that suits all lights of `kinds`, of which there are at least two."""
    local = np.repeat([not k.at_infinity for k in kinds], [k.count for k in kinds])
    bright = np.flatnonzero(local & (np.asarray(importance) > 0))
    if bright.size < 2:
        return PowerChoice(importance)
    near = NearChoice(kinds, np.flatnonzero(local))
    return near if local.all() else SharedChoice(importance, near, local)


def importance_of(kinds):
    """Weights of the choice, (count,): by power among lights at a finite distance, by irradiance among suns.

    A sun's power has no scale that fits a lamp's: in a vast scene it would be nearly all, though few points may see
    the sun. So n suns together have n/(n + 1) of the choice where there are other lights, as in PBRT, 4th ed., 12.6.
    """
    if not kinds:
        return np.zeros(0)
    power = [np.asarray(k.power, np.float64) if not k.at_infinity else np.zeros(k.count) for k in kinds]
    sun = [np.asarray(k.power, np.float64) if k.at_infinity else np.zeros(k.count) for k in kinds]
    power, sun = np.concatenate(power), np.concatenate(sun)
    suns = int((sun > 0).sum())
    if not suns or not power.any():
        return power + sun
    return power / power.sum() + suns * sun / sun.sum()


def _bounds_of(kinds):
    """Centres, spreads, axes and powers of the lights at a finite distance."""
    kinds = [k for k in kinds if not k.at_infinity]
    center, spread, axis = zip(*(k.bounds() for k in kinds), strict=True)
    axis = [np.zeros(c.shape) if a is None else a for a, c in zip(axis, center, strict=True)]
    power = np.concatenate([k.power for k in kinds])
    return np.concatenate(center, axis=1), np.concatenate(spread), np.concatenate(axis, axis=1), power
