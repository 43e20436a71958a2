# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that move in an edited scene: their rows alone are written, their trees alone are built."""

from dataclasses import replace

import numpy as np
import pytest

from zraka.core.accel import Accel
from zraka.core.arena import Arena
from zraka.core.compile import compile_scene, moving
from zraka.core.diagnostics import Diagnostics
from zraka.core.geometry import Geometry
from zraka.core.render import render
from zraka.core.scene import Curves, Instance, Material, PointLight, Scene, Spheres, World
from zraka.core.settings import Settings
from zraka.core.stability.shapes import box, camera, quad, sphere

SETTINGS = Settings(width=24, height=16, samples=2, threads=1)
GREY, GLOSSY = Material.diffuse(0.6), Material.principled(roughness=0.3)
LAMP = Material.emission((1.0, 0.8, 0.6), 5.0)
BALL, BOX = sphere(0.4, (0, 0, 0), 12), box(0.5, (0, 0, 0))


def at(x, y, z, scale=(1, 1, 1)):
    matrix = np.diag([*scale, 1.0])
    matrix[:3, 3] = x, y, z
    return matrix


SCENE = Scene(
    camera((0, -4, 1), (0, 0, 0), fov=0.8),
    (
        Instance(quad(6, (0, 0, -1), "+z"), np.eye(4), (GREY,), "floor"),
        Instance(BALL, at(-0.8, 0, 0, (1, 2, 0.5)), (GLOSSY,), "ball"),
        Instance(BOX, at(0.6, 0.2, 0), (GREY,), "box"),
        Instance(BALL, at(0, 0.8, 0.4), (GREY,), "other ball"),
        Instance(quad(0.6, (0, 0, 1.5), "-z"), np.eye(4), (LAMP,), "lamp"),
        Instance(quad(0.1, (2.5, 2.5, 4), "+z"), np.eye(4), (GREY,), "highest"),
    ),
    spheres=(Spheres(np.array([[0.2, -0.6, -0.6]]), np.array([0.2]), GREY, "sphere"),),
    curves=(
        Curves(
            np.array([[-1, 0, -1], [-1, 0, 0], [-0.8, 0, 0.6]]),
            np.full(3, 0.03),
            np.array([3]),
            material=GREY,
            name="hair",
        ),
    ),
    lights=(PointLight((1, -1, 2), (60.0,) * 3),),
    world=World((0.2,) * 3),
)


def with_moved(scene, **places):
    """The scene with some instances elsewhere, by name."""
    instances = tuple(replace(i, transform=places.get(i.name.replace(" ", "_"), i.transform)) for i in scene.instances)
    return replace(scene, instances=instances)


RAYS = tuple(np.random.default_rng(1).normal(size=(2, 3, 500)).astype(np.float32))


@pytest.fixture(autouse=True)
def small(monkeypatch):
    """Small scenes too get a tree for each object."""
    monkeypatch.setattr(moving, "FEWEST_TRIANGLES", 1)


def edited(*scenes, settings=SETTINGS):
    """All of these compiled one after the other."""
    before = None
    for scene in scenes:
        before, earlier = compile_scene(scene, settings, Diagnostics(), before=before, editable=True), before
    return before, earlier


MOVES = {
    "one": {"box": at(0.3, -0.4, 0.2)},
    "one of a shared mesh": {"ball": at(-0.5, -0.2, 0.3, (0.4, 1.5, 1))},
    "both of a shared mesh": {"ball": at(-1, 0, 0), "other_ball": at(0.2, 0.3, -0.3, (2, 1, 1))},
    "a lamp": {"lamp": at(0.5, 0.2, -0.4), "box": at(0.6, 0.1, 0)},
}


@pytest.mark.parametrize("name", MOVES)
def test_what_moves_is_seen_where_a_fresh_scene_has_it(name):
    scene = with_moved(SCENE, **MOVES[name])
    moved, before = edited(SCENE, scene)
    assert moved.accel is before.accel
    assert moved.geometry.facets is before.geometry.facets
    fresh = compile_scene(scene, SETTINGS, Diagnostics())
    np.testing.assert_array_equal(moved.geometry.origin, fresh.geometry.origin)
    for table in ("facets", "vertices", "index", "material", "object"):
        np.testing.assert_array_equal(getattr(moved.geometry, table), getattr(fresh.geometry, table), table)
    row = fresh.geometry.normal_row
    row = row[row >= 0]  # triangles without area had some too
    np.testing.assert_array_equal(moved.geometry.normals[row], fresh.geometry.normals[row])
    picture = render(moved, SETTINGS).image()
    np.testing.assert_allclose(picture, render(fresh, SETTINGS).image(), rtol=1e-4, atol=1e-5)
    unmoved = render(compile_scene(SCENE, SETTINGS, Diagnostics()), SETTINGS).image()
    assert (np.abs(picture - unmoved) > 1e-3).any()


