# SPDX-License-Identifier: GPL-3.0-or-later
"""A room whose walls show where they are, seen by every kind of camera."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass

import bpy
import numpy as np

from zraka.addon.bench.engines import match, operate, watched

from .geometry_scenes import put

PANORAMAS = [item.identifier for item in bpy.types.Camera.bl_rna.properties["panorama_type"].enum_items]
KINDS = ["PERSP", "ORTHO", *PANORAMAS]
CENTRES = 0.01  # width of a filter that leaves nothing but the pixels' centres
TOLERANCE = 1e-3


@dataclass(frozen=True)
class Case:
    """A camera of a kind, changed by ``change(data, render, kind)``."""

    kind: str
    name: str
    change: Callable = lambda data, render, kind: None
    pixel_filter: tuple = ("GAUSSIAN", CENTRES)

    @property
    def item(self):
        """The case's name."""
        kind = {"PERSP": "perspective", "ORTHO": "orthographic"}.get(self.kind, self.kind.lower().replace("_", " "))
        return f"{kind}, {self.name}"


def choose(data, kind):
    """Make camera `data` a projection or a panorama by name."""
    data.type = kind if kind in ("PERSP", "ORTHO") else "PANO"
    if data.type == "PANO":
        data.panorama_type = kind


def shine(obj, strength=1.0):
    """Make `obj` emit; returns its tree and emission node."""
    material = bpy.data.materials.new("Shine")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    emission, output = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
    emission.inputs["Strength"].default_value = strength
    tree.links.new(emission.outputs[0], output.inputs["Surface"])
    obj.data.materials.append(material)
    return tree, emission


def room(scene):
    """Stand the camera in a box whose walls emit where they are, seen through the pixels' centres."""
    scene.camera = scene.camera or put(scene, bpy.data.cameras.new("Camera"), "Camera")
    scene.camera.location, scene.camera.rotation_euler = (0.3, -0.2, 0.4), (1.2, 0.3, 0.5)
    bpy.ops.mesh.primitive_cube_add(size=4, rotation=(0.1, 0.2, 0.3))
    tree, emission = shine(bpy.context.object)
    geometry, mapping = tree.nodes.new("ShaderNodeNewGeometry"), tree.nodes.new("ShaderNodeMapping")
    mapping.inputs["Location"].default_value, mapping.inputs["Scale"].default_value = (4, 4, 4), (1, 1, 1)
    tree.links.new(geometry.outputs["Position"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs[0], emission.inputs["Color"])
    scene.world = bpy.data.worlds.new("World")
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    scene.render.resolution_x, scene.render.resolution_y = 96, 64
    scene.zraka.samples = 1
    match(scene)
    scene.zraka.method = "RAYCAST"  # whose first sample is in the centre
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "GAUSSIAN", CENTRES


# -- what is changed ---------------------------------------------------------------------------------------------------


def shifted(data, render, kind):
    """Shift, sensor fit, pixels that are not square, the limits of panoramas."""
    data.shift_x, data.shift_y, data.sensor_fit = 0.1, -0.07, "VERTICAL"
    render.pixel_aspect_x = 1.4
    data.latitude_min, data.latitude_max, data.longitude_min, data.longitude_max = -0.4, 1.2, -1, 2.5
    data.fisheye_fov, data.fisheye_lens = 4, 8
    if kind == "CENTRAL_CYLINDRICAL":
        data.central_cylindrical_range_u_min, data.central_cylindrical_range_u_max = -1, 2
        data.central_cylindrical_range_v_min, data.central_cylindrical_range_v_max = -1, 3
        data.central_cylindrical_radius = 1.3


def bordered(data, render, kind):
    """A border between clipping planes, an upright picture, the sensor's width fitted."""
    render.resolution_x, render.resolution_y = 60, 90
    data.clip_start, data.clip_end, data.lens, data.sensor_fit = 1.5, 2.5, 20, "HORIZONTAL"
    render.use_border = render.use_crop_to_border = True
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.2, 0.75, 0.1, 0.9


CENTRED = tuple(
    Case(kind, name, change)
    for kind in KINDS
    for name, change in (("plain", lambda *_: None), ("shifted", shifted), ("bordered", bordered))
)
FILTERS = (("BOX", 1.0), ("GAUSSIAN", 1.5), ("BLACKMAN_HARRIS", 1.5), ("BLACKMAN_HARRIS", 3.0))
FILTERED = tuple(
    Case(kind, f"{name.lower()} {width:g}", pixel_filter=(name, width)) for kind in KINDS for name, width in FILTERS
)
CASES = CENTRED  # whose pictures have no noise
SAMPLES = 1024  # of a filter


def set_up(scene, case):
    """The room, as the case's camera sees it."""
    room(scene)
    choose(scene.camera.data, case.kind)
    case.change(scene.camera.data, scene.render, case.kind)
    name, width = case.pixel_filter
    if width != CENTRES:
        scene.render.resolution_x, scene.render.resolution_y = 24, 16
        scene.zraka.samples = SAMPLES
        match(scene)
        for group, setting in ((scene.zraka, "pixel_filter"), (scene.cycles, "pixel_filter_type")):
            setattr(group, setting, name)
            group.filter_width = width


def pictures(scene, case):
    """Ours, Cycles', messages."""
    set_up(scene, case)
    with watched() as seen:
        ours, _ = operate(scene, "ZRAKA")
    return ours, operate(scene, "CYCLES")[0], seen.messages


def measure(scene, case):
    """Share of the pixels that agree, greatest difference in those in metres, messages."""
    ours, theirs, messages = pictures(scene, case)
    apart = np.abs(ours - theirs).max(axis=-1)
    return float((apart <= TOLERANCE).mean()), float(apart[apart <= TOLERANCE].max()), messages
