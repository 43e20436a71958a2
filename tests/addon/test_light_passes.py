# SPDX-License-Identifier: GPL-3.0-or-later
"""Light passes and shader AOVs beside Cycles' own."""

import warnings

import bpy
import numpy as np
import pytest

from zraka.addon import passes
from zraka.addon.bench.engines import match

from .test_passes import add, material, rendered

KINDS = ("diffuse", "glossy", "transmission")
SWITCHES = [f"use_pass_{kind}_{part}" for kind in KINDS for part in ("direct", "indirect", "color")]
SWITCHES += ["use_pass_emit", "use_pass_environment", "use_pass_ambient_occlusion"]
SIZE = 48, 32
BLOCK = 16


@pytest.fixture
def room(blender_scene):
    """A corner with balls that scatter in all ways, lamps and a sky."""
    scene = blender_scene
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0.0, -5.0, 1.6), (1.45, 0.0, 0.0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    floor = material("floor", "BsdfDiffuse", 0, Color=(0.7, 0.6, 0.5, 1))
    wall = material("wall", "BsdfPrincipled", 0, **{"Base Color": (0.3, 0.5, 0.7, 1), "Roughness": 0.5})
    balls = [
        material("paint", "BsdfPrincipled", 0, **{"Base Color": (0.7, 0.2, 0.1, 1), "Roughness": 0.4}),
        material("gloss", "BsdfAnisotropic", 0, Color=(0.5, 0.7, 0.9, 1), Roughness=0.5),
        material("glass", "BsdfGlass", 0, Color=(0.9, 0.8, 0.7, 1), Roughness=0.5),
        material("leaf", "BsdfTranslucent", 0, Color=(0.3, 0.7, 0.2, 1)),
    ]
    add(scene, "floor", floor, 0, lambda: bpy.ops.mesh.primitive_plane_add(size=12))
    turned = {"size": 3, "location": (0, 2, 1), "rotation": (np.pi / 2, 0, 0)}
    add(scene, "wall", wall, 0, lambda: bpy.ops.mesh.primitive_plane_add(**turned))
    for k, m in enumerate(balls):
        place = {"radius": 0.55, "location": (-1.8 + 1.2 * k, 0, 0.6), "segments": 32, "ring_count": 16}
        ball = add(scene, m.name, m, 0, lambda p=place: bpy.ops.mesh.primitive_uv_sphere_add(**p))
        for polygon in ball.data.polygons:
            polygon.use_smooth = True
    shining = material("shining", "Emission", 0, Color=(1, 0.6, 0.3, 1), Strength=4.0)
    panel = {"size": 0.6, "location": (-0.6, 1.9, 1.6), "rotation": (np.pi / 2, 0, 0)}
    add(scene, "panel", shining, 0, lambda: bpy.ops.mesh.primitive_plane_add(**panel))
    light = bpy.data.lights.new("area", "AREA")
    light.energy, light.size = 120.0, 1.0
    lamp = bpy.data.objects.new("area", light)
    lamp.location, lamp.rotation_euler = (1.5, -1.5, 3.5), (-0.4, 0.4, 0.0)
    scene.collection.objects.link(lamp)
    scene.world = bpy.data.worlds.new("World")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        scene.world.use_nodes = True
    background = next(n for n in scene.world.node_tree.nodes if n.bl_idname == "ShaderNodeBackground")
    background.inputs[0].default_value, background.inputs[1].default_value = (0.5, 0.6, 0.8, 1), 0.3
    scene.world.light_settings.distance = 0.7
    scene.zraka.samples, scene.zraka.depth = 512, 5
    match(scene)
    for switch in SWITCHES:
        setattr(scene.view_layers[0], switch, True)
    return scene


def rgb(found, name):
    return np.stack([found[name][c] for c in "RGB"])


def deviation(ours, theirs):
    """Mean difference of the means of blocks, as a share of the mean."""
    means = [
        p.reshape(3, SIZE[1] // BLOCK, BLOCK, SIZE[0] // BLOCK, BLOCK).mean(axis=(2, 4), dtype=np.float64)
        for p in (ours, theirs)
    ]
    return np.abs(means[0] - means[1]).mean() / means[1].mean()


def test_light_passes_are_those_of_cycles(room, tmp_path):
    ours, _ = rendered(room, "ZRAKA", tmp_path / "ours.exr")
    theirs, _ = rendered(room, "CYCLES", tmp_path / "theirs.exr")
    assert set(ours) == set(theirs)
    names = {p.guide: p.name for p in passes.passes_of(room.view_layers[0])}

    def lit(found, kind, part):
        return rgb(found, names[f"{kind}_{part}"]) * rgb(found, names[f"{kind}_color"])

    for name in ("ambient_occlusion", "emission", "environment", "diffuse_color", "diffuse_direct"):
        assert deviation(rgb(ours, names[name]), rgb(theirs, names[name])) < 0.02, name
    for kind in KINDS:
        for part in ("direct", "indirect"):
            a, b = lit(ours, kind, part), lit(theirs, kind, part)
            if (kind, part) == ("transmission", "direct"):  # no lamp shines into the ball of glass
                assert a.mean() < 1e-5 and b.mean() < 1e-5
                continue
            assert deviation(a, b) < 0.02, (kind, part)
            assert deviation(1.04 * a, b) > 0.02
            assert deviation(a, lit(theirs, KINDS[KINDS.index(kind) - 1], "indirect")) > 0.2
    whole = sum(lit(ours, kind, part) for kind in KINDS for part in ("direct", "indirect"))
    whole = whole + rgb(ours, names["emission"]) + rgb(ours, names["environment"])
    np.testing.assert_allclose(whole, rgb(ours, "Combined"), atol=1e-4 * whole.mean())


def test_shader_aovs_are_those_of_cycles(blender_scene, tmp_path):
    """Behind a veil, in a group, of what no node reads, and of the world."""
    scene, view_layer = blender_scene, blender_scene.view_layers[0]
    scene.render.resolution_x, scene.render.resolution_y = 32, 32
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location = (0, 0, 5)
    scene.collection.objects.link(camera)
    scene.camera = camera
    far = material("far", "BsdfDiffuse", 0)
    tell(far.node_tree, "amount", 2.0)
    coordinates = far.node_tree.nodes.new("ShaderNodeTexCoord")
    tell(far.node_tree, "tint", coordinates.outputs["Generated"])
    veil = material("veil", "BsdfPrincipled", 0, Alpha=0.3)
    group = bpy.data.node_groups.new("group", "ShaderNodeTree")
    tell(group, "amount", 1.0)
    veil.node_tree.nodes.new("ShaderNodeGroup").node_tree = group
    add(scene, "far", far, 0, lambda: bpy.ops.mesh.primitive_plane_add(size=2.5))
    add(scene, "veil", veil, 0, lambda: bpy.ops.mesh.primitive_plane_add(size=2, location=(1, 0, 1)))
    scene.world = bpy.data.worlds.new("far around")
    if scene.world.node_tree is None:
        scene.world.use_nodes = True
    tell(scene.world.node_tree, "amount", 3.0)
    tell(scene.world.node_tree, "tint", scene.world.node_tree.nodes.new("ShaderNodeTexCoord").outputs["Generated"])
    for name, kind in (("amount", "VALUE"), ("tint", "COLOR"), ("nobody's", "VALUE")):
        aov = view_layer.aovs.add()
        aov.name, aov.type = name, kind
    scene.zraka.samples = 64
    match(scene)
    ours, _ = rendered(scene, "ZRAKA", tmp_path / "ours.exr")
    theirs, _ = rendered(scene, "CYCLES", tmp_path / "theirs.exr")
    for name, letters in (("amount", "X"), ("tint", "RGBA"), ("nobody's", "X")):
        assert set(ours[name]) == set(theirs[name]) == set(letters)
        for letter in letters:
            a, b = ours[name][letter], theirs[name][letter]
            plain, veiled = np.s_[14:18, 10:14], np.s_[14:18, 18:22]  # away from edges
            for part in (plain, np.s_[:3, :3]):
                assert a[part].mean() == pytest.approx(b[part].mean(), rel=1e-3, abs=2e-3), (name, letter)
            # The chance at which Cycles' paths go on is a little more than what is let through.
            assert a[veiled].mean() == pytest.approx(b[veiled].mean(), rel=0.08), (name, letter)
    assert ours["amount"]["X"][16, 20] == pytest.approx(1 + 0.7 * 2, rel=1e-5)


def tell(tree, name, value):
    """Add an AOV Output node for a number, or for what an output socket gives as a colour."""
    node = tree.nodes.new("ShaderNodeOutputAOV")
    node.aov_name = name
    if isinstance(value, float):
        node.inputs["Value"].default_value = value
    else:
        tree.links.new(value, node.inputs["Color"])
