# SPDX-License-Identifier: GPL-3.0-or-later
"""Input that random scenes once stumbled over (`tests/fuzz`): no warning of numpy, no error but `SceneError`."""

from types import SimpleNamespace

import numpy as np
import pytest

from zraka.core import estimate
from zraka.core.arena import Arena
from zraka.core.bsdf import lookup
from zraka.core.compile import compile_scene
from zraka.core.diagnostics import Diagnostics, SceneError
from zraka.core.methods.transparency import _onwards
from zraka.core.methods.wavefront import watched_arithmetic
from zraka.core.scene import (
    AreaLight,
    Camera,
    Instance,
    Link,
    Material,
    Mesh,
    Node,
    ObjectInfo,
    Plane,
    PointLight,
    Spheres,
)
from zraka.core.settings import METHODS, Settings

from .scenes import box, camera, film_of, looking_down, placed, quad, scene

VIEW = camera((0, -3, 1), (0, 0, 0), fov=0.4)


@pytest.fixture(autouse=True)
def as_users_have_it():
    """Overflows and NaN are what these scenes are made of."""
    with watched_arithmetic(False):
        yield


def renders(*materials, **more):
    """Films of boxes of `materials`, side by side, by every method."""
    things = [Instance(box(2.0 / len(materials), (n * 2.0 / len(materials) - 1, 0, 0)), materials=(m,), **more)
              for n, m in enumerate(materials)]  # fmt: skip
    view = scene(VIEW, *things, lights=(PointLight((1, -2, 3), (9, 9, 9)),), world=0.2)
    return [film_of(view, 2, (4 * len(materials), 4), method=method) for method in METHODS]


def graph(op, value_op, output, name, inputs=None, properties=None):
    """A material whose closure `op` takes input `name` from a node."""
    nodes = (Node(value_op, inputs or {}, properties or {}), Node(op, {name: Link(0, output)}))
    return Material("linked", nodes, 1)


def test_a_colour_of_no_float32():
    for film in renders(Material.diffuse((1e39, 0.5, 0.5))):
        assert np.isfinite(film.image()).all()


def test_an_objects_colour_of_no_float32():
    material = graph("diffuse", "object_info", "color", "color")
    renders(material, info=ObjectInfo(color=(1e39, 0.0, 0.0, 1.0)))


@pytest.mark.parametrize("transform", [np.diag([1.0, 0, 1, 1]), np.full((4, 4), np.nan), np.ones((4, 4)), np.eye(3)])
def test_a_camera_that_looks_nowhere_is_refused(transform):
    with pytest.raises(SceneError, match="camera"):
        compile_scene(scene(Camera(transform)), Settings(), Diagnostics())


@pytest.mark.parametrize("name", ["color", "roughness", "normal"])
def test_vectors_and_numbers_fit_every_closure(name):
    """A link brings what its node makes, whatever the closure expects."""
    closures = ("diffuse", "glossy", "glass", "metallic", "sheen", "toon")
    renders(*(graph(op, "checker", output, name) for op in closures for output in ("color", "fac")))


def test_a_number_is_a_vector_of_it_to_closures():
    nodes = (Node("checker", {"color1": (0.5, 0.5, 0.5), "color2": (0.5, 0.5, 0.5)}), Node("separate_xyz", {}))
    given = {"roughness": Link(0, "color"), "color": (0.5, 0.5, 0.5)}
    linked = renders(Material("linked", (*nodes, Node("glossy", given)), 2))
    plain = renders(Material.single("glossy", roughness=0.5, color=(0.5, 0.5, 0.5)))
    for a, b in zip(linked, plain, strict=True):
        np.testing.assert_allclose(a.image(), b.image(), rtol=2e-3, atol=1e-4)


def test_a_constant_number_is_a_vector_to_closures():
    renders(Material.single("glossy", anisotropy=0.5, tangent=0.5, roughness=0.3))


@pytest.mark.parametrize("op", ["gradient", "checker", "noise", "wave", "magic", "brick", "voronoi", "gabor"])
def test_a_number_is_a_vector_to_textures(op):
    nodes = (Node("checker"), Node(op, {"vector": Link(0, "fac")}), Node("diffuse", {"color": Link(1, "color")}))
    output = {"gabor": "value", "voronoi": "color"}.get(op, "color")
    renders(Material("linked", (*nodes[:2], Node("diffuse", {"color": Link(1, output)})), 2))


