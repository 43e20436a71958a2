# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender's cameras see, beside Cycles: every projection, depth of field, pixel filters."""

from __future__ import annotations

from dataclasses import replace

import bpy
import numpy as np
import pytest

from zraka.addon.bench.engines import match, operate
from zraka.core.report.error import agreement
from zraka.core.sampling.pixel_filter import filter_profile

from . import lens_cases
from .camera_cases import CENTRED, FILTERED, KINDS, TOLERANCE, choose, pictures, shine
from .camera_cases import room as build_room
from .lens_cases import Case, renders, set_lens, squares


@pytest.fixture
def scene(blender_scene, add_camera):
    """A camera, single-threaded, both engines set alike."""
    add_camera(blender_scene)
    render = blender_scene.render
    render.threads_mode, render.threads = "FIXED", 1
    match(blender_scene)
    return blender_scene


@pytest.fixture
def room(scene):
    """A camera in a box whose walls show where they are, seen through the pixels' centres."""
    build_room(scene)
    return scene


@pytest.mark.parametrize("case", CENTRED, ids=lambda case: case.item)
def test_positions(blender_scene, case):
    ours, theirs, messages = pictures(blender_scene, case)
    assert not messages
    assert theirs.std() > 0.5
    assert (np.abs(ours - theirs).max(axis=-1) <= TOLERANCE).mean() >= 0.999
    aside = np.abs(np.roll(ours, 1, axis=1) - theirs).max(axis=-1)
    assert (aside <= TOLERANCE).mean() < 0.9  # a pixel aside is seen
    assert case.name != "bordered" or (ours.sum(axis=-1) < 1).any()  # something was clipped


@pytest.mark.slow
@pytest.mark.parametrize("case", FILTERED, ids=lambda case: case.item)
def test_filtered_positions(blender_scene, case):
    """Means over the filter, but for the noise of the room's edges: 1% of the range of positions."""
    ours, theirs, messages = pictures(blender_scene, case)
    assert not messages
    assert (np.abs(ours - theirs).max(axis=-1) <= 0.06).mean() >= 0.999
    assert np.abs(ours - theirs).mean() < 0.01 < np.abs(np.roll(ours, 1, axis=1) - theirs).mean()


@pytest.mark.parametrize("kind", KINDS)
def test_window_coordinates(room, kind):
    if bpy.app.version < (4, 5) and kind in ("FISHEYE_EQUIDISTANT", "FISHEYE_EQUISOLID"):
        pytest.skip("Cycles undid these directions wrongly until it was mended in 2024")
    choose(room.camera.data, kind)
    tree = bpy.context.object.data.materials[0].node_tree
    mapping = next(node for node in tree.nodes if node.type == "MAPPING")
    tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Window"], mapping.inputs["Vector"])
    ours, theirs = (operate(room, engine)[0] for engine in ("ZRAKA", "CYCLES"))
    assert theirs[32].std() > 0.1
    assert (np.abs(ours - theirs).max(axis=-1) <= TOLERANCE).mean() >= 0.999


def test_beside_a_round_picture_is_black_and_opaque(room):
    if room.world.node_tree is None:
        room.world.use_nodes = True
    room.world.node_tree.nodes["Background"].inputs[0].default_value = (1, 1, 1, 1)
    choose(room.camera.data, "FISHEYE_EQUIDISTANT")
    for method in ("RAYCAST", "PATHTRACE"):
        room.zraka.method = method
        ours, _ = operate(room, "ZRAKA")
        assert (ours[0, 0] == 0).all()
        assert (ours[32, 48] > 0).all()


# -- depth of field ----------------------------------------------------------------------------------------------------


@pytest.fixture
def lights(blender_scene):
    """Bright little squares before, in and behind the focus at 3 m."""
    squares(blender_scene)
    return blender_scene


@pytest.mark.parametrize("case", lens_cases.CASES, ids=lambda case: case.item)
def test_depth_of_field(blender_scene, case):
    same, ratio = lens_cases.measure(blender_scene, case)
    assert same >= 0.97
    assert abs(ratio - 1) < 0.02


def test_another_lens_is_told_apart(lights):
    right = Case("", blades=5, rotation=0.3)
    set_lens(lights, right)
    wanted = renders(lights, "ZRAKA")
    for wrong in ({"fstop": 0.12}, {"rotation": 0.9}, {"ratio": 1.2}):
        set_lens(lights, replace(right, **wrong))
        assert agreement(renders(lights, "ZRAKA"), wanted) < 0.97


def test_everything_is_in_focus_in_the_classic_methods(lights):
    lights.zraka.method, lights.zraka.samples = "RAYCAST", 1
    sharp, _ = operate(lights, "ZRAKA")
    lights.camera.data.dof.use_dof, lights.camera.data.dof.aperture_fstop = True, 0.1
    blurred, _ = operate(lights, "ZRAKA")
    np.testing.assert_allclose(blurred, sharp, atol=1e-4)


# -- pixel filters -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("kind", "width"), [("BOX", 1.0), ("GAUSSIAN", 1.5), ("BLACKMAN_HARRIS", 1.5)])
def test_edge_of_a_half_plane(scene, kind, width):
    size, edge = 16, 8.3
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", size
    bpy.ops.mesh.primitive_plane_add(size=100, location=(edge - size / 2 - 50, 0, 0))
    shine(bpy.context.object)
    scene.zraka.samples = scene.cycles.samples = 1024
    for group, name in ((scene.zraka, "pixel_filter"), (scene.cycles, "pixel_filter_type")):
        setattr(group, name, kind)
        group.filter_width = width
    ours, theirs = (operate(scene, engine)[0][..., 0].mean(axis=0) for engine in ("ZRAKA", "CYCLES"))
    half, profile = filter_profile(kind.lower(), width)
    x = np.linspace(-half, half, 10001)
    cdf = np.cumsum(profile(x))
    wanted = np.interp(edge - np.arange(size) - 0.5, x, cdf / cdf[-1])
    np.testing.assert_allclose(ours, wanted, atol=3e-3)
    np.testing.assert_allclose(ours, theirs, atol=0.01)


def test_filters_default_as_in_cycles(blender_scene):
    group, cycles = blender_scene.zraka, blender_scene.cycles
    assert (group.pixel_filter, group.filter_width) == (cycles.pixel_filter_type, cycles.filter_width)
