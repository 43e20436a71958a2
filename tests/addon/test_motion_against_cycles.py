# SPDX-License-Identifier: GPL-3.0-or-later
"""What moves while the shutter is open, beside Cycles: camera, objects, their shapes, and what is to stand still."""

from __future__ import annotations

import math
import warnings

import bpy
import numpy as np
import pytest

from zraka.addon.bench.engines import match, operate, watched
from zraka.core.report.error import agreement

SAMPLES = 128


def paint(obj, shader, color=(0.8, 0.8, 0.8)):
    """Give `obj` a material of one shader node."""
    material = bpy.data.materials.new("Paint")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    node, output = tree.nodes.new(shader), tree.nodes.new("ShaderNodeOutputMaterial")
    node.inputs["Color"].default_value = (*color, 1)
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    obj.data.materials.append(material)
    return node


def curves_of(owner):
    """Animation curves of an ID, also of one that has slots for them."""
    data = owner.id_data.animation_data
    if hasattr(data.action, "fcurves"):
        return data.action.fcurves
    return data.action.layers[0].strips[0].channelbag(data.action_slot).fcurves


def move(owner, name, start, end, frames=(1, 3)):
    """Let a property of `owner` run evenly from `start` to `end`."""
    for frame, value in zip(frames, (start, end), strict=True):
        setattr(owner, name, value)
        owner.keyframe_insert(name, frame=frame)
    for curve in curves_of(owner):
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"


