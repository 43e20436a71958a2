# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps with shader nodes: closed forms, light samples against scattered rays, what is shared and what is folded."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from zraka.core.arena import Arena
from zraka.core.compile.features import Feature
from zraka.core.compile.scene import compile_scene
from zraka.core.diagnostics import Diagnostics
from zraka.core.lights.area import AreaLights
from zraka.core.lights.shaded import ShadedLights
from zraka.core.nodes.ies import Interpolated
from zraka.core.nodes.ies_file import parse
from zraka.core.render import render
from zraka.core.scene import (
    AreaLight,
    Camera,
    Instance,
    LampNodes,
    Link,
    Material,
    Mesh,
    Node,
    PointLight,
    Scene,
    SpotLight,
    SunLight,
)
from zraka.core.settings import Settings

from .test_lights_sampling import at, compiled, irradiance, irradiance_mis, looking_down, numbers


def emitting(value, *nodes, name="lamp"):
    """A lamp's shader that emits `value`, an input, of a graph `nodes`."""
    return Material(name, (*nodes, Node("emission", {"color": value})), len(nodes))


def coordinates(output, scale=1.0, shift=0.0, transform=None):
    """A lamp's nodes that emit coordinates times and plus a number."""
    inputs = {"a": Link(0, output), "b": (scale,) * 3, "c": (shift,) * 3}
    shader = emitting(Link(1, "vector"), Node("tex_coord"), Node("vector_math_multiply_add", inputs))
    return LampNodes(shader, np.eye(4) if transform is None else transform)


@pytest.mark.parametrize("output", ["object", "generated"])
def test_coordinates_in_the_world(output):
    """The lamp's own height over itself is 0, over the world 1."""
    transform = looking_down(z=1.0)
    lamp = AreaLight(transform, (10.0,) * 3, (0.8, 0.8), nodes=coordinates(output, 0.3, 2.0, transform))
    in_world = replace(lamp, nodes=replace(lamp.nodes, in_world=True))
    own, world = (irradiance(compiled(light))[2] for light in (lamp, in_world))
    assert world == pytest.approx(own * 2.3 / 2.0, rel=1e-5)


def falloff(output, strength=1.0):
    shader = emitting(Link(0, output), Node("light_falloff", {"strength": strength}))
    return LampNodes(shader)


def area(z=1.0, side=0.8, **more):
    transform = looking_down(z=z)
    return AreaLight(transform, (10.0, 10.0, 10.0), (side, side), nodes=coordinates("uv", 1.0, 0.0, transform), **more)


BALL = PointLight((0.1, 0.2, 1.0), (10.0, 5.0, 2.0), radius=0.3, soft_falloff=False)
LAMPS = {
    "area": area(),
    "ellipse": area(shape="ELLIPSE"),
    "spread": area(spread=1.5),
    "ball": replace(BALL, nodes=coordinates("normal", 0.5, 1.0)),
    "disk": replace(BALL, soft_falloff=True, nodes=coordinates("object", 0.5, 1.0)),
    "spot": SpotLight((0, 0, 1), (0, 0, -1), (10,) * 3, angle=1.5, radius=0.2, nodes=coordinates("uv")),
    "sun": SunLight((0.2, 0, -1), (3, 2, 1), angle=0.6, nodes=coordinates("uv")),
}


@pytest.mark.parametrize("name", LAMPS)
def test_scattered_rays_and_light_samples_see_the_same(name):
    lights = compiled(LAMPS[name])
    assert isinstance(lights.sampler.kinds[0], ShadedLights)
    found = irradiance(lights, (0.2, 0.1, 0))
    np.testing.assert_allclose(irradiance_mis(lights, (0.2, 0.1, 0), 1 << 16), found, rtol=1e-2)
    plain = irradiance(compiled(replace(LAMPS[name], nodes=None)), (0.2, 0.1, 0))
    assert np.abs(found / plain - 1).max() > 0.05


@pytest.mark.parametrize(("output", "power"), [("quadratic", 2), ("linear", 1), ("constant", 0)])
@pytest.mark.parametrize("distance", [0.1, 3.0])
def test_falloff_of_a_point(output, power, distance):
    light = PointLight((0, 0, distance), (4 * math.pi,) * 3, nodes=falloff(output, 2.0))
    np.testing.assert_allclose(irradiance(compiled(light)), 2.0 * distance**-power, rtol=1e-5)


