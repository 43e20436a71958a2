# SPDX-License-Identifier: GPL-3.0-or-later
"""All four methods in one image, and the sheet they stand on."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from zraka.addon import compare, headless, passes
from zraka.core import render as rendering
from zraka.core.settings import METHODS


@pytest.fixture
def lit_scene(blender_scene, add_camera):
    """A floor under a point light, a sphere's shadow on it."""
    add_camera(blender_scene)
    with headless.quiet():
        bpy.ops.mesh.primitive_plane_add(size=20)
        bpy.ops.mesh.primitive_cube_add(size=0.5, location=(0.3, 0, 0.8))
    lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    lamp.data.energy = 500.0
    lamp.location = (1, 1, 3)
    blender_scene.collection.objects.link(lamp)
    blender_scene.zraka.samples = 4
    return blender_scene


def pixels_of(image):
    pixels = np.zeros(image.size[0] * image.size[1] * 4, np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(image.size[1], image.size[0], 4)


def test_all_methods_into_one_image(lit_scene):
    lit_scene.zraka.method = "RAYTRACE"
    with headless.quiet():
        assert bpy.ops.zraka.compare_methods() == {"FINISHED"}
    assert (lit_scene.render.engine, lit_scene.zraka.method) == ("ZRAKA", "RAYTRACE")
    assert lit_scene.render.use_compositing
    image = bpy.data.images[compare.IMAGE]
    sheet = pixels_of(image)
    height, width = sheet.shape[0] // 2, sheet.shape[1] // 2
    quarters = [sheet[y + 8 : y + 32, x : x + 32, :3] for y in (height - 4, 0) for x in (8, width + 4)]
    assert all(quarter.max() > 0.1 for quarter in quarters)
    assert np.abs(quarters[0] - quarters[1]).max() > 0.05  # shadows
    # Again, of another size: the same image.
    lit_scene.render.resolution_x = 40
    with headless.quiet():
        bpy.ops.zraka.compare_methods()
    assert image.size[0] == 2 * 40 + 3 * 8


def test_a_comparison_on_its_thread_is_stopped(lit_scene):
    lit_scene.zraka.samples = 100000
    with headless.quiet():
        job = headless.export_layer(bpy, lit_scene, lit_scene.view_layers[0].name)
    comparison = compare.Comparison(job)
    comparison.start()
    assert comparison.busy
    assert 0 <= comparison.progress < 1
    assert "Phong" in comparison.text
    comparison.stop(wait=60)
    assert not comparison.busy
    assert comparison.films == {}
    assert comparison.error is None


def test_what_goes_wrong_is_one_sentence(lit_scene, monkeypatch):
    def fail(*args, **kwargs):
        raise ValueError("no such light")

    monkeypatch.setattr(rendering, "render", fail)
    with headless.quiet(), pytest.raises(RuntimeError, match="The comparison stopped: no such light"):
        bpy.ops.zraka.compare_methods()
    lit_scene.camera = None
    with headless.quiet(), pytest.raises(RuntimeError, match="camera"):
        bpy.ops.zraka.compare_methods()


def test_the_methods_are_all():
    assert set(compare._NAMES) == set(METHODS)


def test_light_passes_are_exposed(lit_scene):
    """As the picture is; colours of surfaces are not."""
    kinds = {f"{kind}_{way}" for kind in ("diffuse", "glossy", "transmission") for way in ("direct", "indirect")}
    assert passes._LIGHT == {"emission", "environment"} | kinds
