# SPDX-License-Identifier: GPL-3.0-or-later
"""Textures and emission that are tiny, huge, negative or not finite."""

from __future__ import annotations

import numpy as np

from ..scene import Image, Instance, Link, Material, Mesh, Node, World
from ..settings import METHODS
from .axis import Axis
from .case import PATH, Case
from .placing import ALBEDO
from .shapes import camera, looking_down, placed, quad, scene

FLOAT = "Non-Color"
GREY = 128 / 255


def mapped(size=4.0):
    """A square with a UV map over all of it."""
    plain = quad(size)
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)
    return Mesh(plain.vertices, plain.triangles, uvs={"map": corners[plain.triangles.ravel()]})


def pictured(pixels, surface="emission", interpolation="Linear"):
    """A square that shows a picture, seen from above in whole."""
    image = Image("picture", np.asarray(pixels), colorspace=FLOAT)
    nodes = (
        Node("image", {}, {"image": image, "interpolation": interpolation}),
        Node(surface, {"color": Link(0, "color")}),
    )
    shown = Instance(mapped(), materials=(Material("pictured", nodes, 1),))
    return scene(camera((0, 0, 2), (0, 0, 0), fov=1.0), shown, world=1.0)


def level(width, height, value=0.5):
    """A picture of one grey."""
    return np.full((height, width, 3), value, np.float32)


def bytes_of(width, height):
    """A picture of the grey `GREY`, a byte a texel."""
    return np.full((height, width, 1), 128, np.uint8)


def spotted(value, side=16):
    """A grey picture with one bad texel."""
    pixels = level(side, side)
    pixels[side // 2, side // 2] = value
    return pixels


def emitting(strength):
    """A square that emits, and a floor that it lights."""
    lamp = placed(quad(1.0, (0, 0, 1), "-z"), Material.emission(strength=strength))
    floor = placed(quad(40), Material.diffuse(ALBEDO))
    return scene(camera((0.1, 0, 0.5), (0, 0, 0), fov=1e-4), floor, lamp)


def in_a_world(radiance):
    """A floor under a world."""
    return looking_down(placed(quad(4), Material.diffuse(ALBEDO)), world=radiance)


def in_a_pictured_world(pixels):
    """A floor under a picture of all directions."""
    world = World.textured(Image("sky", pixels, colorspace=FLOAT))
    bare = looking_down(placed(quad(4), Material.diffuse(ALBEDO)))
    return type(bare)(bare.camera, bare.instances, world=world)


def _shown(pixels, truth=0.5, **more):
    return Case(lambda: pictured(pixels), truth, PATH, samples=16, settings={"depth": 1}, **more)


def _lit_by(strength, told, **more):
    return Case(lambda: emitting(strength), settings={"depth": 2}, told=told, **more)


NOT_FINITE = "not finite"
TEXTURES = {
    "1×1": _shown(level(1, 1)),
    "1×1, repeated, as a surface": Case(lambda: pictured(level(1, 1), "diffuse"), 0.5, samples=16),
    "1×16384": _shown(level(1, 16384)),
    "16384×1": _shown(level(16384, 1)),
    "16384×64": _shown(level(16384, 64)),
    "16384×16384": Case(lambda: pictured(bytes_of(16384, 16384)), GREY, samples=16, settings={"depth": 1}),
    "texel of 1e30": Case(lambda: pictured(spotted(1e30), "diffuse"), settings={"depth": 4}),
    "NaN texel": Case(lambda: pictured(spotted(np.nan)), told=NOT_FINITE, finite=False),
    "infinite texel": Case(lambda: pictured(spotted(np.inf)), told=NOT_FINITE, finite=False),
    "NaN texel on a surface": Case(lambda: pictured(spotted(np.nan), "diffuse"), told=NOT_FINITE, finite=False),
    "NaN texel in the world": Case(
        lambda: in_a_pictured_world(spotted(np.nan, 64)), 0.4, told=NOT_FINITE, finite=False
    ),
    "negative texel": Case(lambda: pictured(spotted(-1.0)), (0.5 * 255 - 1) / 256),
}
EMISSIONS = {
    "0": Case(lambda: emitting(0.0), 0.0, METHODS, settings={"depth": 2}),
    "1e-30": Case(lambda: emitting(1e-30), settings={"depth": 2}),
    "1e30": Case(lambda: emitting(1e30), settings={"depth": 2}),
    "NaN": _lit_by(np.nan, NOT_FINITE, finite=False),
    "infinite": _lit_by(np.inf, NOT_FINITE, finite=False),
    "1e38": _lit_by(1e38, NOT_FINITE, finite=False),
    "-1": Case(lambda: emitting(-1.0), settings={"depth": 2}),
    "NaN world": Case(lambda: in_a_world(np.nan), 0.0, told=NOT_FINITE, finite=False),
    "infinite world": Case(lambda: in_a_world(np.inf), 0.0, told=NOT_FINITE, finite=False),
    "world of 1e30": Case(lambda: in_a_world(1e30), ALBEDO * 1e30),
    "world of 1e-30": Case(lambda: in_a_world(1e-30), ALBEDO * 1e-30),
}

AXES = (
    Axis("texture", "square of one grey: 1/2", TEXTURES.get, tuple(TEXTURES)),
    Axis("emission", "emitting square or world: as described, or told and left out", EMISSIONS.get, tuple(EMISSIONS)),
)
