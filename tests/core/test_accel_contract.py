# SPDX-License-Identifier: GPL-3.0-or-later
"""What `core.accel` relies on: embreex's behaviour, which its own tests do not assert, and both ways of attaching."""

import importlib.util
import os
import sys
from pathlib import Path
from threading import Thread

import numpy as np
import pytest
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore import EmbreeDevice
from embreex.rtcore_scene import EmbreeScene

from zraka.core import accel as accel_module
from zraka.core.accel import Accel
from zraka.core.arena import Arena
from zraka.core.geometry import Geometry

TRIANGLE = np.float32([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]])
UP, DOWN = np.float32([[0, 0, 1]]), np.float32([[0, 0, -1]])
ABOVE = np.float32([[0.25, 0.5, 2]])


@pytest.fixture
def scene():
    made = EmbreeScene(EmbreeDevice(), robust=True)
    TriangleMesh(made, TRIANGLE)
    return made


# -- embreex -----------------------------------------------------------------------------------------------------------


def test_intersect_reports_distance_in_units_of_d_and_barycentrics(scene):
    hit = scene.run(ABOVE, 2 * DOWN, query="INTERSECT", output=True)
    assert hit["tfar"] == pytest.approx(1)
    np.testing.assert_allclose([hit["u"][0], hit["v"][0]], [0.25, 0.5], atol=1e-6)
    assert hit["primID"] == 0
    assert hit["geomID"] == 0
    assert {hit[k].dtype for k in ("tfar", "u", "v")} == {np.dtype(np.float32)}
    assert hit["primID"].dtype == hit["geomID"].dtype == np.int32


def test_miss_is_minus_one(scene):
    hit = scene.run(ABOVE, UP, query="INTERSECT", output=True)
    assert hit["primID"] == -1
    assert hit["geomID"] == -1
    assert hit["tfar"] > 1e36


def test_distances_given_are_limits_and_are_overwritten(scene):
    limit = np.float32([1.9])
    assert scene.run(ABOVE, DOWN, dists=limit, query="INTERSECT", output=True)["primID"] == -1
    limit = np.float32([9])
    scene.run(ABOVE, DOWN, dists=limit, query="INTERSECT", output=True)
    assert limit == pytest.approx(2), "embreex no longer writes into dists: the copy in Accel.intersect can go"
    limit = np.float32([9])
    scene.run(ABOVE, DOWN, dists=limit, query="OCCLUDED")
    assert limit == 9.0


def test_occluded_is_zero_and_free_is_minus_one(scene):
    both = np.float32([[0, 0, -1], [0, 0, 1]])
    np.testing.assert_array_equal(scene.run(np.repeat(ABOVE, 2, 0), both, query="OCCLUDED"), [0, -1])
    near = np.float32([1.9, 2.1])
    np.testing.assert_array_equal(
        scene.run(np.repeat(ABOVE, 2, 0), np.repeat(DOWN, 2, 0), dists=near, query="OCCLUDED"), [-1, 0]
    )


def test_columns_go_in_without_a_copy_and_one_direction_serves_all(scene):
    rng = np.random.default_rng(1)
    o, d = np.float32(rng.normal(size=(3, 500))), np.float32(rng.normal(size=(3, 500)))
    strided = scene.run(o.T, d.T, query="INTERSECT", output=True)
    dense = scene.run(o.T.copy(), d.T.copy(), query="INTERSECT", output=True)
    for name in ("primID", "tfar", "u", "v"):
        np.testing.assert_array_equal(strided[name], dense[name])
    one = scene.run(o.T, d[:, :1].T, query="OCCLUDED")
    np.testing.assert_array_equal(one, scene.run(o.T, np.repeat(d[:, :1], 500, 1).T, query="OCCLUDED"))


def test_a_ray_that_starts_on_a_surface_hits_it(scene):
    on = ABOVE * np.float32([1, 1, 0])
    hit = scene.run(on, UP, query="INTERSECT", output=True)
    assert hit["primID"] == 0
    assert hit["tfar"] == 0.0


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_rays_that_are_no_rays_miss(scene, bad):
    assert scene.run(ABOVE * np.float32(bad), DOWN, query="OCCLUDED") == -1
    assert scene.run(ABOVE, DOWN * np.float32(0), query="OCCLUDED") == -1


def test_no_rays_and_no_geometry_are_fine():
    empty = EmbreeScene(EmbreeDevice())
    none = np.zeros((0, 3), np.float32)
    assert empty.run(ABOVE, DOWN, query="OCCLUDED") == -1
    assert empty.run(none, none, query="INTERSECT", output=True)["primID"].size == 0


def test_float64_is_refused(scene):
    with pytest.raises(ValueError, match="dtype"):
        scene.run(ABOVE.astype(float), DOWN, query="OCCLUDED")


