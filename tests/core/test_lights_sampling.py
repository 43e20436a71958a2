# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights: irradiance against closed forms, densities against directions, scattered rays against light samples."""

import math

import numpy as np
import pytest
from scipy import stats

from zraka.core.arena import Arena
from zraka.core.compile.lights import compile_lights
from zraka.core.diagnostics import Diagnostics
from zraka.core.geometry import Geometry
from zraka.core.sampling.warp import INV_PI, square_to_cosine_hemisphere
from zraka.core.scene import AreaLight, Camera, PointLight, Scene, SpotLight, SunLight, World

UP = (0.0, 0.0, 1.0)
RHO = 0.8
N = 1 << 16


def numbers(count=N):
    """Well spread numbers (uc, u0, u1) in [0, 1): a rank-1 lattice after Roberts' R3 sequence."""
    g = 1.2207440846057596
    i = np.arange(1, count + 1)
    return [np.minimum((i * g**-k) % 1.0, 1 - 2**-24).astype(np.float32) for k in (1, 2, 3)]


def compiled(*lights, triangles=(), emission=None, **scene):
    """Compiled lights of a scene of lamps and emissive `triangles` (T, 3, 3)."""
    geometry = Geometry.from_arrays(triangles)
    scene = Scene(Camera(), lights=lights, **scene)
    return compile_lights(scene, geometry, [emission], Diagnostics())


def at(p, count=N):
    return np.repeat(np.array(p, np.float32)[:, None], count, axis=1)


def irradiance(lights, p=(0, 0, 0), normal=UP, count=N):
    """Irradiance (3,) at `p` by light samples."""
    s = lights.sampler.sample(at(p, count), *numbers(count), Arena())
    assert all(a.dtype == np.float32 for a in s[:4])
    assert all(np.isfinite(a).all() for a in (s.wi, s.weight))
    assert not np.isnan(s.distance).any() and not np.isnan(s.pdf).any() and (s.pdf > 0).all()
    np.testing.assert_allclose(np.linalg.norm(s.wi, axis=0), 1.0, atol=1e-5)
    return (s.weight * np.maximum(np.array(normal) @ s.wi, 0)).mean(axis=1, dtype=np.float64)


def irradiance_mis(lights, p=(0, 0, 0), count=1 << 18):
    """The same at a surface that faces up, by light samples and cosine-sampled rays together."""
    from zraka.core.sampling import mis

    arena = Arena()
    uc, u0, u1 = numbers(count)
    s = lights.sampler.sample(at(p, count), uc, u0, u1, arena)
    cosine = np.maximum(s.wi[2], 0)
    total = (s.weight * cosine * mis.weight(s.pdf, (cosine * INV_PI).astype(np.float32), arena)).mean(axis=1)
    d = square_to_cosine_hemisphere(u0, u1, arena)
    far = np.full(count, np.inf, np.float32)
    seen = lights.lamps.radiance(at(p, count), d, far, d[2] * np.float32(INV_PI), arena)
    return total + math.pi * seen.mean(axis=1, dtype=np.float64)


def looking_down(x=0.0, y=0.0, z=1.0):
    transform = np.eye(4)
    transform[:3, 3] = x, y, z
    return transform


def area(z=1.0, x=0.0, y=0.0, power=10.0, **kw):
    return AreaLight(looking_down(x, y, z), (power,) * 3, **kw)


def point(z=1.0, power=100.0, **kw):
    return PointLight((0, 0, z), (power,) * 3, **kw)


def spot(z=1.0, power=100.0, direction=(0, 0, -1), **kw):
    return SpotLight((0, 0, z), direction, (power,) * 3, **kw)


def square_above(z=1.0, side=1.0, x=0.0, y=0.0):
    a, b, c, d = (np.array([x + sx * side, y + sy * side, z]) for sx, sy in ((0, 0), (1, 0), (1, 1), (0, 1)))
    return np.array([[a, b, c], [a, c, d]])


def sun_direction(degrees):
    t = math.radians(degrees)
    return (math.sin(t), 0.0, -math.cos(t))


# -- closed forms: radiance of a Lambert surface of albedo 0.8 facing up at the origin ---------------------------------

