# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking at points whose answer is known."""

import numpy as np
import pytest

from zraka.core.bake import Bake, BakePoints, Viewer, bake, points_of
from zraka.core.compile import compile_scene
from zraka.core.diagnostics import Diagnostics
from zraka.core.scene import Instance, Material, Mesh
from zraka.core.settings import Settings

from .scenes import camera, cornell, merged, placed, quad, scene

FAR = camera((30, 0, 1), (0, 0, 0))
LIT = frozenset({"direct", "indirect", "color"})


def baked(description, plan, triangles, u, v, number=0, samples=64, change=0.0, **settings):
    """Values (P, 4) at points of instance `number`; all of them must exist."""
    settings = Settings(samples=samples, threads=1, **settings)
    compiled = compile_scene(description, settings, Diagnostics())
    around = np.full((2, len(triangles)), change)
    points, found = points_of(compiled, number, np.asarray(triangles), np.asarray(u), np.asarray(v), around, -around)
    assert found.all()
    return bake(compiled, points, plan, settings)[0]


def test_occlusion_beside_a_wall():
    """A wall over the angle θ hides (1 - cos θ) / 2 of the cosine-weighted hemisphere."""
    floor = placed(quad(2.0), Material.diffuse())
    wall = placed(quad(center=(-1.0, 0, 0.5), normal="+x", sides=(1000, 1)), Material.diffuse())
    at = np.linspace(0.1, 0.9, 5)
    # Of the first triangle, (-1, -1), (1, -1), (1, 1): x is 2 (u + v) - 1.
    found = baked(scene(FAR, floor, wall), Bake("ao", distance=1e6), np.zeros(5, int), at / 2, at / 2, samples=4096)
    distance = 2 * at
    expected = (1 + distance / np.hypot(distance, 1)) / 2
    np.testing.assert_allclose(found[:, 0], expected, atol=0.01)
    assert np.abs(found[:, 0] - 1).max() > 0.05
    near = baked(scene(FAR, floor, wall), Bake("ao", distance=0.1), np.zeros(5, int), at / 2, at / 2)
    np.testing.assert_array_equal(near, 1)


def test_light_of_a_white_furnace_by_parts():
    """Under a sky of 1 a grey floor sends on its albedo, all of it direct; without its colour it is 1."""
    floor = scene(FAR, placed(quad(2.0), Material.diffuse((0.2, 0.4, 0.8))), world=1.0)
    where = [0, 1], [0.2, 0.3], [0.3, 0.1]
    for parts, expected in (
        ({"direct", "color"}, (0.2, 0.4, 0.8)),
        ({"direct"}, (1, 1, 1)),
        ({"indirect"}, (0, 0, 0)),
        ({"color"}, (0.2, 0.4, 0.8)),
    ):
        found = baked(floor, Bake("diffuse", frozenset(parts)), *where)
        np.testing.assert_allclose(found, [(*expected, 1)] * 2, rtol=1e-4)
    np.testing.assert_allclose(baked(floor, Bake("combined", LIT | {"diffuse"}), *where)[0], (0.2, 0.4, 0.8, 1), 1e-4)
    assert not baked(floor, Bake("combined", LIT | {"glossy", "transmission"}), *where)[:, :3].any()
    assert not baked(floor, Bake("glossy", LIT), *where)[:, :3].any()


def test_direct_and_indirect_make_up_all():
    where = [0, 1, 0], [0.2, 0.3, 0.6], [0.3, 0.1, 0.3]
    of = {
        name: baked(cornell(), Bake("diffuse", frozenset({"color", *parts})), *where, samples=256)[:, :3]
        for name, parts in (("both", {"direct", "indirect"}), ("direct", {"direct"}), ("indirect", {"indirect"}))
    }
    np.testing.assert_allclose(of["both"], of["direct"] + of["indirect"], rtol=1e-3)
    assert (of["indirect"] > 0.1 * of["both"]).all()


def test_own_light_is_a_part():
    lamp = scene(FAR, placed(quad(2.0), Material.emission((1, 0.5, 0.25), 2.0)))
    where = [0], [0.2], [0.3]
    np.testing.assert_allclose(baked(lamp, Bake("emit"), *where)[0], (2, 1, 0.5, 1))
    np.testing.assert_allclose(baked(lamp, Bake("combined", LIT | {"emit"}), *where)[0], (2, 1, 0.5, 1))
    assert not baked(lamp, Bake("combined", LIT), *where)[0, :3].any()


