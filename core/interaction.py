# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a ray met a surface, and how further rays leave it without meeting it again.

float32 cannot hold a point exactly on a surface. A hit therefore carries `offset`, a bound on how far its point may lie
off the surface, and rays start that far to their own side of it. No epsilon depends on the scene's size. Source: Pharr,
Jakob and Humphreys, "Physically Based Rendering" (4th ed.), section 6.8.
"""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np

from .geometry import CORNERS, NORMAL, NORMAL_ROW, OFFSET, UNIT_ROUNDOFF, in_reading_order
from .limits import at_least
from .vecmath import dot, normalize, with_sign

# Relative error bounds of points on spheres and planes, with room for the next ray's own rounding.
_SPHERE_SLACK = 16 * UNIT_ROUNDOFF
_PLANE_SLACK = 16 * UNIT_ROUNDOFF
# Of strands: shares of the radius, in which Embree looks for the surface step by step, and of the coordinates.
_TUBE_SLACK = 1e-3
_STRAND_SLACK = 32 * UNIT_ROUNDOFF

# The share of its length by which a shadow ray ends early, so that it does not meet the light's own surface.
SHADOW_EPSILON = 1e-4
SHORTEST = 1e-30  # no shadow ray is shorter: its direction is a quotient by the length

# Columns of the corners in tables of UV coordinates and of shading normals.
_UV = (slice(0, 2), slice(2, 4), slice(4, 6))
_NORMALS = (slice(0, 3), slice(3, 6), slice(6, 9))


class Interaction(NamedTuple):
    """A surface seen by a ray.

    p (3, N); ng (3, N) unit geometric normal on the viewer's side; ns (3, N) shading normal turned with it, the same
    array where nothing is smooth; front (N,) bool, whether the viewer is in front; offset (N,) distance along ng that
    clears the surface; prim (N,) int32.
    """

    p: np.ndarray
    ng: np.ndarray
    ns: np.ndarray
    front: np.ndarray
    offset: np.ndarray
    prim: np.ndarray


def make_interact(geometry):
    """The function ``interact(hits, o, d, arena) -> Interaction`` for the kinds of primitives that `geometry` has.

    All lanes must have hit; `hits` are dense, `o` and `d` (3, N) the rays that hit.
    """
    counts = geometry.triangle_count, geometry.sphere_count, geometry.segment_count, geometry.plane_count
    first = np.cumsum([0, *counts]).tolist()
    facets, normals = in_reading_order(geometry.facets), in_reading_order(geometry.normals)
    on_triangles = _on_triangles_by_row if facets.flags.c_contiguous else _on_triangles
    functions = [partial(on_triangles, facets, normals)]
    functions += [partial(function, geometry) for function in (_on_spheres, _on_strands, _on_planes)]
    kinds = [kind for kind in zip(first, first[1:], functions, strict=False) if kind[1] > kind[0]]
    if len(kinds) == 1:
        return kinds[0][2]
    return partial(_on_several, kinds, len(geometry.normals) > 0)


def spawn(p, offset, ng, w, arena):
    """Origin (3, N) of a ray that leaves `p` towards `w` (3, N), moved off the surface to the side of `w`."""
    o = arena.empty(p.shape)
    with arena.frame():
        step = dot(w, ng, arena)
        with_sign(offset, step)
        np.multiply(ng, step, out=o)
        np.add(o, p, out=o)
    return o


def spawn_to(p, offset, ng, w, distance, arena, in_front=False):
    """Shadow ray from `p` to the point at `distance` (N,), which may be inf, along the unit vectors `w`.

    The start is moved off the surface, so the ray is turned by as much: one that only ran parallel would miss the
    point, and meet the light's own surface early where it grazes it. `in_front` tells that all leave to the side of
    `ng`, where nothing need be found out.

    Returns
    -------
    o : (3, N)
        As of `spawn`.
    d : (3, N)
        Towards the point; nearly, but not exactly, of length 1.
    tmax : (N,)
        In units of |d|; ends before the point.
    """
    count = w.shape[1]
    o, d, tmax = arena.empty((3, count)), arena.empty((3, count)), arena.empty(count)
    with arena.frame():
        step = arena.empty(count)
        side = offset if in_front else with_sign(offset, dot(w, ng, arena, out=step))
        np.multiply(ng, side, out=o)
        np.add(o, p, out=o)
        at_least(distance, SHORTEST, tmax)
        np.divide(side, tmax, out=step)
        np.multiply(ng, step, out=d)
        np.subtract(w, d, out=d)
    np.multiply(tmax, 1.0 - SHADOW_EPSILON, out=tmax)
    return o, d, tmax


def uv_at(geometry, name, prim, u, v, arena):
    """UV coordinates (2, N) of hits on map `name`; zero on spheres and planes."""
    out = arena.empty((2, prim.size))
    table = geometry.uvs[name]
    if not len(table):
        out.fill(0)
        return out
    with arena.frame():
        _weigh(table, _UV, prim, u, v, out, arena)
        if geometry.count > len(table):
            beyond = np.greater_equal(prim, len(table), out=arena.empty(prim.size, bool))
            np.copyto(out, np.float32(0), where=beyond)
    return out


def interpolate_rows(table, corners, prim, u, v, arena):
    """Values (C, N) at hits on triangles, of a table whose `corners` are three slices of columns."""
    out = arena.empty((corners[0].stop - corners[0].start, prim.size))
    with arena.frame():
        _weigh(table, corners, prim, u, v, out, arena)
    return out


def corner_values_at(table, prim, u, v, arena):
    """Values (C, N) at hits, of a table (T, 3 C) of the triangles' corners; zero on spheres and planes."""
    count = table.shape[1] // 3
    if not len(table):
        return arena.zeros((count, prim.size))
    out = interpolate_rows(table, [slice(k * count, (k + 1) * count) for k in range(3)], prim, u, v, arena)
    with arena.frame():
        beyond = np.greater_equal(prim, len(table), out=arena.empty(prim.size, bool))
        np.copyto(out, np.float32(0), where=beyond)
    return out


