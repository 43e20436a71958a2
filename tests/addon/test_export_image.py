# SPDX-License-Identifier: GPL-3.0-or-later
"""Images: by file where that is the truth, else by pixels."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from zraka.addon.export import image as export_module
from zraka.addon.export.image import Images, export_image, frame_number, numbered
from zraka.core.diagnostics import Diagnostics
from zraka.core.nodes.image_files import read_file
from zraka.core.nodes.image_loader import load

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


def test_alpha_modes_of_a_file(saved):
    """Before 5.2 Cycles asks the file whether its colours are times alpha."""
    straight = "STRAIGHT" if bpy.app.version >= (5, 2) else "AUTO"
    for mode, expected in (("STRAIGHT", straight), ("CHANNEL_PACKED", "CHANNEL_PACKED"), ("NONE", "NONE")):
        saved.alpha_mode = mode
        exported = export(saved)
        assert exported.alpha_mode == expected
        assert exported.filepath == saved.filepath


def test_generated_float_image_is_linear_with_colours_times_alpha():
    image = painted(float_buffer=True)
    exported = export(image)
    assert exported.pixels.dtype == np.float32
    assert exported.colorspace == "Linear Rec.709"
    assert exported.alpha_mode == ("STRAIGHT" if bpy.app.version >= (5, 2) else "PREMUL")
    np.testing.assert_allclose(exported.pixels[1, 1], PIXEL)
    image.alpha_mode = "CHANNEL_PACKED"
    exported = export(image)
    assert exported.alpha_mode == "CHANNEL_PACKED"
    np.testing.assert_allclose(exported.pixels[1, 1], PIXEL)


def test_a_missing_image_is_neither(saved, tmp_path):
    (tmp_path / "picture.png").unlink()
    exported = export(saved)
    assert exported.pixels is None
    assert exported.filepath == ""
    assert exported.name == "picture.png"


@pytest.mark.parametrize("content", [b"", b"no picture at all"])
def test_an_image_without_pixels_is_magenta_and_said(saved, tmp_path, content):
    """Blender gives an image that it cannot read the size 0 × 0; generated ones have a pixel at least."""
    (tmp_path / "picture.png").write_bytes(content)
    saved.reload()
    assert tuple(saved.size) == (0, 0)
    diagnostics = Diagnostics()
    texels = load(export(saved), diagnostics, "material 'Test'")
    assert texels.values.reshape(-1).tolist() == [1, 0, 1, 1]
    (message,) = diagnostics.messages()
    assert "picture.png" in message and "magenta" in message


def test_images_are_exported_once_and_packed_ones_once_for_all(saved):
    images = Images(Diagnostics())
    assert images(saved) is images(saved)
    saved.pack()
    first = export(saved)
    assert export(saved) is first
    saved.colorspace_settings.name = "Non-Color"
    assert export(saved) is not first
    saved.pixels[0] = 0.25
    assert export(saved).pixels[0, 0, 0] == 64


def test_what_no_library_reads_comes_from_blender(saved, monkeypatch):
    monkeypatch.setattr(export_module, "can_read", lambda path: False)
    assert export(saved).pixels.shape == (2, 4, 4)


def test_tiles(saved, tmp_path):
    (tmp_path / "picture.1001.png").write_bytes((tmp_path / "picture.png").read_bytes())
    (tmp_path / "picture.1012.png").write_bytes((tmp_path / "picture.png").read_bytes())
    saved.filepath = str(tmp_path / "picture.<UDIM>.png")
    saved.source = "TILED"
    for number in {1002, 1012} - {tile.number for tile in saved.tiles}:
        saved.tiles.new(number)
    diagnostics = Diagnostics()
    tiles = export(saved, diagnostics).tiles
    assert [tiles[number].filepath for number in (1001, 1012)] == [
        str(tmp_path / f"picture.{number}.png") for number in (1001, 1012)
    ]
    assert (tiles[1002].filepath, tiles[1002].pixels) == ("", None)
    assert diagnostics.messages() == []


def test_a_tile_never_saved():
    image = bpy.data.images.new("Tiles", 4, 2, tiled=True)
    assert export(image).tiles[1001].pixels.shape[2] == 4


def test_packed_tiles(saved, tmp_path):
    for number in (1001, 1002):
        (tmp_path / f"picture.{number}.png").write_bytes((tmp_path / "picture.png").read_bytes())
    saved.filepath = str(tmp_path / "picture.<UDIM>.png")
    saved.source = "TILED"
    if 1002 not in {tile.number for tile in saved.tiles}:
        saved.tiles.new(1002)
    saved.pack()
    for number in (1001, 1002):
        (tmp_path / f"picture.{number}.png").unlink()
    tiles = export(saved).tiles
    assert tiles[1001].pixels[0, 0].tolist() == [255, 0, 0, 255]
    assert read_file(tiles[1002].filepath).pixels[0, 0].tolist() == [255, 0, 0, 255]


@pytest.mark.parametrize(
    "frame, cyclic, number", [(1, False, 2), (3, False, 3), (6, False, 6), (9, False, 6), (2, True, 6), (7, True, 3)]
)
def test_frames_of_a_sequence(frame, cyclic, number):
    class User:
        frame_duration, frame_start, frame_offset, use_cyclic = 4, 3, 2, cyclic

    assert frame_number(User, frame) == number


@pytest.mark.parametrize(
    "path, expected",
    [("/a1/b.0004.png", "/a1/b.0012.png"), ("/a/7v2_x.exr", "/a/7v12_x.exr"), ("/a/100.v.tif", "/a/012.v.tif")],
)
def test_numbered(path, expected):
    assert numbered(path, 12) == expected
