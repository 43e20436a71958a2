# SPDX-License-Identifier: GPL-3.0-or-later
"""Hit points, and rays that leave them without meeting the surface again."""

from dataclasses import replace

import numpy as np
import pytest

from zraka.core import geometry as tables
from zraka.core.accel import Accel, Hits
from zraka.core.arena import Arena
from zraka.core.geometry import NORMAL, NORMAL_ROW, OFFSET, Geometry, in_reading_order
from zraka.core.interaction import corner_values_at, interpolate_rows, make_interact, spawn, spawn_to, uv_at
from zraka.core.vecmath import dot

LANES = 2000
SIDES = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
SIZES = (1e-5, 1e-2, 1.0, 1e3, 1e6)
PLACES = (0.0, 1.0, 1e3, 1e7)


def columns(rng, count=LANES):
    """Random unit vectors (3, N), float64."""
    v = rng.normal(size=(3, count))
    return v / np.linalg.norm(v, axis=0)


def leaving(rng, n):
    """Directions on the side of `n`, half of them grazing down to a cosine of 1e-8."""
    w, n = columns(rng, n.shape[1]), n.astype(float)
    cosine = np.abs((w * n).sum(0))
    cosine = np.where(rng.random(cosine.size) < 0.5, cosine, 10 ** rng.uniform(-8, 0, cosine.size))
    along = w - n * (w * n).sum(0)
    along /= np.linalg.norm(along, axis=0)
    return np.ascontiguousarray((along * np.sqrt(1 - np.minimum(cosine, 1) ** 2) + n * cosine).astype(np.float32))


def tetrahedra(rng, count, kind, size, place):
    """Corners of closed bodies (count, 4, 3, 3), fronts outside."""
    v = rng.normal(size=(count, 4, 3))
    if kind == "flat":
        v[..., 2] *= 1e-3
    elif kind == "needle":
        v[..., 1:] *= 1e-3
    elif kind in ("axes", "sliver"):
        # Three faces in coordinate planes: nothing is rounded there, so no bound by coordinates alone helps.
        v = np.zeros((count, 4, 3))
        v[:, [1, 2, 3], [0, 1, 2]] = rng.uniform(0.1, 1, (count, 3))
        if kind == "sliver":
            v[:, 2, 1] *= 1e-4
    v = np.float32(v * size + place * columns(rng, count).T[:, None, :])
    t = v[:, SIDES].astype(float)
    n = np.cross(t[:, :, 1] - t[:, :, 0], t[:, :, 2] - t[:, :, 0])
    inward = ((t[:, :, 0] - v.astype(float).mean(1)[:, None]) * n).sum(-1) < 0
    return np.where(inward[..., None, None], t[:, :, [0, 2, 1]], t)


def seen_from_outside(rng, geometry, arena):
    """Random points on the triangles of `geometry`, viewed along their normal."""
    root, x = np.sqrt(rng.random(LANES)), rng.random(LANES)
    prim = rng.integers(0, geometry.triangle_count, LANES).astype(np.int32)
    hits = Hits(np.ones(LANES, np.float32), prim, np.float32(root * (1 - x)), np.float32(root * x))
    d = np.ascontiguousarray(-geometry.facets[prim, NORMAL].T)
    return make_interact(geometry)(hits, d, d, arena)


def false_hits(rng, kinds, shrink=1.0):
    """Rays that leave convex bodies and meet them, and all rays."""
    found = rays = 0
    arena = Arena()
    for kind in kinds:
        for size in SIZES:
            for place in PLACES:
                for corners in tetrahedra(rng, 4, kind, size, place):
                    geometry = Geometry.from_arrays(triangles=corners)
                    if not geometry.facets[:, NORMAL].any(1).all():
                        continue
                    with arena.frame():
                        s = seen_from_outside(rng, geometry, arena)
                        w = leaving(rng, s.ng)
                        # Below a cosine of 1e-7 the side is what float32 says it is, here as in `spawn`.
                        out = dot(w, s.ng, arena) > 0
                        o = spawn(s.p, s.offset * np.float32(shrink), s.ng, w, arena)
                        found += int((Accel(geometry).occluded(o, w, None, arena) & out).sum())
                        rays += int(out.sum())
    return found, rays


