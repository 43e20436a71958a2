# SPDX-License-Identifier: GPL-3.0-or-later
"""Spot lights: a point light of any sort, seen through a cone."""

from __future__ import annotations

import numpy as np

from ..limits import within
from .base import LightHits, rows_at, rows_of
from .cap import distance_to_axis

_SHARPEST = 1e6  # stands for 1/blend where the edge is sharp


class SpotLights:
    """Lights of `source` (`PointLights`, `SphereLights` or `DiskLights`) behind cones.

    With c the cosine between the axis and the ray that leaves, c0 that of half the angle, the light is multiplied by
    smoothstep((c - c0)/((1 - c0)·blend)) and not renormalised, as Blender does. Cosines are taken from 1, so that
    narrow cones keep their edge.

    Parameters
    ----------
    direction : (3, count) where the axes point, unit
    angle : (count,) full angle of the cones, rad
    blend : (count,) in [0, 1]
    """

    at_infinity = False

    def __init__(self, source, direction, angle, blend):
        self.source = source
        self.count = source.count
        self._backward = np.ascontiguousarray(-np.asarray(direction), np.float32)
        range_ = 2.0 * np.sin(np.asarray(angle, np.float64) / 4.0) ** 2  # 1 - c0
        blend = np.asarray(blend, np.float64)
        self._per_range = (1.0 / range_).astype(np.float32)
        self._per_blend = (1.0 / np.maximum(blend, 1.0 / _SHARPEST)).astype(np.float32)
        self.power = source.power * 0.5 * range_ * (1.0 - 0.5 * blend)
        self.extended = source.extended

    def bounds(self):
        """Where the lights are, for their choice: a cone shines to one side at most."""
        return self.source.bounds()._replace(axis=-self._backward)

    def box(self):
        """Corners of bounding boxes, (3, count) each."""
        return self.source.box()

    def sample(self, rows, p, u0, u1, arena):
        """As `source` samples, dimmed by the cone."""
        sample = self.source.sample(rows, p, u0, u1, arena)
        with arena.frame():
            np.multiply(sample.weight, self.attenuation(rows, sample.wi, arena), out=sample.weight)
        return sample

    def attenuation(self, rows, wi, arena):
        """Share of the light that leaves against `wi`, (N,)."""
        x = distance_to_axis(wi, rows_of(self._backward, rows, arena), arena)
        with arena.frame():
            np.multiply(x, rows_of(self._per_range, rows, arena), out=x)
            np.subtract(1.0, x, out=x)
            np.multiply(x, rows_of(self._per_blend, rows, arena), out=x)
            within(x, 0.0, 1.0, x)
            slope = np.multiply(x, -2.0, out=arena.empty(x.shape))
            np.add(slope, 3.0, out=slope)
            np.multiply(slope, x, out=slope)
            np.multiply(slope, x, out=x)
        return x

    def reach(self, rows, o, d, arena):
        """Distance (N,) at which rays that cross the source do."""
        return self.source.reach(rows, o, d, arena)

    def intersect(self, rows, o, d, tmin, tmax, arena):
        """Rays that cross the source between `tmin` and `tmax`."""
        hits = self.source.intersect(rows, o, d, tmin, tmax, arena)
        radiance = arena.empty((3, hits.lanes.size))
        with arena.frame():
            dimmed = self.attenuation(rows_at(rows, hits.lanes, arena), arena.take(d, hits.lanes), arena)
            np.multiply(hits.radiance, dimmed, out=radiance)
        return LightHits(hits.lanes, radiance, hits.pdf)
