# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps whose shader nodes say something else in each direction, at each distance or at each of their points.

The program of a lamp gives what its light is multiplied with. It runs where light is sampled and where a scattered ray
meets the lamp; both tell it, as Cycles does, the bounces so far and the distance, but no kind of ray.
"""

from __future__ import annotations

import numpy as np

from ..arena import Arena
from .base import LightHits, rows_at, towards

_RECEIVERS = 1024  # points that a lamp's mean is taken over
_MOST_LANES = 1 << 18
_LEAST = 1e-3  # of its source's power that a lamp is chosen by, whatever its nodes say


class ShadedLights:
    """Lights of `source`, a kind of lamp, whose light is multiplied by a shader.

    Parameters
    ----------
    source : kind of light
    shader : callable
        ``shader(rows, p, wi, distance, arena, ray=None) -> (3, N)`` or what broadcasts to it: what the light of lamps
        `rows` towards points `p` (3, N), from where unit `wi` (3, N) and `distance` (N,) lead to the lamps, is
        multiplied with. Its `by_ray` is that of the kind, its `form` one of `core.lights.forms`.
    receivers : callable
        ``receivers(rng, count) -> (3, count, n)``, some n points that each of the lamps may light, about. The power by
        which lamps are chosen is the source's times the mean of what the nodes say towards them, a thousandth at least.
    """

    is_shaded = True

    def __init__(self, source, shader, receivers):
        self.source, self.shader = source, shader
        self.count, self.extended, self.at_infinity = source.count, source.extended, source.at_infinity
        self.by_ray = shader.by_ray
        self.power = source.power * self._means(receivers)

    def bounds(self):
        """Where the lights are, for their choice."""
        return self.source.bounds()

    def box(self):
        """Corners of bounding boxes, (3, count) each."""
        return self.source.box()

    def sample(self, rows, p, u0, u1, arena, ray=None):
        """As `source` samples, times what the nodes say."""
        sample = self.source.sample(rows, p, u0, u1, arena)
        with arena.frame():
            said = self.shader(rows, p, sample.wi, sample.distance, arena, ray)
            np.multiply(sample.weight, said, out=sample.weight)
        return sample

    def intersect(self, rows, o, d, tmin, tmax, arena, ray=None):
        """Rays that cross the source between `tmin` and `tmax`."""
        hits = self.source.intersect(rows, o, d, tmin, tmax, arena)
        n = hits.lanes.size
        radiance = arena.empty((3, n))
        if n == 0:
            return hits
        with arena.frame():
            rows, o, d = rows_at(rows, hits.lanes, arena), arena.take(o, hits.lanes), arena.take(d, hits.lanes)
            distance = self.source.reach(rows, o, d, arena)
            said = self.shader(rows, o, d, distance, arena, None if ray is None else ray.at(hits.lanes))
            np.multiply(hits.radiance, said, out=radiance)
        return LightHits(hits.lanes, radiance, hits.pdf)

    def towards_point(self, row, p, wi, distance, arena):
        """What lamp number `row` says to points `p` (3, N) on the whole: of several of its points the mean, (3, N)."""
        points = self.shader.form.mean_points(row)
        if points is None:
            return self.shader(row, p, wi, distance, arena)
        total = arena.zeros(p.shape)
        for point in points.T:
            with arena.frame():
                wi, distance = towards(p, point.reshape(3, 1), arena)
                np.add(total, self.shader(row, p, wi, distance, arena), out=total)
        return np.divide(total, points.shape[1], out=total)

    def _means(self, receivers):
        """Mean (count,) of what the nodes say, weighed by the light of the source."""
        rng, arena = np.random.default_rng(0), Arena()
        each = max(min(_RECEIVERS, _MOST_LANES // self.count), 1)
        rows = np.repeat(np.arange(self.count, dtype=np.int32), each)
        p = receivers(rng, each).reshape(3, -1).astype(np.float32)
        with arena.frame(), np.errstate(all="ignore"):
            sample = self.source.sample(rows, p, *rng.random((2, rows.size), np.float32), arena)
            light = np.abs(sample.weight).mean(axis=0, dtype=np.float64)
            if not self.at_infinity:
                light = light * np.square(sample.distance, dtype=np.float64)
            said = np.broadcast_to(self.shader(rows, p, sample.wi, sample.distance, arena), p.shape)
            said = np.abs(said).mean(axis=0, dtype=np.float64)
            light, said = light.reshape(-1, each), said.reshape(-1, each)
            good = np.isfinite(light) & np.isfinite(said)
            light, said = np.where(good, light, 0.0), np.where(good, said, 0.0)
            mean = (light * said).sum(axis=1) / light.sum(axis=1)
        return np.clip(np.nan_to_num(mean, nan=_LEAST), _LEAST, 1e6)