def test_no_ray_meets_the_body_that_it_leaves():
    found, rays = false_hits(np.random.default_rng(1), ("round", "flat", "needle", "axes", "sliver"))
    assert rays > 500_000
    assert found == 0


def test_the_fuzz_can_fail():
    found, _ = false_hits(np.random.default_rng(2), ("round", "sliver"), shrink=0.02)
    assert found > 100


@pytest.mark.parametrize("place", [0.0, 1.0, 1e3])
def test_nothing_leaks_out_of_a_closed_body(place):
    """Rays from the inner side of a face meet another one: closed, and not jumped over."""
    rng, arena = np.random.default_rng(3), Arena()
    inside = missed = 0
    for corners in tetrahedra(rng, 20, "axes", 1e3, place):
        geometry = Geometry.from_arrays(triangles=corners)
        with arena.frame():
            s = seen_from_outside(rng, geometry, arena)
            # Beside an edge the step itself leads out.
            reach = np.full(LANES, np.inf)
            for normal, start in zip(geometry.facets[:, NORMAL], geometry.corners[:3].T, strict=True):
                depth = -(normal.astype(float) @ (s.p.astype(float) - start[:, None]))
                reach = np.where(np.abs(normal @ s.ng) < 0.999, np.minimum(reach, depth), reach)
            w = -leaving(rng, s.ng)
            o = spawn(s.p, s.offset, s.ng, w, arena)
            hits = Accel(geometry).intersect(o, w, None, arena)
            clear = (reach > 4 * s.offset) & (dot(w, s.ng, arena) < 0)
            inside += int(clear.sum())
            missed += int(((hits.prim < 0) | (hits.prim == s.prim))[clear].sum())
    assert inside > 30_000
    assert missed == 0


@pytest.mark.parametrize("place", [0.0, 1e4])
def test_no_ray_slips_between_triangles(place):
    """From inside a closed fan around an axis, through every vertex and along every edge."""
    rng, arena = np.random.default_rng(8), Arena()
    angle = np.sort(rng.uniform(0, 2 * np.pi, 200))
    rim = np.float32(np.stack([np.cos(angle), np.sin(angle), 0.1 * np.sin(9 * angle)], -1) + place)
    following = np.roll(rim, -1, axis=0)
    top, bottom = (np.broadcast_to(np.float32([place, place, place + z]), rim.shape) for z in (1, -1))
    fan = np.concatenate([np.stack([rim, following, top], 1), np.stack([following, rim, bottom], 1)])
    share = np.float32(rng.random((50, 1, 1)))
    targets = np.concatenate([fan.reshape(-1, 3), (fan + share[..., None] * (np.roll(fan, 1, 1) - fan)).reshape(-1, 3)])
    o = np.float32(place + 0.2 * columns(rng, len(targets)))
    d = np.ascontiguousarray(targets.T - o)
    assert Accel(Geometry.from_arrays(triangles=fan)).occluded(o, d, None, arena).all()


