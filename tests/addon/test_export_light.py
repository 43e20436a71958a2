# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights in Blender's units, and the world."""

from __future__ import annotations

import math
import warnings

import bpy
import numpy as np
import pytest

from zraka.addon.export.cache import ExportCache
from zraka.addon.export.scene import export_scene
from zraka.core import scene as description
from zraka.core.compile.scene import compile_scene
from zraka.core.compile.world import compile_world
from zraka.core.diagnostics import Diagnostics
from zraka.core.settings import Settings


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
    assert light.nodes is None
    falloff = tree.nodes.new("ShaderNodeLightFalloff")
    tree.links.new(falloff.outputs[0], emission.inputs["Strength"])
    (light,) = export(scene, diagnostics).lights
    assert light.power == (10, 10, 10)
    assert [node.op for node in light.nodes.shader.nodes] == ["light_falloff", "emission"]
    assert diagnostics.messages() == []


def test_lights_as_blender_adds_them_are_not_diagnosed(scene):
    bpy.ops.object.light_add(type="POINT")
    diagnostics = Diagnostics()
    export(scene, diagnostics)
    assert diagnostics.messages() == []


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


def add_nodes(tree, *names):
    return [tree.nodes.new(f"ShaderNode{name}") for name in names]


def test_environment_texture_comes_as_a_graph(scene):
    tree, background = new_world(scene)
    sky, mapping, coordinates = add_nodes(tree, "TexEnvironment", "Mapping", "TexCoord")
    sky.image, sky.projection = bpy.data.images.new("Sky", 4, 2, float_buffer=True), "MIRROR_BALL"
    mapping.vector_type, mapping.inputs["Rotation"].default_value = "TEXTURE", (0, 0, 1)
    for source, target in (
        (coordinates.outputs["Generated"], mapping.inputs["Vector"]),
        (mapping.outputs[0], sky.inputs[0]),
    ):
        tree.links.new(source, target)
    tree.links.new(sky.outputs[0], background.inputs["Color"])
    diagnostics = Diagnostics()
    world = export(scene, diagnostics).world
    assert diagnostics.messages() == []
    assert world.name == "World" and world.nodes[world.surface].op == "background"
    ops = {node.op: node for node in world.nodes}
    assert ops["background"].inputs["strength"] == 2
    assert ops["environment"].properties["projection"] == "MIRROR_BALL"
    assert ops["environment"].properties["image"].name == "Sky"
    assert ops["mapping"].properties["vector_type"] == "TEXTURE"
    assert ops["mapping"].inputs["rotation"] == (0, 0, 1)
    compiled = compile_world(world, diagnostics)
    assert compiled.is_black and diagnostics.messages() == []  # a new image is black


def test_environment_texture_without_image_is_magenta(scene):
    tree, background = new_world(scene)
    (sky,) = add_nodes(tree, "TexEnvironment")
    tree.links.new(sky.outputs[0], background.inputs["Color"])
    diagnostics = Diagnostics()
    compiled = compile_world(export(scene, diagnostics).world, diagnostics)
    np.testing.assert_allclose(compiled.mean, (2, 0, 2), rtol=1e-5)
    (message,) = diagnostics.messages()
    assert "no image" in message and "world 'World'" in message


@pytest.mark.parametrize("packed", [True, False])
@pytest.mark.parametrize(
    "kind, depth, stored", [("PNG", "8", 0.21586), ("PNG", "16", 0.21404), ("OPEN_EXR", "32", 0.5), ("HDR", "32", 0.5)]
)
def test_pictures_of_all_kinds(scene, tmp_path, packed, kind, depth, stored):
    """Half grey as stored: sRGB in PNG, linear in the others."""
    oiio = pytest.importorskip("OpenImageIO")
    path = str(tmp_path / ("sky." + {"PNG": "png", "OPEN_EXR": "exr", "HDR": "hdr"}[kind]))
    grey = np.full((8, 16, 3), 128 / 255 if depth == "8" else 0.5, np.float32)
    oiio.ImageBuf(grey).write(path, {"8": "uint8", "16": "uint16", "32": "float"}[depth])
    tree, background = new_world(scene, strength=1.0)
    (sky,) = add_nodes(tree, "TexEnvironment")
    sky.image = bpy.data.images.load(path)
    if packed:
        sky.image.pack()
    tree.links.new(sky.outputs[0], background.inputs["Color"])
    diagnostics = Diagnostics()
    compiled = compile_world(export(scene, diagnostics).world, diagnostics)
    np.testing.assert_allclose(compiled.mean, stored, rtol=4e-3)
    assert diagnostics.messages() == []


