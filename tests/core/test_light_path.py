# SPDX-License-Identifier: GPL-3.0-or-later
"""What rays are told of themselves: sampled lobes, trails of paths, lights and worlds that ask."""

from dataclasses import replace

import numpy as np
import pytest

from zraka.core.arena import Arena
from zraka.core.bsdf import diffuse, glass, glossy, translucent
from zraka.core.bsdf.base import BSDFSample, Lobe
from zraka.core.bsdf.mixture import Mixture
from zraka.core.compile import compile_scene
from zraka.core.compile.features import Feature
from zraka.core.compile.scene import Surface
from zraka.core.diagnostics import Diagnostics
from zraka.core.lights.triangle import TriangleLights
from zraka.core.methods.trails import after_scattering, light_ray, new_trail, pass_straight, ray_of, shadow_ray
from zraka.core.nodes.base import SHADOW_RAY, Ray
from zraka.core.scene import Link, Material, Node, Spheres, SunLight, World
from zraka.core.settings import Settings

from .scenes import looking_down, placed, quad, radiance

N = 4096
UP = np.repeat(np.float32([[0], [0], [1]]), N, axis=1)
WHITE = np.ones((3, 1), np.float32)


def sampled(*entries):
    """Flags and directions of samples from a list of lobes, seen along the normal."""
    surface = Surface(*[None] * 9)._replace(wo=UP, ng=UP, ns=UP)
    entries = [(lobe, WHITE, params, None) for lobe, params in entries]
    u = np.random.default_rng(1).random((3, N), np.float32)
    mixture = Mixture(lobe for lobe, *_ in entries)
    plain = mixture.sample(entries, surface, *u, Arena())
    told = mixture.sample(entries, surface, *u, Arena(), with_flags=True)
    assert plain.flags is None
    np.testing.assert_array_equal(plain.wi, told.wi)
    return told


def test_samples_tell_their_lobe():
    index = {"eta": np.float32([1.5])}
    told = sampled((diffuse, {}), (glossy.Mirror, {}), (glass.Smooth, index), (translucent, {}))
    values = {lobe.flags.value for lobe in (diffuse, glossy.Mirror, glass.Smooth, translucent)}
    assert set(told.flags.tolist()) == values
    is_diffuse = (told.flags & Lobe.DIFFUSE.value) != 0
    np.testing.assert_array_equal(is_diffuse, np.isfinite(told.pdf))
    assert is_diffuse.mean() == pytest.approx(0.5, abs=0.05)
    is_reflected = told.flags == diffuse.flags.value
    np.testing.assert_array_equal((told.wi[2] > 0)[is_diffuse], is_reflected[is_diffuse])


@pytest.mark.parametrize("lobe", [diffuse, translucent, glossy.Mirror])
def test_a_lobe_alone_is_told(lobe):
    assert set(sampled((lobe, {})).flags.tolist()) == {lobe.flags.value}


def test_trails_count_scatterings_and_passages():
    arena, out, trail = Arena(), Arena(), new_trail(4, Arena())
    pass_straight(trail, np.array([1]))
    side = np.float32([1, 1, -1, -1])
    sample = BSDFSample(
        np.stack([0 * side, 0 * side, side]),
        None,
        np.float32([0.5, np.inf, 0.5, 0.5]),
        flags=np.uint8([lobe.flags.value for lobe in (diffuse, glossy.Mirror, glass.Rough, translucent)]),
    )
    after = after_scattering(trail, sample, UP[:, :4], np.arange(4), arena, out)
    ray = ray_of(after, 1, np.float32([1, 2, 3, 4]))
    assert ray.camera == 0 and ray.depth == 1 and ray.length.tolist() == [1, 2, 3, 4]
    assert ray.diffuse.tolist() == [1, 0, 0, 1] and ray.glossy.tolist() == [0, 1, 1, 0]
    assert ray.singular.tolist() == [0, 1, 0, 0]
    assert ray.reflection.tolist() == [1, 1, 0, 0] and ray.transmission.tolist() == [0, 0, 1, 1]
    assert ray.diffuse_depth.tolist() == [1, 0, 0, 0] and ray.glossy_depth.tolist() == [0, 1, 0, 0]
    assert ray.transmission_depth.tolist() == [0, 0, 1, 1] and ray.transparent_depth.tolist() == [0, 1, 0, 0]
    shadow, light = shadow_ray(after, 1), light_ray(after, 1)
    assert shadow.shadow == 1 and shadow.depth == 2 and shadow.transparent_depth.tolist() == [0, 1, 0, 0]
    assert light.shadow == light.diffuse == light.glossy == 0 and light.depth == 2
    assert after_scattering(after, sample, UP[:, :4], np.arange(4), arena, out)[3].tolist() == [2, 0, 0, 0]


