# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything that a ray can hit, as read-only tables.

Primitives are numbered through: triangles ``0..T-1``, then S spheres, then K infinite planes. A triangle's corners,
normal and error bound stand in one row of 64 bytes, its *facet*: a hit costs one cache line, and Embree reads its
vertices from the same memory.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from .scene import Material
from .spaces import Objects, View

# Columns of a facet. Corners stand 16 bytes apart, as Embree likes its vertices.
CORNERS = (slice(0, 3), slice(4, 7), slice(8, 11))
NORMAL = slice(12, 15)
OFFSET, NORMAL_ROW = 3, 15
FACET_COLUMNS = 16

UNIT_ROUNDOFF = 2.0**-24

# Of a triangle's offset: shares of its corners' coordinates (4 gamma(7)) and of its longest side.
# tests/core/test_interaction.py holds them to zero false hits.
_SLACK = 28 * UNIT_ROUNDOFF
_SIDE_SLACK = 32 * UNIT_ROUNDOFF

_BLOCK = 1 << 15


@dataclass(frozen=True, eq=False)
class Geometry:
    """Tables of T triangles, S spheres, K planes; P = T + S + K primitives. Positions are relative to `origin`.

    Parameters
    ----------
    origin : (3,) float64
        World position of the tables' zero, subtracted before the cast to float32.
    facets : (T, 16) float32
        Rows ``v0, offset, v1, 0, v2, 0, ng, normal row (int32 bits)``: corners, unit normal of the front, distance
        along the normal that clears the surface (`core.interaction`).
    centers, radii : (3, S), (S,) float32
    plane_points, plane_normals : (3, K) float32
        The point of each plane that is nearest to `origin`, and its unit normal.
    material, object : (P,) int32
        Number in `materials`; number of the instance, Spheres or Plane, counted through in this order.
    materials : tuple of Material
    normals : (R, 9) float32
        Unit shading normals in world space at the three corners of the smooth triangles.
    uvs : mapping of str to (T, 6) float32
        ``u0 v0 u1 v1 u2 v2`` by name of the map; "" is each mesh's active one. A mesh without the map has zeros.
    corner_values : mapping to (T, 3 C) float32
        What else shader nodes read at the triangles' corners (`core.compile.corners`), only what they do read.
    objects, view : Objects, View, optional
        What shader nodes know of objects, where they ask, and of the camera.
    """

    origin: np.ndarray
    facets: np.ndarray
    centers: np.ndarray
    radii: np.ndarray
    plane_points: np.ndarray
    plane_normals: np.ndarray
    material: np.ndarray
    object: np.ndarray
    materials: tuple[Material, ...]
    normals: np.ndarray
    uvs: dict[str, np.ndarray] = field(default_factory=dict)
    corner_values: dict = field(default_factory=dict)
    objects: Objects | None = None
    view: View | None = None

    @classmethod
    def from_arrays(cls, triangles=(), centers=(), radii=(), plane_points=(), plane_normals=(), material=None):
        """Geometry of bare arrays, taken as they are: nothing is recentred or dropped.

        Parameters
        ----------
        triangles : (T, 3, 3)
            Corners, counter-clockwise seen from the front.
        centers, radii : (S, 3), (S,)
        plane_points, plane_normals : (K, 3)
            Unit normals.
        material : Material, optional
            Of every primitive.
        """
        corners = np.asarray(triangles, np.float32).reshape(-1, 3, 3)
        facets = empty_facets(len(corners))
        for k, columns in enumerate(CORNERS):
            facets[:, columns] = corners[:, k]
        finish_facets(facets)
        centers, points, normals = (columns_of(a) for a in (centers, plane_points, plane_normals))
        count = len(facets) + centers.shape[1] + points.shape[1]
        return cls(
            origin=np.zeros(3),
            facets=facets,
            centers=centers,
            radii=np.array(radii, np.float32).reshape(-1),
            plane_points=points,
            plane_normals=normals,
            material=np.zeros(count, np.int32),
            object=np.zeros(count, np.int32),
            materials=(material or Material.diffuse(),),
            normals=np.zeros((0, 9), np.float32),
        )

    @property
    def triangle_count(self):
        """T."""
        return len(self.facets)

    @property
    def sphere_count(self):
        """S."""
        return self.radii.size

    @property
    def plane_count(self):
        """K."""
        return self.plane_points.shape[1]

    @property
    def count(self):
        """P."""
        return self.material.size

    @cached_property
    def corners(self):
        """(9, T) float32, rows v0.xyz, v1.xyz, v2.xyz."""
        return np.ascontiguousarray(np.concatenate([self.facets[:, k] for k in CORNERS], axis=1).T)

    @cached_property
    def normal_row(self):
        """(T,) int32, each triangle's row of `normals`, -1 where it is flat; None when all are flat."""
        return np.ascontiguousarray(self.facets.view(np.int32)[:, NORMAL_ROW]) if len(self.normals) else None


def columns_of(vectors):
    """(N, 3) vectors as a (3, N) float32 array, C-contiguous."""
    return np.ascontiguousarray(np.asarray(vectors, np.float32).reshape(-1, 3).T)


def empty_facets(count):
    """Facets of `count` flat triangles, zero elsewhere."""
    facets = np.zeros((count, FACET_COLUMNS), np.float32)
    facets.view(np.int32)[:, NORMAL_ROW] = -1
    return facets


def finish_facets(facets):
    """Fill in normal and offset of facets whose corners stand; tell which are triangles.

    Returns
    -------
    (T,) bool
        False where a coordinate is not finite or the height is below float32's resolution of the longest side. These
        have normal and offset zero.

    Notes
    -----
    The offset bounds, along the normal, the error of a point computed from barycentrics, of Embree's distance to the
    triangle and of adding the offset to the point. The first is ``gamma(7) (|b0 v0| + |b1 v1| + |b2 v2|)`` in Pharr,
    Jakob and Humphreys, "Physically Based Rendering" (4th ed.), section 6.8.4; the sum is at most the largest of the
    three, which makes the bound one number a triangle, and four times as much covers the rest. The longest side enters
    because Embree rounds in proportion to it: a ray that leaves beside an edge must pass the neighbouring triangle.
    """
    good = np.zeros(len(facets), bool)
    for start in range(0, len(facets), _BLOCK):
        good[start : start + _BLOCK] = _finish_block(facets[start : start + _BLOCK])
    return good


def _finish_block(facets):
    a, b, c = (facets[:, k].T.astype(np.float64) for k in CORNERS)
    with np.errstate(invalid="ignore", over="ignore"):
        e, f = b - a, c - a
        n = np.stack([e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]])
        area = np.sqrt((n * n).sum(0))
        longest = np.maximum(np.maximum((e * e).sum(0), (f * f).sum(0)), ((f - e) ** 2).sum(0))
        good = np.isfinite(area) & (area > 2 * UNIT_ROUNDOFF * longest)
    n = np.where(good, n / np.where(good, area, 1.0), 0.0)
    reach = np.maximum(np.maximum(np.abs(a), np.abs(b)), np.abs(c))
    offset = _SLACK * (np.abs(n) * np.where(good, reach, 0.0)).sum(0)
    offset += _SIDE_SLACK * np.sqrt(np.where(good, longest, 0.0))
    facets[:, NORMAL] = n.T
    facets[:, OFFSET] = offset
    return good
