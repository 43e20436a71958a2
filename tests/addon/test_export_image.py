# SPDX-License-Identifier: GPL-3.0-or-later
"""Images: by file where that is the truth, else by pixels."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from zraka.addon.export.image import Images, export_image
from zraka.core.diagnostics import Diagnostics

PIXEL = (0.5, 0.25, 0.125, 0.5)  # straight alpha


@pytest.fixture(autouse=True)
def fresh_file():
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)


def painted(name="Painted", **kwargs):
    image = bpy.data.images.new(name, 4, 2, alpha=True, **kwargs)
    pixels = np.tile(np.array(PIXEL, np.float32), (2, 4, 1))
    pixels[0, 0] = (1, 0, 0, 1)  # bottom left
    image.pixels.foreach_set(pixels.reshape(-1))
    return image


@pytest.fixture
def saved(tmp_path):
    image = painted()
    image.filepath_raw, image.file_format = str(tmp_path / "picture.png"), "PNG"
    image.save()
    bpy.data.images.remove(image)
    return bpy.data.images.load(str(tmp_path / "picture.png"))


def export(image, diagnostics=None):
    return export_image(image, diagnostics or Diagnostics())


def test_a_file_is_left_to_the_core(saved):
    exported = export(saved)
    assert exported.pixels is None
    assert exported.filepath == saved.filepath
    assert exported.colorspace == "sRGB"
    assert not saved.has_data  # Blender did not read it


def test_a_relative_path_is_made_absolute(saved, tmp_path):
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    saved.filepath = "//picture.png"
    assert export(saved).filepath == str(tmp_path / "picture.png")


def test_a_packed_image_comes_as_stored_bytes(saved, tmp_path):
    saved.pack()
    (tmp_path / "picture.png").unlink()
    saved.colorspace_settings.name = "Non-Color"
    exported = export(saved)
    assert exported.filepath == ""
    assert exported.colorspace == "Non-Color"
    assert exported.pixels.dtype == np.uint8
    assert exported.pixels.shape == (2, 4, 4)
    assert exported.pixels[0, 0].tolist() == [255, 0, 0, 255]  # row 0 is the bottom
    assert exported.pixels[1, 3].tolist() == [128, 64, 32, 128]


def test_painted_over_a_file(saved):
    saved.pixels[0] = 0.0
    assert saved.is_dirty
    assert export(saved).pixels[0, 0].tolist() == [0, 0, 0, 255]


def test_alpha_none(saved):
    saved.alpha_mode = "NONE"
    assert export(saved).pixels[1, 1].tolist() == [128, 64, 32, 255]


def test_generated_float_image_is_linear_with_straight_alpha():
    image = painted(float_buffer=True)
    exported = export(image)
    assert exported.pixels.dtype == np.float32
    assert exported.colorspace == "Linear Rec.709"
    np.testing.assert_allclose(exported.pixels[1, 1], (1.0, 0.5, 0.25, 0.5))  # colour was stored times alpha
    image.alpha_mode = "CHANNEL_PACKED"
    np.testing.assert_allclose(export(image).pixels[1, 1], PIXEL)


def test_a_missing_image_is_neither(saved, tmp_path):
    (tmp_path / "picture.png").unlink()
    exported = export(saved)
    assert exported.pixels is None
    assert exported.filepath == ""
    assert exported.name == "picture.png"


def test_tiles_are_said_once_and_images_exported_once():
    image = bpy.data.images.new("Tiles", 4, 2, tiled=True)
    diagnostics = Diagnostics()
    images = Images(diagnostics)
    assert images(image) is images(image)
    assert diagnostics.messages() == [
        "UDIM images are not supported; their first tile is used everywhere (image 'Tiles')"
    ]
