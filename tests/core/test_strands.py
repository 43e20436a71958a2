# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair: tubes around splines, what nodes know of them, and rays that leave them."""

from __future__ import annotations

import importlib.util
import os
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from zraka.core import accel as accel_module
from zraka.core.accel import Accel
from zraka.core.arena import Arena
from zraka.core.compile import compile_scene, round_tables
from zraka.core.compile.geometry import compile_geometry
from zraka.core.compile.needs import needs_of
from zraka.core.compile.round_tables import intercepts
from zraka.core.diagnostics import Diagnostics, SceneError
from zraka.core.interaction import corner_values_at, make_interact, spawn
from zraka.core.render import render
from zraka.core.scene import Attribute, Camera, Curves, Instance, Link, Material, Mesh, Node, Scene, Spheres, World
from zraka.core.settings import Settings

CAMERA = Camera(np.eye(4))


def straight(radius=0.1, length=2.0, **more):
    """A tube along X, from 0 to `length`."""
    points = np.stack([np.linspace(0, length, 5), np.zeros(5), np.zeros(5)], axis=1)
    return Curves(points, np.full(5, radius), np.array([5]), **more)


def bent(count=300, radius=0.01, seed=0):
    """Strands that bend, in a box around 0."""
    rng = np.random.default_rng(seed)
    t = np.linspace(-1, 1, 7)[:, None]
    points = (
        rng.uniform(-1, 1, (count, 1, 3)) * (1, 1, 0) + t * (0, 0, 1) + 0.2 * np.sin(3 * t + rng.random((count, 1, 3)))
    )
    return Curves(points.reshape(-1, 3), np.full(7 * count, radius), np.full(count, 7))


def geometry_of(*curves, **more):
    return compile_geometry(Scene(CAMERA, curves=curves), **more)