def test_a_slope_over_an_area_light():
    """Far below the lamp's middle, UV is 1/2 on the mean; nearer to one side it is more of that side."""
    far = irradiance(compiled(area(z=50.0))) / irradiance(compiled(replace(area(z=50.0), nodes=None)))
    np.testing.assert_allclose(far[:2], 0.5, rtol=1e-3)
    near = irradiance(compiled(area(z=0.2)), (0.3, 0, 0)) / irradiance(
        compiled(replace(area(z=0.2), nodes=None)), (0.3, 0, 0)
    )
    assert near[0] > 0.6 and near[1] == pytest.approx(0.5, rel=1e-2)


def test_constants_are_folded():
    value = Node("math_power", {"a": 2.0, "b": 3.0})
    nodes = LampNodes(emitting(Link(0, "value"), value))
    lights = compiled(replace(area(), nodes=nodes))
    (kind,) = lights.sampler.kinds
    assert type(kind) is AreaLights
    plain = compiled(replace(area(), nodes=None, power=(80.0,) * 3))
    p, u = at((0.2, 0.1, 0), 64), numbers(64)
    ours, theirs = (x.sampler.sample(p, *u, Arena()) for x in (lights, plain))
    np.testing.assert_array_equal(ours.weight, theirs.weight)


def test_black_nodes_leave_the_lamp_out():
    diagnostics = Diagnostics()
    scene = Scene(Camera(), lights=(replace(BALL, nodes=LampNodes(Material("dark"))),))
    assert compile_scene(scene, Settings(width=4, height=4), diagnostics).lights.sampler.count == 0
    assert "no power" in diagnostics.messages()[0]


def test_lamps_of_one_graph_share_a_table():
    """With the constants of each, however many there are; each is where it was."""
    lamps = [PointLight((x, 0, 1.0), (4 * math.pi,) * 3, nodes=falloff("constant", 1.0 + x)) for x in range(20)]
    lights = compiled(*lamps, PointLight((0, 0, -9), (1, 1, 1)), SunLight((0, 0, 1), (1, 1, 1)))
    assert [k.count for k in lights.sampler.kinds] == [20, 1, 1]
    kind = lights.sampler.kinds[0]
    for x in (0, 7, 19):
        s = kind.sample(x, at((0, 0, 0), 1), *numbers(1)[1:], Arena())
        np.testing.assert_allclose(s.weight[:, 0], 1.0 + x, rtol=1e-5)
        found = lights.classic.illuminate(x, at((0, 0, 0), 1), Arena()).irradiance
        np.testing.assert_allclose(found[:, 0], 1.0 + x, rtol=1e-5)


def test_many_lamps_are_met_in_boxes():
    many = [replace(BALL, position=(0, 0, z), nodes=coordinates("normal", 0.5, 1.0)) for z in np.linspace(1, 3, 12)]
    lights = compiled(*many)
    assert lights.lamps.count == 12
    np.testing.assert_allclose(irradiance_mis(lights, count=1 << 15), irradiance(lights), rtol=3e-2)


def test_brighter_nodes_are_chosen_more_often():
    dark, bright = (PointLight((0, 0, 1), (1, 1, 1), nodes=falloff("quadratic", s)) for s in (1.0, 9.0))
    np.testing.assert_allclose(compiled(dark, bright).sampler.pmf, (0.1, 0.9), rtol=1e-4)
    unseen = replace(dark, nodes=falloff("quadratic", 0.0))
    assert 0 < compiled(unseen, bright).sampler.pmf[0] < 1e-3


def floor_scene(*lights):
    mesh = Mesh(np.float32([(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)]), np.int32([(0, 1, 2), (0, 2, 3)]))
    return Scene(Camera(looking_down(z=3.0)), (Instance(mesh, materials=(Material.diffuse(),)),), lights=lights)


def asking_for_depth():
    return LampNodes(emitting(Link(0, "ray_depth"), Node("light_path")))


