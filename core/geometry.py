# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything that a ray can hit, as read-only tables.

Primitives are numbered through: triangles ``0..T-1``, then S spheres, C segments of strands, K infinite planes. A
triangle's corners, normal and error bound stand in one row of 64 bytes, its *facet*: a hit costs one cache line. Embree
is given vertices that triangles share, from which it builds its tree faster.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from .arena import Arena
from .scene import Material
from .spaces import Objects, View
from .strands import Strands

# Columns of a facet. Corners stand 16 bytes apart, as Embree likes its vertices.
CORNERS = (slice(0, 3), slice(4, 7), slice(8, 11))
NORMAL = slice(12, 15)
OFFSET, NORMAL_ROW = 3, 15
FACET_COLUMNS = 16

# So many triangles are worked on at once: few enough to stay in the cache, enough for threads not to wait for Python.
BLOCK = 1 << 15

# Tables of so many rows, or fewer, are read by column, which then stays in the cache, others by row, at a line a hit.
_FEW_ROWS = 1 << 16

# Rows that must follow the index: Embree may read 16 bytes from each on.
INDEX_PADDING = 2

UNIT_ROUNDOFF = 2.0**-24

# Of a triangle's offset: shares of its corners' coordinates (4 gamma(7)) and of its longest side.
# tests/core/test_interaction.py holds them to zero false hits.
_SLACK = 28 * UNIT_ROUNDOFF
_SIDE_SLACK = 32 * UNIT_ROUNDOFF


