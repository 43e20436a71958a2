# SPDX-License-Identifier: GPL-3.0-or-later
"""Sky Texture: where its sun is, how much light comes from it, and how that light is found."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from zraka.core.arena import Arena
from zraka.core.compile.lights import compile_lights
from zraka.core.compile.world import compile_world
from zraka.core.diagnostics import Diagnostics
from zraka.core.geometry import Geometry
from zraka.core.lights.environment import EnvironmentMap
from zraka.core.nodes import sky
from zraka.core.nodes.base import Context
from zraka.core.nodes.sky_multiple_scattering import MultipleScattering
from zraka.core.nodes.sky_single_scattering import SingleScattering
from zraka.core.scene import Camera, Link, Material, Node, Scene, World
from zraka.tests import stat

from .scenes import film_of, looking_down, placed, quad

SCATTERING = ("SINGLE_SCATTERING", "MULTIPLE_SCATTERING", "NISHITA")
ANALYTIC = ("PREETHAM", "HOSEK_WILKIE")


def world(strength=1.0, **properties):
    """A world that shows a sky texture."""
    nodes = (Node("sky", {}, properties), Node("background", {"color": Link(0, "color"), "strength": strength}))
    return World(nodes=nodes, surface=1)


@cache
def compiled(*args, **kwargs):
    """The light of `world`."""
    return compile_world(world(*args, **kwargs), Diagnostics())


def shown(d, **properties):
    """Colours (3, n) of a sky texture in directions `d`."""
    operation = sky.OPERATIONS["sky"]
    properties = operation.prepare(properties, Diagnostics(), "")
    return operation.run(Context(Arena(), d.shape[1]), {"vector": d}, properties)["color"]


def ring(elevation):
    """Directions of equal elevation, one every degree of rotation."""
    return np.stack([towards(elevation, math.radians(k)) for k in range(360)], axis=1)


def uniform_directions(n, seed=1):
    """Unit vectors all around, (3, n)."""
    rng = np.random.default_rng(seed)
    z, phi = rng.uniform(-1, 1, n), rng.uniform(-math.pi, math.pi, n)
    r = np.sqrt(1 - z * z)
    return np.stack([r * np.cos(phi), r * np.sin(phi), z]).astype(np.float32)


def towards(elevation, rotation):
    """Where Blender has the sun: rotation 0 is +Y, from there it goes to +X."""
    across = math.cos(elevation)
    return np.array([across * math.sin(rotation), across * math.cos(rotation), math.sin(elevation)], np.float32)


@pytest.mark.parametrize("kind", SCATTERING)
def test_the_sun_is_where_it_is_put(kind):
    properties = {"sky_type": kind, "sun_elevation": 0.5, "sun_rotation": math.radians(130)}
    assert abs(np.argmax(shown(ring(0.5), sun_disc=False, **properties)[1]) - 130) <= 1
    np.testing.assert_allclose(sky.suns_of([Node("sky", {}, properties)])[0].axis, towards(0.5, math.radians(130)))
    d = np.stack([towards(0.5 + a, math.radians(130)) for a in (0.004, 0.006)], axis=1)
    inside, outside = shown(d, **properties)[1]
    assert inside > 100 * outside


@pytest.mark.parametrize("kind", ANALYTIC)
def test_formulas_glow_around_the_sun(kind):
    glow = shown(ring(0.7), sky_type=kind, sun_direction=tuple(towards(0.7, math.radians(50))))
    assert abs(np.argmax(glow[1]) - 50) <= 1
    assert not sky.suns_of([Node("sky", {}, {"sky_type": kind})])


def test_a_sun_beyond_the_zenith_comes_down_on_the_other_side():
    (over,) = sky.suns_of([Node("sky", {}, {"sun_elevation": math.pi - 0.3, "sun_rotation": 0.2})])
    np.testing.assert_allclose(over.axis, towards(0.3, 0.2 + math.pi), atol=1e-6)


@pytest.mark.parametrize("size", [0.009512, 0.3])
@pytest.mark.parametrize("model", [SingleScattering, MultipleScattering])
def test_the_disc_gives_the_irradiance_of_the_sun(model, size):
    """Its limb is darker, so that it gives four fifths of what an even disc of that brightness would."""
    kind = {SingleScattering: "SINGLE_SCATTERING", MultipleScattering: "MULTIPLE_SCATTERING"}[model]
    light = compiled(2.0, sky_type=kind, sun_elevation=1.0, sun_size=size, sun_intensity=0.7)
    direct = sky.XYZ_TO_RGB @ model(1.0, 100.0, 1.0, 1.0, 1.0).sun(1.0)
    share = light.suns.irradiance[:, 0] / (0.8 * 0.7 * 2.0 * direct)
    np.testing.assert_allclose(share, 1.0, rtol=0.02)


def test_before_blender_5_light_fades_below_the_horizon_and_the_disc_hides_the_sky():
    properties = {"sky_type": "NISHITA", "sun_elevation": 0.5, "sun_size": 0.3}
    low = np.array([[0.6, 0.6], [0.0, 0.0], [0.0, -0.1]], np.float32)
    horizon, below = shown(low, **properties).T
    np.testing.assert_allclose(below, horizon * (1 - 0.1 * 2.5) ** 3, rtol=1e-5)
    assert not shown(np.float32([[0.6], [0.0], [-0.41]]), **properties).any()
    assert not shown(towards(0.5, 0.0)[:, None], sun_intensity=0.0, **properties).any()
    assert shown(towards(0.5, 0.0)[:, None], sun_disc=False, **properties).all()


def test_a_high_sun_is_brighter_and_whiter():
    low, high = (MultipleScattering(e, 100.0, 1.0, 1.0, 1.0).sun(e) for e in (0.05, 1.2))
    assert (high > low).all() and high[2] / high[0] > 3 * low[2] / low[0]


@pytest.mark.parametrize("kind", SCATTERING[:2])
def test_sampling_agrees_with_its_density(kind):
    """The share of all directions in cells, and the density integrates to 1."""
    light = compiled(sky_type=kind, sun_size=0.2, sun_elevation=0.8)  # of a disc of this size all is easily seen
    light.choice = 1.0
    rng = np.random.default_rng(3)
    n = 1 << 16
    u0, u1 = rng.random((2, n), np.float32)
    sample = light.sample(0, np.zeros((3, n), np.float32), u0, u1, Arena())
    np.testing.assert_allclose(sample.pdf, light.pdf(sample.wi, Arena()), rtol=1e-5)
    axis = light.suns.axis[:, :1]
    angle = np.arccos(np.clip((sample.wi * axis).sum(axis=0), -1, 1))
    edges = np.array([0.0, 0.03, 0.06, 0.0999, 0.1005, 0.3, 0.8, 1.5, math.pi])
    counts = np.histogram(angle, edges)[0]
    expected = [ring_integral(light, axis, *pair) * n for pair in pairwise(edges)]
    assert sum(expected) == pytest.approx(n, rel=2e-3)
    p = stat.chi_square(counts, expected)
    assert p > stat.LEVEL
    wrong = np.array(expected)
    wrong[0] *= 1.1
    assert stat.chi_square(counts, wrong) < stat.LEVEL


def ring_integral(light, axis, low, high):
    """Probability of directions between two angles to `axis`."""
    count = 4000 if high - low > 0.01 else 400
    rng = np.random.default_rng(11)
    cosine = np.cos(low) + (np.arange(count) + rng.random(count)) / count * (np.cos(high) - np.cos(low))
    phi = rng.uniform(0, 2 * math.pi, (100, count))
    sine = np.sqrt(1 - cosine**2)
    x, y, z = (np.ravel(np.broadcast_to(a, phi.shape)) for a in (sine * np.cos(phi), sine * np.sin(phi), cosine))
    w = axis[:, 0].astype(float)
    s = np.cross(w, [1.0, 0.0, 0.0])
    s /= np.linalg.norm(s)
    d = x * s[:, None] + y * np.cross(w, s)[:, None] + z * w[:, None]
    density = light.pdf(np.ascontiguousarray(d, np.float32), Arena())
    return float(density.mean(dtype=np.float64)) * 2 * math.pi * (math.cos(low) - math.cos(high))


def test_a_floor_in_the_sun_without_noise_from_it():
    """Light sampling and scattered rays together find the same as the sky's own integral."""
    properties = {"sky_type": "MULTIPLE_SCATTERING", "sun_elevation": 0.6}
    light = compiled(**properties)
    n = 1 << 18
    d = uniform_directions(n, 5)
    d[2] = np.abs(d[2])
    irradiance = (light.eval(d, Arena(), averaged=True).astype(float) * d[2]).mean(axis=1) * 2 * math.pi
    irradiance = irradiance + light.suns.irradiance[:, 0] * math.sin(0.6)
    floor = replace(looking_down(placed(quad(4.0), Material.diffuse(0.8))), world=world(**properties))
    picture = film_of(floor, 256, 16).image()[..., :3]
    np.testing.assert_allclose(picture.mean(axis=(0, 1)), 0.8 / math.pi * irradiance, rtol=0.01)
    assert (picture.std(axis=(0, 1)) / picture.mean(axis=(0, 1)) < 0.02).all()


