# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps as their shader nodes see them, where a ray meets them.

Positions, normals and UV coordinates, measured in Cycles 5.0. With w from the lamp to the point that is lit, and l the
same in the lamp's own space (not of unit length where the lamp is scaled):

| lamp | position | normal | UV |
| --- | --- | --- | --- |
| point | on its surface | w; of a ball, its own | the normal in the lamp's space, by longitude and latitude |
| spot | likewise | likewise | 1/2 + c·(lx, ly)/(-lz), c = 1/2·cot(angle/2): the cone's square is 0 to 1 |
| area | on its surface | its own | over its sides, also where it is round |
| sun | w, as a point of the world | w | 1/2 - (lx, ly)/(4·sin(angle/4)·cos(θ/2)), θ to its axis; 1/2 of angle 0 |
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..spaces import transform_direction, transform_point
from ..vecmath import dot, normalize
from .base import rows_of
from .point import SphereLights

_STEPS = (-0.6, 0.0, 0.6)  # of half a side, between the points that stand for an area light


class Meeting(NamedTuple):
    """Where rays meet a lamp: what nodes read of a surface.

    p relative to the geometry's origin, ng, ns, wo (3, N); front (N,) bool; prim (N,) number of the lamp; u, v (N,) of
    which UV = (1 - u - v, u).
    """

    p: np.ndarray
    ng: np.ndarray
    ns: np.ndarray
    front: np.ndarray
    prim: np.ndarray
    wo: np.ndarray
    u: np.ndarray
    v: np.ndarray


class RoundForm:
    """Point and spot lights.

    Parameters
    ----------
    source : PointLights, SphereLights or DiskLights
    to_object : (12, count)
        Rows of matrices into the lamps' spaces.
    angle : (count,), optional
        Full angle of the cones; None of point lights.
    """

    def __init__(self, source, to_object, angle=None):
        self._source, self._to_object = source, to_object
        self._scale = None if angle is None else (0.5 / np.tan(0.5 * np.asarray(angle, np.float64))).astype(np.float32)

    def meet(self, rows, p, wi, distance, arena):
        """Position and normal (3, N) and UV coordinates, two (N,), of directions `wi` from `p`."""
        wo = np.negative(wi, out=arena.empty(wi.shape))
        position, normal = _along(p, wi, distance, arena), wo
        if isinstance(self._source, SphereLights):
            normal = np.subtract(position, rows_of(self._source.position, rows, arena), out=arena.empty(wi.shape))
            normalize(normal, arena, out=normal)
        elif not self._source.extended:
            np.copyto(position, rows_of(self._source.position, rows, arena))
        to_object = rows_of(self._to_object, rows, arena)
        if self._scale is None:
            uv = _on_sphere(transform_direction(to_object, normal, arena))
        else:
            x, y, z = transform_direction(to_object, wo, arena)
            slope = rows_of(self._scale, rows, arena) / np.minimum(z, np.float32(-1e-20))
            uv = np.float32(0.5) - x * slope, np.float32(0.5) - y * slope
        return position, normal, uv

    def mean_points(self, row):
        """Points (3, n) that stand for lamp number `row` where a lamp is one direction."""
        return self._source.position[:, row : row + 1]


class AreaForm:
    """Area lights of `size` (2, count) before the transform; `frame` as of `AreaLights`."""

    def __init__(self, frame, size, to_object):
        self._frame, self._to_object = frame, to_object
        with np.errstate(all="ignore"):
            self._per_size = (1.0 / np.asarray(size, np.float64)).astype(np.float32)

    def meet(self, rows, p, wi, distance, arena):
        """Position and normal (3, N) and UV coordinates, two (N,), of directions `wi` from `p`."""
        position = _along(p, wi, distance, arena)
        normal = np.array(np.broadcast_to(rows_of(self._frame[9:12], rows, arena), wi.shape))
        local = transform_point(rows_of(self._to_object, rows, arena), position, arena)
        per_size = rows_of(self._per_size, rows, arena)
        return position, normal, [local[i] * per_size[i] + np.float32(0.5) for i in range(2)]

    def mean_points(self, row):
        """Points (3, n) that stand for lamp number `row` where a lamp is one direction."""
        center, x, y, _, half = np.split(self._frame[:, row : row + 1], (3, 6, 9, 12))
        steps = [(i, j) for i in _STEPS for j in _STEPS]
        return np.concatenate([center + x * (half[0] * i) + y * (half[1] * j) for i, j in steps], axis=1)


class SunForm:
    """Suns of full `angle` (count,) in direction `axis` (3, count), unit; `origin` (3,) is the geometry's."""

    def __init__(self, axis, angle, to_object, origin):
        self._axis = np.asarray(axis, np.float32)
        sine = np.sin(0.25 * np.asarray(angle, np.float64))
        self._scale = np.divide(0.25, sine, out=np.zeros(sine.shape), where=sine > 1e-7).astype(np.float32)
        self._to_object, self._origin = to_object, np.asarray(origin, np.float32).reshape(3, 1)

    def meet(self, rows, p, wi, distance, arena):
        """Position and normal (3, N) and UV coordinates, two (N,), of directions `wi` from `p`."""
        wo = np.negative(wi, out=arena.empty(wi.shape))
        position = np.subtract(wo, self._origin, out=arena.empty(wi.shape))
        x, y, _ = transform_direction(rows_of(self._to_object, rows, arena), wo, arena)
        half = np.sqrt(np.maximum(0.5 + 0.5 * dot(rows_of(self._axis, rows, arena), wi, arena), 1e-12))
        scale = rows_of(self._scale, rows, arena) / half
        return position, wo, (np.float32(0.5) - x * scale, np.float32(0.5) - y * scale)

    def mean_points(self, row):
        """None: a sun is one direction as it is."""
        return None


def _along(p, wi, distance, arena):
    """The points (3, N) at `distance` from `p`."""
    out = np.multiply(wi, distance, out=arena.empty(wi.shape))
    return np.add(out, p, out=out)


def _on_sphere(d):
    """Longitude and latitude of directions (3, N), from 0 to 1."""
    x, y, z = d
    around = np.float32(0.5) - np.arctan2(x, y) * np.float32(0.5 / math.pi)
    around = np.where((x == 0) & (y == 0), np.float32(0), around)
    return around, np.float32(1) - np.arctan2(np.hypot(x, y), z) * np.float32(1 / math.pi)
