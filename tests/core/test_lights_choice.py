# SPDX-License-Identifier: GPL-3.0-or-later
"""Choice among several lights, panels of two triangles, and many lamps that rays cross."""

import math

import numpy as np
import pytest
from scipy import stats

from zraka.core.arena import Arena
from zraka.core.compile.lights import compile_lights
from zraka.core.diagnostics import Diagnostics
from zraka.core.geometry import Geometry
from zraka.core.lights import lamps as lamps_module
from zraka.core.lights.choice import PowerChoice
from zraka.core.lights.panel import PanelLights, find_panels
from zraka.core.lights.triangle import TriangleLights, outward
from zraka.core.scene import AreaLight, Camera, PointLight, Scene, SpotLight, SunLight

N = 1 << 16


def compiled(*lights, triangles=(), emission=(1.0, 1.0, 1.0)):
    """Compiled lights of a scene of lamps and emissive `triangles` (T, 3, 3)."""
    return compile_lights(Scene(Camera(), lights=lights), Geometry.from_arrays(triangles), [emission], Diagnostics())


def turned(rng, place):
    """A random rotation and a place, (4, 4)."""
    matrix = np.eye(4)
    matrix[:3, :3] = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    matrix[:3, 3] = place
    return matrix


def points(count, seed=0):
    """Point lights of very different powers in a cube of side 2."""
    rng = np.random.default_rng(seed)
    powers = 4 * math.pi * rng.pareto(1.5, count)
    return [PointLight(tuple(p), (w, w, w)) for p, w in zip(rng.uniform(-1, 1, (count, 3)), powers, strict=True)]


def mixed(count, seed=0):
    """Lamps of every sort, and a sun and a sun disk."""
    rng = np.random.default_rng(seed)
    found = [SunLight((0, 0, -1), (1, 1, 1)), SunLight((0, 1, -1), (1, 1, 1), angle=0.1)]
    for i in range(count):
        place, power = tuple(rng.uniform(-1, 1, 3)), (float(rng.pareto(1.5)) + 0.01,) * 3
        found.append(
            [
                PointLight(place, power, 0.02),
                PointLight(place, power, 0.02, soft_falloff=False),
                AreaLight(turned(rng, place), power, (0.1, 0.2)),
                SpotLight(place, tuple(rng.normal(size=3)), power, 1.5),
                SpotLight(place, tuple(rng.normal(size=3)), power, 1.5, radius=0.03),
                PointLight(place, power),
            ][i % 6]
        )
    return found


def cloud(count, seed=1, size=1.5):
    """Random points, (3, count)."""
    return np.random.default_rng(seed).uniform(-size, size, (3, count)).astype(np.float32)


def square(size=1.0, z=1.0):
    a, b, c, d = (np.array([x * size, y * size, z]) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1)))
    return np.array([[a, b, c], [a, c, d]])


SCENES = {
    "two": points(2),
    "three": points(3),
    "sixteen": points(16),
    "seventeen": points(17),
    "thousand": points(1000),
    "same place": [PointLight((0, 0, 0), (w, w, w)) for w in (1.0, 2.0, 3.0)] * 7,
    "mixed 5": mixed(5),
    "mixed 100": mixed(100),
}


# -- probabilities -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", SCENES)
def test_probabilities_add_up_to_one(name):
    sampler, arena = compiled(*SCENES[name]).sampler, Arena()
    p = cloud(50)
    total = sum(
        np.broadcast_to(sampler.pmf_at(light, p, arena), 50).astype(np.float64) for light in range(sampler.count)
    )
    np.testing.assert_allclose(total, 1.0, atol=2e-5)


