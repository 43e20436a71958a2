# SPDX-License-Identifier: GPL-3.0-or-later
"""Tiles of three colours seen from above while the shutter is open, and what of them moves."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass

import bpy
import numpy as np

from zraka.addon.bench.engines import match, operate
from zraka.core.report.error import agreement

from .geometry_scenes import put

SAMPLES = 128


@dataclass(frozen=True)
class Case:
    """What moves, ``move(scene)``; `stills` asks for the mean of Cycles' stills, as its own blur shows less."""

    item: str
    move: Callable
    stills: bool = False
    shows: bool = True
    note: str = ""


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


def tiles(scene):
    """Put them before a camera at frame 2, the shutter open for a whole frame around it."""
    scene.camera = scene.camera or put(scene, bpy.data.cameras.new("Camera"), "Camera")
    scene.camera.location.z = 6.0
    for number in range(6):
        bpy.ops.mesh.primitive_plane_add(size=0.8, location=(-2 + 1.6 * (number % 3), -0.6 + 1.2 * (number // 3), 0))
        paint(bpy.context.object, "ShaderNodeEmission", np.roll((1.0, 0.5, 0.2), number))
    scene.render.resolution_x, scene.render.resolution_y = 48, 32
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    scene.zraka.samples = SAMPLES
    match(scene)
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0
    scene.frame_set(2)


def renders(scene, engine, seeds=(1, 2)):
    """Two pictures of other seeds."""
    pictures = []
    for seed in seeds:
        scene.zraka.seed = scene.cycles.seed = seed
        pictures.append(operate(scene, engine)[0])
    return np.stack(pictures)


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
    """The one that moves."""
    return next(o for o in bpy.data.objects if o.type == "MESH")


def measure(scene, case):
    """Share of the blocks within 2%; that of a standstill; the mean over Cycles'."""
    tiles(scene)
    case.move(scene)
    ours, theirs = renders(scene, "ZRAKA"), mean_of_stills(scene) if case.stills else renders(scene, "CYCLES")
    scene.render.use_motion_blur = False
    still = agreement(renders(scene, "ZRAKA"), theirs)
    scene.render.use_motion_blur = True
    return agreement(ours, theirs), still, float(ours.mean() / theirs.mean())


# -- what moves --------------------------------------------------------------------------------------------------------


def camera_at(position):
    """A camera that moves and turns; where in the shutter's time the frame lies."""

    def change(scene):
        scene.render.motion_blur_position = position
        move(scene.camera, "location", (-0.6, -0.3, 6), (0.6, 0.3, 5))
        move(scene.camera, "rotation_euler", (0, 0, -0.2), (0, 0, 0.2))

    return change


def zoom(scene):
    """Another lens."""
    move(scene.camera.data, "lens", 35, 70)


def slide(scene):
    """An object on its way."""
    move(first_tile(), "location", (-2, -0.6, 0), (1, 0.4, 1))


def turn(scene):
    """A long object that turns."""
    move(first_tile(), "rotation_euler", (0, 0, 0), (0, 0, math.radians(120)))
    first_tile().scale = (3, 1, 1)


def shape(scene):
    """A shape key."""
    tile = first_tile()
    tile.shape_key_add(name="Basis")
    key = tile.shape_key_add(name="Long")
    for point in key.data:
        point.co.x *= 4
        point.co.y += 1
    move(key, "value", 0, 1)


def armature(scene):
    """A bone that moves two corners."""
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


def slow_shutter(scene):
    """A shutter that opens slowly."""
    curve = scene.render.motion_blur_shutter_curve
    points = curve.curves[0].points
    points[0].location, points[-1].location = (0, 0), (1, 1)
    curve.update()
    move(scene.camera, "location", (-0.6, 0, 6), (0.6, 0, 6))


def switched_off(scene):
    """Object and camera that are to stand still by their switches."""
    slide(scene)
    move(scene.camera, "location", (-0.6, 0, 6), (0.6, 0, 6))
    first_tile().cycles.use_motion_blur = scene.camera.cycles.use_motion_blur = False


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


def still_lamp(scene):
    """A lamp that is to stand still by its switch."""
    lamp(scene).cycles.use_motion_blur = False


CASES = (
    *(Case(f"moving camera, {p.lower()} on frame", camera_at(p)) for p in ("START", "CENTER", "END")),
    Case("zoom", zoom, stills=True, note="Cycles lets the angle of view change evenly between three moments"),
    Case("moving object", slide),
    Case("turning object", turn, note="on the true circle: every moment is evaluated by Blender"),
    Case("shape keys", shape),
    Case("armature", armature),
    Case("shutter curve", slow_shutter),
    Case('switches "Motion Blur" of objects and cameras', switched_off, shows=False),
    Case('switch "Motion Blur" of a lamp', still_lamp, shows=False),
    Case("moving lamp", lamp, stills=True, note="Cycles lets lamps stand still"),
)
