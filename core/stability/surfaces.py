# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces: roughness, index of refraction, albedo, number of bounces, grazing angles."""

from __future__ import annotations

import math

import numpy as np

from ..scene import Material, SunLight
from ..settings import METHODS
from .axis import Axis
from .case import Case
from .placing import ALBEDO, SUNLIT, glowing_room, room_radiance
from .shapes import camera, looking_down, placed, quad, scene, sphere

WHITE = (1.0, 1.0, 1.0)
# GGX of roughness² in single scattering, seen along the normal: the directional albedo by quadrature in float64.
GGX_ALBEDO = {0.25: 0.995703, 0.5: 0.915813, 0.75: 0.626886, 1.0: 1 - math.log(2)}
ROUGHNESSES = (0.0, 1e-5, 1e-4, 9.9e-4, 1e-3, 1.1e-3, 0.01, 0.0316, 0.0317, 0.05, 0.1)
INDICES = (1 / 2.4, 0.9999, 1 - 1e-6, 1.0, 1 + 1e-6, 1.0001, 1.5, 2.4, 10.0, 100.0, 1e3)
SOME_INDICES = (1 / 2.4, 0.9999, 1.0, 1.0001, 1.5, 2.4)


def ball_in_a_furnace(material):
    """A smooth ball in a white world."""
    return scene(camera((0, -4, 0), (0, 0, 0), fov=0.15), placed(sphere(rings=32), material), world=1.0)


def plane_in_a_furnace(material):
    """A plane in a white world, seen along its normal."""
    return looking_down(placed(quad(40), material), world=1.0)


def mirrored_lamp(roughness):
    """An emitting square seen in a mirror that is as good as ideal: the whole picture is the lamp."""
    mirror = placed(quad(4.0), Material.glossy(WHITE, roughness))
    lamp = placed(quad(2.0, (0, 1, 1), "-z"), Material.emission())
    return scene(camera((0, -1, 1), (0, 0, 0), fov=1e-3), mirror, lamp)


def glass_plate(ior):
    """A plate of glass before a white square."""
    glass = Material.glass(ior=ior)
    plate = placed(quad(10), glass), placed(quad(10, (0, 0, -0.5), "-z"), glass)
    return looking_down(*plate, placed(quad(10, (0, 0, -2)), Material.emission()))


def plate_truth(ior):
    """(1 - r)/(1 + r) with r = ((n - 1)/(n + 1))²."""
    r = ((ior - 1) / (ior + 1)) ** 2
    return (1 - r) / (1 + r)


def below_glass(angle):
    """An emitter beyond a glass boundary, looked at from the inside at `angle` degrees to the normal."""
    a = math.radians(angle)
    boundary = placed(quad(1e4, normal="+z"), Material.glass(ior=1.5))
    sky = placed(quad(1e6, (0, 0, 1), "-z"), Material.emission())
    eye = (-math.sin(a), 0.0, -math.cos(a))
    return scene(camera(eye, (0, 0, 0), fov=1e-5), boundary, sky)


def below_glass_truth(angle, ior=1.5):
    """1 - F from the dense side; 0 under total reflection."""
    a = math.radians(angle)
    s = ior * math.sin(a)
    if s >= 1:
        return 0.0
    ci, ct = math.cos(a), math.sqrt(1 - s * s)
    rs = ((ior * ci - ct) / (ior * ci + ct)) ** 2
    rp = ((ci - ior * ct) / (ci + ior * ct)) ** 2
    return 1 - (rs + rp) / 2


def grazing_sun(angle):
    """A floor in a sun `angle` degrees from overhead."""
    a = math.radians(angle)
    return looking_down(
        placed(quad(4), Material.diffuse(ALBEDO)), lights=[SunLight((math.sin(a), 0, -math.cos(a)), (3,) * 3)]
    )


def grazing_view(angle, material):
    """A wide floor in a white world, seen at `angle` degrees from its normal."""
    a = math.radians(angle)
    eye = np.array([0.0, -math.sin(a), math.cos(a)])
    return scene(camera(eye, (0, 0, 0), fov=1e-3 * math.cos(a)), placed(quad(1e4), material), world=1.0)


def _glossy(r):
    return Case(lambda: ball_in_a_furnace(Material.glossy(WHITE, r)), 1.0, settings={"depth": 2})


def _rough(r):
    truth = GGX_ALBEDO.get(r)
    return Case(lambda: plane_in_a_furnace(Material.glossy(WHITE, r)), truth, samples=1024, settings={"depth": 2})


def _rough_glass(r):
    glass = Material.glass(roughness=r)
    return Case(lambda: ball_in_a_furnace(glass), 1.0, settings={"depth": 64})


def _room(albedo, hits=None):
    hits = hits or (65 if albedo >= 0.99 else 9)  # roulette is noisy between
    told = "albedo" if albedo > 1 else ""
    truth = room_radiance(albedo, hits)
    return Case(
        lambda: glowing_room(albedo=albedo),
        truth,
        settings={"depth": hits},
        samples=256 if hits <= 10 else 64 if hits < 1000 else 16,
        size=(8, 8) if hits < 1000 else (32, 32),  # few passes: each casts a ray for every bounce
        told=told,
    )


