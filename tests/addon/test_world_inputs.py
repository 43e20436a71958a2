# SPDX-License-Identifier: GPL-3.0-or-later
"""Input nodes in a world beside Cycles: what they say of directions."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from zraka.addon.bench.engines import operate, watched

from .camera_cases import KINDS, choose
from .nodes.harness import add, compare, fresh_scene, output, signed

COORDINATES = ("Generated", "Normal", "UV", "Object", "Camera", "Window", "Reflection")
GEOMETRY = ("Position", "Normal", "True Normal", "Incoming", "Parametric", "Backfacing", "Pointiness")
SHOWN = [
    *(("TexCoord", name) for name in COORDINATES),
    *(("NewGeometry", name) for name in (*GEOMETRY, "Random Per Island")),
    *(("CameraData", name) for name in ("View Vector", "View Z Depth", "View Distance")),
    *(("ObjectInfo", name) for name in ("Location", "Random")),
    *(("Attribute", name) for name in ("Color", "Alpha")),
    *(("LightPath", name) for name in ("Is Camera Ray", "Ray Depth", "Transparent Depth")),
    ("Fresnel", 0),
    ("LayerWeight", "Facing"),
    ("Tangent", 0),
    ("Wireframe", 0),
    ("NormalMap", 0),
    ("TexNoise", 0),
    ("TexChecker", 0),
]
# Cycles 4.2 mirrors what it tells of these directions; mended in July 2024, for 4.3 ("round-trip tests").
MIRRORED = ("FISHEYE_EQUIDISTANT", "FISHEYE_EQUISOLID") if bpy.app.version < (4, 3) else ()


def both(build, kind="PERSP"):
    """A world that shows what `build` returns to a kind of camera, by Zraka and by Cycles, and Zraka's messages."""
    scene = fresh_scene()
    camera = scene.camera
    camera.rotation_euler, camera.location = (1.2, 0.1, 0.4), (1, 2, 3)
    choose(camera.data, kind)
    camera.data.lens = 18
    scene.world = bpy.data.worlds.new("World")
    if scene.world.node_tree is None:
        scene.world.use_nodes = True
    tree = scene.world.node_tree
    tree.nodes.clear()
    background = add(tree, "Background", {"Color": build(tree)})
    tree.links.new(output(background), add(tree, "OutputWorld").inputs["Surface"])
    with watched() as seen:
        ours, _ = operate(scene, "ZRAKA")
    return ours, operate(scene, "CYCLES")[0], seen.messages


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "socket"), SHOWN)
def test_agrees_with_cycles(kind, socket):
    ours, theirs, messages = both(lambda tree: signed(tree, output(add(tree, kind), socket)))
    assert messages == [] and compare(ours, theirs, 1e-3)[1] == 0


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind not in ("PERSP", "ORTHO")])
def test_window_coordinates_of_panoramas(kind):
    ours, theirs, messages = both(lambda tree: output(add(tree, "TexCoord"), "Window"), kind)
    assert messages == [] and theirs.std() > 0.1
    if kind in MIRRORED:
        theirs[..., 0] = np.where(theirs.any(axis=-1), 1 - theirs[..., 0], 0)
    assert compare(ours, theirs, 1e-3)[1] == 0
    assert compare(np.roll(ours, 1, axis=0), theirs, 1e-3)[1] > 0.5


def test_window_coordinates_of_a_world_seen_in_parallel_are_said():
    *_, messages = both(lambda tree: output(add(tree, "TexCoord"), "Window"), "ORTHO")
    assert len(messages) == 1 and "window coordinates" in messages[0]


def test_attributes_of_the_view_layer_are_said():
    node = {"attribute_type": "VIEW_LAYER", "attribute_name": "frame_current"}
    *_, messages = both(lambda tree: output(add(tree, "Attribute", **node), "Color"))
    assert len(messages) == 1 and "frame_current" in messages[0]
