# SPDX-License-Identifier: GPL-3.0-or-later
"""Bright little squares before, in and behind the focus, through every kind of lens."""

from __future__ import annotations

import math
from dataclasses import dataclass

import bpy
import numpy as np

from zraka.addon.bench.engines import match, picture
from zraka.core.report.error import agreement

from .camera_cases import choose, shine
from .geometry_scenes import put

FOCUS = 3.0


@dataclass(frozen=True)
class Case:
    """A lens of a kind of camera; `on_object` focuses it by an object where the focus is."""

    item: str
    kind: str = "PERSP"
    blades: int = 0
    rotation: float = 0.0
    ratio: float = 1.0
    fstop: float = 0.1
    on_object: bool = False
    note: str = ""


CASES = (
    Case("disk"),
    Case("pentagon, turned", blades=5, rotation=0.3),
    Case("narrow disk", ratio=1.7),
    Case("disk, focused on an object", on_object=True),
    Case("orthographic, hexagon", "ORTHO", 6, 0.2, 1.0, 1.0),
    Case("equirectangular, narrow pentagon", "EQUIRECTANGULAR", 5, 0.3, 1.3),
    Case("mirror ball, narrow triangle", "MIRRORBALL", 3, 0.3, 1.3),
    Case("fisheye, pentagon", "FISHEYE_EQUISOLID", 5, 0.4),
)


def squares(scene):
    """The squares; the focus is 3 m before the camera."""
    scene.camera = scene.camera or put(scene, bpy.data.cameras.new("Camera"), "Camera")
    scene.camera.location, scene.camera.rotation_euler = (0, 0, 0), (math.pi / 2, 0, 0)
    scene.world = bpy.data.worlds.new("World")
    for x, y, z in ((-0.6, 6, 0.4), (0, 3, 0), (0.5, 6, 0.4), (0.2, 2, -0.15), (-0.6, 6, -0.4)):
        bpy.ops.mesh.primitive_plane_add(size=0.06 * y, location=(x, y, z), rotation=(math.pi / 2, 0, 0))
        shine(bpy.context.object, 5.0)
    scene.render.resolution_x, scene.render.resolution_y = 64, 48
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    match(scene)


def set_lens(scene, case):
    """The case's lens."""
    data = scene.camera.data
    choose(data, case.kind)
    data.lens, data.clip_start, data.clip_end, data.fisheye_lens, data.ortho_scale = 100, 0.5, 50, 100, 3
    data.longitude_min, data.longitude_max, data.latitude_min, data.latitude_max = -0.25, 0.25, -0.2, 0.2
    dof = data.dof
    dof.use_dof, dof.focus_distance, dof.aperture_fstop = True, FOCUS, case.fstop
    dof.aperture_blades, dof.aperture_rotation, dof.aperture_ratio = case.blades, case.rotation, case.ratio
    if case.on_object:
        dof.focus_distance = 1.0
        dof.focus_object = put(scene, None, "Focus", location=(0.4, FOCUS, 0.2))


def renders(scene, engine, samples=512):
    """Two pictures of other random numbers."""
    return np.stack([picture(scene, engine, samples, seed) for seed in (1, 2)])


def measure(scene, case):
    """Share of the blocks that agree with Cycles as far as noise tells, and the ratio of the means."""
    squares(scene)
    set_lens(scene, case)
    ours, theirs = renders(scene, "ZRAKA"), renders(scene, "CYCLES")
    return agreement(ours, theirs), float(ours.mean() / theirs.mean())
