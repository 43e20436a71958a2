# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender's cameras see, beside Cycles: every projection, depth of field, pixel filters."""

from __future__ import annotations

import math
import warnings

import bpy
import numpy as np
import pytest

from zraka.addon.bench.engines import match, operate, picture, watched
from zraka.core.report.error import agreement
from zraka.core.sampling.pixel_filter import filter_profile

PANORAMAS = [item.identifier for item in bpy.types.Camera.bl_rna.properties["panorama_type"].enum_items]
KINDS = ["PERSP", "ORTHO", *PANORAMAS]


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
    camera = scene.camera
    camera.location, camera.rotation_euler = (0.3, -0.2, 0.4), (1.2, 0.3, 0.5)
    bpy.ops.mesh.primitive_cube_add(size=4, rotation=(0.1, 0.2, 0.3))
    tree, emission = shine(bpy.context.object)
    geometry, mapping = tree.nodes.new("ShaderNodeNewGeometry"), tree.nodes.new("ShaderNodeMapping")
    mapping.inputs["Location"].default_value, mapping.inputs["Scale"].default_value = (4, 4, 4), (1, 1, 1)
    tree.links.new(geometry.outputs["Position"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs[0], emission.inputs["Color"])
    scene.world = bpy.data.worlds.new("World")
    scene.zraka.method, scene.zraka.samples, scene.cycles.samples = "RAYCAST", 1, 1
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "GAUSSIAN", 0.01
    scene.render.resolution_x, scene.render.resolution_y = 96, 64
    return scene


def assert_same_positions(scene):
    with watched() as seen:
        ours, _ = operate(scene, "ZRAKA")
    theirs, _ = operate(scene, "CYCLES")
    assert not seen.messages
    assert theirs.std() > 0.5
    same = np.abs(ours - theirs).max(axis=-1) <= 1e-3
    assert same.mean() >= 0.999
    assert (np.abs(np.roll(ours, 1, axis=1) - theirs).max(axis=-1) <= 1e-3).mean() < 0.9  # a pixel aside is seen
    return ours


@pytest.mark.parametrize("kind", KINDS)
def test_positions(room, kind):
    choose(room.camera.data, kind)
    assert_same_positions(room)


@pytest.mark.parametrize("kind", KINDS)
def test_positions_with_shift_fit_and_limits(room, kind):
    data = room.camera.data
    choose(data, kind)
    data.shift_x, data.shift_y, data.sensor_fit = 0.1, -0.07, "VERTICAL"
    room.render.pixel_aspect_x = 1.4
    data.latitude_min, data.latitude_max, data.longitude_min, data.longitude_max = -0.4, 1.2, -1, 2.5
    data.fisheye_fov, data.fisheye_lens = 4, 8
    if kind == "CENTRAL_CYLINDRICAL":
        data.central_cylindrical_range_u_min, data.central_cylindrical_range_u_max = -1, 2
        data.central_cylindrical_range_v_min, data.central_cylindrical_range_v_max = -1, 3
        data.central_cylindrical_radius = 1.3
    assert_same_positions(room)


@pytest.mark.parametrize("kind", KINDS)
def test_positions_between_clipping_planes_in_a_border(room, kind):
    data, render = room.camera.data, room.render
    choose(data, kind)
    render.resolution_x, render.resolution_y = 60, 90
    data.clip_start, data.clip_end, data.lens, data.sensor_fit = 1.5, 2.5, 20, "HORIZONTAL"
    render.use_border = render.use_crop_to_border = True
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.2, 0.75, 0.1, 0.9
    ours = assert_same_positions(room)
    assert (ours.sum(axis=-1) < 1).any()  # something was clipped


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

LENSES = {  # kind, blades, rotation, ratio, f-stop
    "pentagon": ("PERSP", 5, 0.3, 1.0, 0.1),
    "narrow disk": ("PERSP", 0, 0.0, 1.7, 0.1),
    "orthographic": ("ORTHO", 6, 0.2, 1.0, 1.0),
    "equirectangular": ("EQUIRECTANGULAR", 5, 0.3, 1.3, 0.1),
    "mirror ball": ("MIRRORBALL", 3, 0.3, 1.3, 0.1),
    "fisheye": ("FISHEYE_EQUISOLID", 5, 0.4, 1.0, 0.1),
}


@pytest.fixture
def lights(scene):
    """Bright little squares before, in and behind the focus at 3 m."""
    scene.camera.location, scene.camera.rotation_euler = (0, 0, 0), (math.pi / 2, 0, 0)
    scene.world = bpy.data.worlds.new("World")
    for x, y, z in ((-0.6, 6, 0.4), (0, 3, 0), (0.5, 6, 0.4), (0.2, 2, -0.15), (-0.6, 6, -0.4)):
        bpy.ops.mesh.primitive_plane_add(size=0.06 * y, location=(x, y, z), rotation=(math.pi / 2, 0, 0))
        shine(bpy.context.object, 5.0)
    scene.render.resolution_x, scene.render.resolution_y = 64, 48
    return scene


def set_lens(data, kind, blades, rotation, ratio, fstop):
    choose(data, kind)
    data.lens, data.clip_start, data.clip_end, data.fisheye_lens, data.ortho_scale = 100, 0.5, 50, 100, 3
    data.longitude_min, data.longitude_max, data.latitude_min, data.latitude_max = -0.25, 0.25, -0.2, 0.2
    dof = data.dof
    dof.use_dof, dof.focus_distance, dof.aperture_fstop = True, 3.0, fstop
    dof.aperture_blades, dof.aperture_rotation, dof.aperture_ratio = blades, rotation, ratio


def renders(scene, engine, samples=512):
    return np.stack([picture(scene, engine, samples, seed) for seed in (1, 2)])


@pytest.mark.parametrize("name", LENSES)
def test_depth_of_field(lights, name):
    set_lens(lights.camera.data, *LENSES[name])
    ours, theirs = renders(lights, "ZRAKA"), renders(lights, "CYCLES")
    assert agreement(ours, theirs) >= 0.97
    assert abs(ours.mean() / theirs.mean() - 1) < 0.02


def test_another_lens_is_told_apart(lights):
    set_lens(lights.camera.data, *LENSES["pentagon"])
    right = renders(lights, "ZRAKA")
    for wrong in (("PERSP", 5, 0.3, 1.0, 0.12), ("PERSP", 5, 0.9, 1.0, 0.1), ("PERSP", 5, 0.3, 1.2, 0.1)):
        set_lens(lights.camera.data, *wrong)
        assert agreement(renders(lights, "ZRAKA"), right) < 0.97


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