@pytest.mark.parametrize("native", [True, False])
def test_spheres_are_left_and_crossed(native):
    rng, arena = np.random.default_rng(4), Arena()
    for radius in SIZES:
        for place in PLACES:
            if place > 1e5 * radius:
                continue
            for start in (0.5, 1.5, 1e3):
                geometry = Geometry.from_arrays(centers=[place * columns(rng, 1)[:, 0]], radii=[radius])
                c = geometry.centers.astype(float)
                o = np.float32(c + radius * start * columns(rng))
                target = c + radius * columns(rng) * rng.random(LANES) ** 0.3
                d = np.float32((target - o) / np.linalg.norm(target - o, axis=0))
                accel = Accel(geometry, native)
                with arena.frame():
                    hits = accel.intersect(o, d, None, arena)
                    assert (hits.prim == 0).all()
                    s = make_interact(geometry)(hits, o, d, arena)
                    assert s.ns is s.ng
                    assert (s.front == (start > 1)).all()
                    assert (np.abs(np.linalg.norm(s.p - c, axis=0) - radius) <= s.offset).all()
                    outward = np.ascontiguousarray(np.where(s.front, s.ng, -s.ng))
                    np.testing.assert_allclose(np.linalg.norm(outward, axis=0), 1, atol=1e-6)
                    w = leaving(rng, outward)
                    out = dot(w, outward, arena) > 0
                    o = spawn(s.p, s.offset, s.ng, w, arena)
                    assert not (accel.occluded(o, w, None, arena) & out).any()
                    # A chord's length is 2 r cos.
                    chord = 2 * radius * np.abs((w.astype(float) * outward).sum(0))
                    back = -w
                    hits = accel.intersect(spawn(s.p, s.offset, s.ng, back, arena), back, None, arena)
                    long = out & (chord > 20 * s.offset)
                    assert (hits.prim[long] == 0).all()
                    assert (hits.t[long] > 0.5 * chord[long]).all()


@pytest.mark.parametrize("normal", [(0, 0, 1), (0.3, -0.5, 0.8), (1e-5, 0, 1)])
def test_planes_are_left(normal):
    rng, arena = np.random.default_rng(5), Arena()
    normal = np.array(normal) / np.linalg.norm(normal)
    for distance in (0.0, 1.0, 1e6):
        for scale in (1e-5, 1.0, 1e3, 1e7):
            geometry = Geometry.from_arrays(plane_points=[normal * distance], plane_normals=[normal])
            accel = Accel(geometry)
            o = np.float32(normal[:, None] * distance + scale * rng.normal(size=(3, LANES)))
            d = np.float32(rng.normal(size=(3, LANES)))
            with arena.frame():
                hits = accel.intersect(o, d, None, arena)
                kept = np.flatnonzero(hits.prim == 0)
                hits = Hits(*(a[kept] for a in hits))
                s = make_interact(geometry)(hits, o[:, kept].copy(), d[:, kept].copy(), arena)
                height = geometry.plane_normals[:, 0].astype(float) @ (s.p - geometry.plane_points.astype(float))
                assert (np.abs(height) <= s.offset).all()
                w = leaving(rng, s.ng)
                for side in (w, -w):
                    o2 = spawn(s.p, s.offset, s.ng, side, arena)
                    assert not (accel.occluded(o2, side, None, arena) & (dot(w, s.ng, arena) > 0)).any()


# -- what is seen ------------------------------------------------------------------------------------------------------


def smooth_triangle():
    geometry = Geometry.from_arrays(triangles=[[[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 0, 5], [1, 0, 5], [0, 1, 5]]])
    geometry.facets.view(np.int32)[1, NORMAL_ROW] = 0
    normals = np.float32([[0.6, 0, 0.8, 0, 0.6, 0.8, 0, 0, 1]])
    return replace(geometry, normals=normals)


def look(geometry, o, d):
    arena = Arena()
    o, d = np.float32(o).T.copy(), np.float32(d).T.copy()
    return make_interact(geometry)(Accel(geometry).intersect(o, d, None, arena), o, d, arena)


def test_triangle_from_both_sides():
    s = look(
        Geometry.from_arrays(triangles=[[[0, 0, 2], [1, 0, 2], [0, 1, 2]]]),
        [[0.2, 0.3, 9], [0.2, 0.3, -9]],
        [[0, 0, -1], [0, 0, 1]],
    )
    np.testing.assert_allclose(s.p.T, [[0.2, 0.3, 2]] * 2, atol=1e-6)
    np.testing.assert_array_equal(s.ng.T, [[0, 0, 1], [0, 0, -1]])
    np.testing.assert_array_equal(s.front, [True, False])
    np.testing.assert_array_equal(s.prim, [0, 0])
    assert s.ns is s.ng
    assert all(a.dtype == np.float32 for a in (s.p, s.ng, s.offset))