def test_rays_of_some_lanes():
    ray = Ray(depth=2, length=np.float32([1, 2, 3]))
    assert ray.at(np.array([2, 0])).length.tolist() == [3, 1] and ray.at(slice(1, 3)).length.tolist() == [2, 3]
    assert ray.at(np.array([1])).depth == 2 and SHADOW_RAY.at(np.array([1])) == SHADOW_RAY


def test_emitters_are_asked_from_where_they_are_seen():
    corners = np.float32([[0, 0, 2, 1, 0, 2, 0, 1, 2]]).T
    asked = {}

    def emitted(prim, u, v, arena, wo, ray=None):
        asked.update(wo=wo, ray=ray)
        return np.ones((3, u.size), np.float32)

    lights = TriangleLights(corners, np.zeros(1, np.int32), WHITE, None, (emitted,), np.zeros(1, np.int32))
    p, u = np.zeros((3, N), np.float32), np.random.default_rng(1).random((2, N), np.float32)
    found = lights.sample(0, p, *u, Arena(), Ray(depth=3))
    np.testing.assert_array_equal(asked["wo"], -found.wi)
    np.testing.assert_array_equal(asked["ray"].length, found.distance)
    assert asked["ray"].depth == 3
    lights.sample(0, p, *u, Arena())
    assert asked["ray"] is None


def test_emission_that_depends_on_the_view_beside_spheres():
    nodes = (Node("layer_weight"), Node("emission", {"strength": Link(0, "facing")}))
    lit = looking_down(placed(quad(1.0, (0, 0, 2)), Material("facing", nodes, 1)), height=0.5)
    more = replace(lit, spheres=(Spheres([(0, 0, 9)], [0.5], Material.diffuse()),))
    prim, corner = np.zeros(2, np.int32), np.full(2, 0.25, np.float32)
    wo = np.float32([[0, 0.6], [0, 0], [-1, -0.8]])
    one, other = (
        compile_scene(s, Settings(), Diagnostics()).emission_at(prim, corner, corner, Arena(), wo) for s in (lit, more)
    )
    np.testing.assert_allclose(one, other, rtol=1e-5)
    assert one[0, 0] < one[0, 1]


def world(output):
    """A world that shines where an output of the Light Path node is 1."""
    nodes = (Node("light_path"), Node("background", {"color": Link(0, output)}))
    return World(nodes=nodes, surface=1)


@pytest.mark.parametrize(("output", "expected"), [("is_camera_ray", 0.0), ("is_diffuse_ray", 0.5), ("ray_depth", 1.0)])
def test_worlds_for_some_rays(output, expected):
    floor = looking_down(placed(quad(100), Material.diffuse((0.5, 0.5, 0.5))))
    floor = replace(floor, world=world(output))
    assert radiance(floor, 64, depth=2) == pytest.approx(expected, rel=1e-3)
    made = compile_scene(floor, Settings(), Diagnostics())
    assert Feature.LIGHT_PATH in made.features and Feature.ENVIRONMENT in made.features
    empty = replace(floor, instances=())
    assert radiance(empty, 1) == (1.0 if output != "is_diffuse_ray" else 0.0)


@pytest.mark.parametrize("method", ["phong", "raycast", "raytrace", "pathtrace"])
def test_every_method_takes_the_lobes_normals(method):
    """A sun from above on a floor whose normal is turned by 60 degrees."""
    nodes = (
        Node("mapping", {"vector": Link(1, "true_normal"), "rotation": (0.0, np.pi / 3, 0.0)}),
        Node("geometry"),
        Node("diffuse", {"color": (1.0, 1.0, 1.0), "normal": Link(0, "vector")}),
    )
    sun = SunLight((0, 0, -1), (np.pi,) * 3)
    floor = looking_down(placed(quad(100), Material("turned", nodes, 2)), lights=(sun,))
    found = radiance(floor, 1, depth=1, method=method)
    flat = radiance(looking_down(placed(quad(100), Material.diffuse((1, 1, 1))), lights=(sun,)), 1, method=method)
    assert flat == pytest.approx(1.0, rel=1e-3)
    assert found == pytest.approx(0.5, rel=1e-3)