TRUTHS = {
    "point at 1": ([point(1)], 2.026424),
    "point at 10": ([point(10)], 0.0202642),
    "soft 0.1": ([point(radius=0.1)], 2.006360),
    "soft 0.5": ([point(radius=0.5)], 1.621139),
    "sphere 0.1": ([point(radius=0.1, soft_falloff=False)], 2.026424),
    "sphere 0.9": ([point(radius=0.9, soft_falloff=False)], 2.026424),
    "spot": ([spot(blend=0.0)], 2.026424),
    "spot soft": ([spot(blend=0.0, radius=0.1, angle=2.0)], 2.006360),
    "spot beside": ([spot(blend=0.0, direction=(1, 0, -1), angle=math.radians(89))], 0.0),
    "sun": ([SunLight(sun_direction(0), (3, 3, 3))], 0.763944),
    "sun at 60": ([SunLight(sun_direction(60), (3, 3, 3))], 0.381972),
    "sun disk 0.53": ([SunLight(sun_direction(0), (3, 3, 3), angle=math.radians(0.53))], 0.763944),
    "sun disk 10": ([SunLight(sun_direction(0), (3, 3, 3), angle=math.radians(10))], 0.763944),
    "sun disk 10 at 60": ([SunLight(sun_direction(60), (3, 3, 3), angle=math.radians(10))], 0.381972),
    "area small": ([area(power=1, size=(0.02, 0.02))], 0.0810461),
    "area": ([area(power=10)], 0.609771),
    "area behind": ([area(z=-1)], 0.0),
    "area not normalized": ([area(x=0.5, y=0.5, power=math.pi, normalize=False)], 0.110825),
    "area corner": ([area(x=0.5, y=0.5, power=math.pi)], 0.110825),
    "disk": ([area(power=math.pi**2 / 4, shape="DISK")], 0.16),
    "disk of 1e-3": ([area(power=1e6 * math.pi**2 / 4, size=(1e-3, 1e-3), shape="DISK")], RHO * 0.25e-6 * 1e6 * 1e6),
    "thousand": ([point(power=0.1)] * 1000, 2.026424),
}


@pytest.mark.parametrize("name", TRUTHS)
def test_closed_forms(name):
    lights, truth = TRUTHS[name]
    np.testing.assert_allclose(irradiance(compiled(*lights)) * RHO / math.pi, truth, rtol=2e-3, atol=1e-9)


@pytest.mark.parametrize("name", [k for k, (lights, _) in TRUTHS.items() if compiled(*lights).lamps.count])
def test_closed_forms_with_scattered_rays(name):
    lights, truth = TRUTHS[name]
    np.testing.assert_allclose(irradiance_mis(compiled(*lights)) * RHO / math.pi, truth, rtol=1e-2, atol=1e-9)


def test_point_off_axis():
    p = (math.sqrt(3), 0, 0)
    np.testing.assert_allclose(irradiance(compiled(point()), p) * RHO / math.pi, 0.253303, rtol=1e-3)


@pytest.mark.parametrize("height", [2.0, 1.05])
def test_sphere_emitter(height):
    lamp = point(z=height, power=4 * math.pi**2, radius=1.0, soft_falloff=False)  # radiance 1
    np.testing.assert_allclose(irradiance(compiled(lamp)), math.pi / height**2, rtol=1e-3)


def test_inside_a_sphere_all_is_bright():
    lamp = point(z=0.3, power=4 * math.pi**2, radius=1.0, soft_falloff=False)
    np.testing.assert_allclose(irradiance(compiled(lamp)), math.pi, rtol=1e-3)


def test_emissive_square():
    lights = compiled(triangles=square_above(), emission=(1.0, 2.0, 0.0))
    result = irradiance(lights, count=1 << 18) * RHO / math.pi
    np.testing.assert_allclose(result, [0.110825, 0.22165, 0.0], rtol=2e-3)
    np.testing.assert_allclose(irradiance(lights, (0, 0, 2), (0, 0, -1)) * RHO / math.pi, result, rtol=5e-3)


def test_textured_emitter():
    def ramp(prim, u, v, arena, wo):
        """The sum x + y on the square: u and v are weights of the second and third corner."""
        x = np.where(prim == 0, u + v, u)
        y = np.where(prim == 0, v, u + v)
        return np.stack([x + y, np.ones_like(u), np.zeros_like(u)]).astype(np.float32)

    lights = compiled(triangles=square_above(z=50.0, x=-0.5, y=-0.5), emission=((1.0, 1.0, 0.0), ramp))
    np.testing.assert_allclose(irradiance(lights, count=1 << 18) * 2500, [1.0, 1.0, 0.0], rtol=2e-3)


