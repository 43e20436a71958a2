# SPDX-License-Identifier: GPL-3.0-or-later
"""Which bodies hide their far sides for certain, and that only those do."""

import math

import numpy as np
import pytest

from zraka.core.arena import Arena
from zraka.core.compile import compile_scene
from zraka.core.diagnostics import Diagnostics
from zraka.core.lights.far_sides import FarSides, far_sides
from zraka.core.lights.triangle import outward
from zraka.core.scene import Instance, Link, Material, Mesh, Node
from zraka.core.settings import Settings
from zraka.core.stability.shapes import box, camera, merged, moved, quad, scene, sphere
from zraka.core.visibility import ObjectSet, Rays, Visibility

COARSE = 1e-3  # bound on a point's error that makes all bodies here small


def hidden_from(*meshes, shades=True, clearance=COARSE):
    """Distance from which on the body of each mesh hides its far sides; None where none does."""
    corners = [m.vertices[m.triangles].astype(float).reshape(-1, 9) for m in meshes]
    group = np.repeat(np.arange(len(meshes)) * 3, [len(c) for c in corners])
    corners = np.concatenate(corners).T
    v0, v1, v2 = corners.reshape(3, 3, -1)
    real = np.linalg.norm(np.cross(v1 - v0, v2 - v0, axis=0), axis=0) > 1e-12
    corners, group = corners[:, real], group[real]
    found = far_sides(
        corners, group, outward(corners, group), np.full(group.size, clearance), lambda n: np.full(n.size, shades)
    )
    if found is None or found._hidden_from is None:
        return None
    return [float(found._hidden_from[group == k].max()) for k in np.unique(group)]


def turned(mesh):
    """The same mesh inside out."""
    return Mesh(mesh.vertices, mesh.triangles[:, ::-1])


@pytest.mark.parametrize("mesh", [box(1.0), turned(box(1.0)), box(1.0, (5, 0, 0)), sphere(0.5, rings=8)])
def test_a_closed_body_hides_its_far_side_from_beyond_its_size(mesh):
    assert hidden_from(mesh) == [pytest.approx(math.sqrt(3), rel=1e-6)]


def test_parts_that_are_closed_hide_theirs():
    assert hidden_from(merged([box(1.0), box(1.0, (3, 0, 0))])) is not None
    assert hidden_from(merged([box(1.0), box(1.0, (0.5, 0.5, 0.5))])) is not None


@pytest.mark.parametrize(
    "mesh",
    [
        quad(1.0),
        merged([quad(1.0), quad(1.0, (0, 0, 1), "-z")]),  # encloses a volume, but for its sides
        Mesh(box().vertices, box().triangles[:-1]),
        merged([box(1.0), box(0.9, (3, 0, 0), inward=True)]),
        merged([box(1.0), quad(1.0, (3, 0, 0))]),
    ],
    ids=["square", "two squares", "a hole", "a part inside out", "an open part"],
)
def test_what_is_open_hides_nothing_for_certain(mesh):
    assert hidden_from(mesh) is None


def test_each_body_is_judged_by_itself():
    hole = Mesh(box().vertices, box().triangles[:-1])
    assert hidden_from(hole, box(2.0), quad(1.0)) == [math.inf, pytest.approx(2 * math.sqrt(3)), math.inf]


def test_large_bodies_and_those_that_let_light_pass_are_left_to_shadow_rays():
    assert hidden_from(box(1.0), clearance=1e-5) is None
    assert hidden_from(box(1.0), shades=False) is None


@pytest.mark.parametrize("size", [0.5, 3.0])
def test_only_far_sides_seen_from_beyond_the_body_lose_their_light(size):
    n = 3
    up = np.zeros((3, n), np.float32)
    up[2] = 1
    sides = FarSides(np.float32([[0, 0], [0, 0], [1, -1]]), np.full(2, 1e-6), np.full(2, size))
    distance, weight = np.float32([1, 1, 4]), np.ones((3, n), np.float32)
    sides.hide(np.array([0, 1, 0]), up, distance, weight, Arena())
    assert weight[0].tolist() == [float(size > 1), 1.0, 0.0]
    assert distance[1] == 1
    assert (distance[[0, 2]] * (1 - 1e-4) < [1, 4]).all()


def small_ball(material=None, **visibility):
    """The compiled sampler's tables of the smallest emitting ball."""
    ball = Instance(
        sphere(rings=16),
        np.diag([1e-5, 1e-5, 1e-5, 1.0]),
        (material or Material.emission(),),
        visibility=Visibility(**visibility),
    )
    view = camera((0, -0.5, 0.1), (0, 0, 0))
    floor = moved(quad(40.0), Material.diffuse(0.8), (0, 0, -1))
    (kind,) = compile_scene(scene(view, floor, ball), Settings(width=1, height=1), Diagnostics()).lights.sampler.kinds
    return kind._far_sides._hidden_from


def test_a_small_opaque_ball_hides_its_far_side():
    assert small_ball().max() < 1e-4


def test_a_body_without_shadow_or_with_blockers_of_its_own_is_left_to_shadow_rays():
    assert small_ball(rays=Rays(31) & ~Rays.SHADOW) is None
    assert small_ball(blockers=ObjectSet(frozenset({"floor"}))) is None


def test_a_body_that_light_passes_is_left_to_shadow_rays():
    nodes = (
        Node("transparent", {"color": (0.5,) * 3}),
        Node("emission", {"color": (1.0,) * 3, "strength": 1.0}),
        Node("add_shader", {"a": Link(0, "bsdf"), "b": Link(1, "bsdf")}),
    )
    assert small_ball(Material("veil", nodes, 2)) is None
