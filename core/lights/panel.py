# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels: emissive rectangles of the scene, each made of two triangles, both sides shining.

One light instead of two: no choice between the halves, and directions uniform in the whole's solid angle.
"""

from __future__ import annotations

import math

import numpy as np

from ..limits import at_least
from .base import Bounds, LightSample, rows_of
from .rectangle import Rectangles

_TOLERANCE = 1e-5  # of the diagonal: how far a rectangle's corner may be from its place
_TINY = 1e-36  # keeps densities finite


class PanelLights:
    """Rectangles of the scene that emit.

    Parameters
    ----------
    corner, edge0, edge1 : (3, count) float64
        A corner and the sides that leave it, at right angles.
    prim : (2, count) int32
        Their triangles' numbers among the scene's primitives.
    radiance : (3, count)
    axis : (3, count), optional
        From `outward` of `core.lights.triangle`; serves the choice alone.
    far_sides : FarSides, optional
        As of `core.lights.triangle`.
    """

    extended = False  # rays hit the triangles themselves
    at_infinity = False

    def __init__(self, corner, edge0, edge1, prim, radiance, axis=None, far_sides=None):
        length0, length1 = np.linalg.norm(edge0, axis=0), np.linalg.norm(edge1, axis=0)
        x = edge0 / length0
        y = edge1 - (x * edge1).sum(axis=0) * x
        y /= np.linalg.norm(y, axis=0)
        half = 0.5 * np.stack([length0, length1])
        center = corner + 0.5 * (edge0 + edge1)
        self._shapes = Rectangles(center, x, y, np.cross(x, y, axis=0), half, both_sides=True)
        self._axis = axis
        self._far_sides = far_sides
        self.prim = np.ascontiguousarray(prim, np.int32)
        self.radiance = np.ascontiguousarray(radiance, np.float32)
        self.count = self._shapes.count
        self.power = 2.0 * math.pi * self._shapes.area * np.abs(np.asarray(radiance, np.float64)).mean(axis=0)

    def bounds(self):
        """Where the lights are, for their choice."""
        return Bounds(self._shapes.frame[0:3], self._shapes.spread, self._axis)

    def sample(self, rows, p, u0, u1, arena):
        """A direction to a point of the panel."""
        weight, pdf = arena.empty(p.shape), arena.empty(p.shape[-1])
        wi, distance, inverse = self._shapes.sample(rows, p, u0, u1, arena)
        np.divide(1.0, at_least(inverse, _TINY, pdf), out=pdf)
        with arena.frame():
            np.multiply(rows_of(self.radiance, rows, arena), inverse, out=weight)
            if self._far_sides is not None:
                self._far_sides.hide(rows, wi, distance, weight, arena)
        return LightSample(wi, distance, weight, pdf)

    def density(self, rows, p, wi, distance, arena):
        """Solid-angle density (N,) of `sample` for directions `wi` from `p` that meet the panel at `distance`."""
        pdf = self._shapes.inverse_density(rows, p, wi, distance, arena)
        return np.divide(1.0, at_least(pdf, _TINY, pdf), out=pdf)


def find_panels(corners, alike):
    """Neighbouring triangles that make a rectangle.

    Parameters
    ----------
    corners : (9, T)
        v0, v1, v2.
    alike : (T - 1,) bool
        Whether a triangle and the next one may be one light.

    Returns
    -------
    first : (n,) int
        Number of the first triangle of each pair; the second one follows.
    corner, edge0, edge1 : (3, n) float64
    """
    none = np.zeros(0, np.intp), *np.zeros((3, 3, 0))
    first = np.flatnonzero(alike)
    if first.size == 0:
        return none
    a, b = (np.asarray(corners, np.float64)[:, k].reshape(3, 3, -1) for k in (first, first + 1))
    same = (a[:, None] == b[None, :]).all(axis=2)  # corner of one, corner of the other
    shared_a, shared_b = same.any(axis=1), same.any(axis=0)
    two = (shared_a.sum(axis=0) == 2) & (shared_b.sum(axis=0) == 2)
    first, a, b, shared_a, shared_b = first[two], a[..., two], b[..., two], shared_a[:, two], shared_b[:, two]
    lanes = np.arange(first.size)
    own_a = np.argmin(shared_a, axis=0)  # the corner at the right angle, opposite the diagonal
    corner, end0, end1 = (a[(own_a + k) % 3, :, lanes].T for k in range(3))
    opposite = b[np.argmin(shared_b, axis=0), :, lanes].T
    edge0, edge1 = end0 - corner, end1 - corner
    diagonal = np.linalg.norm(end1 - end0, axis=0)
    gap = np.linalg.norm(corner + edge0 + edge1 - opposite, axis=0)
    skew = np.abs(diagonal - np.linalg.norm(opposite - corner, axis=0))
    kept = _without_overlap(first, np.maximum(gap, skew) < _TOLERANCE * diagonal)
    return first[kept], corner[:, kept], edge0[:, kept], edge1[:, kept]


def _without_overlap(first, good):
    """Indices of `good` pairs of which no two share a triangle: every other one of a run."""
    index = np.flatnonzero(good)
    if index.size == 0:
        return index
    start = np.append(True, np.diff(first[index]) > 1)
    since = np.arange(index.size) - np.flatnonzero(start)[np.cumsum(start) - 1]
    return index[since % 2 == 0]
