# SPDX-License-Identifier: GPL-3.0-or-later
"""Choice of a light and of a direction to it."""

from __future__ import annotations

import numpy as np

from .base import LightSample
from .choice import choice_of


class LightSampler:
    """Samples the light of a scene, one light a lane.

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
    shadowless : (count,) bool, optional
        Lights that shine through everything: their samples get distance 0.

    Attributes
    ----------
    count : int
        Number of lights that can be chosen. With 0 every sample has weight 0.
    pmf : (count,) float32
        Share of all importance: the probability of the choice of lights at infinity. That of the others, `pmf_at`,
        depends on the point.
    has_shadowless : bool
    tells_lights : bool
        Whether samples carry the numbers of their lights.
    """

    tells_lights = False

    def __init__(self, kinds, importance, prim_count, environment, shadowless=None):
        self.kinds = tuple(kinds)
        self.environment = environment
        counts = [k.count for k in self.kinds]
        self.count = sum(counts)
        self._first = [sum(counts[:i]) for i in range(len(counts))]
        importance = np.asarray(importance, np.float64)
        self.pmf = (importance / importance.sum()).astype(np.float32) if self.count else np.zeros(0, np.float32)
        self._choice = choice_of(self.kinds, importance) if self.count > 1 else None
        self.has_shadowless = shadowless is not None and any(shadowless)
        self._shadowless = np.asarray(shadowless, bool) if self.has_shadowless else None
        self._surfaces = [
            (first, kind) for first, kind in zip(self._first, self.kinds, strict=True) if hasattr(kind, "density")
        ]
        self._light_of_prim = np.full(prim_count, -1, np.int32)
        for first, kind in self._surfaces:
            self._light_of_prim[kind.prim] = np.arange(first, first + kind.count)
        if self.count == 0:
            self._sample = self._sample_nothing
        elif self.count == 1:
            self._sample = self._sample_only
        elif len(self.kinds) == 1:
            self._sample = self._sample_one_kind
        else:
            self._sample = self._sample_by_kind

    def adopt(self, prim, twin):
        """Let primitives `prim` (n,) count as the lights of the primitives `twin` (n,), in whose places they are."""
        self._light_of_prim[prim] = self._light_of_prim[twin]

    def sample(self, p, uc, u0, u1, arena, ray=None):
        """A direction towards some light.

        Parameters
        ----------
        p : (3, N) float32
            Points that are lit.
        uc, u0, u1 : (N,) float32
            In [0, 1): choice of the light, and of a point on it.
        ray : Ray, optional
            What the shaders of lights are told of the rays; None where none asks.

        Returns
        -------
        LightSample
            Weight and density include the choice.
        """
        return self._sample(p, uc, u0, u1, arena, ray)

    def pmf_at(self, light, p, arena):
        """Probability (N,) or (1,) of the choice of `light`, a number or (N,), at the points `p` (3, N)."""
        if self._choice is None:
            return arena.full(1, 1.0)
        return self._choice.pmf(light, p, arena)

    def is_sampled(self, prim):
        """Whether the primitives `prim` (N,) can be chosen."""
        return self._light_of_prim[prim] >= 0

    def pdf_prim(self, prim, p, d, t, arena):
        """Density with which `sample` would have drawn a ray that hits primitive `prim`.

        Parameters
        ----------
        prim : (N,) int
        p : (3, N)
            Point that is lit, where the ray starts.
        d : (3, N)
            Unit direction of the ray.
        t : (N,)
            Distance from `p`.

        Returns
        -------
        (N,) float32
            Per solid angle, choice included; 0 for primitives that are never chosen.
        """
        pdf = arena.zeros(prim.size)
        with arena.frame():
            light = arena.take(self._light_of_prim, prim)
            for first, kind in self._surfaces:
                with arena.frame():
                    lanes = np.flatnonzero((light >= first) & (light < first + kind.count))
                    if lanes.size:
                        own, at, wi, distance = (arena.take(a, lanes) for a in (light, p, d, t))
                        rows = 0 if kind.count == 1 else own - first
                        density = kind.density(rows, at, wi, distance, arena)
                        pdf[lanes] = np.multiply(density, self.pmf_at(own, at, arena), out=density)
        return pdf

    def _sample_nothing(self, p, uc, u0, u1, arena, ray):
        n = p.shape[-1]
        wi = arena.zeros((3, n))
        wi[2].fill(1)
        return LightSample(wi, arena.full(n, 1.0), arena.zeros((3, n)), arena.zeros(n))

    def _sample_only(self, p, uc, u0, u1, arena, ray):
        return self._unshadowed(_of_kind(self.kinds[0], 0, p, u0, u1, arena, ray), 0)

    def _sample_one_kind(self, p, uc, u0, u1, arena, ray):
        choice = self._choice.sample(p, uc, arena)
        sample = _of_kind(self.kinds[0], choice.index, p, u0, u1, arena, ray)
        return self._unshadowed(_chosen(sample, choice.pmf), choice.index)

    def _sample_by_kind(self, p, uc, u0, u1, arena, ray):
        n = p.shape[-1]
        out = LightSample(arena.empty((3, n)), arena.empty(n), arena.empty((3, n)), arena.empty(n))
        with arena.frame():
            choice = self._choice.sample(p, uc, arena)
            for first, kind in zip(self._first, self.kinds, strict=True):
                with arena.frame():
                    lanes = np.flatnonzero((choice.index >= first) & (choice.index < first + kind.count))
                    if lanes.size:
                        rows = 0 if kind.count == 1 else arena.take(choice.index, lanes) - first
                        chosen = (arena.take(a, lanes) for a in (p, u0, u1))
                        part = _of_kind(kind, rows, *chosen, arena, None if ray is None else ray.at(lanes))
                        for whole, piece in zip(_components(out), _components(part), strict=True):
                            whole[lanes] = piece
            _chosen(out, choice.pmf)
            return self._unshadowed(out, choice.index)

    def _unshadowed(self, sample, light):
        """`sample` of the lights `light`, one or (N,): what is at distance 0 stands in no shadow."""
        if self._shadowless is not None:
            np.copyto(sample.distance, 0.0, where=self._shadowless[light])
        if self.tells_lights:
            sample = sample._replace(light=np.broadcast_to(light, sample.pdf.shape).copy())
        return sample


def _of_kind(kind, rows, p, u0, u1, arena, ray):
    """A direction towards lights `rows` of `kind`."""
    if ray is not None and getattr(kind, "is_shaded", False):
        return kind.sample(rows, p, u0, u1, arena, ray)
    return kind.sample(rows, p, u0, u1, arena)


def _components(sample):
    """All (N,) arrays of a sample; writing lanes of one after the other is twice as fast as of (3, N)."""
    return (*sample.wi, sample.distance, *sample.weight, sample.pdf)


def _chosen(sample, pmf):
    """`sample` given the light, with the probability of the choice, in place."""
    np.divide(sample.weight, pmf, out=sample.weight)
    np.multiply(sample.pdf, pmf, out=sample.pdf)
    return sample