# -- one kind of primitive each ----------------------------------------------------------------------------------------


def _on_triangles(facets, normals, hits, o, d, arena):
    """Of tables in Fortran's order."""
    count = hits.prim.size
    p, ng, offset, front = _results(count, arena)
    ns = arena.empty(ng.shape) if len(normals) else ng
    with arena.frame():
        number = arena.empty(count, np.intp)
        np.copyto(number, hits.prim)  # numpy copies other indices at each call
        _weigh_columns(facets, CORNERS, number, hits.u, hits.v, p, arena)
        for column, out in zip(facets[:, NORMAL].T, ng, strict=True):
            _column(column, number, out)
        _column(facets[:, OFFSET], number, offset)
        side = _turn(ng, d, ng, front, arena)
        if ns is not ng:
            np.copyto(ns, ng)
            _smooth(normals, arena.take(facets[:, NORMAL_ROW].view(np.int32), number), hits, side, ns, arena)
    return Interaction(p, ng, ns, front, offset, hits.prim)


def _on_triangles_by_row(facets, normals, hits, o, d, arena):
    """The same of tables in C's order, of which each hit costs one cache line."""
    p, ng, offset, front = _results(hits.prim.size, arena)
    ns = arena.empty(ng.shape) if len(normals) else ng
    with arena.frame():
        rows = _rows(facets, hits.prim, arena)
        _interpolate([rows[:, k] for k in CORNERS], hits.u, hits.v, p, arena)
        np.copyto(offset, rows[:, OFFSET])
        np.copyto(ng, rows[:, NORMAL].T)  # dense from here on
        side = _turn(ng, d, ng, front, arena)
        if ns is not ng:
            np.copyto(ns, ng)
            _smooth(normals, rows.view(np.int32)[:, NORMAL_ROW], hits, side, ns, arena)
    return Interaction(p, ng, ns, front, offset, hits.prim)