def test_smooth_lanes_among_flat_ones():
    s = look(smooth_triangle(), [[0.5, 0.25, -1], [0.5, 0.25, 9], [0.5, 0.25, 3]], [[0, 0, 1], [0, 0, -1], [0, 0, 1]])
    np.testing.assert_array_equal(s.prim, [0, 1, 1])
    n = 0.25 * np.array([0.6, 0, 0.8]) + 0.5 * np.array([0, 0.6, 0.8]) + 0.25 * np.array([0, 0, 1])
    n /= np.linalg.norm(n)
    np.testing.assert_allclose(s.ns.T, [[0, 0, -1], n, -n], atol=1e-6)
    np.testing.assert_array_equal(s.ng.T, [[0, 0, -1], [0, 0, 1], [0, 0, -1]])


def test_all_lanes_smooth_equals_some_lanes_smooth():
    o, d = [[0.5, 0.25, 9], [0.1, 0.25, 9]], [[0, 0, -1]] * 2
    alone = look(smooth_triangle(), o, d)
    mixed = look(smooth_triangle(), [*o, [0.5, 0.25, -1]], [*d, [0, 0, 1]])
    np.testing.assert_array_equal(alone.ns, mixed.ns[:, :2])


def test_each_kind_among_others_is_as_alone():
    """Lanes are sorted by kind and put back."""
    rng, arena = np.random.default_rng(6), Arena()
    whole = Geometry.from_arrays(
        triangles=rng.normal(size=(50, 3, 3)),
        centers=rng.normal(size=(5, 3)),
        radii=np.full(5, 0.5),
        plane_points=[[0, 0, -2], [0, 3, 0]],
        plane_normals=[[0, 0, 1], [0, 1, 0]],
    )
    o, d = np.float32(3 * rng.normal(size=(3, LANES))), np.float32(rng.normal(size=(3, LANES)))
    hits = Accel(whole).intersect(o, d, None, arena)
    met = np.flatnonzero(hits.prim >= 0)
    hits, o, d = Hits(*(a[met] for a in hits)), o[:, met].copy(), d[:, met].copy()
    s = make_interact(whole)(hits, o, d, arena)
    assert s.ns is s.ng
    np.testing.assert_allclose(s.p, o + hits.t * d, atol=1e-4, rtol=1e-4)
    assert ((s.ng * d).sum(0) <= 0).all()
    kinds = np.digitize(hits.prim, [50, 55])
    assert set(kinds) == {0, 1, 2}
    ball = kinds == 1
    np.testing.assert_allclose(np.abs((s.p - whole.centers[:, np.where(ball, hits.prim - 50, 0)])[:, ball]).max(), 0.5,
                               atol=0.05)  # fmt: skip
    np.testing.assert_array_equal(s.offset[kinds == 0], whole.facets[hits.prim[kinds == 0], OFFSET])
    smooth = replace(whole, normals=np.ones((1, 9), np.float32))
    np.testing.assert_array_equal(make_interact(smooth)(hits, o, d, arena).ns, s.ng)


def test_few_and_many_triangles_give_the_same_bits(monkeypatch):
    """Few are read column by column, many row by row."""
    rng, arena = np.random.default_rng(8), Arena()
    flat = Geometry.from_arrays(triangles=rng.normal(size=(50, 3, 3)))
    facets = flat.facets.copy()
    facets.view(np.int32)[::2, NORMAL_ROW] = np.arange(25)
    smooth = replace(flat, facets=facets, normals=np.float32(rng.normal(size=(25, 9))))
    for geometry in (flat, smooth):
        few = seen_from_outside(np.random.default_rng(9), geometry, arena)
        with monkeypatch.context() as patch:
            patch.setattr(tables, "_FEW_ROWS", 0)
            many = seen_from_outside(np.random.default_rng(9), geometry, arena)
        for one, other in zip(few, many, strict=True):
            np.testing.assert_array_equal(one, other)
        assert (few.ns is few.ng) == (geometry is flat)


