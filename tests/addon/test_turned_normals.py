# SPDX-License-Identifier: GPL-3.0-or-later
"""What closures do with normals that nodes have turned, beside Cycles."""

from __future__ import annotations

import bpy
import pytest

from zraka.addon.bench.engines import match

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
