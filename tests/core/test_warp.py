# SPDX-License-Identifier: GPL-3.0-or-later
"""Maps of the unit square, and the statistical tests themselves."""

import math

import numpy as np
import pytest

from zraka.core.arena import Arena
from zraka.core.sampling import warp
from zraka.tests import stat

N = 100_000
EXTREMES = np.float32([0.0, 1.0 - 2.0**-24, 0.5, 2.0**-24])
SPHERE = {
    "sphere": (warp.square_to_uniform_sphere, lambda wi, arena: np.full(wi.shape[1], warp.INV_FOUR_PI)),
    "hemisphere": (warp.square_to_cosine_hemisphere, lambda wi, arena: warp.cosine_hemisphere_pdf(wi[2], arena)),
}


def sampler(square_to):
    def sample(u, arena):
        return square_to(u[0], u[1], arena), np.ones(u.shape[1])

    return sample


@pytest.mark.parametrize("name", SPHERE)
def test_directions_follow_their_density(name):
    square_to, pdf = SPHERE[name]
    assert stat.check_sampler(sampler(square_to), pdf, N) > stat.sidak(stat.LEVEL, len(SPHERE))


def test_the_test_fails_for_a_wrong_density():
    """A density 5% too large, or one without the cosine, must be found."""
    square_to, pdf = SPHERE["hemisphere"]
    assert stat.check_sampler(sampler(square_to), lambda wi, a: 1.05 * pdf(wi, a), 4 * N) < 1e-6
    assert stat.check_sampler(sampler(square_to), lambda wi, a: (wi[2] > 0) / (2 * math.pi), N) < 1e-6


def test_p_values_are_uniform_where_all_is_right():
    rng = np.random.default_rng(1)
    expected = rng.random(60) * 50 + 1
    p = [stat.chi_square(rng.multinomial(int(expected.sum()), expected / expected.sum()), expected) for _ in range(400)]
    assert 0.02 < np.mean(np.array(p) < 0.05) < 0.09
    p = [stat.t_test(rng.normal(3.0, 2.0, 200), 3.0) for _ in range(400)]
    assert 0.02 < np.mean(np.array(p) < 0.05) < 0.09
    assert stat.t_test(rng.normal(3.2, 1.0, 2000), 3.0) < 1e-6
    assert stat.sidak(0.01, 10) == pytest.approx(0.001005, rel=1e-3)


def test_disk_is_uniform_and_inverts():
    arena = Arena()
    u = np.random.default_rng(2).random((2, N), np.float32)
    p = warp.square_to_uniform_disk_concentric(u[0], u[1], arena)
    assert np.abs(warp.disk_to_square_concentric(p) - u).max() < 1e-6
    r2 = p[0] ** 2 + p[1] ** 2
    counts = np.histogram2d(r2, np.arctan2(p[1], p[0]), bins=(10, 16), range=((0, 1), (-math.pi, math.pi)))[0]
    assert stat.chi_square(counts, np.full(counts.shape, N / counts.size)) > stat.LEVEL


def test_triangle_is_uniform():
    arena = Arena()
    u = np.random.default_rng(3).random((2, N), np.float32)
    b = warp.square_to_uniform_triangle(u[0], u[1], arena)
    assert b.min() >= 0 and (b[0] + b[1]).max() <= 1
    x, y = 1 - (1 - b[0]) ** 2, b[1] / (1 - b[0])  # uniform numbers when b is
    counts = np.histogram2d(x, y, bins=(12, 12), range=((0, 1), (0, 1)))[0]
    assert stat.chi_square(counts, np.full(counts.shape, N / counts.size)) > stat.LEVEL


@pytest.mark.parametrize("angle", [1.2, 0.1, 1e-3, 1e-6])
def test_cone_is_uniform_for_tiny_angles(angle):
    arena = Arena()
    cap = warp.one_minus_cosine(math.sin(angle), math.cos(angle))
    assert cap == pytest.approx(2 * math.sin(angle / 2) ** 2, rel=1e-12)
    u = np.random.default_rng(4).random((2, N), np.float32)
    w = warp.square_to_uniform_cone(u[0], u[1], np.float32(cap), arena)
    sine = np.hypot(w[0], w[1]).astype(np.float64)
    height = sine**2 / (1 + w[2]) / cap  # uniform in [0, 1]
    assert height.max() < 1 + 1e-5
    counts = np.histogram2d(height, np.arctan2(w[1], w[0]), bins=(10, 8), range=((0, 1.00001), (-math.pi, math.pi)))[0]
    assert stat.chi_square(counts, np.full(counts.shape, N / counts.size)) > stat.sidak(stat.LEVEL, 4)
    assert warp.uniform_cone_pdf(cap) * 2 * math.pi * cap == pytest.approx(1)


def test_extreme_numbers_give_unit_vectors():
    arena = Arena()
    u0, u1 = (np.ascontiguousarray(a.ravel()) for a in np.meshgrid(EXTREMES, EXTREMES))
    for w in (
        warp.square_to_uniform_sphere(u0, u1, arena),
        warp.square_to_cosine_hemisphere(u0, u1, arena),
        warp.square_to_uniform_cone(u0, u1, np.float32(0.3), arena),
    ):
        assert w.dtype == np.float32
        assert np.abs((w * w).sum(axis=0) - 1).max() < 1e-6
