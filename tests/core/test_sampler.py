# SPDX-License-Identifier: GPL-3.0-or-later
"""Random numbers: uniform, stratified, independent between dimensions, the same for every schedule."""

import numpy as np
import pytest

from zraka.core.arena import Arena
from zraka.core.sampling.sampler import Draw, Sampler

PIXELS = np.arange(4096, dtype=np.int32)


def draw(group, count, sample, pixels=PIXELS, seed=0):
    arena = Arena()
    sampler = Sampler(seed)
    return sampler.draw(group, range(count), sampler.keys(pixels, arena), None, (sample,), arena)


def test_points_lie_in_the_unit_interval():
    for group in (Draw.PIXEL.at(0), Draw.BSDF.at(30)):
        u = draw(group, 4, 5)
        assert u.dtype == np.float32 and u.min() >= 0 and u.max() < 1


@pytest.mark.parametrize("cells", [(16, 1), (8, 2), (4, 4), (2, 8), (1, 16)])
def test_sixteen_samples_of_a_pixel_fill_every_elementary_interval(cells):
    points = np.stack([draw(Draw.LIGHT.at(1), 2, s) for s in range(16)])
    x, y = ((points[:, k] * cells[k]).astype(int) for k in (0, 1))
    occupied = np.sort(x * cells[1] + y, axis=0)
    assert (occupied == np.arange(16)[:, None]).all()


def test_independent_numbers_are_not_stratified():
    """The check above can fail."""
    points = np.stack([draw(Draw.LIGHT.at(9), 2, s) for s in range(16)])
    occupied = np.sort((points[:, 0] * 4).astype(int) * 4 + (points[:, 1] * 4).astype(int), axis=0)
    assert not (occupied == np.arange(16)[:, None]).all(axis=0).any()


def test_dimensions_groups_pixels_and_seeds_are_uncorrelated():
    # Of one sample: the samples of a pixel are stratified, so they must depend on each other.
    rows = np.vstack(
        [draw(g, 4, 0, seed=seed) for g in (0, 1, 2, 5, 41, 42) for seed in (0, 1)]
        + [draw(1, 4, 0, pixels=PIXELS + 4096)]
    )
    correlation = np.corrcoef(rows) - np.eye(len(rows))
    # 5 standard errors of 4096 samples; thousands of pairs are compared.
    assert np.abs(correlation).max() < 5 / np.sqrt(PIXELS.size)


def test_mean_and_variance_are_those_of_the_uniform_distribution():
    for group in (2, 50):
        u = draw(group, 4, 7)
        np.testing.assert_allclose(u.mean(axis=1), 0.5, atol=5 * np.sqrt(1 / 12 / PIXELS.size))
        np.testing.assert_allclose(u.var(axis=1), 1 / 12, rtol=0.08)


def test_lanes_of_several_samples_get_the_numbers_of_each():
    arena, sampler = Arena(), Sampler(3)
    slots = np.repeat(np.arange(3, dtype=np.uint8), PIXELS.size)
    keys = sampler.keys(np.tile(PIXELS, 3), arena)
    for group in (1, 60):
        together = sampler.draw(group, range(3), keys, slots, (4, 5, 6), arena)
        apart = np.concatenate([draw(group, 3, s, seed=3) for s in (4, 5, 6)], axis=1)
        np.testing.assert_array_equal(together, apart)


def test_groups_of_different_bounces_never_coincide():
    groups = [kind.at(depth) for kind in Draw for depth in range(100)]
    assert len(set(groups)) == len(groups)
