# SPDX-License-Identifier: GPL-3.0-or-later
"""Texture values as they reach the picture."""

import dataclasses

import numpy as np
import pytest

from zraka.core.compile import compile_scene
from zraka.core.diagnostics import Diagnostics
from zraka.core.render import render
from zraka.core.scene import Image, Link, Material, Node
from zraka.core.settings import Settings

from .scenes import looking_down, placed, quad

SETTINGS = Settings(width=8, height=8, samples=4, depth=1, threads=1)


def seen(image):
    """Mean colour of a glowing square that shows `image` on its UV map, and what was diagnosed."""
    nodes = (
        Node("image", {}, {"image": image}),
        Node("emission", {"color": Link(0, "color"), "strength": 1.0}),
    )
    mesh = dataclasses.replace(quad(4), uvs={"UVMap": np.array([[0, 0], [1, 0], [1, 1]] * 2, np.float32)})
    diagnostics = Diagnostics()
    description = looking_down(placed(mesh, Material("textured", nodes, 1)))
    film = render(compile_scene(description, SETTINGS, diagnostics), SETTINGS)
    assert film.nonfinite == 0
    return film.image()[..., :3].mean(axis=(0, 1)), diagnostics.messages()


@pytest.mark.parametrize("colorspace, expected", [("sRGB", 0.2158605), ("Non-Color", 0.5019608)])
def test_grey_128(colorspace, expected):
    pixels = np.full((4, 4, 4), 128, np.uint8)
    pixels[..., 3] = 255
    color, messages = seen(Image("grey", pixels, colorspace=colorspace))
    assert color == pytest.approx(expected, rel=4e-3)
    assert messages == []


def test_a_wrong_colour_space_is_noticed():
    pixels = np.full((4, 4, 4), 128, np.uint8)
    assert seen(Image("grey", pixels, colorspace="Non-Color"))[0] != pytest.approx(0.2158605, rel=4e-3)


def test_missing_image_is_magenta_and_said():
    color, messages = seen(Image("lost", filepath="/nowhere/lost.png"))
    assert color == pytest.approx((1.0, 0.0, 1.0))
    assert any("lost" in message for message in messages)
