# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights in Blender's units, and the world."""

from __future__ import annotations

import math
import warnings

import bpy
import numpy as np
import pytest

from zraka.addon.export.scene import export_scene
from zraka.core import scene as description
from zraka.core.diagnostics import Diagnostics


@pytest.fixture
def scene():
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    scene = bpy.context.scene
    scene.camera = add(scene, bpy.data.cameras.new("Camera"))
    return scene


def add(scene, data):
    obj = bpy.data.objects.new(data.name, data)
    scene.collection.objects.link(obj)
    return obj


def add_light(scene, kind, **settings):
    data = bpy.data.lights.new(kind.title(), kind)
    for name, value in settings.items():
        setattr(data, name, value)
    obj = add(scene, data)
    obj.visible_camera = False  # what Blender's own operator sets, in all versions
    return obj


def export(scene, diagnostics=None):
    bpy.context.view_layer.update()
    return export_scene(bpy.context.evaluated_depsgraph_get(), diagnostics or Diagnostics())


def enable_nodes(owner):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        owner.use_nodes = True
    return owner.node_tree


def test_point_light_keeps_its_radius_under_scale(scene):
    obj = add_light(scene, "POINT", energy=100, color=(1, 0.5, 0.25), shadow_soft_size=0.5, use_soft_falloff=False)
    obj.location, obj.scale = (1, 2, 3), (2, 2, 2)
    (light,) = export(scene).lights
    assert isinstance(light, description.PointLight)
    assert light.position == (1, 2, 3)
    assert light.power == (100, 50, 25)
    assert light.radius == 0.5
    assert not light.soft_falloff
    assert light.normalize
    assert light.casts_shadow


def test_sun_shines_along_its_negative_z(scene):
    obj = add_light(scene, "SUN", energy=3, angle=0.2)
    obj.rotation_euler.y = math.pi / 2
    obj.scale = (5, 5, 5)
    (light,) = export(scene).lights
    np.testing.assert_allclose(light.direction, (-1, 0, 0), atol=1e-6)
    assert light.irradiance == (3, 3, 3)
    assert light.angle == pytest.approx(0.2)


def test_spot(scene):
    obj = add_light(scene, "SPOT", energy=10, spot_size=1.0, spot_blend=0.5, use_shadow=False)
    if hasattr(obj.data.cycles, "cast_shadow"):  # before 5.0
        obj.data.cycles.cast_shadow = False
    diagnostics = Diagnostics()
    (light,) = export(scene, diagnostics).lights
    assert isinstance(light, description.SpotLight)
    assert light.direction == (0, 0, -1)
    assert light.angle == pytest.approx(1.0)
    assert light.blend == 0.5
    assert not light.casts_shadow
    assert diagnostics.messages() == []
    obj.scale.x = 2
    export(scene, diagnostics)
    assert "cone stays round" in diagnostics.messages()[0]


@pytest.mark.parametrize(
    ("shape", "expected", "size"),
    [
        ("SQUARE", "RECTANGLE", (0.5, 0.5)),
        ("RECTANGLE", "RECTANGLE", (0.5, 0.25)),
        ("DISK", "ELLIPSE", (0.5, 0.5)),
        ("ELLIPSE", "ELLIPSE", (0.5, 0.25)),
    ],
)
def test_area(scene, shape, expected, size):
    obj = add_light(scene, "AREA", energy=7, shape=shape, size=0.5, size_y=0.25, spread=1.0)
    obj.scale = (2, 3, 1)
    (light,) = export(scene).lights
    assert (light.shape, light.size, light.power) == (expected, size, (7, 7, 7))
    assert light.spread == pytest.approx(1.0)
    np.testing.assert_allclose(np.diag(light.transform), (2, 3, 1, 1))


def test_portals_do_not_shine(scene):
    obj = add_light(scene, "AREA")
    if not hasattr(obj.data, "cycles"):
        pytest.skip("portals are a setting of Cycles")
    obj.data.cycles.is_portal = True
    assert export(scene).lights == ()


