# SPDX-License-Identifier: GPL-3.0-or-later
"""Stiff scenes, where two scales fight: is the mean right, how fast does the error fall, and who carries the light."""

from __future__ import annotations

import math
import time
from typing import NamedTuple

import numpy as np

from ..compile import compile_scene
from ..diagnostics import Diagnostics
from ..methods.pathtrace import PathTrace
from ..methods.wavefront import Chunk, Worker
from ..scene import Instance, Material, Mesh, PointLight, SunLight
from .case import EVERY_FEATURE, METHOD_VARIANTS, OTHER_ROUTE, Case, film_of, mean_of, settings_of
from .placing import ALBEDO, glowing_room, room_radiance
from .shapes import camera, disk, orthographic, placed, quad, scene

SEEDS = 16
CRITICAL_T = 4.073  # of 15 degrees of freedom: a right mean fails once in a thousand runs
CLAMP = 10.0  # the sum of a sample's channels at which the clamp is tried, in means of the picture
RUNGS = (16, 64, 256)  # shares of the samples at which the error is measured
DIRECT = {"depth": 1}


class Stiff(NamedTuple):
    """A stiff scene: its `case`, the closed form in words, and whether the quick run has it."""

    name: str
    truth: str
    case: Case
    quick: bool = False


class Finding(NamedTuple):
    """What was measured; `ladder` are (samples, seconds, relative error of one render).

    `others` is the t furthest from 0 of the same seeds by Embree's other interface and with all stages.
    """

    stiff: Stiff
    mean: float
    error: float  # standard error of the mean over seeds
    t: float
    others: float
    ladder: list
    clamped: float  # share of the energy that the clamp removes
    lights: float  # share of the energy that sampled lights carry
    nonfinite: int
    seconds: float

    @property
    def verdict(self):
        """Whether the mean is the truth and nothing was lost on the way."""
        return "pass" if max(abs(self.t), abs(self.others)) <= CRITICAL_T and self.nonfinite == 0 else "fail"


# -- scenes ------------------------------------------------------------------------------------------------------------


def _sun_and_sky():
    floor = placed(quad(4), Material.diffuse(ALBEDO))
    sun = SunLight((0, 0, -1), (3, 3, 3), math.radians(0.01))
    return scene(camera((0, 0, 1), (0, 0, 0), fov=0.005), floor, lights=[sun], world=0.01)


def _plate(top, thickness):
    glass = Material.glass()
    return placed(quad(40, (0, 0, top)), glass), placed(quad(40, (0, 0, top - thickness), "-z"), glass)


def _lamp_behind_glass():
    lamp = placed(quad(2e-3, (0, 0, 0)), Material.emission(strength=1e4))
    view = orthographic(camera((0, 0, 3), (0, 0, 0)), 0.02)
    return scene(view, *_plate(1.0, 0.2), lamp)


def _wall_with_hole(radius):
    angle = np.linspace(0, 2 * np.pi, 257)
    inner = np.stack((radius * np.cos(angle), radius * np.sin(angle), 0 * angle + 1), axis=1)
    k = np.arange(256)
    triangles = np.concatenate((np.stack((k, k + 1, k + 257), 1), np.stack((k + 1, k + 258, k + 257), 1)))
    mesh = Mesh(np.vstack((inner, inner * (100, 100, 1))).astype(np.float32), triangles.astype(np.int32))
    return Instance(mesh, materials=(Material("black"),))


def _pinhole():
    """A room below a roof with a hole; the room above is a glowing ceiling."""
    floor = placed(quad(2), Material.diffuse(ALBEDO))
    ceiling = placed(quad(0.5, (0, 0, 1.5), "-z"), Material.emission())
    return scene(camera((0, 0, 0.5), (0, 0, 0), fov=1e-4), floor, _wall_with_hole(0.02), ceiling)


def _slit():
    """A roof of two halves, a slit between them, under a white world."""
    black, half = Material("black"), 5.0
    sides = (half - 0.005, 2 * half)
    left = placed(quad(center=(-(half + 0.005) / 2, 0, 1), sides=sides), black)
    right = placed(quad(center=((half + 0.005) / 2, 0, 1), sides=sides), black)
    walls = [placed(quad(center=(0, y, 0.5), normal="+y", sides=(1.0, 2 * half)), black) for y in (-half, half)]
    walls += [placed(quad(center=(x, 0, 0.5), normal="+x", sides=(2 * half, 1.0)), black) for x in (-half, half)]
    floor = placed(quad(2 * half), Material.diffuse(ALBEDO))
    return scene(camera((0, 0, 0.5), (0, 0, 0), fov=1e-4), floor, left, right, *walls, world=1.0)