def test_the_tables_zero_stays():
    scene = with_moved(SCENE, highest=at(0, 0, 1))
    moved, before = edited(SCENE, scene)
    assert moved.accel is before.accel
    fresh = compile_scene(scene, SETTINGS, Diagnostics())
    assert (moved.geometry.origin != fresh.geometry.origin).any()
    np.testing.assert_allclose(
        moved.geometry.facets[:, :3] + moved.geometry.origin,
        fresh.geometry.facets[:, :3] + fresh.geometry.origin,
        atol=1e-6,
    )
    picture = render(moved, SETTINGS).image()
    np.testing.assert_allclose(picture.mean(), render(fresh, SETTINGS).image().mean(), rtol=1e-3)


def test_triangles_without_area_stay_out():
    broken = replace(BOX, vertices=np.concatenate([BOX.vertices, BOX.vertices[:1]]))
    broken = replace(broken, triangles=np.concatenate([[[0, 0, 1]], broken.triangles, [[2, 2, 2]]]), normals=None)
    first = replace(SCENE, instances=(*SCENE.instances[:2], Instance(broken, at(0.6, 0.2, 0), (GREY,), "box")))
    scene = with_moved(first, box=at(0.3, -0.4, 0.2))
    moved, before = edited(first, scene)
    assert before.geometry.own_number is not None
    assert moved.accel is before.accel
    fresh = compile_scene(scene, SETTINGS, Diagnostics())
    np.testing.assert_array_equal(moved.geometry.facets, fresh.geometry.facets)
    np.testing.assert_array_equal(
        moved.accel.intersect(*RAYS, None, Arena()).prim, fresh.accel.intersect(*RAYS, None, Arena()).prim
    )


ANEW = {
    "mirrored": {"box": at(0.6, 0.2, 0, (-1, 1, 1))},
    "flattened": {"box": at(0.6, 0.2, 0, (1, 1, 0))},
    "far": {"box": at(1e4, 0, 0)},
    "not finite": {"box": at(np.nan, 0, 0)},
}


@pytest.mark.parametrize("name", ANEW)
def test_where_more_changes_all_is_compiled_anew(name):
    scene = with_moved(SCENE, **ANEW[name])
    anew, before = edited(SCENE, scene)
    assert anew.accel is not before.accel
    fresh = compile_scene(scene, SETTINGS, Diagnostics())
    np.testing.assert_array_equal(anew.geometry.facets, fresh.geometry.facets)
    # And moves on from there.
    back, _ = edited(SCENE, scene, SCENE)
    fresh = compile_scene(SCENE, SETTINGS, Diagnostics())
    np.testing.assert_array_equal(back.geometry.facets, fresh.geometry.facets)


def test_another_material_is_not_a_move():
    painted = replace(SCENE, instances=tuple(replace(i, materials=(GREY,)) for i in SCENE.instances))
    anew, before = edited(SCENE, with_moved(painted, box=at(0, 0, 0)))
    assert anew.accel is not before.accel


def test_only_edited_scenes_are_changed_in_place():
    before = compile_scene(SCENE, SETTINGS, Diagnostics())
    facets = before.geometry.facets.copy()
    again = compile_scene(with_moved(SCENE, **MOVES["one"]), SETTINGS, Diagnostics(), before=before)
    assert before.accel.parts is None
    assert again.accel is not before.accel
    np.testing.assert_array_equal(before.geometry.facets, facets)


def test_parts_are_objects_and_not_too_many(monkeypatch):
    starts = moving.parts_of(compile_scene(SCENE, SETTINGS, Diagnostics()).geometry)
    assert starts[0] == 0
    assert len(starts) == 4  # the floor is as small as a part may be
    monkeypatch.setattr(moving, "_MOST_PARTS", 2)
    assert len(moving.parts_of(compile_scene(SCENE, SETTINGS, Diagnostics()).geometry)) == 2
    monkeypatch.setattr(moving, "FEWEST_TRIANGLES", 10**6)
    assert moving.parts_of(compile_scene(SCENE, SETTINGS, Diagnostics()).geometry) is None


def test_trees_of_parts_answer_as_one_does():
    rng = np.random.default_rng(5)
    triangles = rng.normal(size=(3000, 3, 3), scale=0.1) + rng.uniform(-1, 1, (3000, 1, 3))
    geometry = Geometry.from_arrays(triangles, rng.uniform(-1, 1, (80, 3)), np.full(80, 0.05))
    o, d = (rng.normal(size=(3, 4000)).astype(np.float32) for _ in range(2))
    one, many, arena = Accel(geometry), Accel(geometry, parts=[0, 10, 1000, 2990]), Arena()
    for _ in range(2):
        a, b = one.intersect(o, d, None, arena), many.intersect(o, d, None, arena)
        np.testing.assert_array_equal(a.prim, b.prim)
        assert 0.1 < (a.prim >= 0).mean() < 0.99
        np.testing.assert_array_equal(one.occluded(o, d, None, arena), many.occluded(o, d, None, arena))
        geometry.vertices[3 * 10 : 3 * 1000, 0] += 0.5
        many.rebuild(np.arange(10, 1000))
        one = Accel(geometry)
