# SPDX-License-Identifier: GPL-3.0-or-later
"""Phong, ray casting and ray tracing beside the second renderer: the same rays, through the pixels' centres."""

import numpy as np
import pytest

from zraka.core.compile import compile_scene
from zraka.core.diagnostics import Diagnostics
from zraka.core.render import render
from zraka.core.scene import Instance, Link, Material, Node, Plane, PointLight, Spheres, SunLight
from zraka.core.settings import Settings

from ..core.scenes import box, camera, scene
from .scenes import camera_rays, world_of

CUBES = {  # of the thesis: colour, place, degrees about its upright axis, scale; Y up
    "Cube 1": ((1.0, 0.2, 0.3), (0, 0, 0), 0, (1, 1, 1)),
    "Cube 2": ((0.2, 0.2, 0.8), (1, 1, 1), 45, (1, 1, 1)),
    "Floor": ((0.2, 0.8, 0.6), (0, -2, 0), 45, (30, 1, 30)),
    "Wall 1": ((1.0, 1.0, 1.0), (0, 0, 5), 0, (10, 10, 1)),
    "Wall 2": ((1.0, 1.0, 1.0), (-5, 0, 0), 0, (1, 10, 10)),
    "Wall 3": ((1.0, 1.0, 1.0), (0, 0, -5), 0, (10, 10, 1)),
    "Wall 4": ((1.0, 1.0, 1.0), (5, 0, 0), 0, (1, 10, 10)),
}
NUMBERS = {"reflectivity": 0.2, "exponent": 32.0, "ambient": 0.2}


def coated(color):
    """A white gloss of a fifth over Lambert reflection."""
    nodes = (
        Node("diffuse", {"color": color}),
        Node("glossy", {"color": (1.0, 1.0, 1.0), "roughness": 0.5}, {"distribution": "GGX"}),
        Node("mix_shader", {"fac": 0.2, "a": Link(0, "bsdf"), "b": Link(1, "bsdf")}),
    )
    return Material("coated", nodes, 2)


def thesis(count):
    """The first `count` objects of the thesis, its lamp, sky and camera."""
    cube, things = box(2.0), []
    for name, (color, (x, y, z), degrees, (sx, sy, sz)) in list(CUBES.items())[:count]:
        angle = np.radians(degrees)
        turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = turn @ np.diag([sx, sz, sy]), (x, -z, y)
        things.append(Instance(cube, matrix, (coated(color),), name))
    lamp = PointLight((0, 0.5, 3.1), (100.0, 200.0, 200.0))
    made = scene(camera((3, 3, 3), (0.2, 0.1, 0.3), fov=0.7), *things, lights=(lamp,))
    return made.__class__(made.camera, made.instances, lights=made.lights, world=type(made.world)((0.3, 0.4, 1.0)))


def primitives():
    """A mirror, a glass and a diffuse sphere over an endless floor; a point and a sun."""
    balls = [
        Spheres(np.array([[-0.8, 0.2, 0.7]]), np.array([0.7]), Material.glossy((0.9, 0.9, 0.8), 0.0)),
        Spheres(np.array([[0.7, -0.6, 0.5]]), np.array([0.5]), Material.glass((1.0, 1.0, 1.0), 0.0, 1.5)),
        Spheres(np.array([[0.9, 0.9, 0.4]]), np.array([0.4]), Material.diffuse((0.2, 0.3, 0.8))),
    ]
    floor = Plane((0, 0, 0), (0, 0, 1), Material.diffuse((0.5, 0.45, 0.4)))
    lights = (PointLight((1.0, -2.0, 3.0), (100.0, 90.0, 80.0)), SunLight((0.4, 0.6, -1.0), (1.0, 1.2, 1.4)))
    view = camera((0.4, -4.5, 2.2), (0, 0, 0.5), fov=0.4)
    return scene(view, spheres=balls, planes=(floor,), lights=lights, world=0.3)


SCENES = {"open room": lambda: thesis(3), "thesis": lambda: thesis(5), "closed room": lambda: thesis(7)}
CASES = [(name, method, depth) for name in SCENES for method, depth in (("phong", 1), ("raycast", 1), ("raytrace", 3))]


def both(description, method, depth, size=20, **options):
    """Pictures (N, 3) of the core and of the second renderer."""
    settings = Settings(method=method, width=size, height=size, samples=1, depth=depth, threads=1, **options)
    ours = render(compile_scene(description, settings, Diagnostics()), settings).image()[..., :3]
    o, d = camera_rays(description.camera, size, size)
    levels = depth if method == "raytrace" else 1
    theirs = world_of(description).whitted(o, d, levels, shadows=method != "phong", **options)
    return ours.reshape(-1, 3).astype(float), theirs


def apart(ours, theirs):
    """Relative difference of each pixel."""
    return (np.abs(ours - theirs) / np.maximum(np.abs(theirs), 1e-3)).max(axis=1)


@pytest.mark.parametrize(("name", "method", "depth"), CASES)
def test_scenes_of_the_thesis(name, method, depth):
    ours, theirs = both(SCENES[name](), method, depth, **NUMBERS)
    difference = apart(ours, theirs)
    # A pixel's centre may fall on an edge, or on the edge of a shadow.
    assert np.mean(difference > 1e-4) < 0.01, np.sort(difference)[-8:]
    assert theirs.std(axis=0).min() > 0.01


@pytest.mark.parametrize(("method", "depth"), [("phong", 1), ("raycast", 1), ("raytrace", 2), ("raytrace", 5)])
def test_spheres_glass_and_mirror(method, depth):
    ours, theirs = both(primitives(), method, depth, size=32, exponent=32.0)
    assert np.mean(apart(ours, theirs) > 1e-4) < 0.01, np.sort(apart(ours, theirs))[-20:]


def test_the_comparison_can_fail():
    """A picture that is a thousandth brighter is told apart."""
    ours, theirs = both(thesis(3), "raycast", 1, **NUMBERS)
    assert np.mean(apart(ours * 1.001, theirs) > 1e-4) > 0.5