def test_geometry_added_after_the_first_ray_is_ignored(scene):
    scene.run(ABOVE, DOWN, query="OCCLUDED")
    TriangleMesh(scene, TRIANGLE + np.float32([0, 0, 1]))
    assert scene.run(ABOVE, DOWN, query="INTERSECT", output=True)["tfar"] == pytest.approx(2)


# -- both ways of attaching --------------------------------------------------------------------------------------------


def mixed_geometry(rng):
    return Geometry.from_arrays(
        triangles=rng.normal(size=(500, 1, 3)) + 0.2 * rng.normal(size=(500, 3, 3)),
        centers=rng.normal(size=(20, 3)),
        radii=rng.uniform(0.05, 0.2, 20),
        plane_points=[[0, 0, -2]],
        plane_normals=[[0, 0, 1]],
    )


def random_rays(rng, count=20000):
    return np.float32(3 * rng.normal(size=(3, count))), np.float32(rng.normal(size=(3, count)))


def same_hits():
    """Both routes against each other; the body of the test under another Embree too."""
    rng, arena = np.random.default_rng(2), Arena()
    geometry = mixed_geometry(rng)
    o, d = random_rays(rng)
    inside = np.repeat(geometry.centers, 100, axis=1)
    o[:, : inside.shape[1]] = inside
    tmax = np.float32(rng.exponential(5, o.shape[1]))
    fast, slow = Accel(geometry), Accel(geometry, native=False)
    assert fast.native
    assert not slow.native
    for limit in (None, tmax):
        kept = tmax.copy()
        a, b = fast.intersect(o, d, limit, arena), slow.intersect(o, d, limit, arena)
        # Where two surfaces are equally near, rounding decides.
        differ = a.prim != b.prim
        assert differ.mean() < 1e-3
        np.testing.assert_allclose(a.t[differ], b.t[differ], rtol=1e-5)
        hit = (a.prim >= 0) & ~differ
        assert set(np.unique(np.digitize(a.prim[hit], [500, 520]))) == {0, 1, 2}
        np.testing.assert_allclose(a.t[hit], b.t[hit], rtol=1e-5, atol=1e-6)
        for accel, hits in ((fast, a), (slow, b)):
            np.testing.assert_array_equal(accel.occluded(o, d, limit, arena), hits.prim >= 0)
        np.testing.assert_array_equal(tmax, kept)


def test_both_routes_find_the_same_hits():
    same_hits()


def test_the_same_under_blenders_embree(run_python):
    bpy = importlib.util.find_spec("bpy")
    library = Path(bpy.origin).parent / "lib" / "libembree4.so.4" if bpy and bpy.origin else None
    if not sys.platform.startswith("linux") or library is None or not library.exists():
        pytest.skip("needs the bpy module for Linux")
    here = Path(__file__)
    body = (
        f"import importlib.util; s = importlib.util.spec_from_file_location('t', {str(here)!r});"
        "m = importlib.util.module_from_spec(s); s.loader.exec_module(m); m.same_hits();"
        "print('same, library', m.accel_module._loaded_library()._name)"
    )
    done = run_python("-c", body, env={**os.environ, "LD_PRELOAD": str(library)})
    assert done.returncode == 0, done.stdout + done.stderr
    assert "same, library None" in done.stdout


@pytest.mark.parametrize("breakage", ["layout", "library", "refusal"])
def test_falls_back_when_embree_cannot_be_reached(monkeypatch, breakage):
    if breakage == "layout":
        monkeypatch.setattr(accel_module, "_DEVICE_OBJECT_AT", 24)
    elif breakage == "library":
        monkeypatch.setattr(accel_module, "_library", lambda: None)
    else:
        monkeypatch.setattr(accel_module._Api, "attach", lambda self, kind, buffers: False)
    accel_module._sees_inside.cache_clear()
    rng, arena = np.random.default_rng(3), Arena()
    geometry = mixed_geometry(rng)
    o, d = random_rays(rng, 2000)
    found = Accel(geometry).intersect(o, d, None, arena)
    accel_module._sees_inside.cache_clear()
    np.testing.assert_array_equal(found.prim, Accel(geometry, native=False).intersect(o, d, None, arena).prim)


@pytest.mark.parametrize(("count", "missed"), [(64, False), (65, True)])
def test_few_spheres_are_seen_from_inside_even_where_embree_culls(monkeypatch, count, missed):
    monkeypatch.setattr(accel_module, "_sees_inside", lambda: False)
    centers = np.zeros((count, 3))
    centers[:, 0] = 3 * np.arange(count)
    geometry, arena = Geometry.from_arrays(centers=centers, radii=np.ones(count)), Arena()
    accel = Accel(geometry)
    assert accel.insides_missed == missed
    assert accel.native
    rng = np.random.default_rng(10)
    o, d = random_rays(rng, 2000)
    o[2] += 20
    d[2] -= 5
    found, expected = (a.intersect(o, d, None, arena).prim for a in (accel, Accel(geometry, native=False)))
    np.testing.assert_array_equal(found, expected)


