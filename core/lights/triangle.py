# SPDX-License-Identifier: GPL-3.0-or-later
"""Emissive triangles, both sides shining: points uniform on the area."""

from __future__ import annotations

import math

import numpy as np

from ..limits import at_least
from ..sampling.warp import square_to_uniform_triangle
from ..vecmath import dot
from .base import NEAREST_SQUARED, Bounds, LightSample, normalize_length, rows_of

_TINY = 1e-36  # keeps densities finite
_MIX = tuple(map(np.uint64, (0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9)))  # odd, for hashes
_OPEN = 1e-3  # vector area and volume of a flat or open surface, as shares of its area


class TriangleLights:
    """Triangles of the scene that emit.

    Parameters
    ----------
    corners : (9, count) float32
        v0, v1, v2.
    prim : (count,) int32
        Their numbers among the scene's primitives.
    radiance : (3, count)
        Constant radiance, or of textured emitters the mean, which serves the choice alone.
    axis : (3, count), optional
        From `outward`; serves the choice alone.
    textures : sequence of callable
        ``Le(prim, u, v, arena, wo, [ray]) -> (3, n)`` of textured emitters, towards `wo`.
    texture : (count,) int, optional
        Number in `textures`, -1 where the radiance is constant.
    far_sides : FarSides, optional
        Where bodies may hide their far sides; else None.
    """

    extended = False  # rays hit the triangles themselves
    at_infinity = False

    def __init__(self, corners, prim, radiance, axis=None, textures=(), texture=None, far_sides=None):
        v0, v1, v2 = np.asarray(corners, np.float64).reshape(3, 3, -1)
        across = 0.5 * np.cross(v1 - v0, v2 - v0, axis=0)
        self._corners = np.ascontiguousarray(np.concatenate([v0, v1 - v0, v2 - v0, across]), np.float32)
        self.prim = np.ascontiguousarray(prim, np.int32)
        self.radiance = np.ascontiguousarray(radiance, np.float32)
        self.count = self.prim.size
        self.area = np.linalg.norm(across, axis=0)
        self.power = 2.0 * math.pi * self.area * np.abs(np.asarray(radiance, np.float64)).mean(axis=0)
        self._axis = axis
        self._textures = tuple(textures)
        self.is_shaded = bool(self._textures)
        self._texture = None if texture is None else np.ascontiguousarray(texture, np.int32)
        self._far_sides = far_sides

    def bounds(self):
        """Where the lights are, for their choice."""
        v0, e1, e2 = self._corners[0:9].astype(np.float64).reshape(3, 3, -1)
        spread = ((e1 * e1).sum(axis=0) + (e2 * e2).sum(axis=0) - (e1 * e2).sum(axis=0)) / 18.0
        return Bounds(v0 + (e1 + e2) / 3.0, spread, self._axis)

    def sample(self, rows, p, u0, u1, arena, ray=None):
        """A direction to a point of the triangle."""
        n = p.shape[-1]
        wi, distance, weight, pdf = arena.empty((3, n)), arena.empty(n), arena.empty((3, n)), arena.empty(n)
        with arena.frame():
            corners = rows_of(self._corners, rows, arena)
            v0, e1, e2 = corners[0:3], corners[3:6], corners[6:9]
            b = square_to_uniform_triangle(u0, u1, arena)
            t = arena.empty(n)
            for i in range(3):
                np.subtract(v0[i], p[i], out=wi[i])
                np.add(wi[i], np.multiply(e1[i], b[0], out=t), out=wi[i])
                np.add(wi[i], np.multiply(e2[i], b[1], out=t), out=wi[i])
            normalize_length(wi, distance, arena)
            inverse = self._inverse_density(corners[9:12], wi, distance, arena)
            np.divide(1.0, at_least(inverse, _TINY, pdf), out=pdf)
            if ray is not None:
                ray = ray._replace(length=distance)
            np.multiply(self._emitted(rows, b, wi, ray, arena), inverse, out=weight)
            if self._far_sides is not None:
                self._far_sides.hide(rows, wi, distance, weight, arena)
        return LightSample(wi, distance, weight, pdf)

    def density(self, rows, p, wi, distance, arena):
        """Solid-angle density (N,) of `sample` for directions `wi` from `p` that meet the triangle at `distance`."""
        pdf = self._inverse_density(rows_of(self._corners[9:12], rows, arena), wi, distance, arena)
        return np.divide(1.0, at_least(pdf, _TINY, pdf), out=pdf)

    def _inverse_density(self, across, wi, distance, arena):
        """1/pdf: area·cosθ/distance², where `across` (3, N) is the area times the normal."""
        inverse = dot(across, wi, arena)
        np.abs(inverse, out=inverse)
        with arena.frame():
            squared = np.multiply(distance, distance, out=arena.empty(distance.shape))
            np.divide(inverse, at_least(squared, NEAREST_SQUARED, squared), out=inverse)
        return inverse

    def _emitted(self, rows, b, wi, ray, arena):
        """Radiance that leaves barycentric coordinates `b` (2, N) against `wi` (3, N), (3, N) or (3, 1)."""
        radiance = rows_of(self.radiance, rows, arena)
        if not self._textures:
            return radiance
        n = b.shape[-1]
        out = arena.empty((3, n))
        np.copyto(out, radiance)
        with arena.frame():
            prim, texture = np.broadcast_to(rows_of(self.prim, rows, arena), n), rows_of(self._texture, rows, arena)
            for k, evaluate in enumerate(self._textures):
                lanes = np.flatnonzero(np.broadcast_to(texture == k, n))
                if lanes.size:
                    wo = np.negative(wi[:, lanes])
                    asking = () if ray is None else (ray.at(lanes),)
                    out[:, lanes] = evaluate(prim[lanes], b[0][lanes], b[1][lanes], arena, wo, *asking)
        return out


