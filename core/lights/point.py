# SPDX-License-Identifier: GPL-3.0-or-later
"""Point lights: without extent, as spheres, and as disks that turn to whoever looks."""

from __future__ import annotations

import math

import numpy as np

from ..limits import at_least
from ..vecmath import dot
from .base import NEAREST_SQUARED, Bounds, LightHits, LightSample, rows_at, rows_of, towards
from .cap import SMALLEST_CAP, cap_pdf, cap_weight, distance_to_axis, sample_cap


class PointLights:
    """Points of radiant `intensity` (3, count), W/sr, at `position` (3, count)."""

    extended = False
    at_infinity = False

    def __init__(self, position, intensity):
        self.position = np.ascontiguousarray(position, np.float32)
        self.intensity = np.ascontiguousarray(intensity, np.float32)
        self.count = self.position.shape[1]
        self.power = 4.0 * math.pi * np.abs(np.asarray(intensity, np.float64)).mean(axis=0)

    def bounds(self):
        """Where the lights are, for their choice."""
        return Bounds(self.position, np.zeros(self.count))

    def sample(self, rows, p, u0, u1, arena):
        """The direction to the point; the weight is I/d²."""
        n = p.shape[-1]
        weight, pdf = arena.empty((3, n)), arena.full(n, math.inf)
        wi, distance = towards(p, rows_of(self.position, rows, arena), arena)
        with arena.frame():
            squared = arena.empty(n)
            np.multiply(distance, distance, out=squared)
            at_least(squared, NEAREST_SQUARED, squared)
            np.divide(rows_of(self.intensity, rows, arena), squared, out=weight)
        return LightSample(wi, distance, weight, pdf)


class _RoundLights:
    """Lights seen as a cap of directions around their centre; `radius` (count,), `radiance` (3, count)."""

    extended = True
    at_infinity = False

    def __init__(self, position, radius, radiance):
        self.position = np.ascontiguousarray(position, np.float32)
        self.radius = np.ascontiguousarray(radius, np.float32)
        self.radiance = np.ascontiguousarray(radiance, np.float32)
        self.count = self.position.shape[1]
        surface = 4.0 * math.pi * np.asarray(radius, np.float64) ** 2
        self.power = math.pi * surface * np.abs(np.asarray(radiance, np.float64)).mean(axis=0)

    def bounds(self):
        """Where the lights are, for their choice."""
        return Bounds(self.position, np.asarray(self.radius, np.float64) ** 2)

    def box(self):
        """Corners of bounding boxes, (3, count) each."""
        return self.position - self.radius, self.position + self.radius

    def sample(self, rows, p, u0, u1, arena):
        """A direction uniformly within the cap."""
        n = p.shape[-1]
        axis, distance = towards(p, rows_of(self.position, rows, arena), arena)
        radius = rows_of(self.radius, rows, arena)
        cap = self._cap(distance, radius, arena)
        wi = sample_cap(axis, cap, u0, u1, arena)
        weight = cap_weight(rows_of(self.radiance, rows, arena), cap, arena, n)
        pdf = cap_pdf(cap, arena, n)
        with arena.frame():
            lowered = np.multiply(u0, cap, out=arena.empty(n))  # 1 - cosθ
            self._surface(distance, radius, lowered, arena)
        return LightSample(wi, distance, weight, pdf)

    def intersect(self, rows, o, d, tmin, tmax, arena):
        """Rays that cross the light between `tmin` and `tmax`."""
        with arena.frame():
            hit, distance = self._crosses(rows, o, d, tmin, tmax, arena)
            lanes = np.flatnonzero(hit)
            distances = distance[lanes]
        rows = rows_at(rows, lanes, arena)
        cap = self._cap(distances, rows_of(self.radius, rows, arena), arena)
        return LightHits(lanes, rows_of(self.radiance, rows, arena), cap_pdf(cap, arena, lanes.size))

    def reach(self, rows, o, d, arena):
        """Distance (N,) at which rays that cross the light do."""
        axis, distance = towards(o, rows_of(self.position, rows, arena), arena)
        with arena.frame():
            lowered = distance_to_axis(d, axis, arena)
            self._surface(distance, rows_of(self.radius, rows, arena), lowered, arena)
        return distance