def _smooth(normals, row, hits, side, ns, arena):
    """Write the interpolated normals of the smooth lanes into `ns`."""
    lane = np.flatnonzero(row >= 0)
    if lane.size == row.size:
        _shading_normal(normals, row, hits.u, hits.v, side, ns, arena)
    elif lane.size:
        n = arena.empty((3, lane.size))
        row, u, v, side = (arena.take(a, lane) for a in (row, hits.u, hits.v, side))
        _shading_normal(normals, row, u, v, side, n, arena)
        for i in range(3):
            ns[i][lane] = n[i]


def _shading_normal(normals, row, u, v, side, out, arena):
    _weigh(normals, _NORMALS, row, u, v, out, arena)
    normalize(out, arena, out=out)
    np.multiply(out, side, out=out)


def _on_spheres(geometry, hits, o, d, arena):
    count = hits.prim.size
    p, ng, offset, front = _results(count, arena)
    with arena.frame():
        number = np.subtract(hits.prim, geometry.triangle_count, out=arena.empty(count, np.int32))
        center, radius = arena.take(geometry.centers, number), arena.take(geometry.radii, number)
        n = arena.empty((3, count))
        np.multiply(d, hits.t, out=n)
        np.add(n, o, out=n)
        np.subtract(n, center, out=n)
        normalize(n, arena, out=n)
        np.multiply(n, radius, out=p)
        np.add(p, center, out=p)
        _turn(n, d, ng, front, arena)
        # The error of the nearest point and of Embree's discriminant, both of the order of the radius.
        _projected(center, ng, offset, arena)
        np.add(offset, radius, out=offset)
        np.multiply(offset, _SPHERE_SLACK, out=offset)
    return Interaction(p, ng, ng, front, offset, hits.prim)


def _on_strands(geometry, hits, o, d, arena):
    """The normal points away from the spline, as in Cycles, whose "3D Curves" these are."""
    count = hits.prim.size
    p, ng, offset, front = _results(count, arena)
    with arena.frame():
        segment = np.subtract(hits.prim, geometry.first_segment, out=arena.empty(count, np.int32))
        tube, n = geometry.strands.at(segment, hits.u, arena), arena.empty((3, count))
        center, radius = tube[:3], tube[3]
        np.multiply(d, hits.t, out=n)
        np.add(n, o, out=n)
        np.subtract(n, center, out=n)
        normalize(n, arena, out=n)
        lost = np.flatnonzero(~n.any(axis=0))  # a strand thinner than the coordinates' last digit faces the viewer
        n[:, lost] = -d[:, lost] / np.sqrt((d[:, lost] ** 2).sum(axis=0))
        np.multiply(n, radius, out=p)
        np.add(p, center, out=p)
        _turn(n, d, ng, front, arena)
        _projected(p, ng, offset, arena)
        np.multiply(offset, _STRAND_SLACK, out=offset)
        np.multiply(radius, _TUBE_SLACK, out=radius)
        np.add(offset, radius, out=offset)
    return Interaction(p, ng, ng, front, offset, hits.prim)


def _on_planes(geometry, hits, o, d, arena):
    count = hits.prim.size
    p, ng, offset, front = _results(count, arena)
    with arena.frame():
        number = np.subtract(hits.prim, geometry.count - geometry.plane_count, out=arena.empty(count, np.int32))
        point, n = arena.take(geometry.plane_points, number), arena.take(geometry.plane_normals, number)
        away, move, reach = arena.empty((3, count)), arena.empty((3, count)), arena.zeros((3, count))
        np.multiply(d, hits.t, out=p)
        np.add(p, o, out=p)
        np.subtract(p, point, out=away)
        np.multiply(n, dot(away, n, arena), out=move)
        np.subtract(p, move, out=p)
        _turn(n, d, ng, front, arena)
        # Everything that was rounded on the way.
        for part in (p, move, point):
            np.abs(part, out=away)
            np.add(reach, away, out=reach)
        _projected(reach, ng, offset, arena)
        np.multiply(offset, _PLANE_SLACK, out=offset)
        # In a plane through zero along the axes nothing is rounded, and any distance will do.
        at_least(offset, 1e-30, offset)
    return Interaction(p, ng, ng, front, offset, hits.prim)