AXES = (
    Axis(
        "roughness, glossy ball",
        "ball of white metal in a white world: 1",
        _glossy,
        ROUGHNESSES,
        0.1,
        (0.0, 0.1),
        (0.0, 1e-4, 9.9e-4, 1.1e-3, 0.01, 0.1),
    ),
    Axis(
        "roughness, glossy plane",
        "plane of white metal in a white world: the GGX albedo",
        _rough,
        (0.25, 0.5, 0.75, 1.0),
        0.5,
        (0.25, 1.0),
        (0.5, 1.0),
    ),
    Axis(
        "roughness, mirrored lamp",
        "lamp that fills a mirror: its radiance, on both sides of the switch to the ideal lobe",
        lambda r: Case(lambda: mirrored_lamp(r), 1.0, settings={"depth": 2}),
        ROUGHNESSES[:-1],
        1e-3,
        (0.0, 0.05),
        (0.0, 1e-4, 9.9e-4, 1e-3, 1.1e-3, 0.05),
    ),
    Axis(
        "roughness, glass ball",
        "rough glass ball in a white world: 1",
        _rough_glass,
        (0.0, 1e-5, 1e-4, 9.9e-4, 1e-3, 1.1e-3, 0.01, 0.05),
        0.01,
        (0.0, 0.05),
        (0.0, 1e-4, 9.9e-4, 1.1e-3, 0.01),
    ),
    Axis(
        "index of refraction, glass ball",
        "glass ball in a white world: 1",
        lambda n: Case(
            lambda: ball_in_a_furnace(Material.glass(ior=n)), 1.0, samples=16, settings={"depth": 64 if n < 5 else 1024}
        ),
        INDICES,
        1.5,
        (1 / 2.4, 1e3),
        SOME_INDICES,
    ),
    Axis(
        "index of refraction, plate",
        "glass plate before a white square: (1 - r)/(1 + r), r = ((n - 1)/(n + 1))²",
        lambda n: Case(lambda: glass_plate(n), plate_truth(n), samples=256, settings={"depth": 64}),
        INDICES[:-3],
        1.5,
        (1 / 2.4, 2.4),
        SOME_INDICES,
    ),
    Axis(
        "angle inside glass (°)",
        "white square beyond a boundary of glass, seen from inside: 1 - F, 0 from the critical angle 41.81° on",
        lambda a: Case(lambda: below_glass(a), below_glass_truth(a), samples=256, settings={"depth": 2}),
        (0.0, 20.0, 41.0, 41.8, 41.82, 60.0, 89.0, 89.9, 89.999),
        0.0,
        (0.0, 89.999),
        (0.0, 41.0, 41.82, 89.999),
    ),
    Axis(
        "albedo",
        "closed room of emitting walls, N = 9 or 65 hits: (1 - ρᴺ⁺¹)/(1 - ρ); above 1 the user is told",
        _room,
        (0.0, 0.5, 0.9, 0.999, 1 - 1e-5, 1 - 1e-6, 1.0, 1.01),
        0.5,
        (0.0, 1 - 1e-5),
        (0.0, 0.5, 1 - 1e-5, 1.0, 1.01),
    ),
    Axis(
        "depth",
        "closed room of emitting walls, albedo 0.999, N hits: (1 - ρᴺ⁺¹)/(1 - ρ)",
        lambda n: _room(0.999, n),
        (1, 2, 10, 30, 100, 1000),
        2,
        (1, 1000),
        (1, 2, 30),
    ),
    Axis(
        "angle of light (°)",
        "floor under a slanting sun: ρ/π · E cos θ",
        lambda a: Case(
            lambda: grazing_sun(a),
            SUNLIT * math.cos(math.radians(a)),
            METHODS,
            samples=16,
            settings={"depth": 1},
        ),
        (0.0, 45.0, 80.0, 89.0, 89.9, 89.99, 89.999),
        0.0,
        (0.0, 89.999),
        (0.0, 89.9, 89.999),
    ),
    Axis(
        "angle of view (°), diffuse",
        "white floor in a white world: 1",
        lambda a: Case(lambda: grazing_view(a, Material.diffuse(WHITE)), 1.0),
        (0.0, 45.0, 80.0, 89.0, 89.9, 89.99, 89.999),
        0.0,
        (0.0, 89.999),
        (0.0, 89.9, 89.999),
    ),
    Axis(
        "angle of view (°), mirror",
        "mirror in a white world: 1",
        lambda a: Case(lambda: grazing_view(a, Material.glossy(WHITE, 0.01)), 1.0),
        (0.0, 45.0, 80.0, 89.0, 89.9, 89.99, 89.999),
        0.0,
        (0.0, 89.999),
        (0.0, 89.0, 89.9, 89.999),
    ),
)