def test_every_kind_at_once():
    lamps = [
        point(2, power=10), point(2.5, power=20, radius=0.2), point(3, power=30, radius=0.3, soft_falloff=False),
        spot(2, power=5), spot(2, power=5, radius=0.1), SunLight(sun_direction(30), (1, 1, 1)),
        SunLight(sun_direction(20), (1, 2, 1), angle=0.1), area(z=2, power=5), area(z=2, power=5, shape="DISK"),
    ]  # fmt: skip
    square = square_above(z=1.5)
    parts = [compiled(lamp) for lamp in lamps] + [compiled(triangles=square, emission=(1, 1, 1))]
    whole = compiled(*lamps, triangles=square, emission=(1, 1, 1))
    assert whole.sampler.pmf.sum(dtype=np.float64) == pytest.approx(1.0, abs=1e-6)
    expected = sum(irradiance(part) for part in parts)
    np.testing.assert_allclose(irradiance(whole, count=1 << 20), expected, rtol=5e-3)


def test_closed_forms_can_fail():
    """Without the cosine, or with a density 5% off, the comparison above would not hold."""
    lights, truth = TRUTHS["disk"]
    s = compiled(*lights).sampler.sample(at((0, 0, 0)), *numbers(), Arena())
    assert s.weight.mean() * RHO / math.pi != pytest.approx(truth, rel=2e-2)
    assert (s.weight * s.wi[2]).mean() / 1.05 * RHO / math.pi != pytest.approx(truth, rel=2e-2)


# -- densities ---------------------------------------------------------------------------------------------------------

LAMPS = {
    "disk": point(radius=0.4),
    "sphere": point(radius=0.4, soft_falloff=False),
    "spot disk": spot(radius=0.3, angle=1.0),
    "spot sphere": spot(radius=0.3, angle=1.0, soft_falloff=False),
    "sun": SunLight(sun_direction(25), (3, 3, 3), angle=0.4),
    "rectangle": area(x=0.3, y=-0.2, size=(1.0, 0.5)),
    "rectangle large": area(z=0.1, x=0.2, size=(4.0, 3.0)),
    "rectangle small": area(x=0.1, size=(0.05, 0.1)),
    "rectangle of spread 90": area(x=0.3, y=-0.2, size=(1.0, 0.5), spread=math.pi / 2),
    "ellipse": area(x=0.2, size=(1.0, 0.6), shape="ELLIPSE"),
    "ellipse small": area(x=0.1, size=(0.05, 0.1), shape="ELLIPSE"),
}


@pytest.mark.parametrize("name", LAMPS)
def test_density_of_scattered_rays_is_that_of_samples(name):
    lights = compiled(LAMPS[name], point())
    arena = Arena()
    s = lights.sampler.sample(at((0, 0, 0)), *numbers(), arena)
    kept = np.flatnonzero(np.isfinite(s.pdf) & (s.weight[0] > 0))
    wi, pdf, distance = np.ascontiguousarray(s.wi[:, kept]), s.pdf[kept], s.distance[kept]
    far = np.full(kept.size, np.inf, np.float32)
    ((lanes, emitted, density),) = ((a.copy() for a in h) for h in lights.lamps.crossings(wi * 0, wi, far, arena))
    assert lanes.size > 0.99 * kept.size  # a few at the very edge may miss
    tolerance = 2e-3 if "rectangle small" in name or "ellipse small" in name else 1e-4
    np.testing.assert_allclose(density, pdf[lanes], rtol=tolerance)
    weight = s.weight[:, kept][:, lanes]
    np.testing.assert_allclose(np.broadcast_to(emitted, weight.shape) / density, weight, rtol=5e-3, atol=1e-4)
    if np.isfinite(distance).all():
        assert not list(lights.lamps.crossings(wi * 0, wi, distance * np.float32(0.999), arena))
        ((lanes, _, _),) = lights.lamps.crossings(wi * 0, wi, distance * np.float32(1.001), arena)
        assert lanes.size > 0.99 * kept.size


@pytest.mark.parametrize("name", LAMPS)
def test_transparent_surfaces_on_the_way_change_neither_light_nor_density(name):
    """A ray cut in two sees each lamp once, with the density of the point where it started."""
    lights = compiled(LAMPS[name])
    arena = Arena()
    _, u0, u1 = numbers()
    d = square_to_cosine_hemisphere(u0, u1, arena)
    pdf = d[2] * np.float32(INV_PI)
    start, far = at((0.1, 0, 0)), np.full(N, np.inf, np.float32)
    cut = np.random.default_rng(4).uniform(0.01, 2.0, N).astype(np.float32)
    whole = lights.lamps.radiance(start, d, far, pdf, arena)
    first = lights.lamps.radiance(start, d, cut, pdf, arena)
    second = lights.lamps.radiance(start + d * cut, d, far, pdf, arena, passed=cut)
    different = np.abs(first + second - whole) > 1e-3 * np.abs(whole).max()
    assert whole.any() and different.sum() < 10  # rounding at a light's edge