def test_rays_are_told_only_where_nodes_ask():
    settings = Settings(width=4, height=4, samples=4, depth=2)
    quiet = compile_scene(floor_scene(area()), settings, Diagnostics())
    assert Feature.LIGHT_PATH not in quiet.features
    asking = compile_scene(floor_scene(replace(area(), nodes=asking_for_depth())), settings, Diagnostics())
    assert Feature.LIGHT_PATH in asking.features


@pytest.mark.parametrize("nodes", [None, area().nodes])
def test_superfluous_features_change_no_byte(nodes):
    settings = Settings(width=8, height=8, samples=4, depth=2)
    scene = floor_scene(replace(area(z=2.0), nodes=nodes))
    compiled_ = [compile_scene(scene, settings, Diagnostics(), f) for f in (None, Feature.all())]
    few, all_ = (render(c, settings).image() for c in compiled_)
    assert few.any()
    np.testing.assert_array_equal(few, all_)


# -- IES files ---------------------------------------------------------------------------------------------------------

HEAD = "IESNA:LM-63-2002\nTILT=NONE\n1 -1 2.0 {v} {h} {kind} 2 0 0 0\n1.0 0.5 10\n"
CANDELA = 0.0706650768394


def file(vertical, horizontal, values, kind=1):
    rows = [" ".join(map(str, row)) for row in (vertical, horizontal, *values)]
    return HEAD.format(v=len(vertical), h=len(horizontal), kind=kind) + "\n".join(rows)


def test_ies_of_one_plane_is_alike_all_around():
    found = parse(file((0, 45, 90), (0,), [(10, 20, 30)]))
    np.testing.assert_allclose(found.horizontal, (0, 2 * math.pi), rtol=1e-6)
    np.testing.assert_allclose(found.vertical, np.radians((0, 45, 90)), rtol=1e-6)
    np.testing.assert_allclose(found.strength, CANDELA * np.array([(10, 20, 30)] * 2), rtol=1e-6)


def test_ies_of_a_quadrant_is_mirrored_twice():
    found = parse(file((0, 90), (0, 90), [(1, 2), (3, 4)]))
    np.testing.assert_allclose(np.degrees(found.horizontal), (0, 90, 180, 270, 360), rtol=1e-6)
    np.testing.assert_allclose(found.strength[:, 0], CANDELA * np.array((1, 3, 1, 3, 1)), rtol=1e-6)


def strengths(text, around, down, **more):
    around, down = np.radians(np.float32([around, down]))
    return Interpolated(parse(text), **more).at(around, down) / np.float32(CANDELA)


def test_ies_between_its_angles():
    """Even light is even up to the ends; before Blender 5.0 what would be beyond them counted as dark."""
    text = file((0, 40, 80, 120), (0, 100, 200, 300), [(8, 8, 8, 8)] * 4)
    around, down = (150, 50, 150, 50, 150), (60, 60, 100, 100, 20)
    np.testing.assert_allclose(strengths(text, around, down), 8, rtol=1e-5)
    found = strengths(text, around, down, dark_ends=True)
    np.testing.assert_allclose(found / 8, (1, 17 / 16, 17 / 16, (17 / 16) ** 2, 1), rtol=1e-5)


@pytest.mark.parametrize("kind", [2, 3])
def test_ies_of_one_plane_with_a_level_axis_is_dark(kind):
    text = file((-90, 0, 90), (0,), [(1, 2, 3)], kind)
    assert (strengths(text, (0, 90, 180), (0, 90, 180)) == 0).all()


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("IESNA\n1 2 3", "no line TILT="),
        ("TILT=NONE\n1 2 3", "ends early"),
        (file((0, 90), (0,), [(1,)]), "ends early"),
        (file((0, 90), (0,), [(1, "x")]), "word where a number"),
        (file((0, 90), (0,), [(1, "nan")]), "not finite"),
        (file((90, 0), (0,), [(1, 2)]), "do not ascend"),
        (file((0, 90), (0,), [(1, 2)], kind=7), "photometric type"),
        (file((0,), (0,), [(1,)]), "too few angles"),
    ],
)
def test_bad_ies_files_say_why(text, reason):
    with pytest.raises(ValueError, match=reason):
        parse(text)
