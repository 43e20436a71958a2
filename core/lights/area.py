# SPDX-License-Identifier: GPL-3.0-or-later
"""Area lights: one-sided rectangles and ellipses of constant radiance."""

from __future__ import annotations

import math

import numpy as np

from ..sampling.warp import square_to_uniform_disk_concentric
from ..vecmath import dot
from .base import NEAREST_SQUARED, LightHits, LightSample, normalize_length, rows_at, rows_of
from .rectangle import project, sample_rectangle, solid_angle

# Below this solid angle (sr) float32 loses it among the four angles, and points uniform on the area do as well.
SMALLEST_SOLID_ANGLE = 0.01
_NARROWEST = 0.01  # rad; float32 cosines do not resolve much narrower spreads


class AreaLights:
    """Rectangles, or the ellipses inscribed in them.

    With a *spread* the radiance depends on the angle a from the normal, as (t - tan a)/(t - spread/2) with
    t = tan(spread/2), and is 0 beyond spread/2. That keeps the power; π is constant radiance. So does Blender.

    A light that fills a good part of the view is sampled by solid angle over the rectangle, an ellipse by rejecting
    what falls beside it; one that looks small, by area.

    Parameters
    ----------
    center, x, y, normal : (3, count)
        `x`, `y`, `normal` are orthonormal; the light shines to the side where `normal` points.
    half : (2, count)
        Half the side lengths along `x` and `y`.
    round_ : (count,) bool
        Which are ellipses.
    radiance : (3, count)
        Of spread π.
    spread : (count,)
        Full angle, rad.
    """

    extended = True
    at_infinity = False

    def __init__(self, center, x, y, normal, half, round_, radiance, spread):
        self._frame = np.ascontiguousarray(np.concatenate([center, x, y, normal, half]), np.float32)
        half = np.asarray(half, np.float64)
        area = half[0] * half[1] * np.where(round_, math.pi, 4.0)
        self._area = area.astype(np.float32)
        self._round = np.ascontiguousarray(round_, bool)
        self._any_round = bool(np.any(round_))
        self.radiance = np.ascontiguousarray(radiance, np.float32)
        self._spread = spread_terms(np.asarray(spread, np.float64)).astype(np.float32)
        self._any_spread = bool(np.any(self._spread[1]))
        self.count = self._area.size
        self.power = math.pi * area * np.abs(np.asarray(radiance, np.float64)).mean(axis=0)

    def sample(self, rows, p, u0, u1, arena):
        """A direction to a point of the light; weight 0 behind it and beside an ellipse."""
        n = p.shape[-1]
        wi, distance, weight, pdf = arena.empty((3, n)), arena.empty(n), arena.empty((3, n)), arena.empty(n)
        with arena.frame():
            frame = rows_of(self._frame, rows, arena)
            edges, height = project(frame, p, arena)
            angle = solid_angle(edges, height, arena)
            near = np.flatnonzero(np.greater(angle, SMALLEST_SOLID_ANGLE, out=arena.empty(n, bool)))
            if near.size == n:
                x, y = sample_rectangle(edges, height, angle, u0, u1, arena)
            else:
                x, y = self._area_point(rows, edges, u0, u1, arena)
                taken = (arena.take(a, near) for a in (edges, height, angle, u0, u1))
                x[near], y[near] = sample_rectangle(*taken, arena)
            _direction(frame, x, y, height, wi, distance, arena)
            self._density(rows, frame, wi, distance, angle, pdf, arena)
            lit = np.greater(height, 0.0, out=arena.empty(n, bool))
            if self._any_round:
                lit &= self._covers(rows, frame, edges, x, y, arena)
            np.divide(rows_of(self.radiance, rows, arena), pdf, out=weight)
            np.multiply(weight, lit, out=weight)
            if self._any_spread:
                np.multiply(weight, self.attenuation(rows, wi, arena), out=weight)
        return LightSample(wi, distance, weight, pdf)

    def intersect(self, rows, o, d, tmin, tmax, arena):
        """Rays that cross the light from its front between `tmin` and `tmax`."""
        with arena.frame():
            n = o.shape[-1]
            frame = rows_of(self._frame, rows, arena)
            edges, height = project(frame, o, arena)
            cosine, t = dot(frame[9:12], d, arena), arena.empty(n)
            np.negative(cosine, out=cosine)
            hit = (cosine > 0.0) & (height > 0.0)
            np.divide(height, np.maximum(cosine, 1e-12, out=cosine), out=t)
            x, y = dot(frame[3:6], d, arena), dot(frame[6:9], d, arena)
            np.multiply(x, t, out=x)
            np.multiply(y, t, out=y)
            hit &= (x >= edges[0]) & (x <= edges[1]) & (y >= edges[2]) & (y <= edges[3])
            hit &= (t > tmin) & (t < tmax)
            if self._any_round:
                hit &= self._covers(rows, frame, edges, x, y, arena)
            lanes = np.flatnonzero(hit)
            distance = t[lanes]
        rows = rows_at(rows, lanes, arena)
        pdf = arena.empty(lanes.size)
        with arena.frame():
            frame = rows_of(self._frame, rows, arena)
            edges, height = project(frame, arena.take(o, lanes), arena)
            angle = solid_angle(edges, height, arena)
            d = arena.take(d, lanes)
            self._density(rows, frame, d, distance, angle, pdf, arena)
        radiance = rows_of(self.radiance, rows, arena)
        if self._any_spread:
            radiance = np.multiply(radiance, self.attenuation(rows, d, arena), out=arena.empty((3, lanes.size)))
        return LightHits(lanes, radiance, pdf)

    def attenuation(self, rows, wi, arena):
        """Radiance against `wi` over that of spread π, (N,)."""
        out = arena.empty(wi.shape[-1])
        normal, spread = rows_of(self._frame[9:12], rows, arena), rows_of(self._spread, rows, arena)
        with arena.frame():
            cosine = dot(normal, wi, arena)
            np.multiply(cosine, cosine, out=out)
            np.subtract(1.0, out, out=out)
            np.sqrt(np.maximum(out, 0.0, out=out), out=out)
            np.maximum(np.negative(cosine, out=cosine), 1e-6, out=cosine)
            np.divide(out, cosine, out=out)  # the tangent
            np.multiply(out, spread[1], out=out)
            np.subtract(spread[0], out, out=out)
            np.maximum(out, 0.0, out=out)
        return out

    def _area_point(self, rows, edges, u0, u1, arena):
        """Points uniform on the lights, (N,) and (N,), relative to the point lit, along `x` and `y`."""
        n = u0.shape[-1]
        point = arena.empty((2, n))
        with arena.frame():
            np.subtract(np.multiply(u0, 2.0, out=point[0]), 1.0, out=point[0])
            np.subtract(np.multiply(u1, 2.0, out=point[1]), 1.0, out=point[1])
            if self._any_round:
                disk = square_to_uniform_disk_concentric(u0, u1, arena)
                np.copyto(point, disk, where=rows_of(self._round, rows, arena))
            middle, half = arena.empty(n), arena.empty(n)
            for i, (low, high) in enumerate((edges[:2], edges[2:])):
                np.multiply(np.subtract(high, low, out=half), 0.5, out=half)
                np.multiply(np.add(high, low, out=middle), 0.5, out=middle)
                np.multiply(point[i], half, out=point[i])
                np.add(point[i], middle, out=point[i])
        return point[0], point[1]

    def _covers(self, rows, frame, edges, x, y, arena):
        """Whether points of the rectangle belong to the light, (N,) bool: not the corners beside an ellipse."""
        with arena.frame():
            n = x.shape[-1]
            reach, s = arena.zeros(n), arena.empty(n)
            for i, v in enumerate((x, y)):
                np.add(edges[2 * i], edges[2 * i + 1], out=s)
                np.multiply(s, -0.5, out=s)
                np.add(s, v, out=s)
                np.divide(s, frame[12 + i], out=s)
                np.multiply(s, s, out=s)
                np.add(reach, s, out=reach)
            return (reach <= 1.0 + 1e-5) | ~rows_of(self._round, rows, arena)

    def _density(self, rows, frame, wi, distance, angle, out, arena):
        """Solid-angle density of `wi`: 1/Ω of lights that look large, else distance²/(area·cosθ)."""
        with arena.frame():
            scale = dot(frame[9:12], wi, arena)
            np.negative(scale, out=scale)
            np.maximum(scale, 1e-12, out=scale)
            np.multiply(scale, rows_of(self._area, rows, arena), out=scale)
            np.multiply(distance, distance, out=out)
            np.maximum(out, NEAREST_SQUARED, out=out)
            np.divide(out, scale, out=out)
            near = np.greater(angle, SMALLEST_SOLID_ANGLE, out=arena.empty(out.shape, bool))
            np.divide(1.0, angle, out=out, where=near)


def spread_terms(spread):
    """The attenuation's value on the normal and its slope in tan a, (2, count)."""
    half = 0.5 * np.clip(spread, _NARROWEST, math.pi - 1e-6)
    slope = 1.0 / (np.tan(half) - half)
    wide = spread > math.pi - 1e-3
    return np.stack([np.where(wide, 1.0, np.tan(half) * slope), np.where(wide, 0.0, slope)])


def _direction(frame, x, y, height, wi, distance, arena):
    """Unit vectors `wi` to the points `x`, `y` of the light's plane, `height` behind its normal, and their distance."""
    with arena.frame():
        t = arena.empty(x.shape)
        for i in range(3):
            np.multiply(frame[3 + i], x, out=wi[i])
            np.add(wi[i], np.multiply(frame[6 + i], y, out=t), out=wi[i])
            np.subtract(wi[i], np.multiply(frame[9 + i], height, out=t), out=wi[i])
    normalize_length(wi, distance, arena)
