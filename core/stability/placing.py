# SPDX-License-Identifier: GPL-3.0-or-later
"""How large a scene may be, and how far from the origin."""

from __future__ import annotations

import math

import numpy as np

from ..scene import Material, PointLight, Spheres, SunLight
from ..settings import METHODS
from .axis import Axis
from .case import Case
from .shapes import box, camera, looking_down, moved, placed, quad, scene, sphere

ALBEDO = 0.8
LIT = ALBEDO / math.pi * 100 / (4 * math.pi) / 1.01  # by a soft light of 100 W and radius 0.1, 1 above
SUNLIT = ALBEDO / math.pi * 3
SCALES = tuple(10.0**k for k in range(-6, 9))
SOME_SCALES = (1e-6, 1e-5, 1.0, 1e7, 1e8)
OFFSETS = (0.0, 1.0, 1e3, 1e4, 1e5, 1e6, 1e7)
SOME_OFFSETS = (0.0, 1e6, 1e7)


def room_radiance(albedo, hits):
    """Radiance in a closed room whose walls emit 1, seen by paths of at most `hits` + 1 hits."""
    terms = hits + 1
    return terms if albedo == 1 else (1 - albedo**terms) / (1 - albedo)


def lit_floor(scale):
    """A floor below a point light whose power grows as the square of the scale."""
    view = camera((0, 0, scale), (0, 0, 0), fov=0.005)
    light = PointLight((0, 0, scale), (100 * scale**2,) * 3, radius=0.1 * scale)
    return scene(view, placed(quad(4 * scale), Material.diffuse(ALBEDO)), lights=[light])


def glowing_room(scale=1.0, albedo=0.5, offset=(0, 0, 0), emitted=1.0):
    """A closed room whose walls emit and reflect, seen from its middle."""
    walls = moved(box(2, inward=True), Material.glowing(albedo, emitted), offset, scale)
    return scene(camera(offset, np.add(offset, (0, scale, 0)), fov=1.0), walls)


def black_room(scale):
    """A closed black room in a blazing world: nothing may leak in."""
    walls = placed(box(2 * scale, inward=True), Material.diffuse(0.0))
    return scene(camera((0, 0, 0), (0, scale, 0), fov=2.0), walls, world=1e6)


def glass_ball(scale, analytic):
    """A ball of glass in a white world."""
    view, glass = camera((0, -4 * scale, 0), (0, 0, 0), fov=0.15), Material.glass()
    if analytic:
        return scene(view, spheres=[Spheres(np.zeros((1, 3)), np.full(1, scale), glass)], world=1.0)
    return scene(view, placed(sphere(scale, rings=32), glass), world=1.0)


def sunlit_floor(offset, by_transform):
    """A floor in the sun, moved by its vertices or by its transform."""
    move = np.full(3, offset)
    mesh = quad(4) if by_transform else quad(4, move)
    sun = SunLight((0, 0, -1), (3, 3, 3))
    return looking_down(moved(mesh, Material.diffuse(ALBEDO), move if by_transform else 0), lights=[sun], at=move)


def room_among_vertices(offset):
    """The glowing room, its place in its vertices."""
    move = np.full(3, offset)
    walls = placed(box(2, move, inward=True), Material.glowing(0.5, 1.0))
    return scene(camera(move, np.add(move, (0, 1, 0)), fov=1.0), walls)


def with_an_outlier(distance):
    """The lit floor, and a small thing very far away."""
    here = lit_floor(1.0)
    far = placed(quad(1.0, (distance, 0, distance)), Material.diffuse(ALBEDO))
    return scene(here.camera, *here.instances, far, lights=here.lights)


def _room(build):
    hits = 8
    return lambda value: Case(lambda: build(value), room_radiance(0.5, hits), settings={"depth": hits})


AXES = (
    Axis(
        "scene scale, lit floor",
        "floor below a soft point light, power as the square of the scale: ρ/π · P/(4π(d² + r²))",
        lambda s: Case(lambda: lit_floor(s), LIT, METHODS, settings={"depth": 1}),
        SCALES,
        1.0,
        (1e-5, 1e7),
        SOME_SCALES,
    ),
    Axis(
        "scene scale, closed room",
        "closed room of emitting walls, albedo 0.5, 8 hits: (1 - ρ⁹)/(1 - ρ)",
        _room(lambda s: glowing_room(s)),
        SCALES,
        1.0,
        (1e-5, 1e7),
        SOME_SCALES,
    ),
    Axis(
        "scene scale, black room",
        "closed black room in a world of 1e6: exactly 0 inside",
        lambda s: Case(lambda: black_room(s), 0.0),
        SCALES,
        1.0,
        (1e-5, 1e7),
        SOME_SCALES,
    ),
    Axis(
        "scene scale, glass ball",
        "glass ball of triangles in a white world: 1",
        lambda s: Case(lambda: glass_ball(s, False), 1.0, settings={"depth": 64}),
        SCALES,
        1.0,
        (1e-5, 1e7),
        SOME_SCALES,
    ),
    Axis(
        "scene scale, glass sphere",
        "glass sphere in closed form in a white world: 1",
        lambda s: Case(lambda: glass_ball(s, True), 1.0, settings={"depth": 64}),
        SCALES,
        1.0,
        (1e-5, 1e7),
        SOME_SCALES,
    ),
    Axis(
        "offset, sunlit floor, in vertices",
        "floor in the sun: ρ/π · E",
        lambda x: Case(lambda: sunlit_floor(x, False), SUNLIT, METHODS, samples=4, settings={"depth": 1}),
        OFFSETS,
        0.0,
        (0.0, 1e6),
        SOME_OFFSETS,
    ),
    Axis(
        "offset, sunlit floor, in the transform",
        "floor in the sun: ρ/π · E",
        lambda x: Case(lambda: sunlit_floor(x, True), SUNLIT, METHODS, samples=4, settings={"depth": 1}),
        OFFSETS,
        0.0,
        (0.0, 1e6),
        SOME_OFFSETS,
    ),
    Axis(
        "offset, closed room, in vertices",
        "closed room of emitting walls, albedo 0.5, 8 hits: (1 - ρ⁹)/(1 - ρ)",
        _room(room_among_vertices),
        OFFSETS,
        0.0,
        (0.0, 1e6),
        SOME_OFFSETS,
    ),
    Axis(
        "offset, closed room, in the transform",
        "closed room of emitting walls, albedo 0.5, 8 hits: (1 - ρ⁹)/(1 - ρ)",
        _room(lambda x: glowing_room(offset=(x, x, x))),
        OFFSETS,
        0.0,
        (0.0, 1e6),
        SOME_OFFSETS,
    ),
    Axis(
        "distance of another object",
        "the lit floor beside a small thing very far away",
        lambda x: Case(lambda: with_an_outlier(x), LIT, METHODS, settings={"depth": 1}),
        (10.0, 1e3, 1e5, 1e6, 1e7, 1e8, 1e12, 1e20, 1e30),
        10.0,
        (10.0, 1e6),
        (10.0, 1e6, 1e30),
    ),
)