def frequencies_p(sampler, p, wrong=1.0):
    """p-value of a chi-square test of choices at `p` (3, 1) against their probabilities."""
    arena, count = Arena(), 200_000
    u = np.random.default_rng(5).random(count, np.float32)
    chosen = sampler._choice.sample(np.repeat(p, count, axis=1), u, arena)
    pmf = np.array([sampler.pmf_at(light, p, arena)[0] for light in range(sampler.count)], np.float64)
    np.testing.assert_allclose(chosen.pmf, pmf[chosen.index], rtol=1e-3, atol=1e-6)
    assert chosen.u.min() >= 0 and chosen.u.max() < 1
    pmf[np.argmax(pmf)] *= wrong
    expected, observed = pmf * count, np.bincount(chosen.index, minlength=sampler.count)
    rare = expected < 10
    expected, observed = (np.append(a[~rare], a[rare].sum()) for a in (expected, observed))
    kept = expected > 5
    return stats.chi2.sf(((observed - expected) ** 2 / np.maximum(expected, 1e-9))[kept].sum(), kept.sum() - 1)


@pytest.mark.parametrize("name", SCENES)
def test_choices_follow_their_probabilities(name):
    sampler = compiled(*SCENES[name]).sampler
    p = np.array([[0.3], [-0.2], [0.4]], np.float32)
    assert frequencies_p(sampler, p) > 1e-3
    assert frequencies_p(sampler, p, wrong=1.2) < 1e-3


def test_suns_keep_their_share_everywhere():
    sampler, p = compiled(*mixed(30)).sampler, cloud(20)
    assert sampler.kinds[0].at_infinity and sampler.kinds[1].at_infinity
    for sun in range(2):
        pmf = np.broadcast_to(sampler.pmf_at(sun, p, Arena()), 20)
        np.testing.assert_allclose(pmf, sampler.pmf[sun], rtol=1e-5)
    assert sampler.pmf[:2].sum() == pytest.approx(2 / 3, rel=1e-5)


def test_a_lane_chooses_alike_alone_and_among_others():
    choice = compiled(*points(300)).sampler._choice
    p, u = cloud(1000), np.random.default_rng(2).random(1000, np.float32)
    whole = choice.sample(p, u, Arena())
    part = choice.sample(np.ascontiguousarray(p[:, 333:500]), u[333:500], Arena())
    for a, b in zip(whole, part, strict=True):
        np.testing.assert_array_equal(a[333:500], b)


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_scale_changes_no_probability(scale):
    lights = points(40)
    scaled = [PointLight(tuple(np.array(x.position) * scale), x.power) for x in lights]
    p, arena = cloud(100), Arena()
    for light in (0, 17):
        a = compiled(*lights).sampler.pmf_at(light, p, arena)
        b = compiled(*scaled).sampler.pmf_at(light, p * np.float32(scale), arena)
        np.testing.assert_allclose(a, b, rtol=1e-3)


# -- estimates ---------------------------------------------------------------------------------------------------------


def fluence(sampler, p, count, seed=9):
    """Estimates of the sum of the intensities over squared distances at `p` (3, 1), (count,) float64."""
    u = np.random.default_rng(seed).random((3, count), np.float32)
    return sampler.sample(np.repeat(p, count, axis=1), *u, Arena()).weight[0].astype(np.float64)


def power_choice(lights, importance):
    """The same lights chosen by power alone."""
    lights.sampler._choice = PowerChoice(importance)
    return lights.sampler


@pytest.mark.parametrize("count", [2, 5, 100, 10_000])
def test_estimates_are_unbiased(count):
    """A t-test against the exact sum, at several points; a probability 5% off is noticed."""
    lights = points(count)
    sampler = compiled(*lights).sampler
    place = np.array([light.position for light in lights])
    intensity = np.array([light.power[0] for light in lights]) / (4 * math.pi)
    scores, wrong = [], []
    for p in cloud(10, seed=4).T:
        truth = (intensity / ((place - p) ** 2).sum(axis=1)).sum()
        values = fluence(sampler, p[:, None], N)
        error = values.std(ddof=1) / math.sqrt(N) + 2e-6 * truth  # the importance of few point lights is exact
        scores.append((values.mean() - truth) / error)
        wrong.append((values.mean() / 1.05 - truth) / error)
    assert np.abs(scores).max() < 4
    assert np.abs(wrong).max() > 5