def test_density_of_triangles_is_that_of_samples():
    lights = compiled(point(), triangles=square_above(), emission=(1, 1, 1))
    arena = Arena()
    s = lights.sampler.sample(at((0.2, 0.1, 0)), *numbers(), arena)
    kept = np.flatnonzero(np.isfinite(s.pdf))
    wi, distance = np.ascontiguousarray(s.wi[:, kept]), s.distance[kept]
    hit = np.array([[0.2], [0.1]]) + wi[:2] * distance
    prim = (hit[1] > hit[0]).astype(np.int32)
    pdf = lights.sampler.pdf_prim(prim, at((0.2, 0.1, 0), kept.size), wi, distance, arena)
    np.testing.assert_allclose(pdf, s.pdf[kept], rtol=1e-4)


def directions_p(lights, factor=1.0):
    """p-value of a chi-square test of sampled directions against the density of scattered rays."""
    rows, columns, fine, count = 12, 24, 24, 60_000
    rng = np.random.default_rng(3)
    s = lights.sampler.sample(at((0, 0, 0), count), *rng.random((3, count), np.float32), Arena())
    lit = s.weight[0] > 0
    z = np.clip(s.wi[2, lit], 0, 1 - 1e-7)
    phi = (np.arctan2(s.wi[1, lit], s.wi[0, lit]) / (2 * math.pi)) % 1.0
    observed = np.histogram2d(z, phi, (rows, columns), ((0, 1), (0, 1)))[0]
    z = (np.arange(rows * fine) + 0.5) / (rows * fine)
    phi = (np.arange(columns * fine) + 0.5) / (columns * fine) * 2 * math.pi
    z, phi = np.meshgrid(z, phi, indexing="ij")
    r = np.sqrt(1 - z * z)
    d = np.stack([r * np.cos(phi), r * np.sin(phi), z]).reshape(3, -1).astype(np.float32)
    density = np.zeros(z.size)
    for lanes, _, pdf in lights.lamps.crossings(d * 0, d, np.full(z.size, np.inf, np.float32), Arena()):
        density[lanes] += pdf
    expected = density.reshape(rows, fine, columns, fine).sum(axis=(1, 3)) * 2 * math.pi / z.size * count * factor
    assert observed[expected == 0].sum() < 20
    cells = expected > 20
    observed, expected = observed[cells], expected[cells]
    return stats.chi2.sf(((observed - expected) ** 2 / expected).sum(), cells.sum())


WIDE = {
    "disk": point(radius=1.5),
    "sphere": point(radius=0.8, soft_falloff=False),
    "sun": SunLight(sun_direction(25), (3, 3, 3), angle=1.2),
    "rectangle": area(x=0.8, y=-0.6, size=(2.0, 1.5)),
    "ellipse": area(x=0.8, size=(3.0, 2.0), shape="ELLIPSE"),
}


@pytest.mark.parametrize("name", WIDE)
def test_directions_follow_their_density(name):
    lights = compiled(WIDE[name])
    assert directions_p(lights) > 1e-3
    assert directions_p(lights, factor=1.05) < 1e-3


def test_environment_is_left_to_scattering():
    lights = compiled(world=World((1.0, 0.5, 0.25)))
    d = at(UP, 4)
    assert lights.sampler.count == 0
    assert lights.environment.pdf(d, Arena()) == 0.0
    np.testing.assert_allclose(lights.environment.eval(d, Arena())[:, 0], (1.0, 0.5, 0.25))


# -- the choice --------------------------------------------------------------------------------------------------------


def test_choice_is_by_power_and_suns_take_their_share():
    two = compiled(point(power=30), point(power=10))
    np.testing.assert_allclose(two.sampler.pmf, [0.75, 0.25])
    mixed = compiled(point(power=30), point(power=10), SunLight(sun_direction(0), (1e-6,) * 3))
    np.testing.assert_allclose(mixed.sampler.pmf, [0.375, 0.125, 0.5])


def test_negative_lights_take_light_away():
    np.testing.assert_allclose(irradiance(compiled(point(power=30), point(power=-10))), 20 / (4 * math.pi), rtol=1e-3)


