# SPDX-License-Identifier: GPL-3.0-or-later
"""Every shader node that this Blender registers and the exporter does not know: named once, and not black."""

from __future__ import annotations

import bpy
import pytest

from zraka.addon.bench.engines import operate, watched
from zraka.addon.export.node_table import NODES

from .harness import add_plane, fresh_scene
from .slope import emptied

LAYOUT = ("ShaderNodeGroup", "ShaderNodeCustomGroup", "ShaderNodeTree", "ShaderNode")
UNKNOWN = [n for n in dir(bpy.types) if n.startswith("ShaderNode") and n not in NODES and n not in LAYOUT]


@pytest.mark.parametrize("kind", UNKNOWN)
def test_what_is_not_known_is_named_and_not_black(kind):
    scene = fresh_scene()
    plane = add_plane(scene)
    material = bpy.data.materials.new("Material")
    tree = emptied(material)
    plane.data.materials.append(material)
    try:
        node = tree.nodes.new(kind)
    except RuntimeError:
        pytest.skip("not a node of materials")
    shown = [s for s in node.outputs if s.enabled]
    if not shown:
        pytest.skip("an end of the graph")
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    emission, last = tree.nodes.new("ShaderNodeEmission"), shown[0]
    emission.inputs["Color"].default_value = (0.3, 0.3, 0.3, 1.0)
    if last.type != "SHADER":
        tree.links.new(last, emission.inputs["Color"])
        last = emission.outputs[0]
    tree.links.new(last, output.inputs["Surface"])
    scene.zraka.method = "PATHTRACE"
    scene.world = bpy.data.worlds.new("World")
    world = emptied(scene.world)
    background, end = world.nodes.new("ShaderNodeBackground"), world.nodes.new("ShaderNodeOutputWorld")
    world.links.new(background.outputs[0], end.inputs["Surface"])
    with watched() as seen:
        picture, _ = operate(scene, "ZRAKA")
    assert len(seen.messages) == 1
    assert node.bl_label in seen.messages[0]
    assert picture.min() > 0
