# SPDX-License-Identifier: GPL-3.0-or-later
"""Descriptions of lights become tables: what is left out, what is said."""

import math
from dataclasses import replace

import numpy as np
import pytest

from zraka.core.arena import Arena
from zraka.core.compile.lights import compile_lights
from zraka.core.diagnostics import Diagnostics
from zraka.core.geometry import Geometry
from zraka.core.scene import AreaLight, Camera, Material, PointLight, Scene, SpotLight, SunLight


def point(power=100.0, **kw):
    return PointLight((0, 0, 1), (power,) * 3, **kw)


def spot(**kw):
    return SpotLight((0, 0, 1), (0, 0, -1), (1, 1, 1), **kw)


def area(**kw):
    return AreaLight(np.eye(4), (1, 1, 1), **kw)


def square():
    return [[(0, 0, 1), (1, 0, 1), (1, 1, 1)], [(0, 0, 1), (1, 1, 1), (0, 1, 1)]]


def upward(count):
    return np.repeat(np.array([[0], [0], [1]], np.float32), count, axis=1)


@pytest.mark.parametrize(
    "lamp, message",
    [
        (point(power=0.0), "no power"),
        (point(power=math.nan), "not finite"),
        (PointLight((math.inf, 0, 0), (1, 1, 1)), "not finite"),
        (area(size=(0.0, 1.0)), "no area"),
        (SunLight((0, 0, 0), (1, 1, 1)), "no direction"),
        (spot(angle=0.0), "no angle"),
    ],
)
def test_lights_that_cannot_shine_are_left_out(lamp, message):
    diagnostics = Diagnostics()
    scene = Scene(Camera(), lights=(lamp,))
    lights = compile_lights(scene, Geometry.from_arrays(), [None], diagnostics)
    assert lights.sampler.count == lights.classic.count == lights.lamps.count == 0
    assert message in diagnostics.messages()[0] and lamp.name in diagnostics.messages()[0]


def test_lights_without_shadow_are_at_distance_zero():
    lamps = (point(), point(casts_shadow=False), SunLight((0, 0, -1), (1, 1, 1), angle=0.1, casts_shadow=False))
    lights = compile_lights(Scene(Camera(), lights=lamps), Geometry.from_arrays(), [None], Diagnostics())
    p, u = np.zeros((3, 256), np.float32), np.random.default_rng(1).random((3, 256), np.float32)
    for chosen in (lamps, lamps[:2], lamps[1:2]):
        lights = compile_lights(Scene(Camera(), lights=chosen), Geometry.from_arrays(), [None], Diagnostics())
        distance = lights.sampler.sample(p, *u, Arena()).distance
        assert set((distance > 0).tolist()) == {light.casts_shadow for light in chosen}
        far = np.ones(1, np.float32)
        told = [lights.classic.shadow_distance(k, far, Arena())[0] > 0 for k in range(len(chosen))]
        assert told == [light.casts_shadow for light in chosen]


def test_emissive_lookups():
    geometry = Geometry.from_arrays(square(), centers=[(0, 0, 5)], radii=[1.0], material=Material.emission())
    lights = compile_lights(Scene(Camera()), geometry, [(1, 1, 1)], Diagnostics())
    assert lights.emissive.tolist() == [True, True, True]
    assert lights.has_extended and not lights.has_delta
    below = np.repeat(np.array([[0.5], [0.5], [-9]], np.float32), 3, axis=1)
    pdf = lights.sampler.pdf_prim(np.arange(3), below, upward(3), np.full(3, 10, np.float32), Arena())
    np.testing.assert_allclose(pdf, [100.0, 100.0, 0.0], rtol=1e-6)  # the two triangles are one panel of area 1


def test_emission_that_is_not_finite_is_said():
    diagnostics = Diagnostics()
    lights = compile_lights(Scene(Camera()), Geometry.from_arrays(square()), [(math.nan, 1, 1)], diagnostics)
    assert lights.sampler.count == 0
    assert "not finite" in diagnostics.messages()[0]


def test_positions_are_relative_to_the_origin():
    """Far from the world's origin nothing is lost: the subtraction is float64."""
    geometry = Geometry.from_arrays()
    geometry = replace(geometry, origin=np.array([1e7, 0.0, 0.0]))
    scene = Scene(Camera(), lights=(PointLight((1e7 + 0.125, 0, 0), (1, 1, 1)),))
    lights = compile_lights(scene, geometry, [None], Diagnostics())
    sample = lights.sampler.sample(np.zeros((3, 1), np.float32), *np.zeros((3, 1), np.float32), Arena())
    assert sample.distance[0] == 0.125
    assert lights.classic.illuminate(0, np.zeros((3, 1), np.float32), Arena()).distance[0] == 0.125