@pytest.mark.parametrize("count, gain", [(4, 4), (1000, 20), (10_000, 20)])
def test_error_is_far_below_that_of_the_choice_by_power(count, gain):
    """Variance at equal samples, median over random points."""
    lights = compiled(*points(count))
    importance = lights.sampler.pmf.astype(np.float64)
    at = [p[:, None] for p in cloud(20, seed=6).T]
    near = [fluence(lights.sampler, p, 4096).var() for p in at]
    by_power = [fluence(power_choice(lights, importance), p, 4096).var() for p in at]
    assert np.median(np.divide(by_power, near)) > gain


def test_lamps_that_face_away_are_seldom_chosen():
    """Of two equal area lights back to back, the one that shines this way."""
    up, down = np.diag([1.0, 1, 1, 1]), np.diag([1.0, -1, -1, 1])
    sampler = compiled(AreaLight(up, (1, 1, 1), (0.1, 0.1)), AreaLight(down, (1, 1, 1), (0.1, 0.1))).sampler
    below, above = (np.array([[0.0], [0], [z]], np.float32) for z in (-2, 2))
    assert sampler.pmf_at(0, below, Arena())[0] > 0.9
    assert sampler.pmf_at(1, above, Arena())[0] > 0.9


def cube(flip=False):
    """An emissive cube of side 1 around zero, twelve triangles."""
    x, y = np.array([1, 0, 0]), np.array([0, 1, 0])
    faces = []
    for _ in range(3):
        x, y = np.roll(x, 1), np.roll(y, 1)
        for z in (np.cross(x, y), -np.cross(x, y)):
            u = x if z @ np.cross(x, y) > 0 else -x
            a, b, c, d = (0.5 * (z + i * u + j * y) for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1)))
            faces += [[a, b, c], [a, c, d]]
    return np.array(faces)[:, :: -1 if flip else 1]


@pytest.mark.parametrize("flip", [False, True])
def test_outsides_of_closed_meshes_are_known(flip):
    triangles = np.concatenate([cube(flip), square(5.0, z=9.0)])
    axis = outward(triangles.reshape(-1, 9).T, np.repeat([4, 7], [12, 2]))
    assert not outward(triangles.reshape(-1, 9).T, np.repeat([4, 7], [12, 2]), largest=1.0).any()
    middle = triangles[:12].mean(axis=1).T
    np.testing.assert_allclose((axis[:, :12] * middle).sum(axis=0), 0.5)
    assert not axis[:, 12:].any()


@pytest.mark.parametrize("place", [(0.9, 0.3, 0.2), (0.1, 0.2, 0.3), (3.0, -2.0, 1.0)])
def test_closed_meshes_are_sampled_without_bias(place):
    """Outside and inside, against the choice by power."""
    lights = compiled(triangles=np.concatenate([cube(), square() * 1e-3 + 9]))  # in a scene larger than the cube
    p, results = np.array(place, np.float32)[:, None], []
    chosen = fluence(lights.sampler, p, 1 << 18)
    plain = fluence(power_choice(lights, lights.sampler.pmf), p, 1 << 18, seed=10)
    for wrong in (1.0, 1.05):
        difference = chosen.mean() / wrong - plain.mean()
        results.append(abs(difference) / math.hypot(chosen.std(), plain.std()) * 512)
    assert results[0] < 4 < results[1]


def test_sides_that_a_closed_mesh_hides_are_seldom_chosen():
    """Variance of the light of the visible faces alone: the others are behind them."""
    p, count, variance = np.array([[0.9], [0.8], [0.7]], np.float32), N, []
    for by_power in (False, True):
        lights = compiled(triangles=np.concatenate([cube(), square() * 1e-3 + 9]))
        sampler = power_choice(lights, lights.sampler.pmf) if by_power else lights.sampler
        u = np.random.default_rng(2).random((3, count), np.float32)
        s = sampler.sample(np.repeat(p, count, axis=1), *u, Arena())
        hit = p + s.wi * s.distance
        face = np.argmax(np.abs(hit), axis=0), np.arange(count)
        variance.append((s.weight[0] * (s.wi[face] * hit[face] < 0)).var())
    assert variance[0] < 0.3 * variance[1]


