# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights: how strong, how large, how near and how many."""

from __future__ import annotations

import math

import numpy as np

from ..scene import AreaLight, Material, Mesh, PointLight, SunLight
from ..settings import METHODS
from .axis import Axis
from .case import PATH, Case
from .placing import ALBEDO, SUNLIT
from .shapes import box, camera, looking_down, moved, placed, quad, scene, sphere

DIRECT = {"depth": 1}
SIZES = (0.0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0, 1e2, 1e3, 1e4)
SOME_SIZES = (0.0, 1e-5, 0.1, 1e4)


def floor(size=40.0):
    """What is lit."""
    return placed(quad(size), Material.diffuse(ALBEDO))


def rectangle_factor(width, height, distance):
    """Form factor from a point to a parallel rectangle whose middle is straight above it."""
    a, b, c = width / 2, height / 2, distance
    p, q = math.hypot(a, c), math.hypot(b, c)
    return 4 / (2 * math.pi) * (a / p * math.atan(b / p) + b / q * math.atan(a / q))


def by_point(distance=1.0, radius=0.0, power=100.0, **more):
    """A floor below a point light."""
    light = PointLight((0, 0, distance), (power,) * 3, radius=radius, **more)
    view = camera((0.1, 0, 0.5), (0, 0, 0), fov=1e-4 * min(distance, 1.0))
    return scene(view, floor(), lights=[light])


def by_point_truth(distance=1.0, radius=0.0, power=100.0):
    """ρ/π · P/(4π(d² + r²))."""
    return ALBEDO / math.pi * power / (4 * math.pi) / (distance**2 + radius**2)


def area_light(size, height=1.0, power=10.0):
    """A square light that shines down from above the origin."""
    matrix = np.eye(4)
    matrix[2, 3] = height
    return AreaLight(matrix, (power,) * 3, (size, size))


def area_truth(size, power=10.0):
    """ρ/π · E below the middle of a square light at distance 1."""
    return ALBEDO * power / (math.pi * size**2) * rectangle_factor(size, size, 1.0)


def by_panel(size, halves=(0, 1)):
    """A floor below an emitting square, or below one of its triangles."""
    whole = quad(size, (0, 0, 1), "-z")
    lamp = Mesh(whole.vertices, whole.triangles[list(halves)])
    emission = Material.emission(strength=1 / size**2)
    return scene(camera((0.1, 0, 0.5), (0, 0, 0), fov=1e-5), floor(), placed(lamp, emission))


def panel_truth(size):
    """ρ · Le · F."""
    return ALBEDO / size**2 * rectangle_factor(size, size, 1.0)


def by_ball(radius):
    """A floor below an emitting ball of triangles; seen from the side."""
    lamp = moved(sphere(rings=16), Material.emission(strength=1 / radius**2), (0, 0, 1), radius)
    return scene(camera((0, -0.5, 0.1), (0, 0, 0), fov=1e-5), floor(), lamp)


def sunlit(angle):
    """A floor in a sun of the angular size `angle`."""
    return looking_down(floor(), lights=[SunLight((0, 0, -1), (3, 3, 3), angle)])


def many(count):
    """A floor below many lights at about one place."""
    places = np.random.default_rng(0).normal((0, 0, 1), 1e-5, (count, 3))
    lights = [PointLight(tuple(p), (100 / count,) * 3) for p in places]
    return scene(camera((0.1, 0, 0.5), (0, 0, 0), fov=1e-4), floor(), lights=lights)


def _in_a_box():
    shell = placed(box(1.0, (0, 0, 2)), Material.diffuse(ALBEDO))
    return looking_down(floor(), shell, lights=[PointLight((0, 0, 2), (100,) * 3, radius=0.1)])


def _on_a_ceiling():
    ceiling = placed(quad(4.0, (0, 0, 1), "-z"), Material.diffuse(0.0))
    view = camera((0.1, 0, 0.5), (0, 0, 0), fov=1e-4)
    return scene(view, floor(), ceiling, lights=[area_light(1.0)])


def _on_the_floor():
    """A light in the floor shines away from it; what is lit is a ceiling."""
    ceiling = placed(quad(40.0, (0, 0, 1), "-z"), Material.diffuse(ALBEDO))
    matrix = np.diag([1.0, -1.0, -1.0, 1.0])
    light = AreaLight(matrix, (10.0,) * 3, (1.0, 1.0))
    view = camera((0.1, 0, 0.5), (0, 0, 1), fov=1e-4)
    return scene(view, placed(quad(40), Material.diffuse(0.0)), ceiling, lights=[light])


def _at_the_floor():
    return looking_down(floor(), lights=[PointLight((0, 0, 0), (100,) * 3)], height=0.5)


