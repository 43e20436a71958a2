# SPDX-License-Identifier: GPL-3.0-or-later
"""What closures do with normals that nodes have turned, beside Cycles."""

from __future__ import annotations

import bpy
import pytest

from zraka.addon.bench.engines import match, operate

from ..reference import agreement, pictures, power
from .nodes.harness import add, add_plane, fresh_scene, output
from .nodes.shapes import ball

CLOSURES = {
    "diffuse": ("BsdfDiffuse", {}),
    "glossy": ("BsdfAnisotropic", {"Roughness": 0.3}),
    "translucent": ("BsdfTranslucent", {}),
    "principled": ("BsdfPrincipled", {"Roughness": 0.4}),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", CLOSURES)
def test_turned_normals_of_closures(name):
    """A steep bump under a sun and a sky: 95% of the blocks within 2% of Cycles beyond the noise of both."""
    ours, theirs = shaded(*CLOSURES[name], bumpy=True)
    share, told = agreement(ours, theirs), power(ours, theirs)
    print(f"{share:.1%} of the blocks agree, {told:.0%} would tell a shift of 5%, {ours.mean() / theirs.mean():.4f}")
    assert share >= 0.95 and told > 0.5


@pytest.mark.slow
def test_a_normal_without_effect_would_be_seen():
    ours, theirs = (pictures(lit(*CLOSURES["diffuse"], bumpy), "ZRAKA", 64) for bumpy in (False, True))
    assert agreement(ours, theirs) < 0.8


@pytest.mark.parametrize("name", ["mirror", "clear glass"])
def test_smooth_normals_mirror_to_above_the_surface(name):
    """A coarse smooth ball under a gradient; with its normals as they are both are too dark and fail."""
    kind, tolerance = {"mirror": ("BsdfAnisotropic", 2e-4), "clear glass": ("BsdfGlass", 1.5e-3)}[name]
    scene = lit(kind, {"Roughness": 0.0}, bumpy=False)
    for lamp in [o for o in scene.objects if o.type == "LIGHT"]:
        bpy.data.objects.remove(lamp)
    tree = scene.world.node_tree
    shifted = add(tree, "Mapping", {"Location": (0.5, 0.5, 0.5), "Scale": (0.5, 0.5, 0.5)})
    tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Generated"], shifted.inputs[0])
    tree.links.new(shifted.outputs[0], tree.nodes["Background"].inputs["Color"])
    scene.render.resolution_x = scene.render.resolution_y = 32
    scene.zraka.depth, scene.zraka.samples = 2, 16
    match(scene)
    ours, theirs = (operate(scene, engine)[0].mean(axis=(0, 1)) for engine in ("ZRAKA", "CYCLES"))
    assert theirs.mean() > 0.1
    assert ours == pytest.approx(theirs, abs=tolerance)


def shaded(kind, inputs, bumpy):
    """The ball as both engines render it."""
    scene = lit(kind, inputs, bumpy)
    return tuple(pictures(scene, engine, 128, 4) for engine in ("ZRAKA", "CYCLES"))


def lit(kind, inputs, bumpy):
    """A scene of a ball with one closure under a sun and a sky."""
    scene = fresh_scene()
    plane = add_plane(scene)
    material = bpy.data.materials.new("Shaded")
    if material.node_tree is None:
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    plane.data.materials.append(material)
    ball(plane, scale=(1, 1, 1))
    closure = add(tree, kind, inputs)
    if bumpy:
        bump = add(tree, "Bump", {"Height": output(add(tree, "TexNoise", {"Scale": 12.0}), 0), "Distance": 2.0})
        tree.links.new(output(bump), closure.inputs["Normal"])
    tree.links.new(closure.outputs[0], add(tree, "OutputMaterial").inputs["Surface"])
    sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    sun.data.energy, sun.data.angle, sun.rotation_euler = 2, 0.3, (0.8, 0.3, 0)
    scene.collection.objects.link(sun)
    scene.world = bpy.data.worlds.new("World")
    if scene.world.node_tree is None:
        scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.4, 0.5, 0.6, 1)
    scene.zraka.method, scene.zraka.depth, scene.cycles.filter_width = "PATHTRACE", 4, 1.0
    match(scene)
    return scene
