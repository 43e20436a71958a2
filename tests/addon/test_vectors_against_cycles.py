# SPDX-License-Identifier: GPL-3.0-or-later
"""The Vector pass beside Cycles: pixels to the places a frame before and a frame after."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from zraka.addon.bench.engines import operate, watched

from .camera_cases import PANORAMAS, choose
from .nodes.harness import fresh_scene
from .test_passes import rendered


def animate(owner, name, *values):
    """Give a property its values at frames 1, 2 and 3."""
    for frame, value in enumerate(values, 1):
        setattr(owner, name, value)
        owner.keyframe_insert(name, frame=frame)


def moves(scene, plane):
    animate(plane, "location", (0, 0, 0), (0.3, 0.1, 0), (0.4, 0.5, 0.2))


def turns(scene, plane):
    animate(plane, "rotation_euler", (0, 0, 0), (0, 0.2, 0.3), (0, 0.5, 0.5))


def bends(scene, plane):
    plane.shape_key_add(name="Basis")
    key = plane.shape_key_add(name="Bent")
    key.data[0].co.x, key.data[1].co.y, key.data[2].co.z = 0.0, -1.0, 0.7
    animate(key, "value", 0.0, 0.3, 1.0)


def bends_mirrored(scene, plane):
    plane.scale.x = -1
    bends(scene, plane)
    moves(scene, plane)


def camera_moves(scene, plane):
    animate(scene.camera, "location", (0, 0, 6), (0.3, 0.1, 6), (0.4, 0.5, 6.2))


def camera_zooms(scene, plane):
    animate(scene.camera.data, "lens", 50, 55, 65)


def camera_turns(scene, plane):
    animate(scene.camera, "rotation_euler", (0, 0, 0), (0, 0.1, 0.2), (0.1, 0.3, 0.2))


def turning(kind):
    """A panorama that turns."""

    def change(scene, plane):
        panoramic(kind)(scene, plane)
        camera_turns(scene, plane)

    change.__name__ = f"{kind.lower()} turns"
    return change


def orthographic(scene, plane):
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 5
    moves(scene, plane)


def panoramic(kind):
    """A panorama of a plane that moves."""

    def change(scene, plane):
        data = scene.camera.data
        choose(data, kind)
        data.fisheye_fov, data.fisheye_lens = 1.5, 30
        data.longitude_min, data.longitude_max, data.latitude_min, data.latitude_max = -1, 1, -0.7, 0.8
        moves(scene, plane)

    change.__name__ = kind.lower()
    return change


def not_blurred(scene, plane):
    """The switch of motion blur means nothing here."""
    plane.cycles.use_motion_blur = False
    moves(scene, plane)


def comes_into_sight(scene, plane):
    animate(plane, "hide_render", True, False, False)
    moves(scene, plane)


def instanced(scene, plane):
    """Copies of a collection are told apart."""
    inner = bpy.data.collections.new("Inner")
    inner.objects.link(plane)
    scene.collection.objects.unlink(plane)
    for x in (-1.1, 1.1):
        copy = bpy.data.objects.new("Copy", None)
        copy.instance_type, copy.instance_collection = "COLLECTION", inner
        scene.collection.objects.link(copy)
        animate(copy, "location", (x, 0, 0), (x, 0.1 * x, 0), (x * 1.2, 0, 0))


CASES = (
    moves,
    turns,
    bends,
    bends_mirrored,
    camera_moves,
    camera_zooms,
    camera_turns,
    orthographic,
    not_blurred,
    comes_into_sight,
    instanced,
    *map(panoramic, PANORAMAS),
    turning("EQUIRECTANGULAR"),
)


@pytest.fixture
def scene():
    """A plane below a camera at frame 2; both engines look through the pixels' centres."""
    made = fresh_scene()
    made.zraka.method = "PATHTRACE"
    made.camera.data.type, made.camera.location.z = "PERSP", 6.0
    bpy.ops.mesh.primitive_plane_add(size=2)
    made.view_layers[0].use_pass_vector = True
    made.cycles.samples = 1
    return made


# Cycles told nothing of zooms, and undid fisheyes wrongly, until it was mended in 2024.
OLD = () if bpy.app.version >= (4, 5) else ("camera_zooms", "fisheye_equidistant", "fisheye_equisolid")


def vectors(scene, engine, folder):
    """The pass, (H, W, 4)."""
    found, _ = rendered(scene, engine, folder / f"{engine}.exr")
    return np.stack([found["Vector"][letter] for letter in "XYZW"], axis=-1)


@pytest.mark.parametrize("case", [case for case in CASES if case.__name__ not in OLD], ids=lambda case: case.__name__)
def test_as_cycles_tells(scene, case, tmp_path):
    case(scene, bpy.data.objects["Plane"])
    scene.frame_set(2)
    ours, theirs = (vectors(scene, engine, tmp_path) for engine in ("ZRAKA", "CYCLES"))
    assert np.abs(theirs).max() > 1
    assert (np.abs(ours - theirs).max(axis=-1) < 1e-2).mean() >= 0.99
    assert scene.frame_current == 2


def test_what_stays_empty_is_said(scene, tmp_path):
    moves(scene, bpy.data.objects["Plane"])
    scene.frame_set(2)
    scene.render.use_motion_blur = True
    with watched() as seen:
        assert not vectors(scene, "ZRAKA", tmp_path).any()
    assert [m for m in seen.messages if "'Vector' stays empty with motion blur" in m]


def test_without_the_pass_no_other_frame_is_visited(scene):
    visited = []
    scene.view_layers[0].use_pass_vector = False
    moves(scene, bpy.data.objects["Plane"])
    scene.frame_set(2)
    note = lambda scene, *_: visited.append(scene.frame_current)  # noqa: E731 - Blender keeps the function itself
    bpy.app.handlers.frame_change_post.append(note)
    try:
        operate(scene, "ZRAKA")
        assert set(visited) <= {2}
        scene.view_layers[0].use_pass_vector = True
        operate(scene, "ZRAKA")
        assert {1, 3} <= set(visited)
    finally:
        bpy.app.handlers.frame_change_post.remove(note)
