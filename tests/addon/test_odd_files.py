# SPDX-License-Identifier: GPL-3.0-or-later
"""What random Blender scenes once stumbled over (`tests/fuzz`)."""

import argparse
import warnings

import bpy
import pytest

from zraka.addon import headless
from zraka.addon.export.image import Images
from zraka.addon.export.material import Materials
from zraka.addon.export.world import export_world
from zraka.core.diagnostics import Diagnostics


def ending_in(block, kind):
    """`block`, a material or a world, of nothing but a node that is an output."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        block.use_nodes = True
    block.node_tree.nodes.clear()
    block.node_tree.nodes.new(f"ShaderNodeOutput{kind}")
    return block


@pytest.mark.parametrize("kind", ["World", "Light", "LineStyle"])
def test_a_material_that_ends_in_an_output_of_another_kind(blender_scene, kind):
    material = ending_in(bpy.data.materials.new("Odd"), kind)
    diagnostics = Diagnostics()
    assert Materials(Images(diagnostics, 1), diagnostics)(material).surface is None


def test_a_world_that_ends_in_a_lights_output(blender_scene):
    world = ending_in(bpy.data.worlds.new("Odd"), "Light")
    assert export_world(world, None, Diagnostics()).radiance == (0.0, 0.0, 0.0)


def test_freestyle_is_left_to_blender(blender_scene, add_camera):
    """Blender crashes over a render that hands in no picture while its lines are on."""
    add_camera(blender_scene)
    bpy.ops.mesh.primitive_plane_add()
    blender_scene.render.use_freestyle = True
    names = ("method", "samples", "depth", "threads", "seed", "time_limit", "size")
    job = headless.export(bpy, blender_scene, argparse.Namespace(**dict.fromkeys(names)))
    assert any("Freestyle" in message for message in job.diagnostics.messages())
