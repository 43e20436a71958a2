# SPDX-License-Identifier: GPL-3.0-or-later
"""Choice of a light and of a direction to it."""

from __future__ import annotations

import numpy as np

from ..sampling.distributions import DiscreteDistribution
from ..vecmath import dot
from .base import LightSample
from .triangle import TriangleLights


class LightSampler:
    """Samples the light of a scene, one light a lane, chosen by power.

    The stages are composed once: a single light is not chosen, lights of one kind are not sorted by kind.

    Parameters
    ----------
    kinds : sequence
        Kinds of light (`core.lights.base`).
    importance : (count,) float
        Of all lights, kind after kind, from `importance_of`.
    prim_count : int
        Number of the scene's primitives.
    environment : ConstantEnvironment

    Attributes
    ----------
    count : int
        Number of lights that can be chosen. With 0 every sample has weight 0.
    pmf : (count,) float32
        Probability of the choice.
    """

    def __init__(self, kinds, importance, prim_count, environment):
        self.kinds = tuple(kinds)
        self.environment = environment
        counts = [k.count for k in self.kinds]
        self.count = sum(counts)
        self._first = [sum(counts[:i]) for i in range(len(counts))]
        self._choice = DiscreteDistribution(importance) if self.count else None
        self.pmf = self._choice.pmf if self.count else np.zeros(0, np.float32)
        self._density = self._triangle_density(prim_count)
        if self.count == 0:
            self._sample = self._sample_nothing
        elif self.count == 1:
            self._sample = self._sample_only
        elif len(self.kinds) == 1:
            self._sample = self._sample_one_kind
        else:
            self._sample = self._sample_by_kind

    def sample(self, p, uc, u0, u1, arena):
        """A direction towards some light.

        Parameters
        ----------
        p : (3, N) float32
            Points that are lit.
        uc, u0, u1 : (N,) float32
            In [0, 1): choice of the light, and of a point on it.

        Returns
        -------
        LightSample
            Weight and density include the choice.
        """
        return self._sample(p, uc, u0, u1, arena)

    def pdf_prim(self, prim, d, t, ng, arena):
        """Density with which `sample` would have drawn a ray that hits primitive `prim`.

        Parameters
        ----------
        prim : (N,) int
        d : (3, N)
            Unit direction of the ray.
        t : (N,)
            Distance from the point that is lit.
        ng : (3, N)
            Unit geometric normal of the primitive, either side.

        Returns
        -------
        (N,) float32
            Per solid angle, choice included; 0 for primitives that are never chosen.
        """
        pdf = arena.take(self._density, prim)
        with arena.frame():
            cosine = dot(d, ng, arena)
            np.abs(cosine, out=cosine)
            np.maximum(cosine, 1e-9, out=cosine)
            np.divide(pdf, cosine, out=pdf)
            np.multiply(pdf, t, out=pdf)
            np.multiply(pdf, t, out=pdf)
        return pdf

    def _triangle_density(self, prim_count):
        """Choice probability over area of each primitive, (P,); 0 for what is no emissive triangle."""
        density = np.zeros(prim_count, np.float64)
        for first, kind in zip(self._first, self.kinds, strict=True):
            if isinstance(kind, TriangleLights):
                density[kind.prim] = self.pmf[first : first + kind.count] / kind.area
        return density.astype(np.float32)

    def _sample_nothing(self, p, uc, u0, u1, arena):
        n = p.shape[-1]
        wi = arena.zeros((3, n))
        wi[2].fill(1)
        return LightSample(wi, arena.full(n, 1.0), arena.zeros((3, n)), arena.zeros(n))

    def _sample_only(self, p, uc, u0, u1, arena):
        return self.kinds[0].sample(0, p, u0, u1, arena)

    def _sample_one_kind(self, p, uc, u0, u1, arena):
        choice = self._choice.sample(uc, arena)
        return _chosen(self.kinds[0].sample(choice.index, p, u0, u1, arena), choice.pmf)

    def _sample_by_kind(self, p, uc, u0, u1, arena):
        n = p.shape[-1]
        out = LightSample(arena.empty((3, n)), arena.empty(n), arena.empty((3, n)), arena.empty(n))
        with arena.frame():
            choice = self._choice.sample(uc, arena)
            for first, kind in zip(self._first, self.kinds, strict=True):
                with arena.frame():
                    lanes = np.flatnonzero((choice.index >= first) & (choice.index < first + kind.count))
                    if lanes.size:
                        rows = 0 if kind.count == 1 else arena.take(choice.index, lanes) - first
                        chosen = (arena.take(a, lanes) for a in (p, u0, u1))
                        part = kind.sample(rows, *chosen, arena)
                        for whole, piece in zip(_components(out), _components(part), strict=True):
                            whole[lanes] = piece
            _chosen(out, choice.pmf)
        return out


def _components(sample):
    """All (N,) arrays of a sample; writing lanes of one after the other is twice as fast as of (3, N)."""
    return (*sample.wi, sample.distance, *sample.weight, sample.pdf)


def _chosen(sample, pmf):
    """`sample` given the light, with the probability of the choice, in place."""
    np.divide(sample.weight, pmf, out=sample.weight)
    np.multiply(sample.pdf, pmf, out=sample.pdf)
    return sample


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