# -- panels ------------------------------------------------------------------------------------------------------------


def test_two_triangles_of_a_rectangle_are_one_panel():
    (kind,) = compiled(triangles=square()).sampler.kinds
    assert isinstance(kind, PanelLights) and kind.count == 1
    assert kind.power[0] == pytest.approx(2 * math.pi)


@pytest.mark.parametrize("rotate", [0, 1, 2])
@pytest.mark.parametrize("other", [(0, 1, 2), (1, 2, 0), (2, 0, 1)])
def test_panels_are_found_however_the_corners_are_numbered(rotate, other):
    one, two = square()
    quad = np.stack([one[[rotate, (rotate + 1) % 3, (rotate + 2) % 3]], two[list(other)]])
    first, _, edge0, edge1 = find_panels(quad.reshape(2, 9).T, np.array([True]))
    assert first.tolist() == [0]
    assert np.abs(np.cross(edge0, edge1, axis=0)[:, 0]) == pytest.approx([0, 0, 1])


def test_what_is_no_rectangle_stays_triangles():
    skewed, bent = square(), square()
    skewed[:, :, 0] += 0.01 * skewed[:, :, 1]
    bent[1, 2, 2] += 0.01
    apart = square()[[0]]
    for triangles in (skewed, bent, np.concatenate([apart, apart + 3])):
        (kind,) = compiled(triangles=triangles).sampler.kinds
        assert isinstance(kind, TriangleLights) and kind.count == 2
    fan = np.concatenate([square(), skewed + 5, square(z=2.0)])
    kinds = compiled(triangles=fan).sampler.kinds
    assert [k.count for k in kinds] == [2, 2]


def test_a_run_of_triangles_is_cut_into_pairs():
    """Every triangle but the last makes a rectangle with the next one; none may be in two."""
    a, b = square()
    c = np.array([[1.0, 1, 1], [0, 1, 1], [1, 2, 1]])
    first, *_ = find_panels(np.stack([a, b, c]).reshape(3, 9).T, np.array([True, True]))
    assert first.size == 1


def corner_angle(x, y, h):
    """Solid angle (sr) of the rectangle from (0, 0) to (x, y) at height h above the origin."""
    return np.arctan(x * y / (h * np.sqrt(x * x + y * y + h * h)))


def sub_rectangles(x, y, h, cells):
    """Solid angles (cells, cells) of a grid on a rectangle of the sides x = (x0, x1), y = (y0, y1)."""
    x, y = np.linspace(*x, cells + 1), np.linspace(*y, cells + 1)
    return np.diff(np.diff(corner_angle(x[:, None], y[None, :], h), axis=0), axis=1)


@pytest.mark.parametrize("below", [True, False])
@pytest.mark.parametrize("height", [0.2, 1.0, 4.0])
def test_directions_to_panels_follow_their_density(height, below):
    """Chi-square over a grid on the panel; near it each cell's share is that of its solid angle, far off its area's."""
    sampler = compiled(triangles=square(2.0, 0.0)).sampler
    p = np.array([[0.6], [0.5], [-height if below else height]], np.float32)
    count, cells = 60_000, 6
    u = np.random.default_rng(3).random((3, count), np.float32)
    s = sampler.sample(np.repeat(p, count, axis=1), *u, Arena())
    hit = p + s.wi * s.distance
    np.testing.assert_allclose(hit[2], 0, atol=1e-4)
    observed, _, _ = np.histogram2d(hit[0], hit[1], cells, ((0, 2), (0, 2)))
    assert observed.sum() > count - 20
    angles = sub_rectangles((-0.6, 1.4), (-0.5, 1.5), height, cells)
    large = 4 / ((1 - 0.6) ** 2 + (1 - 0.5) ** 2 + height**2) > 0.3
    share = angles / angles.sum() if large else np.full((cells, cells), 1 / cells**2)
    for factor, holds in ((1.0, True), (1.05, False)):
        expected = share * count * factor
        p_value = stats.chi2.sf(((observed - expected) ** 2 / expected).sum(), cells**2 - 1)
        assert (p_value > 1e-3) == holds
    assert (1 / s.pdf).mean() == pytest.approx(angles.sum(), rel=1e-2)
    pdf = sampler.pdf_prim(np.zeros(count, np.int32), np.repeat(p, count, axis=1), s.wi, s.distance, Arena())
    np.testing.assert_allclose(pdf, s.pdf, rtol=1e-3)
    np.testing.assert_allclose(s.weight[0] * s.pdf, 1.0, rtol=1e-4)