def _on_several(kinds, smooth, hits, o, d, arena):
    """Each kind of primitive on its own lanes."""
    count = hits.prim.size
    p, ng, offset, front = _results(count, arena)
    ns = arena.empty((3, count)) if smooth else ng
    for begin, end, interact in kinds:
        lane = np.flatnonzero((hits.prim >= begin) & (hits.prim < end))
        with arena.frame():
            own = type(hits)(*(arena.take(a, lane) for a in hits))
            part = interact(own, arena.take(o, lane), arena.take(d, lane), arena)
            p[:, lane], ng[:, lane], front[lane], offset[lane] = part.p, part.ng, part.front, part.offset
            if smooth:
                ns[:, lane] = part.ns
    return Interaction(p, ng, ns, front, offset, hits.prim)


# -- steps -------------------------------------------------------------------------------------------------------------


def _results(count, arena):
    return arena.empty((3, count)), arena.empty((3, count)), arena.empty(count), arena.empty(count, bool)


def _weigh(table, corners, index, u, v, out, arena):
    """Write (1-u-v) a + u b + v c of the rows `index` of `table`, of whose columns a, b and c are the `corners`.

    An index beyond the table stands for its last row.
    """
    if table.flags.c_contiguous:
        rows = _rows(table, index, arena)
        _interpolate([rows[:, k] for k in corners], u, v, out, arena)
    else:
        number = np.minimum(index, len(table) - 1, out=arena.empty(index.size, np.intp))
        _weigh_columns(table, corners, number, u, v, out, arena)


def _weigh_columns(table, corners, number, u, v, out, arena):
    """The same of a table in Fortran's order."""
    with arena.frame():
        weights, values = arena.empty((3, number.size)), arena.empty((3, number.size))
        np.copyto(weights[1], u)
        np.copyto(weights[2], v)
        np.subtract(1.0, u, out=weights[0])
        np.subtract(weights[0], v, out=weights[0])
        for i, row in enumerate(out):
            for corner, value in zip(corners, values, strict=True):
                _column(table[:, corner.start + i], number, value)
            dot(values, weights, arena, out=row)


def _column(values, index, out):
    return values.take(index, out=out, mode="wrap")  # as fast as can be; nothing wraps


def _rows(table, index, arena):
    """Rows `index` of `table` (R, C); one cache line a lane, which one gather a column would not be."""
    out = arena.empty((index.size, table.shape[1]), table.dtype)
    return np.take(table, index, axis=0, out=out, mode="clip")


def _interpolate(corners, u, v, out, arena):
    """(1-u-v) a + u b + v c of three (N, C) arrays, into `out` (C, N)."""
    a, b, c = corners
    with arena.frame():
        w, t = arena.empty(u.size), arena.empty(u.size)
        np.subtract(1.0, u, out=w)
        np.subtract(w, v, out=w)
        for i in range(len(out)):
            np.multiply(a[:, i], w, out=out[i])
            np.multiply(b[:, i], u, out=t)
            np.add(out[i], t, out=out[i])
            np.multiply(c[:, i], v, out=t)
            np.add(out[i], t, out=out[i])


def _turn(n, d, ng, front, arena):
    """Write `n` turned to the viewer and whether it was there before; +1 or -1 (N,) by which it was multiplied."""
    side = arena.empty(front.size)
    dot(n, d, arena, out=side)
    np.negative(side, out=side)
    np.greater(with_sign(1.0, side), 0.0, out=front)
    np.multiply(n, side, out=ng)
    return side


def _projected(reach, n, out, arena):
    """|reach| · |n|."""
    with arena.frame():
        a = np.abs(reach, out=arena.empty(reach.shape))
        b = np.abs(n, out=arena.empty(n.shape))
        dot(a, b, arena, out=out)
