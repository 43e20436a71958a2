# SPDX-License-Identifier: GPL-3.0-or-later
"""Area lights: one-sided rectangles and ellipses of constant radiance."""

from __future__ import annotations

import math

import numpy as np

from ..limits import at_least
from ..vecmath import dot
from .base import Bounds, LightHits, LightSample, rows_at, rows_of
from .rectangle import Rectangles

_NARROWEST = 0.01  # rad; float32 cosines do not resolve much narrower spreads
_TINY = 1e-36  # keeps densities finite


class AreaLights:
    """Rectangles, or the ellipses inscribed in them.

    With a *spread* the radiance depends on the angle a from the normal, as (t - tan a)/(t - spread/2) with
    t = tan(spread/2), and is 0 beyond spread/2. That keeps the power; π is constant radiance. So does Blender.

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
        self._shapes = Rectangles(center, x, y, normal, half, round_)
        self._normal = self._shapes.frame[9:12]
        self.radiance = np.ascontiguousarray(radiance, np.float32)
        self._spread = spread_terms(np.asarray(spread, np.float64)).astype(np.float32)
        self._any_spread = bool(np.any(self._spread[1]))
        self.count = self._shapes.count
        self.power = math.pi * self._shapes.area * np.abs(np.asarray(radiance, np.float64)).mean(axis=0)

    def bounds(self):
        """Where the lights are, for their choice."""
        return Bounds(self._shapes.frame[0:3], self._shapes.spread, self._normal)

    def box(self):
        """Corners of bounding boxes, (3, count) each."""
        return self._shapes.box()

    def sample(self, rows, p, u0, u1, arena):
        """A direction to a point of the light; weight 0 behind it and beside an ellipse."""
        weight, pdf = arena.empty(p.shape), arena.empty(p.shape[-1])
        wi, distance, inverse = self._shapes.sample(rows, p, u0, u1, arena)
        with arena.frame():
            np.divide(1.0, at_least(inverse, _TINY, pdf), out=pdf)
            if self._any_spread:
                np.multiply(inverse, self.attenuation(rows, wi, arena), out=inverse)
            np.multiply(rows_of(self.radiance, rows, arena), inverse, out=weight)
        return LightSample(wi, distance, weight, pdf)

    def intersect(self, rows, o, d, tmin, tmax, arena):
        """Rays that cross the light from its front between `tmin` and `tmax`."""
        lanes, distance = self._shapes.crossed(rows, o, d, arena)
        between = (distance > (tmin if np.isscalar(tmin) else tmin[lanes])) & (distance < tmax[lanes])
        lanes, distance = lanes[between], distance[between]
        rows = rows_at(rows, lanes, arena)
        d = arena.take(d, lanes)
        pdf = self._shapes.inverse_density(rows, arena.take(o, lanes), d, distance, arena)
        np.divide(1.0, at_least(pdf, _TINY, pdf), out=pdf)
        radiance = rows_of(self.radiance, rows, arena)
        if self._any_spread:
            radiance = np.multiply(radiance, self.attenuation(rows, d, arena), out=arena.empty((3, lanes.size)))
        return LightHits(lanes, radiance, pdf)

    @property
    def frame(self):
        """Centre, axes, normal and half the side lengths, (14, count)."""
        return self._shapes.frame

    def reach(self, rows, o, d, arena):
        """Distance (N,) at which rays that cross the light do."""
        distance = arena.empty(d.shape[-1])
        with arena.frame():
            normal = rows_of(self._normal, rows, arena)
            offset = np.subtract(rows_of(self.frame[0:3], rows, arena), o, out=arena.empty(o.shape))
            np.divide(dot(normal, offset, arena), dot(normal, d, arena), out=distance)
        return distance

    def attenuation(self, rows, wi, arena):
        """Radiance against `wi` over that of spread π, (N,)."""
        out = arena.empty(wi.shape[-1])
        normal, spread = rows_of(self._normal, rows, arena), rows_of(self._spread, rows, arena)
        with arena.frame():
            cosine = dot(normal, wi, arena)
            np.multiply(cosine, cosine, out=out)
            np.subtract(1.0, out, out=out)
            np.sqrt(at_least(out, 0.0, out), out=out)
            at_least(np.negative(cosine, out=cosine), 1e-6, cosine)
            np.divide(out, cosine, out=out)  # the tangent
            np.multiply(out, spread[1], out=out)
            np.subtract(spread[0], out, out=out)
            at_least(out, 0.0, out)
        return out


def spread_terms(spread):
    """The attenuation's value on the normal and its slope in tan a, (2, count)."""
    half = 0.5 * np.clip(spread, _NARROWEST, math.pi - 1e-6)
    slope = 1.0 / (np.tan(half) - half)
    wide = spread > math.pi - 1e-3
    return np.stack([np.where(wide, 1.0, np.tan(half) * slope), np.where(wide, 0.0, slope)])