PLACES = {
    "inside a closed box": Case(_in_a_box, 0.0, ("pathtrace", "raycast", "raytrace")),
    "area light in a black ceiling": Case(_on_a_ceiling, area_truth(1.0), settings=DIRECT, samples=256),
    "area light in a black floor": Case(_on_the_floor, area_truth(1.0), settings=DIRECT, samples=256),
    "point light in the floor": Case(_at_the_floor, settings=DIRECT),
}

AXES = (
    Axis(
        "light power",
        "floor below a point light: ρ/π · P/(4πd²)",
        lambda p: Case(lambda: by_point(power=p), by_point_truth(power=p), METHODS, samples=16, settings=DIRECT),
        tuple(10.0**k for k in range(-12, 13, 3)),
        1.0,
        (1e-12, 1e12),
        (1e-12, 1.0, 1e12),
    ),
    Axis(
        "soft point light, radius",
        "floor below a soft point light at 1: ρ/π · P/(4π(d² + r²))",
        lambda r: Case(lambda: by_point(radius=r), by_point_truth(radius=r), METHODS, settings=DIRECT),
        SIZES,
        0.1,
        (1e-5, 1e4),
        SOME_SIZES,
    ),
    Axis(
        "spherical point light, radius",
        "floor below a sphere light at 1, which does not hold the floor: ρ/π · P/(4πd²)",
        lambda r: Case(
            lambda: by_point(radius=r, soft_falloff=False), by_point_truth(), METHODS, samples=256, settings=DIRECT
        ),
        (0.0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 0.5, 0.9, 0.999),
        0.1,
        (1e-5, 0.9),
        (0.0, 1e-5, 0.1, 0.999),
    ),
    Axis(
        "area light, side",
        "floor below a square area light at 1: ρ · P/(πA) · F",
        lambda a: Case(
            lambda: scene(camera((0.1, 0, 0.5), (0, 0, 0), fov=1e-4), floor(), lights=[area_light(a)]),
            area_truth(a),
            samples=256,
            settings=DIRECT,
        ),
        SIZES[1:],
        0.1,
        (1e-5, 1e4),
        SOME_SIZES[1:],
    ),
    Axis(
        "emitting square, side",
        "floor below an emitting square at 1: ρ · Le · F",
        lambda a: Case(lambda: by_panel(a), panel_truth(a), samples=256, settings=DIRECT),
        SIZES[1:],
        0.1,
        (1e-5, 1e4),
        SOME_SIZES[1:],
    ),
    Axis(
        "emitting triangle, side",
        "floor below half an emitting square at 1: ρ · Le · F/2",
        lambda a: Case(lambda: by_panel(a, (0,)), panel_truth(a) / 2, samples=1024, settings=DIRECT),
        SIZES[1:],
        0.1,
        (1e-5, 1e4),
        SOME_SIZES[1:],
    ),
    Axis(
        "emitting ball, radius",
        "floor below a ball of emitting triangles at 1, its outline of 32 corners: ρ · Le · (r²/d²) · 16/π · sin(π/16)",
        lambda r: Case(
            lambda: by_ball(r),
            ALBEDO * 16 / math.pi * math.sin(math.pi / 16),
            samples=1024,
            settings=DIRECT,
            told="without area" if r < 1e-6 else "",  # 1 away from the origin, float32 has no such triangles
        ),
        (1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.05),
        0.05,
        (1e-6, 0.05),
        (1e-6, 1e-5, 0.05),
    ),
    Axis(
        "distance to the light",
        "floor below a point light, power as the square of the distance: ρ/π · P/(4πd²)",
        lambda d: Case(lambda: by_point(d, power=100 * d * d), by_point_truth(), METHODS, samples=16, settings=DIRECT),
        (1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0, 1e2, 1e3, 1e4, 1e5, 1e6),
        1.0,
        (1e-4, 1e6),
        (1e-4, 1.0, 1e6),
    ),
    Axis(
        "sun, angle",
        "floor under a sun overhead, whose radiance is E/(π sin²(angle/2)): ρ/π · E",
        lambda a: Case(lambda: sunlit(a), SUNLIT, METHODS, samples=256, settings=DIRECT),
        (0.0, 1e-8, 1e-6, 1e-5, 1.7e-4, 1e-3, 9.3e-3, 0.1, 1.0, 2.0, 3.0, math.pi),
        9.3e-3,
        (0.0, math.pi),
        (0.0, 1e-5, 9.3e-3, math.pi),
    ),
    Axis(
        "number of lights",
        "floor below many lights at one place: ρ/π · P/(4πd²)",
        lambda n: Case(
            lambda: many(n),
            by_point_truth() if n else 0.0,
            METHODS if n <= 100 else PATH,
            samples=64 if n <= 100 else 4,
            settings=DIRECT,
        ),
        (0, 1, 2, 100, 1000, 10000),
        1,
        (0, 10000),
        (0, 1, 100),
    ),
    Axis("place of the light", "light inside a box: 0; in a surface: as without it", PLACES.get, tuple(PLACES)),
)