@pytest.mark.skipif(bpy.app.version < (4, 5), reason="exposure and temperature came with 4.5")
def test_exposure_temperature_and_normalize(scene):
    obj = add_light(scene, "POINT", energy=10, exposure=2, normalize=False)
    (light,) = export(scene).lights
    assert light.power == (40, 40, 40)
    assert not light.normalize
    obj.data.use_temperature, obj.data.temperature = True, 3000
    (light,) = export(scene).lights
    np.testing.assert_allclose(light.power, 40 * np.array(obj.data.temperature_color), rtol=1e-6)
    assert light.power[0] > light.power[1] > light.power[2]  # 3000 K is warm


def test_a_plain_emission_node_multiplies(scene):
    obj = add_light(scene, "POINT", energy=10)
    tree = enable_nodes(obj.data)
    emission = tree.nodes["Emission"]
    emission.inputs["Color"].default_value = (1, 0.5, 0, 1)
    value = tree.nodes.new("ShaderNodeValue")
    value.outputs[0].default_value = 3
    tree.links.new(value.outputs[0], emission.inputs["Strength"])
    diagnostics = Diagnostics()
    (light,) = export(scene, diagnostics).lights
    assert light.power == (30, 15, 0)
    assert diagnostics.messages() == []
    falloff = tree.nodes.new("ShaderNodeLightFalloff")
    tree.links.new(falloff.outputs[0], emission.inputs["Strength"])
    (light,) = export(scene, diagnostics).lights
    assert light.power == (10, 10, 10)
    assert "light nodes" in diagnostics.messages()[0]


def test_lights_as_blender_adds_them_are_not_diagnosed(scene):
    bpy.ops.object.light_add(type="POINT")
    diagnostics = Diagnostics()
    export(scene, diagnostics)
    assert diagnostics.messages() == []
    bpy.context.object.visible_camera = True
    bpy.context.object.visible_glossy = False
    export(scene, diagnostics)
    assert len(diagnostics.messages()) == 2


# -- world -------------------------------------------------------------------------------------------------------------


def new_world(scene, color=(0.2, 0.4, 0.6, 1), strength=2.0):
    scene.world = bpy.data.worlds.new("World")
    tree = enable_nodes(scene.world)
    tree.nodes.clear()
    background, output = tree.nodes.new("ShaderNodeBackground"), tree.nodes.new("ShaderNodeOutputWorld")
    background.inputs["Color"].default_value = color
    background.inputs["Strength"].default_value = strength
    tree.links.new(background.outputs[0], output.inputs["Surface"])
    return tree, background


def test_no_world_is_black(scene):
    scene.world = None
    assert export(scene).world.radiance == (0, 0, 0)


def test_constant_background(scene):
    tree, background = new_world(scene)
    assert export(scene).world.radiance == pytest.approx((0.4, 0.8, 1.2))
    rgb = tree.nodes.new("ShaderNodeRGB")
    rgb.outputs[0].default_value = (1, 2, 3, 1)
    tree.links.new(rgb.outputs[0], background.inputs["Color"])
    assert export(scene).world.radiance == pytest.approx((2, 4, 6))


def test_world_texture_is_diagnosed_and_its_shown_colour_used(scene):
    tree, background = new_world(scene)
    sky = tree.nodes.new("ShaderNodeTexEnvironment")
    tree.links.new(sky.outputs[0], background.inputs["Color"])
    diagnostics = Diagnostics()
    assert export(scene, diagnostics).world.radiance == pytest.approx((0.4, 0.8, 1.2))
    assert [m for m in diagnostics.messages() if "world 'World'" in m] == diagnostics.messages() != []


def test_world_without_output_is_black(scene):
    tree, _ = new_world(scene)
    tree.links.clear()
    assert export(scene).world.radiance == (0, 0, 0)