def test_attaching_copies_no_triangle_and_outlives_its_geometry():
    rng, arena = np.random.default_rng(4), Arena()
    geometry = Geometry.from_arrays(triangles=rng.random((20000, 1, 3)) + 0.01 * rng.random((20000, 3, 3)))
    o, d = random_rays(rng, 5000)
    accel = Accel(geometry)
    assert any(b is geometry.vertices for b in accel._buffers)
    before = accel.intersect(o, d, None, arena).prim.copy()
    del geometry
    junk = [np.ones((20000, 16), np.float32) for _ in range(20)]
    np.testing.assert_array_equal(accel.intersect(o, d, None, arena).prim, before)
    del junk


# -- the interface -----------------------------------------------------------------------------------------------------


def test_lengths_that_do_not_fit_are_refused():
    accel, arena = Accel(Geometry.from_arrays(triangles=TRIANGLE)), Arena()
    o, d = np.zeros((3, 5), np.float32), np.ones((3, 5), np.float32)
    for bad in ((o, d[:, :4], None), (o, d, np.ones(4, np.float32))):
        with pytest.raises(ValueError, match="rays do not fit"):
            accel.intersect(*bad, arena)
        with pytest.raises(ValueError, match="rays do not fit"):
            accel.occluded(*bad, arena)


def test_one_direction_serves_all_kinds_of_primitive():
    rng, arena = np.random.default_rng(5), Arena()
    geometry = mixed_geometry(rng)
    o = np.float32(rng.normal(size=(3, 3000)))
    d = np.float32([[0.3], [0.2], [-1]])
    for native in (True, False):
        accel = Accel(geometry, native)
        one, all_ = accel.intersect(o, d, None, arena), accel.intersect(o, np.tile(d, 3000), None, arena)
        np.testing.assert_array_equal(one.prim, all_.prim)
        np.testing.assert_array_equal(one.t, all_.t)


def test_nothing_at_all_is_never_hit():
    accel, arena = Accel(Geometry.from_arrays()), Arena()
    o = np.zeros((3, 7), np.float32)
    d = np.ones((3, 7), np.float32)
    assert (accel.intersect(o, d, None, arena).prim == -1).all()
    assert not accel.occluded(o, d, None, arena).any()


def test_rays_that_are_no_rays_miss_every_kind():
    rng, arena = np.random.default_rng(6), Arena()
    o, d = random_rays(rng, 6)
    o[0, 0], d[1, 1], o[2, 2], d[:, 3], o[:, 4], d[0, 5] = np.nan, np.nan, np.inf, 0, np.inf, np.nan
    for native in (True, False):
        accel = Accel(mixed_geometry(rng), native)
        assert (accel.intersect(o, d, None, arena).prim == -1).all()
        assert not accel.occluded(o, d, np.full(6, np.inf, np.float32), arena).any()


def test_clock_counts_the_time_in_embree():
    class Clock:
        seconds = 0.0

    rng, arena, clock = np.random.default_rng(7), Arena(), Clock()
    accel = Accel(mixed_geometry(rng))
    o, d = random_rays(rng)
    accel.intersect(o, d, None, arena, clock)
    first = clock.seconds
    accel.occluded(o, d, None, arena, clock)
    assert 0 < first < clock.seconds


def test_threads_agree():
    rng = np.random.default_rng(8)
    accel = Accel(mixed_geometry(rng))
    o, d = random_rays(rng)
    expected = accel.intersect(o, d, None, Arena()).prim
    found = [None] * 4

    def work(i):
        found[i] = accel.intersect(o, d, None, Arena()).prim

    threads = [Thread(target=work, args=(i,)) for i in range(4)]
    for t in threads:
        t.start()
    for t in threads:
        t.join()
    for f in found:
        np.testing.assert_array_equal(f, expected)


# -- closed forms ------------------------------------------------------------------------------------------------------


def nearest(geometry, o, d, native=True):
    arena = Arena()
    o, d = np.float32(o).reshape(1, 3).T.copy(), np.float32(d).reshape(1, 3).T.copy()
    hits = Accel(geometry, native).intersect(o, d, None, arena)
    return float(hits.t[0]) if hits.prim[0] >= 0 else None