# -- extremes ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e3])
@pytest.mark.parametrize("distance", [0.0, 1e-4, 1.0, 1e5])
@pytest.mark.parametrize("kind", ["disk", "sphere", "spot", "rectangle", "ellipse", "point", "triangle"])
def test_extremes_are_finite(kind, size, distance):
    lamp = {
        "disk": point(distance, radius=size),
        "sphere": point(distance, radius=size, soft_falloff=False),
        "spot": spot(distance, radius=size),
        "rectangle": area(z=distance, size=(size, size)),
        "ellipse": area(z=distance, size=(size, 0.5 * size), shape="ELLIPSE"),
        "point": point(distance),
        "triangle": None,
    }[kind]
    emitter = {"triangles": square_above(distance, size), "emission": (1, 1, 1)}
    lights = compiled(lamp) if lamp else compiled(**emitter)
    result = irradiance(lights, count=4096)
    assert np.isfinite(result).all()
    if distance == 1e5 and size < 1e3:
        power = 1.0 if kind == "triangle" else 100 / (4 * math.pi)
        factor = {"triangle": size**2, "rectangle": 0.4, "ellipse": 0.4}.get(kind, 1.0)
        np.testing.assert_allclose(result, power * factor / distance**2, rtol=1e-2)


@pytest.mark.parametrize("scale", [1e-6, 1e-3, 1e3, 1e6])
def test_scale_with_power_of_its_square_changes_nothing(scale):
    def lamps(s):
        power = 10 * s * s
        return [
            area(z=s, power=power, size=(s, s)), point(2 * s, power, radius=0.1 * s),
            point(2 * s, power, radius=0.1 * s, soft_falloff=False), spot(2 * s, power),
        ]  # fmt: skip

    np.testing.assert_allclose(irradiance(compiled(*lamps(scale))), irradiance(compiled(*lamps(1.0))), rtol=1e-3)


@pytest.mark.parametrize("degrees", [0.01, 1.0, 90.0, 179.0])
def test_blend_of_narrow_and_wide_spots(degrees):
    """Half way through the blended zone, in cosine, half the light arrives."""
    half = math.radians(degrees) / 2
    middle = 2 * math.asin(math.sqrt(0.75) * math.sin(half / 2))  # 1 - cos is 3/4 of the whole
    lamp = spot(angle=2 * half, blend=0.5)
    p = at((math.tan(middle), 0, 0), 1)
    s = compiled(lamp).sampler.sample(p, *numbers(1), Arena())
    intensity = s.weight[0, 0] * s.distance[0] ** 2
    np.testing.assert_allclose(intensity, 0.5 * 100 / (4 * math.pi), rtol=2e-2)


@pytest.mark.parametrize("degrees, values", [(180, [2.5297, 1.5802, 0.7876]), (90, [11.505, 3.5659, 0.4014])])
def test_spread(degrees, values):
    """Radiance of a white Lambert plane 2 below a small light, as rendered by Cycles (bpy 5.0.1), at three places."""
    lights = compiled(area(z=2, power=100, size=(0.01, 0.01), spread=math.radians(degrees)))
    radiance = [irradiance(lights, (x, 0.03125, 0))[0] / math.pi for x in (0.03125, 1.03125, 1.78125)]
    np.testing.assert_allclose(radiance, values, rtol=5e-3)
    _, _, classic = lights.classic.illuminate(0, at((0.03125, 0.03125, 0), 1), Arena())
    np.testing.assert_allclose(classic[:, 0] / math.pi, values[0], rtol=5e-3)


def test_spread_keeps_the_power():
    """Irradiance summed over a large plane below is the power, for every spread."""
    for spread in (0.1, 1.0, 2.0):
        cell = 1.1 * math.tan(spread / 2) / 200
        x = (np.arange(400) - 199.5) * cell
        p = np.stack([*np.meshgrid(x, x), np.zeros((400, 400))]).reshape(3, -1).astype(np.float32)
        lights = compiled(area(z=1, power=10, size=(1e-3, 1e-3), spread=spread))
        s = lights.sampler.sample(p, *numbers(p.shape[1]), Arena())
        assert (s.weight[0] * s.wi[2]).sum(dtype=np.float64) * cell**2 == pytest.approx(10, rel=1e-2)


def test_sheared_and_mirrored_area_light():
    transform = looking_down(0, 0, 1)
    transform[0, :2] = -1.0, 0.3
    upright = irradiance(compiled(area(power=math.pi)))
    np.testing.assert_allclose(irradiance(compiled(AreaLight(transform, (math.pi,) * 3))), upright, rtol=1e-4)
