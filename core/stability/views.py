# SPDX-License-Identifier: GPL-3.0-or-later
"""Cameras: field of view, size of the picture, many samples."""

from __future__ import annotations

import math

from ..scene import Camera, Material, ThinLens
from ..settings import METHODS
from .axis import Axis
from .case import METHOD_VARIANTS, PATH, Case
from .placing import LIT, lit_floor
from .shapes import camera, placed, quad, scene


def half_seen(half, distance=1.0, lens=None, projection="PERSPECTIVE"):
    """An emitting square that covers a quarter of the picture, whose half side at distance 1 is `half`."""
    view = camera((0, 0, distance), (0, 0, 0))
    window = (-half, half, -half, half)
    side = half * (distance if projection == "PERSPECTIVE" else 1)
    return scene(Camera(view.transform, window, projection, lens=lens), placed(quad(side), Material.emission()))


def stretched(width, height):
    """A picture of `width` by `height` pixels, a quarter of which an emitter covers."""
    view = camera((0, 0, 1), (0, 0, 0))
    half = (0.5, 0.5) if width == height else (0.5 * width / max(width, height), 0.5 * height / max(width, height))
    window = (-half[0], half[0], -half[1], half[1])
    square = quad(sides=half)
    return scene(Camera(view.transform, window), placed(square, Material.emission()))


def white():
    """Nothing but light."""
    return scene(camera((0, 0, 1), (0, 0, 0)), placed(quad(1.0), Material.emission(strength=0.1)))


def _of_size(size):
    width, height = map(int, size.split("x"))
    samples = max(32, 4096 // (width * height))
    return Case(lambda: stretched(width, height), 0.25, samples=samples, size=(width, height))


def _sums(count):
    # 0.1 is no float32; the mean of equal samples must be that very number.
    return Case(white, _FLOAT32_TENTH, PATH, tolerance=1e-12, samples=count, size=(1, 1))


_FLOAT32_TENTH = 0.10000000149011612

AXES = (
    Axis(
        "field of view (°)",
        "emitting square over a quarter of the picture: 1/4",
        lambda a: Case(lambda: half_seen(math.tan(math.radians(a) / 2)), 0.25, METHODS, size=(64, 64), samples=4),
        (1e-3, 0.01, 0.1, 1.0, 10.0, 60.0, 120.0, 170.0, 179.0, 179.9),
        60.0,
        (1e-3, 179.9),
        (1e-3, 60.0, 179.9),
    ),
    Axis(
        "half side of a parallel view",
        "emitting square over a quarter of the picture: 1/4",
        lambda h: Case(lambda: half_seen(h, projection="ORTHOGRAPHIC"), 0.25, METHODS, size=(64, 64), samples=4),
        tuple(10.0**k for k in range(-6, 7, 2)),
        1.0,
        (1e-6, 1e6),
        (1e-6, 1.0, 1e6),
    ),
    Axis(
        "aperture",
        "emitting square in focus: 1/4",
        lambda r: Case(lambda: half_seen(0.5, 10.0, ThinLens(r, 10.0)), 0.25, PATH, size=(64, 64), samples=4),
        (0.0, 1e-12, 1e-6, 1e-3, 0.1, 1.0, 10.0, 1e3),
        0.1,
        (0.0, 10.0),
        (0.0, 1e-12, 0.1, 1e3),
    ),
    Axis(
        "size of the picture",
        "emitting square over a quarter of the picture: 1/4",
        _of_size,
        ("1x1", "2x2", "1x4096", "16384x1", "1x16384"),
        quick=("1x1", "1x4096", "16384x1"),
    ),
    Axis(
        "samples of one pixel",
        "mean of equal samples: the sample",
        _sums,
        (2, 4096, 65536, 1000000),
        2,
        (2, 1000000),
        (2, 4096),
        METHOD_VARIANTS[:1],
    ),
    Axis(
        "noise target",
        "floor below a soft point light, as far as the target asks: ρ/π · P/(4π(d² + r²))",
        lambda e: Case(lambda: lit_floor(1.0), LIT, METHODS, samples=256, settings={"depth": 1, "noise_target": e}),
        (1e-12, 1e-6, 1e-4, 1e-3, 0.01, 0.1, 1.0, 1e6),
        0.01,
        (1e-6, 1.0),
        (1e-6, 0.01, 1e6),
    ),
    Axis(
        "noise target, adaptive",
        "the same, pixels that are noisier taking more samples",
        lambda e: Case(
            lambda: lit_floor(1.0),
            LIT,
            METHODS,
            samples=256,
            settings={"depth": 1, "noise_target": e, "adaptive": True},
        ),
        (1e-12, 1e-6, 1e-4, 1e-3, 0.01, 0.1, 1.0, 1e6),
        0.01,
        (1e-6, 1.0),
        (1e-6, 0.01, 1e6),
    ),
)