def test_two_suns_are_both_sampled():
    """Of two skies added together."""
    nodes = (
        Node("sky", {}, {"sun_rotation": 0.0, "sun_size": 0.05}),
        Node("sky", {}, {"sun_rotation": 2.0, "sun_elevation": 1.0, "sun_size": 0.02}),
        Node("background", {"color": Link(0, "color")}),
        Node("background", {"color": Link(1, "color")}),
        Node("add_shader", {"a": Link(2, "bsdf"), "b": Link(3, "bsdf")}),
    )
    light = compile_world(World(nodes=nodes, surface=4), Diagnostics())
    assert light.suns.irradiance.shape == (3, 2)
    rng = np.random.default_rng(3)
    u0, u1 = rng.random((2, 1 << 15), np.float32)
    wi = light.suns.sample(u0, u1, Arena())
    share = [((wi * axis[:, None]).sum(axis=0) > 0.99).mean() for axis in light.suns.axis.T]
    power = np.array([0.2126, 0.7152, 0.0722]) @ light.suns.irradiance
    np.testing.assert_allclose(share, power / power.sum(), atol=0.01)


def test_what_does_not_shine_is_no_sun():
    assert compiled(sun_disc=False).suns is None
    assert compiled(sun_elevation=-0.5).suns is None
    assert compiled(sun_intensity=0.0).suns is None
    dark = compiled(0.0)
    assert dark.is_black if isinstance(dark, EnvironmentMap) else not dark.radiance.any()