def test_mixed_backgrounds_fold_to_a_constant(scene):
    tree, background = new_world(scene, strength=1.0)
    other, mix = add_nodes(tree, "Background", "MixShader")
    other.inputs["Color"].default_value = (1, 1, 1, 1)
    mix.inputs["Fac"].default_value = 0.5
    tree.links.new(background.outputs[0], mix.inputs[1])
    tree.links.new(other.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], next(n for n in tree.nodes if n.type == "OUTPUT_WORLD").inputs["Surface"])
    compiled = compile_world(export(scene).world, Diagnostics())
    assert compiled.is_constant
    np.testing.assert_allclose(compiled.mean, (0.6, 0.7, 0.8))


@pytest.mark.parametrize("name", ["VolumeInfo"])
def test_other_worlds_are_diagnosed_and_the_shown_colour_used(scene, name):
    tree, background = new_world(scene)
    (node,) = add_nodes(tree, name)
    tree.links.new(node.outputs[0], background.inputs["Color"])
    diagnostics = Diagnostics()
    assert export(scene, diagnostics).world.radiance == pytest.approx((0.4, 0.8, 1.2))
    (message,) = diagnostics.messages()
    assert node.bl_label in message and "world 'World'" in message


def test_a_surface_shader_is_no_world(scene):
    tree, _ = new_world(scene)
    (glass,) = add_nodes(tree, "BsdfGlass")
    tree.links.new(glass.outputs[0], next(n for n in tree.nodes if n.type == "OUTPUT_WORLD").inputs["Surface"])
    diagnostics = Diagnostics()
    assert export(scene, diagnostics).world.radiance == pytest.approx((0.4, 0.8, 1.2))
    assert len(diagnostics.messages()) == 1


def test_world_without_output_is_black(scene):
    tree, _ = new_world(scene)
    tree.links.clear()
    assert export(scene).world.radiance == (0, 0, 0)


def nodes_of(scene, cache):
    bpy.context.view_layer.update()
    (light,) = export_scene(bpy.context.evaluated_depsgraph_get(), Diagnostics(), cache=cache).lights
    return light.nodes.shader


def test_nodes_that_stay_are_the_same_object_in_the_next_export(scene):
    tree = enable_nodes(add_light(scene, "POINT").data)
    falloff, ramp = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("LightFalloff", "ValToRGB"))
    tree.links.new(falloff.outputs[0], ramp.inputs[0])
    tree.links.new(ramp.outputs[0], tree.nodes["Emission"].inputs["Color"])
    cache = ExportCache()
    first = nodes_of(scene, cache)
    assert nodes_of(scene, cache) is first
    falloff.inputs["Strength"].default_value = 3
    second = nodes_of(scene, cache)
    assert second is not first
    ramp.color_ramp.elements[0].color = (1, 0, 0, 1)
    assert nodes_of(scene, cache) is not second


@pytest.mark.parametrize("text", ["", "IESNA\nTILT=NONE\n1 -1 2 many", "IESNA\nTILT=NONE\n1 -1 2"])
def test_bad_ies_files_are_told_in_one_sentence(scene, tmp_path, text):
    tree = enable_nodes(add_light(scene, "POINT").data)
    node = tree.nodes.new("ShaderNodeTexIES")
    node.mode = "EXTERNAL"
    node.filepath = str(tmp_path / "lamp.ies")
    tree.links.new(node.outputs[0], tree.nodes["Emission"].inputs["Strength"])
    if text:
        (tmp_path / "lamp.ies").write_text(text)
    diagnostics = Diagnostics()
    compile_scene(export(scene, diagnostics), Settings(width=4, height=4), diagnostics)
    (message,) = diagnostics.messages()
    assert "IES file 'lamp.ies' cannot be read" in message