@dataclass(frozen=True, eq=False)
class Geometry:
    """Tables of T triangles, S spheres, C segments, K planes, P primitives in all. Positions are relative to `origin`.

    Parameters
    ----------
    origin : (3,) float64
        World position of the tables' zero, subtracted before the cast to float32.
    facets : (T, 16) float32
        Rows ``v0, offset, v1, 0, v2, 0, ng, normal row (int32 bits)``: corners, unit normal of the front, distance
        along the normal that clears the surface (`core.interaction`).
    vertices, index : (V, 4) float32, (T, 3) uint32
        The same corners as Embree reads them: points and a zero, and each triangle's numbers of them. `INDEX_PADDING`
        rows follow the index in memory.
    centers, radii : (3, S), (S,) float32
    plane_points, plane_normals : (3, K) float32
        The point of each plane that is nearest to `origin`, and its unit normal.
    material, object : (P,) int32
        Number in `materials`; number of the instance, Spheres, Curves or Plane, counted through in this order.
    materials : tuple of Material
    normals : (R, 9) float32
        Unit shading normals in world space at the three corners of the smooth triangles.
    uvs : mapping of str to (T, 6) float32
        ``u0 v0 u1 v1 u2 v2`` by name of the map; "" is each mesh's active one. A mesh without the map has zeros.
        Spheres and segments have further rows where there are some (`core.compile.round_tables`).
    corner_values : mapping to (T, 3 C) float32
        What else shader nodes read at the triangles' corners (`core.compile.corners`), only what they do read.
    objects, view : Objects, View, optional
        What shader nodes know of objects, where they ask, and of the camera.
    strands : Strands, optional
        Hair, where there is some.
    own_number : (T,) int32, optional
        Number of each triangle in its mesh; None where no triangle was left out.
    probe : Probe, optional
        Rays for shader nodes (`core.nodes.probe`), where they cast some.
    """

    origin: np.ndarray
    facets: np.ndarray
    vertices: np.ndarray
    index: np.ndarray
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
    strands: Strands | None = None
    own_number: np.ndarray | None = None
    probe: object = None

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
        corners = np.asarray(triangles, np.float32).reshape(-1, 3)
        vertices = np.zeros((len(corners), 4), np.float32)
        vertices[:, :3] = corners
        count = len(corners) // 3
        index = np.arange(3 * (count + INDEX_PADDING), dtype=np.uint32).reshape(-1, 3)[:count]
        facets = np.zeros((count, FACET_COLUMNS), np.float32)
        arena = Arena()
        for start in range(0, count, BLOCK):
            rows = slice(start, start + BLOCK)
            with arena.frame():
                fill_facets(facets[rows], vertices, index[rows], arena)
        centers, points, normals = (columns_of(a) for a in (centers, plane_points, plane_normals))
        count = len(facets) + centers.shape[1] + points.shape[1]
        return cls(
            origin=np.zeros(3),
            facets=facets,
            vertices=vertices,
            index=index,
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
    def segment_count(self):
        """C."""
        return 0 if self.strands is None else self.strands.count

    @property
    def first_segment(self):
        """Number of the first segment among all primitives."""
        return self.triangle_count + self.sphere_count

    def on_strand(self, prim):
        """Whether primitives are segments of strands, (N,) bool."""
        return (prim >= self.first_segment) & (prim < self.first_segment + self.segment_count)

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
        return self.corners_of(slice(None))

    def corners_of(self, prim):
        """Corners (9, n) float32 of the triangles `prim`."""
        facets = self.facets[prim]
        return np.ascontiguousarray(np.concatenate([facets[:, k] for k in CORNERS], axis=1).T)

    @property
    def bounds(self):
        """Lower and upper end (3,) of the box around the triangles, of which there must be some."""
        parts = [self.facets[start : start + BLOCK, :11] for start in range(0, len(self.facets), BLOCK)]
        low, high = np.min([p.min(0) for p in parts], axis=0), np.max([p.max(0) for p in parts], axis=0)
        return np.min([low[k] for k in CORNERS], axis=0), np.max([high[k] for k in CORNERS], axis=0)

    @cached_property
    def normal_row(self):
        """(T,) int32, each triangle's row of `normals`, -1 where it is flat; None when all are flat."""
        return np.ascontiguousarray(self.facets.view(np.int32)[:, NORMAL_ROW]) if len(self.normals) else None


def columns_of(vectors):
    """(N, 3) vectors as a (3, N) float32 array, C-contiguous."""
    return np.ascontiguousarray(np.asarray(vectors, np.float32).reshape(-1, 3).T)


def in_reading_order(table):
    """A table of triangles with its columns dense (Fortran's order) where it is short, as it is where it is not."""
    return np.asfortranarray(table) if len(table) <= _FEW_ROWS else table


def fill_facets(facets, vertices, index, arena):
    """Write the facets of flat triangles, a block of them or all; tell which are triangles.

    Parameters
    ----------
    facets : (T, 16) float32
        Written.
    vertices, index : (V, 4) float32, (T, 3) uint32
    arena : Arena

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
    count = len(facets)
    with arena.frame():
        rows = arena.empty((count, 4), np.intp)
        for k in range(4):
            np.copyto(rows[:, k], index[:, min(k, 2)])  # a fourth point, where the normal will stand: one call for all
        np.take(vertices, rows.reshape(-1), axis=0, out=facets.reshape(-1, 4), mode="clip")
    facets.view(np.int32)[:, NORMAL_ROW] = -1
    near = arena.empty((3, 3, count))
    np.copyto(near, facets[:, :12].reshape(-1, 3, 4)[..., :3].transpose(1, 2, 0))
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        normal, longest, good = _normals(near, arena)
        reach = np.abs(near, out=near).max(0)
    if not good.all():
        normal[:, ~good] = reach[:, ~good] = longest[~good] = 0
    for k in range(3):
        facets[:, NORMAL.start + k] = normal[k]
    slack, *others = np.multiply(np.abs(normal, out=normal), reach, out=reach)
    for other in others:
        np.add(slack, other, out=slack)
    np.multiply(slack, _SLACK, out=slack)
    np.multiply(np.sqrt(longest, out=longest), _SIDE_SLACK, out=longest)
    np.add(slack, longest, out=facets[:, OFFSET], casting="same_kind")
    return good


def _normals(corners, arena):
    """Unit normals (3, n), squares of the longest sides (n,) and which are triangles (n,), of corners (3, 3, n).

    float64 inside: sides of slim triangles cancel.
    """
    a, b, c = corners
    count = corners.shape[2]
    e, f, n = (arena.empty((3, count), np.float64) for _ in range(3))
    t, area = (arena.empty(count, np.float64) for _ in range(2))
    for side, end in ((e, b), (f, c)):
        np.subtract(end, a, out=side, dtype=np.float64)
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        np.multiply(e[i], f[j], out=n[k])
        n[k] -= np.multiply(e[j], f[i], out=t)
    longest = _squared(e, t)
    for side in (f, np.subtract(f, e, out=e)):
        np.maximum(longest, _squared(side, area), out=longest)
    np.sqrt(_squared(n, area), out=area)
    good = np.isfinite(area) & (area > 2 * UNIT_ROUNDOFF * longest)
    return np.multiply(n, 1 / area, out=arena.empty(n.shape), casting="same_kind"), longest, good


def _squared(v, out):
    """Squared lengths (n,) of vectors (3, n)."""
    return np.einsum("kn,kn->n", v, v, out=out)