def slit_truth(width=0.01, length=10.0):
    """ρ times the form factor of the slit, a rectangle at distance 1."""
    a, b = width / 2, length / 2
    p, q = math.hypot(a, 1), math.hypot(b, 1)
    return ALBEDO * 2 / math.pi * (a / p * math.atan(b / p) + b / q * math.atan(a / q))


_ALPHA, _RADIUS = 1e-3, 1e-4


def _sharp_gloss():
    """A lamp of radius 1e-4 in a lobe of α = 1e-3, seen along the mirrored direction."""
    plane = placed(quad(4), Material.glossy((1, 1, 1), math.sqrt(_ALPHA)))
    light = PointLight((1, 0, 1), (1.0,) * 3, radius=_RADIUS)
    return scene(camera((-1, 0, 1), (0, 0, 0), fov=1e-6), plane, lights=[light])


def sharp_gloss_truth(count=400):
    """∫ Le D(h) G / (4 cos θo) dω over the lamp by quadrature, the smallness of α making G one.

    Source: Walter et al., "Microfacet Models for Refraction through Rough Surfaces", EGSR 2007, equations 20 and 33.
    """
    distance = math.sqrt(2)
    r = (np.arange(count) + 0.5) / count * _RADIUS
    phi = (np.arange(count) + 0.5) / count * 2 * math.pi
    r, phi = (a.ravel() for a in np.meshgrid(r, phi, indexing="ij"))
    axis, x, y = np.array([1, 0, 1]) / math.sqrt(2), np.array([-1, 0, 1]) / math.sqrt(2), np.array([0, 1, 0])
    wi = axis * distance + np.outer(r * np.cos(phi), x) + np.outer(r * np.sin(phi), y)
    squared = (wi**2).sum(axis=1)
    wi /= np.sqrt(squared)[:, None]
    solid_angle = r * (_RADIUS / count) * (2 * math.pi / count) * distance / squared**1.5
    h = wi + np.array([-1, 0, 1]) / math.sqrt(2)
    h /= np.linalg.norm(h, axis=1)[:, None]
    cosine = h[:, 2]
    tangent = (1 - cosine**2) / cosine**2
    d = 1 / (math.pi * _ALPHA**2 * cosine**4 * (1 + tangent / _ALPHA**2) ** 2)
    radiance = 1 / (4 * math.pi**2 * _RADIUS**2)
    return float((radiance * d / (4 * math.cos(math.pi / 4)) * solid_angle).sum())


_LAMP, _TOP, _THICK, _HIGH = 0.05, 0.5, 0.2, 1.0


def _caustic():
    """A small floor lit by a small lamp through a plate of glass, which only scattered rays can find."""
    floor = placed(quad(0.02), Material.diffuse(ALBEDO))
    lamp = placed(disk(_LAMP, (0, 0, _HIGH), up=False), Material.emission(strength=100.0))
    return scene(camera((0.02, 0, 0.1), (0, 0, 0), fov=1e-4), floor, lamp, *_plate(_TOP, _THICK))


def caustic_truth(ior=1.5, count=20000):
    """ρ · Le · 2 ∫ T(θ) sin θ cos θ dθ over what reaches the lamp, again for each pair of inner reflections."""
    theta = (np.arange(count) + 0.5) / count * 0.2
    inside = np.arcsin(np.sin(theta) / ior)
    ci, ct = np.cos(theta), np.cos(inside)
    fresnel = (((ci - ior * ct) / (ci + ior * ct)) ** 2 + ((ior * ci - ct) / (ior * ci + ct)) ** 2) / 2
    total = 0.0
    for k in range(4):
        reach = (_HIGH - _THICK) * np.tan(theta) + (2 * k + 1) * _THICK * np.tan(inside)
        passed = (1 - fresnel) ** 2 * fresnel ** (2 * k) * (reach < _LAMP)
        total += float((passed * np.sin(theta) * np.cos(theta)).sum() * 0.2 / count)
    return ALBEDO * 100.0 * 2 * total


BOUNCES = 64

