# SPDX-License-Identifier: GPL-3.0-or-later
"""The camera window, the frame and the border against Blender itself."""

from __future__ import annotations

import itertools

import bpy
import numpy as np
import pytest
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Euler, Vector

from zraka.addon.export.camera import export_camera, frame_size, render_border
from zraka.core.camera_window import blender_window
from zraka.core.diagnostics import Diagnostics, SceneError

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
    scene.camera.data.type = "PANO"
    scene.camera.data.dof.use_dof = True
    diagnostics = Diagnostics()
    assert export(scene, diagnostics).projection == "PERSPECTIVE"
    assert len(diagnostics.messages()) == 2
    assert all("camera 'Camera'" in m for m in diagnostics.messages())


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