def test_a_table_takes_nan_for_its_start():
    low, share = lookup.cell(np.float32([np.nan, -1, 0.5, 2, np.inf]), 16)
    assert low.tolist() == [0, 0, 7, 14, 14]
    np.testing.assert_allclose(share, [0, 0, 0.5, 1, 1])


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e30, 0.0])
def test_principled_takes_any_number(value):
    names = ("coat_ior", "ior", "thin_film_thickness", "thin_film_ior", "roughness", "sheen_roughness", "coat_weight")
    layers = {"coat_weight": 1.0, "sheen_weight": 0.5, "thin_film_thickness": 300.0, "transmission_weight": 0.5}
    renders(*(Material.principled(**(layers | {name: value})) for name in names))


def test_an_emitter_at_the_end_of_float32():
    corners = np.float32([[-3e38, 0, 0], [3e38, 0, 0], [0, 3e38, 0]])
    glow = Instance(Mesh(corners, np.array([[0, 1, 2]])), materials=(Material.emission(),))
    film_of(scene(VIEW, glow, placed(quad(), Material.diffuse()), placed(quad(), Material.emission())), 2, 6)


def test_lights_out_of_reach_are_left_out():
    diagnostics, there = Diagnostics(), np.eye(4)
    there[0, 3] = 1e30
    lights = (PointLight((1e30, 0, 0), (1, 1, 1)), AreaLight(there, (1, 1, 1)), PointLight((0, 0, 2), (1, 1, 1)))
    compiled = compile_scene(looking_down(placed(quad(), None), lights=lights), Settings(), diagnostics)
    assert compiled.lights.sampler.count == 1
    assert any("left out" in m for m in diagnostics.messages())


def test_spheres_beyond_float32_are_left_out():
    spheres, diagnostics = (
        Spheres(np.array([[0, 0, 0], [1e39, 0, 0], [0, 0, 0.0]]), np.array([1e39, 1, 1])),
        Diagnostics(),
    )
    compiled = compile_scene(looking_down(spheres=(spheres,)), Settings(), diagnostics)
    assert compiled.geometry.sphere_count == 1
    assert "left out" in diagnostics.messages()[0]


def test_constants_fold_without_a_warning():
    """Infinity times nothing, before there is a lane."""
    nodes = (
        Node("emission", {"color": (np.inf, 0.0, 1.0), "strength": 0.0}),
        Node("diffuse", {"color": (np.inf, np.nan, 1.0)}),
        Node("mix_shader", {"fac": np.nan, "a": Link(0, "bsdf"), "b": Link(1, "bsdf")}),
    )
    renders(Material("constant", nodes, 2))


def test_a_plane_out_of_reach_is_refused():
    beyond = looking_down(placed(quad(), None), planes=(Plane((0, 0, 1e30), (0, 0, 1)),))
    with pytest.raises(SceneError, match="finite point"):
        compile_scene(beyond, Settings(), Diagnostics())


def test_shadow_rays_that_have_arrived_are_not_aimed_anew():
    """One that ended within a surface's error had its step off the surface divided by next to nothing: an overflow."""
    p, still = np.zeros((3, 3), np.float32), np.zeros((3, 3), np.float32)
    surface = SimpleNamespace(
        p=p, ng=np.float32([[0, 0, 0], [0, 0, 0], [1, 1, 1]]), offset=np.full(3, 1e-5, np.float32)
    )
    d = np.float32([[0, 0, 0.6], [0, 0, 0], [1, 1e25, 0.8]])
    o, onwards, tmax = _onwards(surface, still, d, np.float32([1e-30, 1e-30, 1.0]), Arena())
    np.testing.assert_array_equal(onwards[:, :2], d[:, :2])
    assert (tmax[:2] < 1e-29).all()
    assert np.abs(o[:, 2] + onwards[:, 2] - (0.6, 0, 0.8)).max() < 1e-6


@pytest.mark.parametrize("noise", [0.0, 1e76])
def test_the_error_of_a_picture_of_no_brightness_does_not_overflow(noise):
    """Its variance was multiplied by the inverse of the least float64."""
    weight = estimate.noisy_weights(np.zeros((3, 2, 2)), np.full((2, 2), noise), 0.0)
    assert np.isfinite(estimate.relative_error(np.full(4, 1e76), weight))