def hits_of(geometry, o, d):
    arena = Arena()
    o, d = (np.float32(np.broadcast_to(np.reshape(v, (3, -1)), (3, np.size(o) // 3))).copy() for v in (o, d))
    hits = Accel(geometry).intersect(o, d, None, arena)
    met = np.flatnonzero(hits.prim >= 0)
    dense = type(hits)(*(column[met] for column in hits))
    return hits, make_interact(geometry)(dense, o[:, met], d[:, met], arena)


# -- where rays meet them ----------------------------------------------------------------------------------------------


def cylinder_hits():
    """Rays across a straight tube; the body of the test under another Embree too."""
    rng = np.random.default_rng(1)
    x, y = rng.uniform(0.1, 1.9, 4000), rng.uniform(-0.15, 0.15, 4000)
    geometry = geometry_of(straight())
    o = np.stack([x, y, np.full(4000, 3.0)]) - geometry.origin[:, None]
    hits, _ = hits_of(geometry, o, np.tile([[0.0], [0.0], [-1.0]], 4000))
    sure = np.abs(np.abs(y) - 0.1) > 1e-4
    np.testing.assert_array_equal((hits.prim >= 0)[sure], (np.abs(y) < 0.1)[sure])
    met = sure & (hits.prim >= 0)
    np.testing.assert_allclose(hits.t[met], 3 - np.sqrt(0.01 - y[met] ** 2), atol=2e-4)
    met &= (x > 0.5) & (x < 1.5)  # elsewhere u is not the share of the segment's length
    np.testing.assert_allclose((hits.prim + hits.u)[met] / 4, x[met] / 2, atol=1e-3)


def test_a_straight_strand_is_a_cylinder():
    cylinder_hits()


def test_the_same_under_blenders_embree(run_python):
    bpy = importlib.util.find_spec("bpy")
    library = Path(bpy.origin).parent / "lib" / "libembree4.so.4" if bpy and bpy.origin else None
    if not sys.platform.startswith("linux") or library is None or not library.exists():
        pytest.skip("needs the bpy module for Linux")
    here = Path(__file__)
    body = (
        f"import importlib.util; s = importlib.util.spec_from_file_location('t', {str(here)!r});"
        "m = importlib.util.module_from_spec(s); s.loader.exec_module(m); m.cylinder_hits();"
        "m.rays_that_are_no_rays(); m.rays_from_inside(); print('same', m.accel_module._loaded_library()._name)"
    )
    done = run_python("-c", body, env={**os.environ, "LD_PRELOAD": str(library)})
    assert done.returncode == 0, done.stdout + done.stderr
    assert "same None" in done.stdout


def test_points_and_normals_lie_on_the_tube():
    geometry = geometry_of(straight(transform=np.diag([2.0, 2.0, 2.0, 1.0])))
    rng = np.random.default_rng(2)
    o = np.stack([rng.uniform(0.2, 3.8, 2000), rng.uniform(-0.19, 0.19, 2000), np.full(2000, 3.0)])
    hits, surface = hits_of(geometry, o - geometry.origin[:, None], np.tile([[0.0], [0.0], [-1.0]], 2000))
    assert (hits.prim >= 0).all()
    away = surface.p.astype(float) + geometry.origin[:, None]
    np.testing.assert_allclose(np.hypot(away[1], away[2]), 0.2, rtol=1e-5)
    np.testing.assert_allclose(surface.ng[1:], away[1:] / 0.2, atol=1e-4)
    assert surface.front.all()


def test_a_tapered_strand_is_as_wide_as_its_radius():
    taper = Curves([(0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0)], [0.4, 0.3, 0.2, 0.1], [4])
    geometry = geometry_of(taper)
    for x in (1.0, 1.5, 2.0):  # between its inner points a Catmull-Rom spline is straight
        y = np.linspace(0.0, 0.5, 2001)
        o = np.stack([np.full(2001, x), y, np.full(2001, 3.0)]) - geometry.origin[:, None]
        hits, _ = hits_of(geometry, o, np.tile([[0.0], [0.0], [-1.0]], 2001))
        assert y[hits.prim >= 0].max() == pytest.approx(0.4 - 0.1 * x, rel=0.02)


def test_strands_go_through_their_points():
    geometry = geometry_of(bent(20))
    arena, rows = Arena(), np.arange(geometry.segment_count)
    vertices = geometry.strands.vertices[:, :3]
    for u, k in ((0.0, 1), (1.0, 2)):
        at = geometry.strands.at(rows, np.full(rows.size, u, np.float32), arena)[:3].T
        np.testing.assert_allclose(at, vertices[geometry.strands.index + k], atol=1e-6)
    along = geometry.strands.along(rows, np.full(rows.size, 0.5, np.float32), arena)
    np.testing.assert_allclose(np.sqrt((along**2).sum(0)), 1, atol=1e-6)
    assert (along[2] > 0).all()


def test_numbers_run_on_behind_triangles_and_spheres():
    mesh = Mesh(np.float32([[0, 0, -5], [1, 0, -5], [0, 1, -5]]), np.array([[0, 1, 2]]))
    spheres = Spheres(np.array([[5.0, 0, 0], [9.0, 0, 0]]), np.array([0.5, 0.5]))
    scene = Scene(CAMERA, (Instance(mesh),), (spheres,), curves=(straight(), straight(transform=np.eye(4))))
    geometry = compile_geometry(scene)
    assert (geometry.first_segment, geometry.segment_count, geometry.count) == (3, 8, 11)
    assert geometry.object.tolist() == [0, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3]
    for o, prims in (((5, 0, 3), {1}), ((9, 0, 3), {2}), ((0.7, 0, 3), {4, 8}), ((0.2, 0.2, 3), {0})):
        hits, _ = hits_of(geometry, np.array(o, float) - geometry.origin, (0.0, 0.0, -1.0))
        assert int(hits.prim[0]) in prims


# -- rays that leave and rays that are none ----------------------------------------------------------------------------


@pytest.mark.parametrize("radius", [1e-3, 1e-2, 0.1])
@pytest.mark.parametrize("away", [0.0, 1e3])
def test_rays_that_leave_a_strand_do_not_meet_it_again(radius, away):
    rng, count = np.random.default_rng(3), 20000
    geometry = geometry_of(straight(radius), Curves([(away, 0, 0), (away + 1, 0, 0)], [radius, radius], [2]))
    y = rng.uniform(-0.99, 0.99, count) * radius
    o = np.stack([rng.uniform(0.1, 1.9, count), y, np.full(count, 1.0)]) - geometry.origin[:, None]
    hits, surface = hits_of(geometry, o, np.tile([[0.0], [0.0], [-1.0]], count))
    assert (hits.prim >= 0).mean() > 0.999
    w = np.float32(rng.normal(size=surface.p.shape))
    w *= np.sign((w * surface.ng).sum(0)) / np.sqrt((w * w).sum(0))
    arena = Arena()
    again = Accel(geometry).occluded(spawn(surface.p, surface.offset, surface.ng, w, arena), w, None, arena)
    assert again.mean() < 1e-3


def rays_from_inside():
    """They leave their strand unseen, and meet what lies beyond; the body of the test under another Embree too."""
    rng, count, arena = np.random.default_rng(5), 5000, Arena()
    below = Mesh(np.float32([[-9, -9, -1], [9, -9, -1], [0, 9, -1]]), np.array([[0, 1, 2]]))
    scene = Scene(CAMERA, (Instance(below),), curves=(straight(), straight(transform=_moved((0, 0, -0.5)))))
    geometry = compile_geometry(scene)
    accel = Accel(geometry)
    o = np.stack([rng.uniform(0.1, 1.9, count), rng.uniform(-0.03, 0.03, count), rng.uniform(-0.03, 0.03, count)])
    o = np.float32(o - geometry.origin[:, None])
    for z, segments in ((1.0, set()), (-1.0, {5, 6, 7, 8})):
        d = np.float32([[0.0], [0.0], [z]])
        for way in (d, np.tile(d, count)):
            hits = accel.intersect(o, way, None, arena)
            assert set(hits.prim.tolist()) - {-1} == segments
            np.testing.assert_array_equal(accel.occluded(o, way, None, arena), hits.prim >= 0)
            near = np.full(count, 0.3, np.float32)  # ends between both
            assert not accel.occluded(o, way, near, arena).any()
            assert (accel.intersect(o, way, near, arena).prim == -1).all()
    depth = accel.intersect(o, d, None, arena).t + geometry.origin[2] - (o[2] + geometry.origin[2])
    y = o[1] + geometry.origin[1]
    np.testing.assert_allclose(depth - geometry.origin[2], 0.5 - np.sqrt(0.01 - y**2), atol=2e-3)


def _moved(by):
    matrix = np.eye(4)
    matrix[:3, 3] = by
    return matrix


def test_a_strand_is_not_seen_from_inside():
    rays_from_inside()


def test_a_strand_is_seen_into_through_its_open_end():
    """Rays that came in by an end meet the inside, also of a piece that is left between others that are not there."""
    geometry, arena = geometry_of(straight()), Arena()
    accel = Accel(geometry)
    o = np.float32(np.array([[-1.0], [0.0], [0.0]]) - geometry.origin[:, None])
    d = np.float32([[1.0], [0.0], [0.08]])  # meets the wall at x = 0.25
    hits = accel.intersect(o, d, None, arena)
    assert hits.prim.tolist() == [0]
    np.testing.assert_allclose(hits.t, 1.25, rtol=1e-3)
    assert accel.occluded(o, d, None, arena).all()
    surface = make_interact(geometry)(hits, o, d, arena)
    assert not surface.front.any()
    assert surface.ng[2, 0] < -0.99
    aside = np.float32([[1.0], [0.0], [0.2]])  # passes the end by
    assert accel.intersect(o, aside, None, arena).prim.tolist() == [-1]
    within = o + np.float32([[1.0 + 1e-6], [0.0], [0.0]])
    assert accel.intersect(within, d, None, arena).prim.tolist() == [-1]
    rest = Accel(replace(geometry, strands=geometry.strands.part(np.array([False, False, True, True]))))
    assert rest.intersect(o, np.float32([[1.0], [0.0], [0.044]]), None, arena).prim.tolist() == [0]


def rays_that_are_no_rays():
    geometry, arena, rng = geometry_of(bent()), Arena(), np.random.default_rng(4)
    accel = Accel(geometry)
    o, d = np.float32(rng.normal(size=(3, 5000))), np.float32(rng.normal(size=(3, 5000)))
    d = np.float32(-o + 0.3 * d)
    whole = accel.intersect(o, d, None, arena).prim.copy()
    for value in (np.nan, np.inf):
        for vectors in (o, d):
            bad = vectors.copy()
            bad[:, ::7] = value
            rays = (bad, d) if vectors is o else (o, bad)
            found = accel.intersect(*rays, None, arena).prim
            assert (found[::7] == -1).all()
            sound = np.arange(5000) % 7 > 0
            np.testing.assert_array_equal(found[sound], whole[sound])
            assert not accel.occluded(*rays, None, arena)[::7].any()


def test_rays_that_are_no_rays_miss():
    rays_that_are_no_rays()


def test_without_embrees_curves_the_rest_is_rendered_and_it_is_said(monkeypatch):
    monkeypatch.setattr(accel_module, "_library", lambda: None)
    diagnostics = Diagnostics()
    spheres = Spheres(np.array([[0.0, 0, -3]]), np.array([1.0]), Material.emission())
    scene = Scene(CAMERA, spheres=(spheres,), curves=(straight(),))
    settings = Settings(width=8, height=8, samples=1)
    film = render(compile_scene(scene, settings, diagnostics), settings)
    assert film.mean().max() > 0.5
    assert any("curves are not rendered" in m for m in diagnostics.messages())


# -- what is described -------------------------------------------------------------------------------------------------


def test_what_cannot_be_hit_is_left_out_and_said():
    diagnostics = Diagnostics()
    points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (np.nan, 1, 0), (5, 5, 5), (0, 2, 0), (1, 2, 0), (2, 2, 0)]
    geometry = geometry_of(Curves(points, [0.1] * 5 + [0.1, 0, 0], [2, 2, 1, 3], name="Fur"), diagnostics=diagnostics)
    assert geometry.segment_count == 2
    assert diagnostics.messages() == [
        "pieces of strands without radius or with coordinates that are not finite were left out (Fur, 2 times)"
    ]
    assert geometry_of(Curves(np.zeros((1, 3)), [0.1], [1])).strands is None


def test_strands_of_which_nothing_is_left_are_said():
    """Where one piece was left it was told, where none was, nothing."""
    diagnostics = Diagnostics()
    assert geometry_of(Curves(np.zeros((2, 3)), [0.0, 0.0], [2], name="Fur"), diagnostics=diagnostics).strands is None
    assert "left out (Fur)" in diagnostics.messages()[0]


def test_infinite_points_are_left_out_without_a_warning():
    """Times the zeros of a transform they are NaN, of which numpy warned."""
    points = [(0, 0, 0), (1, 0, 0), (2, 0, np.inf)]
    assert geometry_of(Curves(points, [0.1] * 3, [3])).segment_count == 0
    points = [*points, (0, 5, 0), (1, 5, 0)]
    assert geometry_of(Curves(points, [0.1] * 5, [3, 2])).segment_count == 1


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_bad_point_leaves_the_other_strands_their_lengths(bad):
    """Lengths are differences of a running sum, which it made NaN for all strands that follow."""
    points = np.float64([(0, 0, 0), (1, 0, 0), (bad, 0, 0), (0, 0, 0), (1, 0, 0), (4, 0, 0)])
    share, length = intercepts(points, [3, 3])
    np.testing.assert_allclose(share, [0, 1, 1, 0, 0.25, 1])
    np.testing.assert_allclose(length, [1, 4])


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_bad_point_leaves_the_roots_their_generated_coordinates(bad):
    """They are told in the box around all points, which one bad one made NaN."""
    points = [(0, 0, 0), (0, 0, 1), (2, 0, 0), (2, 0, 1), (1, 4, 0), (bad, 0, 0)]
    curves = Curves(points, [0.1] * 6, [2, 2, 2])
    good = Curves(points[:5], [0.1] * 5, [2, 2, 1])
    tables = [round_tables._generated(c)[:4] for c in (curves, good)]
    np.testing.assert_allclose(*tables)
    assert round_tables._generated(Curves(np.zeros((0, 3)), [], np.zeros(0, int))).shape == (0, 3)


@pytest.mark.parametrize("bad", [{"points": np.zeros((5, 2))}, {"counts": [4]}, {"transform": np.eye(3)}])
def test_arrays_that_do_not_fit_are_refused(bad):
    arrays = {"points": np.zeros((5, 3)), "radii": np.ones(5), "counts": [5]} | bad
    with pytest.raises(SceneError, match="curves 'Fur'"):
        geometry_of(Curves(**arrays, name="Fur"))


def test_intercepts_are_shares_of_the_length():
    points = [(0, 0, 0), (1, 0, 0), (4, 0, 0), (0, 0, 0), (0, 2, 0), (7, 7, 7)]
    share, length = intercepts(points, [3, 2, 0, 1])
    np.testing.assert_allclose(share, [0, 0.25, 1, 0, 1, 0])
    np.testing.assert_allclose(length, [4, 2, 0, 0])


def graph(op, output, **properties):
    """A material that emits what a node gives out."""
    nodes = (Node(op, {}, properties), Node("emission", {"color": Link(0, output), "strength": 1.0}))
    return Material("shown", nodes, 1)


def seen(material, **more):
    """The pixel in the middle of a tube that is looked at from above, at a quarter of its length."""
    camera = Camera(np.array([[1, 0, 0, 0.5], [0, 1, 0, 0], [0, 0, 1, 4], [0, 0, 0, 1.0]]), (-1e-4, 1e-4, -1e-4, 1e-4))
    scene = Scene(camera, curves=(straight(material=material, **more),), world=World())
    settings = Settings(width=1, height=1, samples=1, method="raycast")
    film = render(compile_scene(scene, settings, Diagnostics()), settings)
    return film.mean().reshape(-1, 3)[0]


def test_what_nodes_know_of_a_strand():
    for output, expected in (("is_strand", 1), ("intercept", 0.25), ("length", 2), ("thickness", 0.2)):
        np.testing.assert_allclose(seen(graph("hair_info", output)), expected, rtol=1e-2)
    np.testing.assert_allclose(seen(graph("hair_info", "tangent_normal")), (0, 0, 1), atol=0.02)
    assert 0 < seen(graph("hair_info", "random"))[0] < 1


def test_attributes_of_points_strands_and_the_whole():
    for domain, values, expected in (
        ("vertex", np.linspace(0, 2, 5)[:, None], (0.5, 0.5, 0.5)),
        ("strand", [[0.1, 0.2, 0.3]], (0.1, 0.2, 0.3)),
        ("mesh", [[0.1, 0.2, 0.3, 1.0]], (0.1, 0.2, 0.3)),
    ):
        attributes = {"Tint": Attribute(np.float32(values), domain)}
        material = graph("attribute", "color", attribute_name="Tint")
        np.testing.assert_allclose(seen(material, attributes=attributes), expected, atol=5e-3)


def test_uv_and_generated_coordinates_are_the_roots():
    uvs = {"Map": np.float32([[0.3, 0.6]])}
    np.testing.assert_allclose(seen(graph("uv_map", "uv"), uvs=uvs), (0.3, 0.6, 0), atol=1e-6)
    np.testing.assert_allclose(seen(graph("tex_coord", "generated")), (0, 0.5, 0.5), atol=1e-6)


def test_attributes_of_points_in_a_cloud():
    spheres = Spheres(np.eye(3), np.array([1.0, 0, 2]), attributes={"T": Attribute(np.float32([[1], [2], [3]]))})
    needs = needs_of([graph("attribute", "fac", attribute_name="T"), graph("point_info", "random")])
    geometry = compile_geometry(Scene(CAMERA, spheres=(spheres,)), needs=needs)
    zero = np.zeros(2, np.float32)
    read = [
        corner_values_at(geometry.corner_values[key], np.arange(2), zero, zero, Arena())[0].tolist()
        for key in (("attribute", "T"), "point")
    ]
    assert read[0] == [1, 3]  # the one in the middle has no radius
    assert 0 < read[1][0] != read[1][1] < 1 or read[1][0] == 0
