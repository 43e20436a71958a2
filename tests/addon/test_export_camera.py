# SPDX-License-Identifier: GPL-3.0-or-later
"""The camera window, the frame and the border against Blender itself."""

from __future__ import annotations

import itertools
import math

import bpy
import numpy as np
import pytest
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Euler, Vector

from zraka.addon.export.camera import export_camera, frame_size, render_border
from zraka.core.camera_window import blender_window
from zraka.core.diagnostics import Diagnostics, SceneError

PANORAMAS = [item.identifier for item in bpy.types.Camera.bl_rna.properties["panorama_type"].enum_items]
POINTS = np.array([(x, y, -z) for x in (-1.3, 0.2, 2.0) for y in (-0.9, 0.4) for z in (1.0, 7.5)])  # camera space


@pytest.fixture
def scene():
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    scene = bpy.context.scene
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location = (3, -2, 1.5)
    camera.rotation_euler = Euler((1.1, 0.2, 0.6))
    scene.collection.objects.link(camera)
    scene.camera = camera
    return scene


def pixels(camera, width, height, points):
    """Where `points` (camera space) appear in the frame, by the exported window."""
    left, right, bottom, top = camera.window
    depth = -points[:, 2] if camera.projection == "PERSPECTIVE" else 1.0
    return np.stack(
        (
            (points[:, 0] / depth - left) / (right - left) * width,
            (points[:, 1] / depth - bottom) / (top - bottom) * height,
        ),
        axis=1,
    )


def export(scene, diagnostics=None, **kwargs):
    bpy.context.view_layer.update()
    return export_camera(bpy.context.evaluated_depsgraph_get(), diagnostics or Diagnostics(), **kwargs)


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
@pytest.mark.parametrize("fit", ["AUTO", "HORIZONTAL", "VERTICAL"])
def test_window_is_blenders_to_a_hundredth_of_a_pixel(scene, kind, fit):
    data = scene.camera.data
    data.type, data.sensor_fit = kind, fit
    data.lens, data.sensor_width, data.sensor_height, data.ortho_scale = 37.0, 32.0, 18.0, 5.0
    sizes, shifts, aspects = ((640, 480), (300, 700), (512, 512)), ((0, 0), (0.3, -0.2)), ((1, 1), (2, 1), (1, 1.5))
    for (w, h), shift, aspect in itertools.product(sizes, shifts, aspects):
        data.shift_x, data.shift_y = shift
        scene.render.resolution_x, scene.render.resolution_y = w, h
        scene.render.pixel_aspect_x, scene.render.pixel_aspect_y = aspect
        camera = export(scene)
        ours = pixels(camera, w, h, POINTS)
        matrix = camera.transform
        world = POINTS @ matrix[:3, :3].T + matrix[:3, 3]
        theirs = [world_to_camera_view(scene, scene.camera, Vector(p)) for p in world]
        np.testing.assert_allclose(ours, [(v.x * w, v.y * h) for v in theirs], atol=0.01)
        projection = scene.camera.calc_matrix_camera(
            bpy.context.evaluated_depsgraph_get(), x=w, y=h, scale_x=aspect[0], scale_y=aspect[1]
        )
        clip = np.c_[POINTS, np.ones(len(POINTS))] @ np.array(projection).T
        ndc = clip[:, :2] / clip[:, 3:]
        np.testing.assert_allclose(ours, (ndc * 0.5 + 0.5) * (w, h), atol=0.01)


def test_window_of_a_square_sensor():
    assert blender_window(lens=18, sensor_width=36, width=10, height=10) == (-1, 1, -1, 1)
    assert blender_window(ortho_scale=4, width=20, height=10, projection="ORTHOGRAPHIC") == (-2, 2, -1, 1)


def test_scale_of_the_camera_does_not_count(scene):
    before = export(scene).transform
    scene.camera.scale = (3, 0.5, 2)
    np.testing.assert_allclose(export(scene).transform, before, atol=1e-6)
    rotation = before[:3, :3]
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-6)


def test_another_camera_by_name_and_by_object(scene):
    other = bpy.data.objects.new("Other", bpy.data.cameras.new("Other"))
    other.location.x = 9
    scene.collection.objects.link(other)
    assert export(scene, camera="Other").transform[0, 3] == 9
    assert export(scene, camera=other).transform[0, 3] == 9
    assert export(scene).transform[0, 3] == 3


def test_no_camera(scene):
    scene.camera = None
    with pytest.raises(SceneError, match="the scene has no camera; add one or pass --camera NAME"):
        export(scene)
    with pytest.raises(SceneError, match=r"no camera 'Nope'.*'Camera'"):
        export(scene, camera="Nope")


def test_what_the_camera_cannot_do_is_said_once(scene):
    data = scene.camera.data
    if "CUSTOM" not in data.bl_rna.properties["type"].enum_items:
        pytest.skip("this Blender has no cameras written in OSL")
    data.type = "CUSTOM"
    diagnostics = Diagnostics()
    assert export(scene, diagnostics).projection == "PERSPECTIVE"
    assert len(diagnostics.messages()) == 1
    assert "custom cameras are not supported; a perspective one is used" in diagnostics.messages()[0]
    assert "camera 'Camera'" in diagnostics.messages()[0]


