# SPDX-License-Identifier: GPL-3.0-or-later
"""Samples go where the noise is, and the mean stays the mean."""

import numpy as np
import pytest

from zraka.core import adaptive
from zraka.core.film import Film
from zraka.core.neighbours import neighbours_mean

SIZE = 32


def render(noise, samples, seed, allocate=True):
    """A picture of ones with `noise` (SIZE, SIZE), a standard deviation by pixel; samples are exponential."""
    film, rng = Film(SIZE, SIZE), np.random.default_rng(seed)

    def add(pixels, numbers):
        for number in numbers:
            skew = rng.exponential(1.0, pixels.size) - 1
            film.add(pixels, np.tile(1 + noise.ravel()[pixels] * skew, (3, 1)).astype(np.float32), (number,))

    every = np.arange(SIZE * SIZE)
    add(every, range(16))
    goal = (
        adaptive.targets(film.counts(), adaptive.importance(film), samples)
        if allocate
        else np.full(every.size, samples)
    )
    for stop in np.unique(goal):
        add(every[goal == stop], range(16, stop))
    return film


@pytest.fixture
def half_noisy():
    noise = np.full((SIZE, SIZE), 0.02)
    noise[:, SIZE // 2 :] = 0.5
    return noise


def test_noisy_pixels_take_more(half_noisy):
    counts = render(half_noisy, 64, 0).counts().reshape(SIZE, SIZE)
    assert counts[:, -8:].mean() > 4 * counts[:, :8].mean()
    assert counts.min() >= 16 and counts.mean() <= 64


def test_the_error_is_less_for_as_many_samples(half_noisy):
    def error(film):
        return np.sqrt(np.mean((film.mean()[0] - 1) ** 2))

    own, same = (np.mean([error(render(half_noisy, 64, seed, on)) for seed in range(5)]) for on in (True, False))
    assert own < 0.85 * same


def test_equal_noise_keeps_samples_equal():
    counts = render(np.full((SIZE, SIZE), 0.3), 64, 1).counts()
    assert counts.mean() > 48 and counts.max() <= 96


def mean_deviation(judge):
    """Mean of the picture less 1, in standard errors, when `judge` tells the noise that asks for more samples."""
    means = []
    for seed in range(300):
        rng = np.random.default_rng(seed)
        values = rng.exponential(1.0, (64, SIZE * SIZE))
        first = values[:16]
        goal = np.where(judge(np.abs(first[::2].mean(0) - first[1::2].mean(0))), 64, 16)
        total = np.where(np.arange(64)[:, None] < goal, values, 0).sum(0)
        means.append((total / goal).mean())
    return (np.mean(means) - 1) / (np.std(means) / np.sqrt(len(means)))


def test_neighbours_judge_without_bias():
    def by_neighbours(noise):
        around = neighbours_mean(noise.reshape(SIZE, SIZE), adaptive._REACH).ravel()
        return around > np.median(around)

    assert abs(mean_deviation(by_neighbours)) < 4


def test_a_pixel_that_judges_itself_is_biased():
    """What `importance` avoids, and that the test above would see it."""
    assert mean_deviation(lambda noise: noise > np.median(noise)) < -4


@pytest.mark.parametrize("shape", [(1, 1), (1, 7), (3, 2), (9, 30)])
def test_neighbours_mean_is_that_of_the_others(shape):
    values = np.random.default_rng(3).random(shape)
    for y, x in np.ndindex(shape):
        around = values[max(y - 2, 0) : y + 3, max(x - 2, 0) : x + 3]
        others = (around.sum() - values[y, x]) / (around.size - 1) if around.size > 1 else values[y, x]
        assert neighbours_mean(values, 2)[y, x] == pytest.approx(others, rel=1e-6)


def test_the_estimate_stays_honest(half_noisy):
    """Pixels with more samples and fewer, each judged by its own number."""
    films = [render(half_noisy, 64, seed) for seed in range(6)]
    true = np.sqrt(np.mean([np.mean((film.mean()[0] - 1) ** 2) for film in films]))
    told = np.sqrt(np.mean([film.error() ** 2 for film in films]))
    assert told == pytest.approx(true, rel=0.15)
    assert 1.3 * told != pytest.approx(true, rel=0.15)


def test_targets_keep_to_the_mean():
    rng = np.random.default_rng(2)
    for _ in range(20):
        counts = np.full(500, 16)
        goal = adaptive.targets(counts, rng.lognormal(0, 1, 500), 100)
        assert (goal >= counts).all() and 60 < goal.mean() <= 100
