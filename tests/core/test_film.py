# SPDX-License-Identifier: GPL-3.0-or-later
"""Sums stay exact, and the error estimate tells the truth."""

import numpy as np
import pytest

from zraka.core.film import Film


def filled(noise, samples, seed=0, size=64):
    film, rng = Film(size, size), np.random.default_rng(seed)
    pixels = np.arange(size * size)
    for sample in range(samples):
        film.add(pixels, (1 + noise * rng.standard_normal((3, pixels.size))).astype(np.float32), (sample,))
    return film


def test_a_million_equal_samples_keep_their_mean():
    film = Film(1, 1)
    block = np.full((3, 1000), 0.1, np.float32)
    for k in range(1000):
        film.add(np.array([0]), block, range(k * 1000, (k + 1) * 1000))
    assert film.image()[0, 0, 0] == np.float32(0.1)


def test_large_and_small_samples_add_up():
    film = Film(1, 1)
    film.add(np.array([0]), np.full((3, 1), 1e9, np.float32), (0,))
    film.add(np.array([0]), np.ones((3, 1000), np.float32), range(1, 1001))
    np.testing.assert_allclose(film.mean()[:, 0] * 1001, 1e9 + 1000, rtol=1e-12)


@pytest.mark.parametrize("samples", [4, 16, 64])
def test_estimated_error_is_the_true_one_for_independent_samples(samples):
    film = filled(0.5, samples)
    true = np.sqrt(np.mean((film.image()[..., :3] - 1) ** 2))
    # The estimate is of luminance, whose weights make independent channels' noise smaller.
    weights = np.sqrt(0.2126**2 + 0.7152**2 + 0.0722**2)
    assert film.error() == pytest.approx(true * weights, rel=0.06)


def test_error_is_unknown_from_one_sample_and_nothing_without_noise():
    assert filled(0.5, 1).error() == float("inf")
    assert filled(0.0, 2).error() == 0


def test_chunks_of_samples_give_the_same_bits():
    rng = np.random.default_rng(1)
    samples = rng.random((8, 3, 100)).astype(np.float32)
    one, many = Film(10, 10), Film(10, 10)
    for number, block in enumerate(samples):
        one.add(np.arange(100), block.copy(), (number,))
    many.add(np.arange(100), np.concatenate(samples, axis=1), range(8))
    np.testing.assert_array_equal(one.image(), many.image())
    assert one.error() == many.error()


def test_nonfinite_samples_are_counted_and_count_as_black():
    film = Film(2, 1)
    radiance = np.array([[np.nan, 1], [1, 1], [np.inf, 1]], np.float32)
    assert film.add(np.array([0, 1]), radiance, (0,)) == 1
    np.testing.assert_array_equal(film.image()[0, :, :3], [[0, 0, 0], [1, 1, 1]])
