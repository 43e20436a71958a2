# SPDX-License-Identifier: GPL-3.0-or-later
"""Suns: parallel light, and light from a disk of the sky."""

from __future__ import annotations

import math

import numpy as np

from ..sampling.warp import square_to_uniform_cone
from ..vecmath import frame, to_world
from .base import LightHits, LightSample, rows_at, rows_of
from .cap import cap_pdf, cap_weight, distance_to_axis


class SunLights:
    """Parallel light of `irradiance` (3, count) on a facing surface, from where `axis` (3, count), unit, points."""

    extended = False
    at_infinity = True

    def __init__(self, axis, irradiance):
        self.axis = np.ascontiguousarray(axis, np.float32)
        self.irradiance = np.ascontiguousarray(irradiance, np.float32)
        self.count = self.axis.shape[1]
        self.power = np.abs(np.asarray(irradiance, np.float64)).mean(axis=0)

    def sample(self, rows, p, u0, u1, arena):
        """The direction to the sun; the weight is its irradiance."""
        n = p.shape[-1]
        wi, weight = arena.empty((3, n)), arena.empty((3, n))
        with arena.frame():
            np.copyto(wi, rows_of(self.axis, rows, arena))
            np.copyto(weight, rows_of(self.irradiance, rows, arena))
        return LightSample(wi, arena.full(n, math.inf), weight, arena.full(n, math.inf))


class SunDisks:
    """Disks of the sky of constant `radiance` (3, count) around `axis` (3, count), of full `angle` (count,), rad."""

    extended = True
    at_infinity = True

    def __init__(self, axis, angle, radiance):
        self.axis = np.ascontiguousarray(axis, np.float32)
        self.cap = (2.0 * np.sin(np.asarray(angle, np.float64) / 4.0) ** 2).astype(np.float32)
        self.radiance = np.ascontiguousarray(radiance, np.float32)
        self.count = self.axis.shape[1]
        sine = np.sin(0.5 * np.asarray(angle, np.float64))
        self.power = math.pi * sine**2 * np.abs(np.asarray(radiance, np.float64)).mean(axis=0)

    def sample(self, rows, p, u0, u1, arena):
        """A direction uniformly within the disk."""
        n = p.shape[-1]
        wi = arena.empty((3, n))
        cap = rows_of(self.cap, rows, arena)
        weight = cap_weight(rows_of(self.radiance, rows, arena), cap, arena, n)
        with arena.frame():
            axis = rows_of(self.axis, rows, arena)
            s, t = frame(axis, arena)
            np.copyto(wi, to_world(square_to_uniform_cone(u0, u1, cap, arena), s, t, axis, arena))
        return LightSample(wi, arena.full(n, math.inf), weight, cap_pdf(cap, arena, n))

    def intersect(self, rows, o, d, tmin, tmax, arena):
        """Rays that go to infinity within the disk."""
        with arena.frame():
            hit = distance_to_axis(d, rows_of(self.axis, rows, arena), arena) <= rows_of(self.cap, rows, arena)
            hit &= np.isinf(tmax)
            lanes = np.flatnonzero(hit)
        rows = rows_at(rows, lanes, arena)
        pdf = cap_pdf(rows_of(self.cap, rows, arena), arena, lanes.size)
        return LightHits(lanes, rows_of(self.radiance, rows, arena), pdf)

    def reach(self, rows, o, d, arena):
        """Distance (N,) at which rays that cross the disk do."""
        return arena.full(d.shape[-1], math.inf)
