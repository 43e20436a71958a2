# SPDX-License-Identifier: GPL-3.0-or-later
"""Stereo and multi-view renders, previews, exposure, and what files tell of a picture."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from zraka.addon import headless, session, stereo

oiio = pytest.importorskip("OpenImageIO")

SIDE = 24
DISTANCE = 5.0


@pytest.fixture
def scene(blender_scene, add_camera):
    """A white square that emits, seen from above."""
    add_camera(blender_scene, height=DISTANCE)
    with headless.quiet():
        bpy.ops.mesh.primitive_plane_add(size=1)
    material = bpy.data.materials.new("Lamp")
    if material.node_tree is None:
        material.use_nodes = True
    shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    shader.inputs["Emission Color"].default_value = (1, 1, 1, 1)
    shader.inputs["Emission Strength"].default_value = 1.0
    shader.inputs["Base Color"].default_value = (0, 0, 0, 1)
    bpy.context.object.data.materials.append(material)
    render = blender_scene.render
    render.resolution_x = render.resolution_y = SIDE
    blender_scene.zraka.samples, blender_scene.zraka.pixel_filter = 16, "BOX"
    return blender_scene


def write(scene, path, multilayer=False):
    """Render into an EXR file; its spec and pictures by channel, row 0 at the top."""
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "MULTI_LAYER_IMAGE" if multilayer else "IMAGE"
    settings.file_format = "OPEN_EXR_MULTILAYER" if multilayer else "OPEN_EXR"
    settings.color_depth = "32"
    if multilayer:
        settings.views_format = "MULTIVIEW"
        if hasattr(settings, "use_exr_interleave"):
            settings.use_exr_interleave = True
    scene.render.filepath = str(path)
    with headless.quiet():
        bpy.ops.render.render(write_still=True)
    picture = oiio.ImageBuf(str(path))
    pixels = picture.get_pixels(oiio.FLOAT)
    return picture.spec(), {name: pixels[..., k] for k, name in enumerate(picture.spec().channelnames)}


def middle(picture):
    """Mean column of the light in a picture, from the middle in pixels."""
    return (picture.sum(axis=0) @ (np.arange(SIDE) + 0.5)) / picture.sum() - SIDE / 2


def views(scene, path):
    _, channels = write(scene, path, multilayer=True)
    return [
        next(picture for name, picture in channels.items() if f"{view}.R" in name and "Combined" in name)
        for view in ("left", "right")
    ]


@pytest.mark.parametrize(
    ("mode", "at_zero"), [("PARALLEL", None), ("OFFAXIS", 2 * DISTANCE), ("OFFAXIS", DISTANCE), ("TOE", DISTANCE)]
)
def test_each_eye_sees_from_its_place(scene, tmp_path, mode, at_zero):
    """A thing at distance d moves by e/2·f/d·(1 - d/c) pixels between the eyes' middle and each eye.

    e is the distance of the eyes, f the focal length in pixels, c where both windows meet.
    """
    scene.render.use_multiview = True
    settings = scene.camera.data.stereo
    settings.convergence_mode, settings.interocular_distance = mode, 0.4
    settings.pivot, settings.convergence_distance = "CENTER", at_zero or 1e6
    focal = scene.camera.data.lens / scene.camera.data.sensor_width * SIDE
    expected = 0.2 * focal / DISTANCE * (1 - (DISTANCE / at_zero if at_zero else 0))
    left, right = views(scene, tmp_path / "views.exr")
    assert (middle(left), middle(right)) == pytest.approx((expected, -expected), abs=0.08)


def test_each_view_may_have_a_camera_of_its_own(scene, add_camera, tmp_path):
    scene.render.use_multiview, scene.render.views_format = True, "MULTIVIEW"
    scene.camera.name = "Eye_L"
    right = add_camera(scene, "Eye_R", DISTANCE)
    right.location.x = 0.5
    shown = views(scene, tmp_path / "views.exr")
    focal = scene.camera.data.lens / scene.camera.data.sensor_width * SIDE
    assert middle(shown[0]) == pytest.approx(0, abs=0.08)
    assert middle(shown[1]) == pytest.approx(-0.5 * focal / DISTANCE, abs=0.08)


def test_views_that_are_off_are_not_rendered(scene):
    assert stereo.view_names(scene) == []
    scene.render.use_multiview = True
    assert stereo.view_names(scene) == ["left", "right"]
    scene.render.views["left"].use = False
    assert stereo.view_names(scene) == ["right"]


def test_files_tell_how_they_were_made(scene, tmp_path):
    spec, _ = write(scene, tmp_path / "one.exr")
    told = {a.name: a.value for a in spec.extra_attribs if a.name.startswith("zraka.")}
    layer = scene.view_layers[0].name
    assert told[f"zraka.{layer}.method"] == "pathtrace"
    assert told[f"zraka.{layer}.samples"] == "16"
    assert float(told[f"zraka.{layer}.seconds"]) > 0
    assert told[f"zraka.{layer}.estimated_error"].endswith("%")


def test_exposure(scene, tmp_path):
    """A factor of the light, alpha apart; what is emitted is light as well."""
    scene.view_layers[0].use_pass_emit = True
    scene.render.film_transparent = True
    _, plain = write(scene, tmp_path / "plain.exr", multilayer=True)
    scene.zraka.exposure = 2.5
    _, bright = write(scene, tmp_path / "bright.exr", multilayer=True)
    assert plain.keys() == bright.keys()
    for name, picture in plain.items():
        factor = 1.0 if name.endswith(".A") else 2.5
        np.testing.assert_allclose(bright[name], factor * picture, rtol=1e-5)


def test_previews_are_short(scene, monkeypatch):
    """Few samples and two seconds; Blender asks for them in the background of an open tab."""
    jobs = []
    monkeypatch.setattr(session, "export_job", lambda depsgraph, **chosen: jobs.append(chosen))

    class Engine:
        is_preview, camera_override = True, None

    class Graph:
        scene_eval = scene

    session.export_views(Engine, Graph, None)
    assert jobs[0]["samples"] <= 32
    assert jobs[0]["time_limit"] <= 2