@pytest.mark.parametrize(
    ("o", "d", "expected"),
    [
        ((0, 0, 3), (0, 0, -1), 2.0),
        ((0, 0, 3), (0, 0, -2), 1.0),
        ((1, 0, 3), (0.5, 0, -1), 2.0),
        ((0, 0, -3), (0, 0, 1), 4.0),  # from below
        ((0, 0, 3), (0, 0, 1), None),  # behind
        ((0, 0, 3), (1, 0, 0), None),  # parallel
        ((0, 0, 1), (1, 0, 0), None),  # in it
        ((0, 0, 1), (1, 0, -1), 0.0),  # starts on it
        ((0, 0, 1), (1, 0, 1), 0.0),
    ],
)
def test_plane(o, d, expected):
    assert nearest(Geometry.from_arrays(plane_points=[[5, 6, 1]], plane_normals=[[0, 0, 1]]), o, d) == expected


@pytest.mark.parametrize("native", [True, False])
@pytest.mark.parametrize(
    ("o", "d", "expected"),
    [
        ((0, 0, 5), (0, 0, -1), 3.0),
        ((0, 0, 5), (0, 0, -2), 1.5),
        ((0, 0, 5), (0, 0, 1), None),  # behind
        ((0, 0, 1), (0, 0, 1), 1.0),  # inside
        ((0, 0, 0), (0, 3, 4), 0.4),
        ((2 - 1e-6, 0, 5), (0, 0, -1), 5.0),  # all but tangent
        ((2 + 1e-5, 0, 5), (0, 0, -1), None),
        ((9, 9, 9), (0, 0, -1), None),
    ],
)
def test_sphere(native, o, d, expected):
    found = nearest(Geometry.from_arrays(centers=[[0, 0, 0]], radii=[2]), o, d, native)
    assert (found is None) == (expected is None)
    if expected is not None:
        assert found == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("native", [True, False])
def test_sphere_from_its_surface_and_tangent(native):
    geometry = Geometry.from_arrays(centers=[[0, 0, 0]], radii=[2])
    # A zero root may fall to either side; the other root is 4 or behind.
    inward, outward = nearest(geometry, (0, 0, 2), (0, 0, -1), native), nearest(geometry, (0, 0, 2), (0, 0, 1), native)
    assert min(abs(inward), abs(inward - 4)) < 1e-6
    assert outward is None or abs(outward) < 1e-6
    tangent = nearest(geometry, (2, 0, 5), (0, 0, -1), native)
    assert tangent is None or tangent == pytest.approx(5, abs=1e-3)


@pytest.mark.parametrize("native", [True, False])
def test_spheres_against_the_quadratic(native):
    """Roots in float64, with both sides of every sphere seen."""
    rng, arena = np.random.default_rng(9), Arena()
    for radius in (1e-3, 1.0, 1e4):
        geometry = Geometry.from_arrays(centers=[[0.5, -1, 2]], radii=[radius])
        c = geometry.centers.astype(float)
        o = np.float32(c + 2 * radius * rng.normal(size=(3, 4000)))
        d = np.float32(c + radius * rng.normal(size=(3, 4000)) - o)
        hits = Accel(geometry, native).intersect(o, d, None, arena)
        a, b = (d.astype(float) ** 2).sum(0), ((o - c) * d).sum(0)
        root = b * b - a * (((o - c) ** 2).sum(0) - radius**2)
        with np.errstate(invalid="ignore"):
            t = np.where(b + np.sqrt(root) < 0, (-b - np.sqrt(root)) / a, (-b + np.sqrt(root)) / a)
        sure = np.abs(root) > 1e-3 * b * b
        np.testing.assert_array_equal(hits.prim[sure] >= 0, ((root > 0) & (t > 0))[sure])
        hit = sure & (hits.prim >= 0)
        assert hit.sum() > 1000
        np.testing.assert_allclose(hits.t[hit], t[hit], rtol=1e-3, atol=1e-4)


def test_nearest_of_many_planes_and_spheres():
    geometry = Geometry.from_arrays(
        centers=[[0, 0, 0], [0, 0, 4]],
        radii=[1, 1],
        plane_points=[[0, 0, -3], [0, 0, 6]],
        plane_normals=[[0, 0, 1], [0, 0, -1]],
    )
    o = np.float32([[0, 0, 5.5], [0, 0, 2], [0, 0, 2], [5, 0, 2], [5, 0, 2]]).T.copy()
    d = np.float32([[0, 0, -1], [0, 0, -1], [0, 0, 1], [0, 0, -1], [0, 0, 1]]).T.copy()
    for native in (True, False):
        hits = Accel(geometry, native).intersect(o, d, None, Arena())
        np.testing.assert_array_equal(hits.prim, [1, 0, 1, 2, 3])
        np.testing.assert_allclose(hits.t, [0.5, 1, 1, 5, 4], atol=1e-6)