def test_tables_by_column_and_by_row_give_the_same_bits(monkeypatch):
    """Of UV maps too, and of primitives beyond a table, which are none of its triangles."""
    rng, arena = np.random.default_rng(10), Arena()
    table, prim = np.float32(rng.normal(size=(5, 9))), np.arange(8, dtype=np.int32)
    u, v = np.float32(rng.uniform(0, 0.5, size=(2, 8)))
    geometry = Geometry.from_arrays(triangles=rng.normal(size=(5, 3, 3)), centers=np.eye(3), radii=np.ones(3))
    by_column = in_reading_order(table)
    assert not by_column.flags.c_contiguous
    found = corner_values_at(by_column, prim, u, v, arena)
    np.testing.assert_array_equal(found, corner_values_at(table, prim, u, v, arena))
    weights = np.stack([1 - u - v, u, v])
    np.testing.assert_allclose(found[:, :5], np.einsum("tjc,jt->ct", table.reshape(5, 3, 3), weights[:, :5]), rtol=1e-5)
    assert not found[:, 5:].any()
    corners = [slice(0, 3), slice(3, 6), slice(6, 9)]
    one, other = (interpolate_rows(t, corners, prim, u, v, arena) for t in (by_column, table))
    np.testing.assert_array_equal(one, other)
    maps = [replace(geometry, uvs={"": order(table[:, :6])}) for order in (in_reading_order, np.ascontiguousarray)]
    one, other = (uv_at(g, "", prim, u, v, arena) for g in maps)
    np.testing.assert_array_equal(one, other)
    assert not one[:, 5:].any() and one[:, :5].all()
    with monkeypatch.context() as patch:
        patch.setattr(tables, "_FEW_ROWS", 4)
        assert in_reading_order(table) is table


def test_no_lanes():
    for geometry in (smooth_triangle(), Geometry.from_arrays(centers=[[0, 0, 0]], radii=[1])):
        none = np.zeros((3, 0), np.float32)
        hits = Hits(none[0], np.zeros(0, np.int32), none[0], none[0])
        assert make_interact(geometry)(hits, none, none, Arena()).p.shape == (3, 0)
    assert make_interact(Geometry.from_arrays())(hits, none, none, Arena()).p.shape == (3, 0)


# -- shadow rays -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("scale", [1e-4, 1.0, 1e4])
def test_shadow_ray_ends_before_the_lights_surface(scale):
    """Between two facing squares all is free, and blocked with a third one in the middle."""
    rng, arena = np.random.default_rng(7), Arena()
    square = np.float32([[[0, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 0, 0], [1, 1, 0], [0, 1, 0]]])
    lamp, blocker = square + np.float32([0, 0, 1]), 3 * square - np.float32([1, 1, -0.5])
    shift = np.float32([0.3, -0.7, 11])
    between = Geometry.from_arrays(triangles=scale * (np.concatenate([square, lamp]) + shift))
    s = seen_from_outside(rng, between, arena)
    start = np.flatnonzero(s.prim < 2)
    p, offset, ng = s.p[:, start].copy(), s.offset[start], s.ng[:, start].copy()
    target = np.float32(scale * (np.vstack([rng.random((2, start.size)), np.ones(start.size)]) + shift[:, None]))
    to = (target - p).astype(float)
    distance = np.linalg.norm(to, axis=0)
    w = np.ascontiguousarray((to / distance).astype(np.float32))
    distance = distance.astype(np.float32)
    o, d, tmax = spawn_to(p, offset, ng, w, distance, arena)
    assert not Accel(between).occluded(o, d, tmax, arena).any()
    assert Accel(between).occluded(o, d, distance * np.float32(1.001), arena).all()
    third = Geometry.from_arrays(triangles=scale * (np.concatenate([square, lamp, blocker]) + shift))
    assert Accel(third).occluded(o, d, tmax, arena).all()
    assert (dot(w, ng, arena) > 0).all()
    for known, found in zip(spawn_to(p, offset, ng, w, distance, arena, in_front=True), (o, d, tmax), strict=True):
        np.testing.assert_array_equal(known, found)
    _, d, tmax = spawn_to(p, offset, ng, w, np.float32(np.inf), arena)
    assert np.isinf(tmax).all()
    np.testing.assert_array_equal(d, w)
