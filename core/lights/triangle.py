# SPDX-License-Identifier: GPL-3.0-or-later
"""Emissive triangles, both sides shining: points uniform on the area."""

from __future__ import annotations

import math

import numpy as np

from ..sampling.warp import square_to_uniform_triangle
from ..vecmath import cross, dot
from .base import NEAREST_SQUARED, LightSample, normalize_length, rows_of


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
    textures : sequence of callable
        ``Le(prim, u, v, arena) -> (3, n)`` of textured emitters.
    texture : (count,) int, optional
        Number in `textures`, -1 where the radiance is constant.
    """

    extended = False  # rays hit the triangles themselves
    at_infinity = False

    def __init__(self, corners, prim, radiance, textures=(), texture=None):
        v0, v1, v2 = np.asarray(corners, np.float64).reshape(3, 3, -1)
        self._corners = np.ascontiguousarray(np.concatenate([v0, v1 - v0, v2 - v0]), np.float32)
        self.prim = np.ascontiguousarray(prim, np.int32)
        self.radiance = np.ascontiguousarray(radiance, np.float32)
        self.count = self.prim.size
        self.area = 0.5 * np.linalg.norm(np.cross(v1 - v0, v2 - v0, axis=0), axis=0)
        self.power = 2.0 * math.pi * self.area * np.abs(np.asarray(radiance, np.float64)).mean(axis=0)
        self._textures = tuple(textures)
        self._texture = None if texture is None else np.ascontiguousarray(texture, np.int32)

    def sample(self, rows, p, u0, u1, arena):
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
            projected = dot(cross(e1, e2, arena), wi, arena)  # twice area·cosθ
            np.abs(projected, out=projected)
            np.multiply(projected, 0.5, out=projected)
            squared = np.multiply(distance, distance, out=t)
            np.maximum(squared, NEAREST_SQUARED, out=squared)
            np.divide(projected, squared, out=projected)  # 1/pdf
            np.divide(1.0, np.maximum(projected, 1e-36, out=pdf), out=pdf)
            np.multiply(self._emitted(rows, b, arena), projected, out=weight)
        return LightSample(wi, distance, weight, pdf)

    def _emitted(self, rows, b, arena):
        """Radiance at barycentric coordinates `b` (2, N), (3, N) or (3, 1)."""
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
                    out[:, lanes] = evaluate(prim[lanes], b[0][lanes], b[1][lanes], arena)
        return out