STIFF = (
    Stiff(
        "sun disk of 0.01° beside a dim sky",
        "ρ(E/π + L)",
        Case(_sun_and_sky, ALBEDO * (3 / math.pi + 0.01), settings=DIRECT, samples=256),
        True,
    ),
    Stiff(
        "tiny bright lamp seen through glass",
        "(1 - r)/(1 + r) · Le · share of the picture",
        Case(_lamp_behind_glass, 12 / 13 * 1e4 * (2e-3 / 0.04) ** 2, settings={"depth": 32}, size=(64, 64), samples=16),
    ),
    Stiff(
        "pinhole between two rooms",
        "ρ r²/(r² + h²)",
        Case(_pinhole, ALBEDO * 0.02**2 / (0.02**2 + 1), settings=DIRECT, samples=1024),
    ),
    Stiff(
        "lobe of α = 1e-3, lamp of radius 1e-4",
        "∫ Le D/(4 cos θ) dω by quadrature",
        Case(_sharp_gloss, sharp_gloss_truth(), settings=DIRECT, samples=256),
        True,
    ),
    Stiff(
        "interior lit through a slit",
        "ρ times the form factor of a rectangle",
        Case(_slit, slit_truth(), settings=DIRECT, samples=1024),
        True,
    ),
    Stiff(
        "closed box of albedo 0.999",
        f"(1 - ρᴺ⁺¹)/(1 - ρ), N = {BOUNCES}",
        Case(lambda: glowing_room(albedo=0.999), room_radiance(0.999, BOUNCES), settings={"depth": BOUNCES}, samples=4),
    ),
    Stiff(
        "caustic through a plate of glass",
        "ρ Le 2 ∫ T(θ) sin θ cos θ dθ",
        Case(_caustic, caustic_truth(), settings={"depth": 12}, samples=1024),
    ),
)


# -- what is asked of them ---------------------------------------------------------------------------------------------


class _Unlit(PathTrace):
    """Path tracing of which only what scattered rays meet reaches the film, at the weight it has in the whole."""

    def _add_direct(self, *ignored):
        """Leave out the light sampled at a hit."""


def measure(stiff, seeds=SEEDS):
    """The `Finding` of a stiff scene; the classic methods render it, too, for samples that are not finite."""
    started, case = time.perf_counter(), stiff.case
    films = [film_of(case, seed=1 + k) for k in range(seeds)]
    means = np.array([mean_of(film)[0] for film in films])
    mean, error, t = _tested(means, case.truth)
    others = []
    for variant in (OTHER_ROUTE, EVERY_FEATURE):
        again = [film_of(case, variant, seed=1 + k) for k in range(seeds)]
        others.append(_tested(np.array([mean_of(film)[0] for film in again]), case.truth)[2])
        films += again
    films += [film_of(case, variant) for variant in METHOD_VARIANTS[1:]]
    return Finding(
        stiff,
        mean,
        error,
        t,
        max(others, key=abs),
        [_rung(case, share) for share in RUNGS],
        1 - mean_of(film_of(case, clamp_direct=CLAMP * mean, clamp_indirect=CLAMP * mean, seed=1))[0] / float(means[0]),
        1 - _met_by_chance(case) / float(means[0]),
        sum(film.nonfinite for film in films),
        time.perf_counter() - started,
    )


def _tested(means, truth):
    """(mean, its standard error, t) of the pictures' means of all seeds."""
    mean, error = float(means.mean()), float(means.std(ddof=1)) / math.sqrt(means.size)
    # Seeds that all agree leave the rounding of float32 for an error.
    return mean, error, (mean - truth) / max(error, 1e-5 * abs(truth))


def _rung(case, share, runs=4):
    """(Samples, seconds, relative error of the mean) of renders with a 16th, a quarter, all of the samples."""
    samples = max(1, case.samples * share // RUNGS[-1])
    films = [film_of(case, samples=samples, seed=100 + k) for k in range(runs)]
    off = np.array([mean_of(film)[0] for film in films]) / case.truth - 1
    return samples, float(np.median([f.stats["seconds"] for f in films])), float(np.sqrt((off**2).mean()))


def _met_by_chance(case):
    """Mean of what scattered rays carry to the picture of seed 1."""
    settings = settings_of(case, seed=1)
    method = _Unlit(compile_scene(case.build(), settings, Diagnostics()), settings)
    pixels, worker = np.arange(settings.width * settings.height, dtype=np.int32), Worker()
    total, step = 0.0, max(1, min(256, settings.chunk // pixels.size))
    for first in range(0, settings.samples, step):
        samples = tuple(range(first, min(first + step, settings.samples)))
        total += float(method.radiance(Chunk(pixels, samples), worker).sum(dtype=np.float64))
    return total / (3 * pixels.size * settings.samples)
