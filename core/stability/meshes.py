# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes that are slim, doubled, collapsed or not finite, and transforms that are no better."""

from __future__ import annotations

import numpy as np

from ..scene import Instance, Material, Mesh, SunLight
from ..settings import METHODS
from .axis import Axis
from .case import Case
from .placing import ALBEDO, SUNLIT, room_radiance
from .shapes import box, camera, looking_down, merged, placed, quad, scene

SUN = SunLight((0, 0, -1), (3, 3, 3))
GREY = Material.diffuse(ALBEDO)


def sunlit(*things):
    """Things in the sun, seen from above the origin."""
    return looking_down(*things, lights=[SUN])


def slivers(aspect, side=4.0, count=64):
    """A square of `count` strips, the middle ones `aspect` times as long as they are wide."""
    width = side / aspect
    edges = (np.arange(count + 1) - count / 2) * width
    edges[0], edges[-1] = -side / 2, side / 2
    x, y = np.meshgrid(edges, (-side / 2, side / 2), indexing="ij")
    vertices = np.stack((x, y, 0 * x), axis=-1).reshape(-1, 3).astype(np.float32)
    first = 2 * np.arange(count)[:, None]
    triangles = np.concatenate([first + corners for corners in ((0, 2, 3), (0, 3, 1))]).astype(np.int32)
    return Mesh(vertices, triangles)


def sliver_room(aspect):
    """A closed black room in a blazing world, its floor of slivers: nothing may leak between them."""
    walls = box(4.0, inward=True)
    sides = Mesh(walls.vertices, np.array([t for t in walls.triangles if walls.vertices[t][:, 2].max() > -2]))
    base = slivers(aspect)
    floor = Mesh(base.vertices + np.float32([0, 0, -2]), base.triangles)
    black = Material.diffuse(0.0)
    return scene(camera((0, 0, 0), (0, 0, -1), fov=2.0), placed(sides, black), placed(floor, black), world=1e6)


def spoiled(value, column=2):
    """A sunlit floor whose mesh also has a triangle with a bad coordinate."""
    plane = quad(4)
    bad = np.array([[0, 0, 5], [1, 0, 5], [0, 1, 5]], np.float32)
    bad[1, column] = value
    return sunlit(placed(merged([plane, Mesh(bad, np.array([[0, 1, 2]]))]), GREY))


def zero_area():
    """A sunlit floor with triangles that are points and lines."""
    flat = Mesh(np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0]], np.float32), np.array([[0, 1, 2], [0, 0, 0]]))
    return sunlit(placed(merged([quad(4), flat]), GREY))


def layered(count, gap):
    """A floor of `count` layers in one place, or nearly."""
    return sunlit(*(placed(quad(4, (0, 0, -gap * k)), GREY) for k in range(count)))


def coincident_room():
    """A closed emitting room, each wall there twice."""
    walls = box(2, inward=True)
    twice = merged([walls, Mesh(walls.vertices, walls.triangles[::-1])])
    return scene(camera((0, 0, 0), (0, 1, 0), fov=1.0), placed(twice, Material.glowing(0.5, 1.0)))


def transformed(scale):
    """A sunlit floor under a scale, along with a body that a second scale flattens."""
    matrix = np.diag([*scale, 1.0])
    return sunlit(Instance(quad(4), matrix, (GREY,)))


def beside_a_flattened_body():
    """A sunlit floor beside a box that an animation has scaled to nothing."""
    gone = Instance(box(1, (0, 0, 0.5)), np.diag([0.0, 0.0, 0.0, 1.0]), (GREY,))
    return sunlit(placed(quad(4), GREY), gone)


def flattened_room():
    """The glowing room under a transform that mirrors it."""
    walls = Instance(box(2, inward=True), np.diag([-1.0, 1.0, 1.0, 1.0]), (Material.glowing(0.5, 1.0),))
    return scene(camera((0, 0, 0), (0, 1, 0), fov=1.0), walls)


def _lit(build, **more):
    return Case(build, SUNLIT, METHODS, samples=16, settings={"depth": 1}, **more)


ROOM = room_radiance(0.5, 8)
LEFT_OUT = "were left out"
FORMS = {
    "no triangle": Case(lambda: sunlit(), 0.0, METHODS),
    "one triangle": _lit(
        lambda: sunlit(placed(Mesh(np.float32([[-9, -9, 0], [9, -9, 0], [0, 9, 0]]), np.array([[0, 1, 2]])), GREY))
    ),
    "a mesh without faces": _lit(
        lambda: sunlit(
            placed(quad(4), GREY), placed(Mesh(np.zeros((5, 3), np.float32), np.zeros((0, 3), np.int32)), GREY)
        )
    ),
    "triangles without area": _lit(zero_area, told=LEFT_OUT),
    "the same face 100 times": _lit(lambda: sunlit(*(placed(quad(4), GREY) for _ in range(100)))),
    "layers 1e-7 apart": _lit(lambda: layered(10, 1e-7)),
    "layers 1e-12 apart": _lit(lambda: layered(10, 1e-12)),
    "a room whose walls are there twice": Case(coincident_room, ROOM, settings={"depth": 8}),
    "NaN vertex": _lit(lambda: spoiled(np.nan), told=LEFT_OUT, finite=False),
    "infinite vertex": _lit(lambda: spoiled(np.inf), told=LEFT_OUT, finite=False),
    "negative infinite vertex": _lit(lambda: spoiled(-np.inf, 0), told=LEFT_OUT, finite=False),
    "vertex at 1e10": _lit(lambda: spoiled(1e10)),
    "vertex at 1e30": _lit(lambda: spoiled(1e30)),
    "vertex at -3e38": _lit(lambda: spoiled(-3e38, 1)),
    "scale -1": _lit(lambda: transformed((-1, 1, 1))),
    "scale (1, 1, 0) of a plane": _lit(lambda: transformed((1, 1, 0))),
    "scale (1, 1, -1e-30)": _lit(lambda: transformed((1, 1, -1e-30))),
    "a body of scale 0": _lit(beside_a_flattened_body, told=LEFT_OUT),
    "a mirrored room": Case(flattened_room, ROOM, settings={"depth": 8}),
}

AXES = (
    Axis(
        "aspect of slivers",
        "floor of strips in the sun: ρ/π · E",
        lambda a: _lit(lambda: sunlit(placed(slivers(a), GREY))),
        (64.0, 1e3, 1e4, 1e5, 1e6, 1e7),
        64.0,
        (64.0, 1e6),
        (64.0, 1e6),
    ),
    Axis(
        "aspect of slivers, black room",
        "closed black room with a floor of strips in a world of 1e6: exactly 0 inside",
        lambda a: Case(lambda: sliver_room(a), 0.0, samples=256),
        (64.0, 1e3, 1e4, 1e5, 1e6, 1e7),
        64.0,
        (64.0, 1e6),
        (64.0, 1e6),
    ),
    Axis("form of the mesh", "floor in the sun, or the closed room: as without what is bad", FORMS.get, tuple(FORMS)),
)