def outward(corners, group, largest=math.inf):
    """Normals on the outside of triangles that enclose a body, (3, T); zero where both sides may be seen.

    Light from the inside of a body smaller than `largest` is met rarely, so the choice may neglect it.

    Parameters
    ----------
    corners : (9, T) float64
    group : (T,) int
        What each belongs to. It counts as closed when its vector area vanishes, as a closed surface's does.
    """
    v0, v1, v2 = np.asarray(corners, np.float64).reshape(3, 3, -1)
    across = 0.5 * np.cross(v1 - v0, v2 - v0, axis=0)
    area = np.linalg.norm(across, axis=0)
    _, group = np.unique(group, return_inverse=True)

    def total(values):
        return np.bincount(group, values)

    whole = total(area)
    middle = np.stack([total(c * area) / whole for c in (v0 + v1 + v2) / 3.0])
    volume = total((across * (v0 - middle[:, group])).sum(axis=0)) / 3.0
    left = np.linalg.norm([total(a) for a in across], axis=0)
    closed = (left < _OPEN * whole) & (np.abs(volume) > _OPEN * whole**1.5) & (np.sqrt(whole) < largest)
    side = np.where(closed, np.sign(volume), 0.0)
    return across / area * side[group]


def first_in_place(corners, kind):
    """For each triangle the first one of equal corners, in any order, and of equal `kind`, (T,) int.

    Parameters
    ----------
    corners : (9, T)
        float32 values.
    kind : (T,) int
    """
    if kind.size == 0:
        return np.zeros(0, np.intp)
    bits = (np.asarray(corners, np.float32) + np.float32(0)).view(np.uint32).astype(np.uint64).reshape(3, 3, -1)
    mixed = bits[:, 0] * _MIX[0] + bits[:, 1] * _MIX[1] + bits[:, 2] * _MIX[2]
    mixed ^= mixed >> np.uint64(29)
    mixed *= _MIX[0]
    key = mixed.sum(axis=0) + kind.astype(np.uint64) * _MIX[1]
    _, first, inverse = np.unique(key, return_index=True, return_inverse=True)
    return first[inverse]