@pytest.mark.parametrize("height", [0.0, 1e-7, -1e-7])
def test_a_panel_does_not_light_its_own_plane(height):
    sampler = compiled(triangles=square(2.0, 0.0)).sampler
    p = np.array([[0.6], [0.5], [height]], np.float32)
    u = np.random.default_rng(3).random((3, 10_000), np.float32)
    assert sampler.sample(np.repeat(p, 10_000, axis=1), *u, Arena()).weight.mean() < 1e-2


def test_density_of_both_triangles_of_a_panel_is_the_panels():
    lights = compiled(*points(20), triangles=square())
    p, wi = cloud(2, size=0.01), np.array([[0, 0], [0, 0], [1, 1]], np.float32)
    p, one = p[:, [0, 0]].copy(), np.ones(2, np.float32)
    a, b = lights.sampler.pdf_prim(np.arange(2, dtype=np.int32), p, wi, one, Arena())
    assert a == b > 0


# -- many lamps --------------------------------------------------------------------------------------------------------


def crowded(kind):
    """Lamps far apart, or overlapping, some in the same place."""
    rng = np.random.default_rng(8)
    reach, radius = {"apart": (3.0, 0.05), "overlapping": (1.0, 0.2)}[kind]
    found = []
    for i in range(60):
        place = tuple(rng.uniform(-reach, reach, 3))
        found.append(
            [
                PointLight(place, (1, 1, 1), radius),
                PointLight(place, (1, 1, 1), radius, soft_falloff=False),
                AreaLight(turned(rng, place), (1, 1, 1), (radius, 3 * radius)),
                SpotLight(place, tuple(rng.normal(size=3)), (1, 1, 1), 2.0, radius=radius),
            ][i % 4]
        )
    return [*found, found[0], found[1], found[2], SunLight((0, 0, -1), (1, 1, 1), angle=0.2)]


@pytest.mark.parametrize("kind", ["apart", "overlapping"])
@pytest.mark.parametrize("passed", [False, True])
def test_many_lamps_are_crossed_as_one_by_one(kind, passed, monkeypatch):
    rng = np.random.default_rng(1)
    count = 20_000
    o, d = cloud(count, size=3.0), rng.normal(size=(3, count))
    d = (d / np.linalg.norm(d, axis=0)).astype(np.float32)
    tmax = rng.exponential(3.0, count).astype(np.float32)
    tmax[::5] = np.inf
    way = rng.uniform(0, 1, count).astype(np.float32) if passed else None
    pdf = np.full(count, 0.3, np.float32)
    boxed = compiled(*crowded(kind)).lamps
    monkeypatch.setattr(lamps_module, "_FEW", 1000)
    single = compiled(*crowded(kind)).lamps
    fewer = compiled(*crowded(kind)[1:]).lamps
    a, b, c = (x.radiance(o, d, tmax, pdf, Arena(), passed=way)[0].copy() for x in (boxed, single, fewer))
    assert (b > 0).sum() > 50
    np.testing.assert_allclose(a, b, rtol=1e-4, atol=1e-5)
    assert np.abs(a - c).max() > 1e-2  # one lamp less is noticed