def test_places_and_normals():
    """Triangles keep their numbers though one before them has no area, and mirrored ones their corners."""
    corners = np.array([[0, 0, 0], [0, 0, 0], [0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
    mesh = Mesh(corners, np.array([[0, 1, 2], [0, 3, 4]], np.uint32))
    mirror = np.diag((-1.0, 1.0, 2.0, 1.0))
    mirror[:3, 3] = 5, 6, 7
    description = scene(FAR, placed(mesh, Material.diffuse()), Instance(mesh, mirror, (Material.diffuse(),)), world=1.0)
    for number, place in ((0, (0.25, 0.5, 0)), (1, (4.75, 6.5, 7))):
        found = baked(description, Bake("position"), [1], [0.25], [0.5], number)
        np.testing.assert_allclose(found[0, :3], place, atol=1e-4)
        np.testing.assert_allclose(baked(description, Bake("normal"), [1], [0.25], [0.5], number)[0, :3], (0, 0, 1))
    compiled = compile_scene(description, Settings(), Diagnostics())
    nothing = np.zeros((2, 4))
    _, found = points_of(compiled, 1, np.array([0, 1, -1, 2]), np.full(4, 0.25), np.full(4, 0.5), nothing, nothing)
    assert found.tolist() == [False, True, False, False]


def test_a_camera_sees_mirrors_from_its_side():
    mirror = Material.glossy((1, 1, 1), 0.0)
    floor = placed(quad(2.0), mirror)
    wall = placed(quad(center=(-3, 0, 0), normal="+x", sides=(50, 50)), Material.emission((1, 1, 1), 1.0))
    description = scene(FAR, floor, wall)
    where = [0], [0.25], [0.25]
    plan = {"kind": "glossy", "parts": LIT}
    assert baked(description, Bake(**plan), *where)[0, 0] == 0
    seen = baked(description, Bake(**plan, view=Viewer.of(FAR, np.array((-1.0, 0, 0)))), *where)
    np.testing.assert_allclose(seen[0, :3], 1, rtol=1e-3)


def test_texels_over_an_edge_keep_their_mean():
    points = BakePoints(
        np.zeros(1, np.int32), *np.float32([[0.02], [0.3]]), *np.float32([[[0.5], [0.1]], [[-0.2], [0.4]]])
    )
    rng = np.random.default_rng(0)
    half = rng.random((2, 500), np.float32)
    u, v = points.at(np.zeros(1000, int), np.concatenate([half, 1 - half], axis=1))
    assert min(u.min(), v.min(), (1 - u - v).min()) > 0
    assert u.std() > 0.005
    np.testing.assert_allclose((u.mean(), v.mean()), (0.02, 0.3), atol=1e-4)


def test_a_corner_is_not_in_the_wall():
    """Half of what a point at the foot of a wall sees is free, though it lies in the wall's plane."""
    corner = placed(merged([quad(2.0), quad(2.0, center=(-1, 0, 0), normal="+x")]), Material.diffuse())
    found = baked(scene(FAR, corner), Bake("ao", distance=1e6), [0], [0.0], [0.0], samples=1024)
    assert 0.2 < found[0, 0] < 0.8


def test_stopped_and_empty():
    settings = Settings(samples=1 << 20, threads=1)
    compiled = compile_scene(cornell(), settings, Diagnostics())
    number, around = np.zeros(50, int), np.zeros((2, 50))
    points, _ = points_of(compiled, 0, number, np.full(50, 0.2), np.full(50, 0.2), around, around)
    values, film = bake(compiled, points, Bake("combined", LIT | {"diffuse"}), settings, cancelled=lambda: True)
    assert film.stats["stopped"] == "cancelled"
    assert np.isfinite(values).all()
    points, found = points_of(compiled, 0, number - 1, around[0], around[0], around, around)
    assert not found.any()
    assert bake(compiled, points, Bake("ao"), settings)[0].shape == (0, 4)


def test_unknown_kinds_are_refused():
    with pytest.raises(ValueError, match="unknown kind of bake"):
        Bake("shadow")
