# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair: how thin, how large and how far away, and strands that are none."""

from __future__ import annotations

import math

import numpy as np

from ..scene import Curves, Material
from ..settings import METHODS
from .axis import Axis
from .case import EVERY_FEATURE, METHOD_VARIANTS, Case
from .meshes import LEFT_OUT, SUN
from .placing import ALBEDO, OFFSETS, SCALES, SOME_OFFSETS, SOME_SCALES, SUNLIT
from .shapes import camera, looking_down, orthographic, placed, quad, scene

# Without Embree's C API there are no curves, which the user is told.
VARIANTS = (*METHOD_VARIANTS, EVERY_FEATURE)
SLIM = "not met exactly"
THIN = (1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0)


def strand(points, radius, **more):
    """One strand."""
    points = np.asarray(points, np.float64)
    return Curves(points, np.broadcast_to(np.asarray(radius, float), (len(points),)), np.array([len(points)]), **more)


def along_x(radius, length=4.0, count=5, **more):
    """A straight strand whose middle is the origin."""
    x = np.linspace(-length / 2, length / 2, count)
    return strand(np.stack((x, 0 * x, 0 * x), axis=1), radius, **more)


def half_seen(radius, length):
    """An emitting strand that covers half of a picture in parallel projection."""
    return scene(
        orthographic(camera((0, 0, 2), (0, 0, 0)), 2 * radius),
        curves=[along_x(radius, length, material=Material.emission())],
    )


def in_a_furnace(scale=1.0, offset=0.0):
    """A white strand that bends, in a white world."""
    t = np.linspace(-1, 1, 9)
    points = scale * np.stack((t, 0.3 * np.sin(4 * t), 0.2 * np.cos(5 * t)), axis=1)
    matrix = np.eye(4)
    matrix[:3, 3] = offset
    white = strand(points, 0.2 * scale, transform=matrix, material=Material.diffuse(1.0))
    eye, target = np.full(3, offset), np.full(3, offset)
    eye[2] += 3 * scale
    return scene(camera(eye, target, fov=0.01), curves=[white], world=1.0)


def beside(*curves):
    """A sunlit floor beside strands."""
    here = looking_down(placed(quad(4), Material.diffuse(ALBEDO)), lights=[SUN])
    return type(here)(here.camera, here.instances, lights=here.lights, curves=curves)


def _lit(*curves, **more):
    return Case(lambda: beside(*curves), SUNLIT, METHODS, samples=16, settings={"depth": 1}, **more)


def _reaching(x):
    return _lit(strand([(3, 3, 1), (4, 3, 1), (x, 3, 1)], 0.1), told=SLIM)


def _spoiled(value, **more):
    return _lit(strand([(3, 3, 1), (4, 3, 1), (5, 3, 1), (6, value, 1)], 0.1), told=LEFT_OUT, finite=False, **more)


STRANDS = {
    "no strand": _lit(Curves(np.zeros((0, 3)), np.zeros(0), np.zeros(0, int))),
    "one point": _lit(strand([(0, 0, 0.5)], 0.1)),
    "points in one place": _lit(strand(np.full((4, 3), 3.0), 0.1)),
    "radius 0": _lit(strand([(3, 3, 1), (4, 3, 1)], 0.0), told=LEFT_OUT),
    "radius -1": _lit(strand([(3, 3, 1), (4, 3, 1)], -1.0), told=LEFT_OUT),
    "radius NaN": _lit(strand([(3, 3, 1), (4, 3, 1)], math.nan), told=LEFT_OUT, finite=False),
    "radius beyond the length": _lit(strand([(5, 5, 1), (5.001, 5, 1)], 2.0)),
    "NaN point": _spoiled(math.nan),
    "infinite point": _spoiled(math.inf),
    "point at 1e6": _reaching(1e6),
    "point at 1e10": _reaching(1e10),
    "point at 1e30": _reaching(1e30),
    "scale 0": _lit(along_x(0.1, transform=np.diag([0.0, 0.0, 0.0, 1.0])), told=LEFT_OUT),
    "scale -1": Case(
        lambda: scene(
            orthographic(camera((0, 0, 2), (0, 0, 0)), 0.2),
            curves=[along_x(0.1, transform=np.diag([-1.0, 1.0, 1.0, 1.0]), material=Material.emission())],
        ),
        0.5,
        METHODS,
        size=(64, 64),
        samples=4,
    ),
    "the same strand 100 times": Case(
        lambda: scene(
            orthographic(camera((0, 0, 2), (0, 0, 0)), 0.2),
            curves=[along_x(0.1, material=Material.emission())] * 100,
        ),
        0.5,
        METHODS,
        size=(64, 64),
        samples=4,
    ),
}

AXES = (
    Axis(
        "radius of a strand",
        "emitting strand that covers half of the picture, its pieces 100 radii long: 1/2",
        lambda r: Case(lambda: half_seen(r, 400 * r), 0.5, METHODS, size=(64, 64), samples=4),
        THIN,
        1e-2,
        (1e-5, 1.0),
        (1e-5, 1e-2, 1.0),
        VARIANTS,
    ),
    Axis(
        "length of a strand's pieces, in radii",
        "emitting strand that covers half of the picture: 1/2",
        lambda n: Case(
            lambda: half_seen(0.01, 0.04 * n),
            0.5,
            METHODS,
            size=(64, 64),
            samples=4,
        ),
        (1.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6),
        100.0,
        (1.0, 1e6),
        (1.0, 100.0, 1e3, 1e5),
        VARIANTS,
    ),
    Axis(
        "scene scale, hair",
        "white strand that bends in a white world: 1",
        lambda s: Case(lambda: in_a_furnace(s), 1.0, settings={"depth": 256}),
        SCALES,
        1.0,
        (1e-5, 1e7),
        SOME_SCALES,
        VARIANTS,
    ),
    Axis(
        "offset, hair",
        "white strand that bends in a white world: 1",
        lambda x: Case(lambda: in_a_furnace(offset=x), 1.0, settings={"depth": 256}),
        OFFSETS,
        0.0,
        (0.0, 1e6),
        SOME_OFFSETS,
        VARIANTS,
    ),
    Axis("form of strands", "floor in the sun beside strands: ρ/π · E", STRANDS.get, tuple(STRANDS), variants=VARIANTS),
)