@pytest.mark.parametrize("kind", PANORAMAS)
def test_panoramas(scene, kind):
    data = scene.camera.data
    data.type, data.panorama_type = "PANO", kind
    data.shift_x, data.shift_y = 0.25, -0.5
    data.latitude_min, data.longitude_max, data.fisheye_fov, data.fisheye_lens = -0.5, 2.0, 3.0, 8.0
    scene.render.resolution_x, scene.render.resolution_y = 200, 100
    diagnostics = Diagnostics()
    camera = export(scene, diagnostics)
    assert not diagnostics.messages()
    assert (camera.projection, camera.panorama.kind) == ("PANORAMIC", kind)
    np.testing.assert_allclose(camera.window, (0.25, 1.25, -0.5, 0.5))
    panorama = camera.panorama
    assert (panorama.latitude[0], panorama.fov, panorama.lens) == (-0.5, 3.0, 8.0)
    assert panorama.sensor == (36, 18)
    if kind == "CENTRAL_CYLINDRICAL":
        data.central_cylindrical_range_v_max, data.central_cylindrical_radius = 3.0, 1.5
        np.testing.assert_allclose(export(scene).panorama.height, (-1 / 1.5, 2))
    else:
        assert panorama.longitude == (-np.float32(np.pi), 2.0)


def test_sensor_of_a_fisheye_by_fit(scene):
    data = scene.camera.data
    data.type, data.panorama_type, data.sensor_width, data.sensor_height = "PANO", "FISHEYE_EQUISOLID", 30, 20
    scene.render.resolution_x, scene.render.resolution_y = 100, 200
    for fit, sensor in (("AUTO", (15, 30)), ("HORIZONTAL", (30, 60)), ("VERTICAL", (10, 20))):
        data.sensor_fit = fit
        np.testing.assert_allclose(export(scene).panorama.sensor, sensor)


def test_depth_of_field(scene):
    data = scene.camera.data
    assert export(scene).lens is None
    dof = data.dof
    dof.use_dof, dof.aperture_fstop, dof.focus_distance, data.lens = True, 2.0, 7.0, 80
    dof.aperture_blades, dof.aperture_rotation, dof.aperture_ratio = 5, 0.5, 2.0
    lens = export(scene).lens
    assert math.isclose(lens.radius, 0.02)
    assert (lens.focus_distance, lens.blades, lens.rotation, lens.ratio) == (7.0, 5, 0.5, 2.0)
    data.type = "ORTHO"
    assert math.isclose(export(scene).lens.radius, 0.25)


def test_focus_on_an_object_and_on_a_bone(scene):
    camera = scene.camera
    camera.rotation_euler = (0, 0, 0)  # looks down from z = 1.5
    target = bpy.data.objects.new("Target", None)
    target.location = (10, 10, -3)
    scene.collection.objects.link(target)
    dof = camera.data.dof
    dof.use_dof, dof.focus_object = True, target
    assert math.isclose(export(scene).lens.focus_distance, 4.5, rel_tol=1e-6)
    target.location.z = 3.5  # behind the camera
    assert math.isclose(export(scene).lens.focus_distance, 2.0, rel_tol=1e-6)
    bpy.ops.object.armature_add(location=(0, 0, -1))
    dof.focus_object = bpy.context.object
    bone = bpy.context.object.pose.bones[0]
    bone.location = (0, -2, 0)  # along the bone, which points up
    dof.focus_subtarget = bone.name
    assert math.isclose(export(scene).lens.focus_distance, 4.5, rel_tol=1e-6)
    dof.focus_subtarget = "Nope"
    assert math.isclose(export(scene).lens.focus_distance, 2.5, rel_tol=1e-6)


def test_frame_size(scene):
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 333, 101, 50
    assert frame_size(scene) == (166, 50)


BORDERS = ((0.25, 0.75, 0.5, 1.0), (0.1, 0.7, 0.3, 0.9), (0.333, 0.667, 0.0, 0.123))


class BorderProbe(bpy.types.RenderEngine):
    """Notes the size that Blender allocates for the picture."""

    bl_idname, bl_label = "ZRAKA_TEST_BORDER", "Border probe"
    sizes: list = []  # noqa: RUF012

    def render(self, depsgraph):
        result = self.begin_result(0, 0, 1000, 1000)
        self.sizes.append((result.resolution_x, result.resolution_y))
        self.end_result(result)


def test_border_is_the_part_that_blender_allocates(scene):
    bpy.utils.register_class(BorderProbe)
    try:
        scene.render.engine = BorderProbe.bl_idname
        scene.render.resolution_percentage = 100
        assert render_border(scene, 64, 64) is None
        scene.render.use_border = True
        for (x0, x1, y0, y1), (w, h) in itertools.product(BORDERS, ((64, 64), (100, 50), (37, 91))):
            scene.render.resolution_x, scene.render.resolution_y = w, h
            scene.render.border_min_x, scene.render.border_max_x = x0, x1
            scene.render.border_min_y, scene.render.border_max_y = y0, y1
            BorderProbe.sizes.clear()
            bpy.ops.render.render()
            left, bottom, right, top = render_border(scene, w, h)
            assert BorderProbe.sizes[-1] == (right - left, top - bottom)
            assert 0 <= left < right <= w
            assert 0 <= bottom < top <= h
    finally:
        bpy.utils.unregister_class(BorderProbe)
