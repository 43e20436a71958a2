# SPDX-License-Identifier: GPL-3.0-or-later
"""Images to texels: files and pixels, alpha, colour spaces, what is missing or broken."""

import dataclasses
import os

import numpy as np
import pytest

from zraka.core.diagnostics import Diagnostics
from zraka.core.nodes.image_loader import load
from zraka.core.nodes.tiles import Tiles
from zraka.core.sampling.color import srgb_to_linear
from zraka.core.scene import Image

from .test_nodes_image import HEIGHT, SCALES, WIDTH, pixels, sampled


def loaded(image, place="material 'Test'"):
    diagnostics = Diagnostics()
    return load(image, diagnostics, place), diagnostics.messages()


def test_colours_are_times_alpha_unless_it_is_linked():
    """As whole numbers, rounded down, as Cycles stores them."""
    picture = np.full((2, 2, 4), (200, 100, 3, 100), np.uint8)
    texels, _ = loaded(Image("veil", picture, colorspace="Linear Rec.709"))
    stored = np.array([200 * 100 // 255, 100 * 100 // 255, 1]) / 255
    np.testing.assert_allclose(sampled(texels, [0.5], [0.5], rows=3)[:, 0], stored, rtol=1e-6)
    value = sampled(texels, [0.5], [0.5], unassociate=True)[:, 0]
    np.testing.assert_allclose(value, [*(stored / (100 / 255)), 100 / 255], rtol=1e-5)
    assert picture[0, 0].tolist() == [200, 100, 3, 100]


@pytest.mark.parametrize("nearest", [False, True])
def test_halves_are_rounded_as_told(nearest):
    picture = np.random.default_rng(3).random((4, 4, 4)).astype(np.float16)
    image = Image("veil", picture, colorspace="Linear Rec.709", alpha_mode="STRAIGHT", nearest=nearest)
    stored = load(image, Diagnostics(), "").values.reshape(4, 4, 4)[..., :3].astype(np.float64)
    exact = picture[..., :3].astype(np.float64) * picture[..., 3:]
    step = np.spacing(stored.astype(np.float16)).astype(np.float64)
    lowest, highest = (-0.5, 0.5) if nearest else (0, 1)
    assert ((exact - stored) / step >= lowest).all() and ((exact - stored) / step <= highest).all()
    assert ((exact < stored).any()) == nearest


@pytest.mark.parametrize(
    "alpha_mode, colorspace, alpha",
    [("CHANNEL_PACKED", "sRGB", 0.4), ("AUTO", "Non-Color", 0.4), ("NONE", "sRGB", 1.0), ("PREMUL", "sRGB", 0.4)],
)
def test_colours_are_as_stored_where_alpha_is_something_else(alpha_mode, colorspace, alpha):
    picture = np.full((1, 1, 4), (204, 102, 51, 102), np.uint8)
    texels, _ = loaded(Image("packed", picture, colorspace=colorspace, alpha_mode=alpha_mode))
    value = sampled(texels, [0.5], [0.5], unassociate=alpha_mode != "PREMUL")[:, 0]
    color = np.array([0.8, 0.4, 0.2], np.float32)
    color = color if colorspace == "Non-Color" else srgb_to_linear(color)
    np.testing.assert_allclose(value, [*color, alpha], rtol=1e-4)


@pytest.mark.parametrize("dtype", [np.float16, np.float32])
def test_texels_that_are_not_finite_are_counted_and_zero(dtype):
    picture = pixels(dtype)
    picture[0, 0, 1], picture[2, 3, 3], picture[4, 1] = np.nan, np.inf, -np.inf
    given = picture.copy()
    texels, said = loaded(Image("broken", picture, colorspace="Non-Color"))
    assert said == ["image 'broken' has 3 texels that are not finite; they are set to zero (material 'Test')"]
    wrong = ~np.isfinite(given).all(axis=-1)
    values = texels.values.reshape(given.shape)
    assert not values[wrong].any()
    np.testing.assert_array_equal(values[~wrong], given[~wrong])
    np.testing.assert_array_equal(picture, given)  # the caller's


@pytest.mark.parametrize(
    "image, part",
    [
        (None, "choose one in the node"),
        (Image("lost", filepath="/nowhere/lost.png"), "image 'lost' cannot be read"),
        (Image("nothing"), "image 'nothing' cannot be read"),
        (Image("flat", np.zeros((0, 4, 4), np.uint8)), "image 'flat' has 4 × 0 pixels"),
    ],
)
def test_what_is_missing_is_magenta_and_said(image, part):
    texels, said = loaded(image)
    assert len(said) == 1 and part in said[0] and "material 'Test'" in said[0]
    np.testing.assert_array_equal(sampled(texels, [0.5], [0.5], "Linear")[:, 0], [1, 0, 1, 1])
    assert loaded(image)[1] == said  # in the next render too


def test_shapes_of_pixels():
    for channels, expected in ((1, [9, 9, 9, 255]), (2, [9, 9, 9, 9]), (3, [9, 9, 9, 255]), (4, [9, 9, 9, 9])):
        picture = np.full((2, 2, channels), 9, np.uint8)
        texels, _ = loaded(Image("shape", picture, colorspace="Non-Color"))
        np.testing.assert_allclose(sampled(texels, [0.2], [0.2])[:, 0] * 255, expected, rtol=1e-5)
    grey, _ = loaded(Image("flat", np.full((3, 2), 0.5), colorspace="Non-Color"))
    assert (grey.width, grey.height, grey.values.dtype) == (2, 3, np.float32)


def write(path, values, kind="uint8"):
    oiio = pytest.importorskip("OpenImageIO")
    spec = oiio.ImageSpec(values.shape[1], values.shape[0], values.shape[2], kind)
    spec.attribute("oiio:UnassociatedAlpha", 1)
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec) and output.write_image(np.ascontiguousarray(values))
    output.close()
    return str(path)


@pytest.mark.parametrize(
    "ending, kind, channels, dtype",
    [
        ("png", "uint8", 3, np.uint8),
        ("png", "uint8", 1, np.uint8),
        ("png", "uint16", 4, np.uint16),
        ("exr", "half", 3, np.float16),
        ("exr", "float", 1, np.float32),
        ("exr", "float", 5, np.float32),
    ],
)
def test_files_keep_their_type(tmp_path, ending, kind, channels, dtype):
    values = np.random.default_rng(4).random((HEIGHT, WIDTH, channels), np.float32)
    path = write(tmp_path / f"file.{ending}", values, kind)
    texels, said = loaded(Image("file", filepath=path, colorspace="Non-Color"))
    assert said == []
    assert texels.values.dtype == dtype
    assert texels.values.shape == (WIDTH * HEIGHT, 1 if channels == 1 else 4)
    expected = values[::-1, :, : min(channels, 4)].reshape(WIDTH * HEIGHT, -1)  # row 0 is the bottom
    got = texels.values[:, : expected.shape[1]].astype(np.float32) / SCALES[dtype]
    np.testing.assert_allclose(got, expected, atol={np.uint8: 2e-3, np.float16: 3e-4}.get(dtype, 1e-5))


def test_a_file_is_read_once_while_it_is_as_it_was(tmp_path):
    path = write(tmp_path / "file.png", pixels() / np.float32(255))
    first, _ = loaded(Image("one", filepath=path))
    assert loaded(Image("two", filepath=path))[0] is first
    assert loaded(Image("other space", filepath=path, colorspace="Non-Color"))[0] is not first
    write(tmp_path / "file.png", pixels(seed=5) / np.float32(255))
    os.utime(path, ns=(1, 1))
    changed, _ = loaded(Image("three", filepath=path))
    assert changed is not first
    assert not np.array_equal(changed.values, first.values)


def test_a_broken_file(tmp_path):
    path = write(tmp_path / "file.png", pixels() / np.float32(255))
    with open(path, "r+b") as file:
        file.truncate(60)
    _, said = loaded(Image("broken", filepath=path))
    assert len(said) == 1 and "image 'broken' cannot be read" in said[0]


CONFIGURATION = """
ocio_profile_version: 2
environment: {}
search_path: ""
roles: {scene_linear: lin, default: lin}
file_rules: [!<Rule> {name: Default, colorspace: default}]
displays: {none: [!<View> {name: Raw, colorspace: lin}]}
active_displays: []
active_views: []
colorspaces:
  - !<ColorSpace> {name: lin}
  - !<ColorSpace>
    name: Swapped
    aliases: [Other]
    to_scene_reference: !<MatrixTransform> {matrix: [0, 2, 0, 0, 1, 0, 0, 0, 0, 0, 4, 0, 0, 0, 0, 1]}
"""


@pytest.mark.parametrize("space", ["Swapped", "Other"])
@pytest.mark.parametrize("dtype, stored", [(np.uint8, np.float16), (np.float32, np.float32)])
def test_other_colour_spaces_by_their_configuration(tmp_path, space, dtype, stored):
    """Converted without alpha."""
    pytest.importorskip("OpenImageIO")
    (tmp_path / "config.ocio").write_text(CONFIGURATION)
    picture = pixels(dtype)
    image = Image("other", picture, colorspace=space, color_configuration=str(tmp_path / "config.ocio"))
    texels, said = loaded(image)
    assert said == []
    assert texels.values.dtype == stored
    r, g, b, a = np.moveaxis(picture.astype(np.float64) / SCALES[dtype], -1, 0).reshape(4, -1)
    np.testing.assert_allclose(texels.values, np.stack([2 * g * a, r * a, 4 * b * a, a]).T, rtol=3e-3, atol=1e-3)


def test_an_unknown_colour_space_is_said():
    texels, said = loaded(Image("odd", pixels(np.float32), colorspace="Odd"))
    assert said == ["colour space 'Odd' of image 'odd' is not known here; it is read as linear (material 'Test')"]
    assert not texels.encoded


def test_tiles():
    tiles = {number: Image(str(number), np.full((1, 1, 1), number - 1000, np.float32)) for number in (1001, 1002, 1011)}
    tiles = {number: dataclasses.replace(tile, colorspace="Non-Color") for number, tile in tiles.items()}
    texels, said = loaded(Image("tiles", tiles=tiles))
    assert isinstance(texels, Tiles) and said == []
    x = [0.5, 1.5, 0.5, 1.5, 10.5, -0.5, -1.5, np.nan, 3e38]
    y = [0.5, 0.5, 1.5, 1.5, 0.5, 0.5, 0.5, 0.5, np.inf]
    value = sampled(texels, x, y, "Linear")
    assert value[1].tolist() == [1, 2, 11, 0, 0, 1, 0, 0, 0]  # magenta has no green
    assert value[3].tolist() == [1] * 9