class SphereLights(_RoundLights):
    """Spheres that emit on both sides.

    Source: uniform sampling of the visible cap, Wang, "Physically Correct Direct Lighting for Distribution Ray
    Tracing", Graphics Gems III, 1992; from inside, every direction.
    """

    def _cap(self, distance, radius, arena):
        """s²/(1 + c) with s = r/d; 2, the whole sphere, from inside."""
        cap = arena.empty(distance.shape)
        with arena.frame():
            cosine = arena.empty(distance.shape)
            np.maximum(distance, radius, out=cosine)
            np.divide(radius, at_least(cosine, 1e-30, cosine), out=cap)
            np.multiply(cap, cap, out=cap)
            np.subtract(1.0, cap, out=cosine)
            np.sqrt(cosine, out=cosine)
            np.add(cosine, 1.0, out=cosine)
            np.divide(cap, cosine, out=cap)
            at_least(cap, SMALLEST_CAP, cap)
            inside = np.less_equal(distance, radius, out=arena.empty(distance.shape, bool))
            np.copyto(cap, 2.0, where=inside)
        return cap

    def _surface(self, distance, radius, lowered, arena):
        """Turn `distance` to the centre into that to the sphere, along directions of cosine 1 - `lowered`."""
        n = distance.shape[-1]
        with arena.frame():
            half_chord, along = arena.empty(n), arena.empty(n)
            np.subtract(2.0, lowered, out=half_chord)
            np.multiply(half_chord, lowered, out=half_chord)  # sin²θ
            np.multiply(half_chord, distance, out=half_chord)
            np.multiply(half_chord, distance, out=half_chord)
            np.multiply(radius, radius, out=along[: radius.shape[-1]])
            np.subtract(along[: radius.shape[-1]], half_chord, out=half_chord)
            at_least(half_chord, 0.0, half_chord)
            np.sqrt(half_chord, out=half_chord)
            outside = np.greater(distance, radius, out=arena.empty(n, bool))
            np.negative(half_chord, out=half_chord, where=outside)
            np.subtract(1.0, lowered, out=along)
            np.multiply(along, distance, out=along)
            np.add(along, half_chord, out=distance)
            at_least(distance, 0.0, distance)

    def _crosses(self, rows, o, d, tmin, tmax, arena):
        """Whether rays cross the sphere in between, (N,) bool, and their origins' distance to the centre, (N,).

        The discriminant is taken at the point of the ray nearest the centre. Source: Haines et al., "Precision
        Improvements for Ray/Sphere Intersection", Ray Tracing Gems, 2019.
        """
        n = o.shape[-1]
        offset = np.subtract(rows_of(self.position, rows, arena), o, out=arena.empty((3, n)))
        radius = rows_of(self.radius, rows, arena)
        distance, along, chord = dot(offset, offset, arena), dot(offset, d, arena), arena.empty(n)
        np.sqrt(distance, out=distance)
        for i in range(3):
            np.multiply(d[i], along, out=chord)
            np.subtract(offset[i], chord, out=offset[i])
        dot(offset, offset, arena, out=chord)
        np.subtract(radius * radius, chord, out=chord)
        hit = np.greater_equal(chord, 0.0)
        at_least(chord, 0.0, chord)
        np.sqrt(chord, out=chord)
        np.negative(chord, out=chord, where=distance > radius)
        np.add(along, chord, out=along)
        hit &= along > tmin
        hit &= along < tmax
        return hit, distance


class DiskLights(_RoundLights):
    """Disks that face the point they light: Blender's soft falloff. Below the centre E = I/(d² + r²).

    From its axis a disk is a cap of directions too, so it is sampled by solid angle.
    """

    def _cap(self, distance, radius, arena):
        """s²/(1 + c) with s² = r²/(d² + r²)."""
        cap = arena.empty(distance.shape)
        with arena.frame():
            slant, cosine = arena.empty(distance.shape), arena.empty(distance.shape)
            np.hypot(distance, radius, out=slant)
            at_least(slant, 1e-30, slant)
            np.divide(radius, slant, out=cap)
            np.multiply(cap, cap, out=cap)
            np.divide(distance, slant, out=cosine)
            np.add(cosine, 1.0, out=cosine)
            np.divide(cap, cosine, out=cap)
            at_least(cap, SMALLEST_CAP, cap)
        return cap

    def _surface(self, distance, radius, lowered, arena):
        """Turn `distance` to the centre into that to the disk, along directions of cosine 1 - `lowered`."""
        with arena.frame():
            cosine = np.subtract(1.0, lowered, out=arena.empty(distance.shape))
            at_least(cosine, 1e-6, cosine)
            np.divide(distance, cosine, out=distance)

    def _crosses(self, rows, o, d, tmin, tmax, arena):
        """Whether rays cross the disk in between, (N,) bool, and their origins' distance to the centre, (N,)."""
        n = o.shape[-1]
        axis, distance = towards(o, rows_of(self.position, rows, arena), arena)
        radius = rows_of(self.radius, rows, arena)
        cosine, t, reach = dot(axis, d, arena), arena.empty(n), arena.empty(n)
        hit = np.greater(cosine, 0.0)
        at_least(cosine, 1e-6, cosine)
        np.divide(distance, cosine, out=t)
        for i in range(3):  # d/cosθ - axis, the point of a disk at distance 1
            np.divide(d[i], cosine, out=reach)
            np.subtract(reach, axis[i], out=axis[i])
        dot(axis, axis, arena, out=reach)
        np.sqrt(reach, out=reach)
        np.multiply(reach, distance, out=reach)
        hit &= reach <= radius
        hit &= (t > tmin) & (t < tmax)
        return hit, distance