def test_a_sun_alone_in_a_black_sky():
    light = compiled(1e-6, air_density=0.0, aerosol_density=0.0, ozone_density=0.0, sun_elevation=0.5)
    light.choice = 1.0
    u = np.linspace(0, 0.999, 1000, dtype=np.float32)
    sample = light.sample(0, np.zeros((3, 1000), np.float32), u, u[::-1].copy(), Arena())
    assert (light.suns.density(sample.wi, Arena()) > 0).mean() > 0.75
    assert np.isfinite(sample.weight).all()


def test_the_classic_methods_have_a_sun():
    view = Scene(Camera(), world=world(sun_elevation=0.5))
    lights = compile_lights(view, Geometry.from_arrays(()), [], Diagnostics())
    assert lights.classic.count == 1
    lit = lights.classic.illuminate(0, np.zeros((3, 1), np.float32), Arena())
    np.testing.assert_allclose(lit.wi[:, 0], towards(0.5, 0.0), atol=1e-6)
    np.testing.assert_allclose(lit.irradiance[:, 0], lights.environment.suns.irradiance[:, 0], rtol=1e-6)


def test_an_unknown_sky_is_said():
    diagnostics = Diagnostics()
    compile_world(world(sky_type="FUTURE"), diagnostics)
    assert "sky type FUTURE is not supported" in diagnostics.messages()[0]


EXTREMES = (
    {"sun_elevation": 1.0, "air_density": 1000.0, "aerosol_density": 1000.0, "ozone_density": 1000.0},
    {"sun_elevation": 1.0, "air_density": 0.0, "aerosol_density": 0.0, "ozone_density": 0.0, "altitude": 1e5},
    {"sun_elevation": -1.5, "sun_size": 0.0, "altitude": 0.0},
    {"sun_elevation": math.pi / 2, "sun_size": math.pi / 2, "altitude": 60000.0},
)


@pytest.mark.parametrize("kind", SCATTERING)
@pytest.mark.parametrize("extreme", range(len(EXTREMES)))
def test_extreme_atmospheres_are_finite(kind, extreme):
    d = np.concatenate([uniform_directions(1000), np.eye(3, dtype=np.float32), -np.eye(3, dtype=np.float32)], axis=1)
    value = shown(d, sky_type=kind, **EXTREMES[extreme])
    assert np.isfinite(value).all() and (value >= 0).all()


@pytest.mark.parametrize("kind", (*SCATTERING, *ANALYTIC))
def test_what_is_no_direction_stays_in_its_lane(kind):
    d = uniform_directions(100)
    good, bad = shown(d, sky_type=kind), d.copy()
    bad[:, :3] = [[np.nan, np.inf, 0.0]] * 3
    np.testing.assert_array_equal(shown(bad, sky_type=kind)[:, 3:], good[:, 3:])


@pytest.mark.parametrize("altitude", [100.0, 20000.0])
@pytest.mark.parametrize("model", [MultipleScattering, SingleScattering])
def test_a_series_of_azimuths_is_the_sky_itself(model, altitude):
    """Many azimuths at once, which are summed from a few, against each by itself."""
    azimuth = np.linspace(-math.pi, 0.0, 70)
    for sun in (0.0, 0.02, 0.5, 1.5):
        sky_of = model(sun, altitude, 1.0, 2.0, 1.0)
        for elevation in (0.0, 0.01, 0.4, 1.4):
            together = sky_of.sky(elevation, azimuth)
            apart = np.concatenate([sky_of.sky(elevation, part) for part in np.split(azimuth, 7)], axis=1)
            np.testing.assert_allclose(together, apart, atol=5e-4 * apart.max())