@pytest.fixture
def scene(blender_scene, add_camera):
    """Tiles of three colours seen from above at frame 2, the shutter open for a whole frame around it."""
    scene = blender_scene
    add_camera(scene, height=6.0)
    for number in range(6):
        bpy.ops.mesh.primitive_plane_add(size=0.8, location=(-2 + 1.6 * (number % 3), -0.6 + 1.2 * (number // 3), 0))
        paint(bpy.context.object, "ShaderNodeEmission", np.roll((1.0, 0.5, 0.2), number))
    scene.render.resolution_x, scene.render.resolution_y = 48, 32
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    scene.zraka.samples = SAMPLES
    match(scene)
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0
    scene.frame_set(2)
    return scene


def renders(scene, engine, seeds=(1, 2)):
    pictures = []
    for seed in seeds:
        scene.zraka.seed = scene.cycles.seed = seed
        pictures.append(operate(scene, engine)[0])
    return np.stack(pictures)


def assert_same(scene, shifted=True):
    """Both engines' pictures agree, and neither shows the frame at a standstill."""
    ours, theirs = renders(scene, "ZRAKA"), renders(scene, "CYCLES")
    assert agreement(ours, theirs) >= 0.97
    assert abs(ours.mean() / theirs.mean() - 1) < 0.02
    if shifted:
        scene.render.use_motion_blur = False
        assert agreement(renders(scene, "ZRAKA"), theirs) < 0.97
    return ours


def mean_of_stills(scene, moments=16):
    """What Cycles shows at many moments of the time around frame 2, blurred by nothing."""
    scene.render.use_motion_blur = False
    scene.cycles.samples = 2 * SAMPLES // moments
    pictures = []
    for number in range(moments):
        time = 1.5 + (number + 0.5) / moments
        scene.frame_set(int(time), subframe=time % 1)
        pictures.append(renders(scene, "CYCLES"))
    scene.render.use_motion_blur, scene.cycles.samples = True, SAMPLES
    scene.frame_set(2)
    return np.mean(pictures, axis=0)


def first_tile():
    return next(o for o in bpy.data.objects if o.type == "MESH")


@pytest.mark.parametrize("position", ["START", "CENTER", "END"])
def test_a_camera_that_moves(scene, position):
    scene.render.motion_blur_position = position
    move(scene.camera, "location", (-0.6, -0.3, 6), (0.6, 0.3, 5))
    move(scene.camera, "rotation_euler", (0, 0, -0.2), (0, 0, 0.2))
    assert_same(scene)


def test_a_camera_that_zooms(scene):
    """Cycles lets the angle of view change evenly from one moment to the next, and knows but three."""
    move(scene.camera.data, "lens", 35, 70)
    assert agreement(renders(scene, "ZRAKA"), mean_of_stills(scene)) >= 0.97


def test_an_object_that_moves(scene):
    move(first_tile(), "location", (-2, -0.6, 0), (1, 0.4, 1))
    assert_same(scene)


def test_an_object_that_turns(scene):
    move(first_tile(), "rotation_euler", (0, 0, 0), (0, 0, math.radians(120)))
    first_tile().scale = (3, 1, 1)
    assert_same(scene)


def test_a_shape_that_changes(scene):
    tile = first_tile()
    tile.shape_key_add(name="Basis")
    key = tile.shape_key_add(name="Long")
    for point in key.data:
        point.co.x *= 4
        point.co.y += 1
    move(key, "value", 0, 1)
    assert_same(scene)


def test_an_armature(scene):
    tile = first_tile()
    armature = bpy.data.objects.new("Rig", bpy.data.armatures.new("Rig"))
    scene.collection.objects.link(armature)
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    bone = armature.data.edit_bones.new("Bone")
    bone.head, bone.tail = (0, 0, 0), (0, 1, 0)
    bpy.ops.object.mode_set(mode="OBJECT")
    tile.vertex_groups.new(name="Bone").add([0, 2], 1.0, "REPLACE")
    tile.modifiers.new("Rig", "ARMATURE").object = armature
    pose = armature.pose.bones["Bone"]
    move(pose, "location", (0, 0, 0), (1.5, 0, 0))
    assert_same(scene)


def test_a_shutter_that_opens_slowly(scene):
    curve = scene.render.motion_blur_shutter_curve
    points = curve.curves[0].points
    points[0].location, points[-1].location = (0, 0), (1, 1)
    curve.update()
    move(scene.camera, "location", (-0.6, 0, 6), (0.6, 0, 6))
    assert_same(scene)


def test_what_is_switched_off_stands_still(scene):
    move(first_tile(), "location", (-2, -0.6, 0), (1, 0.4, 1))
    move(scene.camera, "location", (-0.6, 0, 6), (0.6, 0, 6))
    first_tile().cycles.use_motion_blur = scene.camera.cycles.use_motion_blur = False
    ours = assert_same(scene, shifted=False)
    scene.render.use_motion_blur = False
    assert agreement(ours, renders(scene, "ZRAKA")) >= 0.97


def lamp(scene):
    """A lamp that moves over a floor."""
    for tile in [o for o in bpy.data.objects if o.type == "MESH"]:
        bpy.data.objects.remove(tile)
    bpy.ops.mesh.primitive_plane_add(size=20)
    paint(bpy.context.object, "ShaderNodeBsdfDiffuse")
    light = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "AREA"))
    light.data.energy, light.data.size = 100, 0.5
    scene.collection.objects.link(light)
    move(light, "location", (-1, 0, 0.7), (1, 0, 0.7))
    return light


def test_a_lamp_that_stands_still_by_its_switch(scene):
    lamp(scene).cycles.use_motion_blur = False
    assert_same(scene, shifted=False)


def test_a_lamp_that_moves(scene):
    """Cycles lets lamps stand still; their motion is the mean of its pictures at many moments."""
    lamp(scene)
    ours = renders(scene, "ZRAKA")
    assert agreement(ours, mean_of_stills(scene)) >= 0.97
    assert agreement(ours, renders(scene, "CYCLES")) < 0.97


def test_nothing_moves(scene):
    blurred = renders(scene, "ZRAKA")
    scene.render.use_motion_blur = False
    np.testing.assert_array_equal(blurred, renders(scene, "ZRAKA"))


def test_a_rolling_shutter_is_said(scene):
    scene.zraka.samples, scene.cycles.rolling_shutter_type = 2, "TOP"
    with watched() as seen:
        operate(scene, "ZRAKA")
    assert seen.messages == ["a rolling shutter is not supported; all rows are exposed at once"]
