# SPDX-License-Identifier: GPL-3.0-or-later
"""Sums stay exact, and the error estimate tells the truth."""

import numpy as np
import pytest

from zraka.core import estimate
from zraka.core.arena import zeros_on_demand
from zraka.core.film import INTERVAL_95, Film
from zraka.core.pixel_set import spread
from zraka.core.report.error import FLOOR, relative_rmse, weights
from zraka.core.sampling.sampler import reverse_int

from .scenes import cornell, film_of


def filled(noise, samples, seed=0, size=64):
    film, rng = Film(size, size), np.random.default_rng(seed)
    pixels = np.arange(size * size)
    for sample in range(samples):
        film.add(pixels, (1 + noise * rng.standard_normal((3, pixels.size))).astype(np.float32), (sample,))
    return film


@pytest.mark.parametrize("by_slices", [True, False])
def test_the_oldest_mark_is_kept_where_the_error_is_judged(by_slices):
    width, height, rng = 512, 300, np.random.default_rng(4)
    total = width * height
    film, samples = Film(width, height, places=rng.permutation(total)), rng.random((9, 3, total), np.float32)
    for number, colour in enumerate(samples):
        for start in range(0, total, 50_001):
            where = slice(start, min(start + 50_001, total))
            pixels = where if by_slices else np.arange(where.start, where.stop)
            film.add(pixels, colour[:, where].copy(), (number,))
    judged = np.unique(film._blocks)
    assert film._eighths.shape == (3, judged.size) != (3, total)
    np.testing.assert_allclose(film._eighths, samples[:2].mean(axis=0)[:, judged], rtol=1e-6)
    np.testing.assert_allclose(film._marks[1], samples[:4].mean(axis=0), rtol=1e-6)
    assert np.isfinite(film.error()) and np.isfinite(film.variance()).all()


def scattered(pixel_errors, by_slices=True, size=(300, 512), samples=13):
    """A film of a picture with a bright corner, whose pixels are traced in any order, by parts."""
    total, rng = size[0] * size[1], np.random.default_rng(4)
    truth = np.ones(size, np.float32)
    truth[: size[0] // 9, : size[1] // 9] = 30.0
    places = rng.permutation(total)
    film = Film(size[1], size[0], places=places, pixel_errors=pixel_errors)
    for number in range(samples):
        colour = truth.ravel()[places] * rng.standard_gamma(2.0, (3, total)).astype(np.float32)
        for start in range(0, total, 50_001):
            where = slice(start, min(start + 50_001, total))
            pixels = where if by_slices else np.arange(where.start, where.stop)
            film.add(pixels, colour[:, where].copy(), (number,))
    return film


@pytest.mark.parametrize("by_slices", [True, False])
def test_a_large_picture_need_not_keep_the_marks_of_all_pixels(by_slices, monkeypatch):
    monkeypatch.setattr("zraka.core.film._SMALL", 1 << 17)
    monkeypatch.setattr("zraka.core.film._GRID", 1 << 15)
    some, every = scattered(False, by_slices), scattered(True)
    assert (some.error_step, every.error_step) == (3, 1)
    assert some._marks.shape[2] < 0.3 * every._marks.shape[2]
    np.testing.assert_array_equal(some.image(), every.image())
    np.testing.assert_array_equal(some.image(slice(2, 5)), every.image()[2:5])
    np.testing.assert_array_equal(some._marks, every._marks[:, :, some._marked._pixels])
    among = np.searchsorted(some._marked._pixels, every._judged._pixels)
    np.testing.assert_array_equal(some._eighths[:, among], every._eighths)
    # The picture's mean square is told by other pixels.
    assert some.error() == pytest.approx(every.error(), rel=0.02)
    assert some._mean_square() == pytest.approx(every._mean_square(), rel=0.05)
    some._doublings = every._doublings
    np.testing.assert_array_equal(some.relative_pixel_error(6), every.relative_pixel_error(6))


def test_a_film_says_whose_error_it_does_not_tell(monkeypatch):
    assert Film(512, 512, pixel_errors=False).error_step == 1
    film = scattered(False, size=(520, 512), samples=2)
    assert film.error_step == 2
    assert film.relative_pixel_error(2).shape == (260, 256)
    for ask in (film.variance, film.pixel_error, film.relative_pixel_error):
        with pytest.raises(ValueError, match="pixel_errors=True"):
            ask()


@pytest.mark.parametrize("count", [10, 1 << 21])
def test_memory_on_demand_is_zero_and_can_be_written(count):
    zeros = zeros_on_demand((2, count), np.float64)
    assert zeros.flags.writeable and zeros.flags.c_contiguous and not zeros[:, ::997].any()
    zeros[1] += 1
    assert (zeros.sum(axis=1) == (0, count)).all()


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


def true_error(film):
    """Relative RMSE against a picture of ones that is known exactly."""
    ones = np.ones((2, film.height, film.width, 3))
    return relative_rmse(film.image()[..., :3], ones, weights(ones[0]))


@pytest.mark.parametrize("samples", [4, 6, 8, 11, 16, 48, 64])
def test_estimated_error_is_the_true_one_for_independent_samples(samples):
    film = filled(0.5, samples)
    assert film.error() == pytest.approx(true_error(film), rel=0.1)


def test_the_error_of_a_large_picture_with_a_small_lamp():
    """A few blocks are judged. Here none holds any of the lamp, which rules the picture's mean square."""
    film, rng, size = Film(320, 200), np.random.default_rng(8), 320 * 200
    judged = np.isin(np.arange(size), spread(np.arange(size).reshape(200, 320))).reshape(200, 320)
    assert judged.mean() < 0.3
    truth = np.ones((200, 320, 3))
    truth[80:100, 160:180][~judged[80:100, 160:180]] = 60.0
    for sample in range(8):
        noise = np.tile(0.5 * rng.standard_normal(size), (3, 1))
        film.add(np.arange(size), (truth.reshape(-1, 3).T + noise).astype(np.float32), (sample,))
    true = relative_rmse(film.image()[..., :3], np.stack([truth, truth]), weights(truth))
    assert film.error() == pytest.approx(true, rel=0.05)
    film._mean_square = lambda: 3.0
    assert film.error() != pytest.approx(true, rel=0.05)


def stratified(samples, seed, size=48):
    """Samples of a ramp at points that are one to each stratum: halves that balance each other."""
    film, rng = Film(size, size), np.random.default_rng(seed)
    pixels, shift = np.arange(size * size), rng.integers(0, 1 << 32, size * size, np.uint32)
    for sample in range(samples):
        point = np.uint32(reverse_int(sample)) ^ shift
        value = 1 + point * 2.0**-32 - 0.5 + 0.2 * rng.standard_normal(pixels.size)
        film.add(pixels, np.tile(value, (3, 1)).astype(np.float32), (sample,))
    return film


@pytest.mark.parametrize("samples", [8, 16, 64])
def test_estimated_error_of_balanced_samples(samples):
    film = stratified(samples, 1)
    assert film.error() == pytest.approx(true_error(film), rel=0.15)
    assert 1.3 * film.error() != pytest.approx(true_error(film), rel=0.15)


def test_a_difference_of_halves_alone_would_be_too_large_for_balanced_samples():
    """Why the estimate goes by how doublings compare."""
    film = stratified(4, 1)
    gains = film._gains(lambda difference: np.square(difference).sum(axis=0), np.arange(film.width * film.height))[1]
    assert np.sqrt(gains[0].mean() / 3) > 1.15 * true_error(film)


def coverage(film, factor=1.0):
    reached = factor * INTERVAL_95 * film.pixel_error().ravel()
    return float((np.abs(film.mean()[1] - 1) <= reached).mean())


@pytest.mark.parametrize("samples", [8, 16, 23, 64])
def test_intervals_of_pixels_hold_the_truth(samples):
    film, rng = Film(64, 64), np.random.default_rng(5)
    for sample in range(samples):
        grey = 1 + 0.5 * rng.standard_normal(64 * 64)
        film.add(np.arange(64 * 64), np.tile(grey, (3, 1)).astype(np.float32), (sample,))
    assert 0.93 < coverage(film) < 0.97
    assert not 0.93 < coverage(film, 1.3) < 0.97


def test_fireflies_do_not_look_bright_to_the_estimate():
    """A sample of a thousand times the others makes its pixel err by much more than it shows."""
    film, rng = Film(64, 64), np.random.default_rng(6)
    for sample in range(16):
        grey = 1 + np.where(rng.random(64 * 64) < 1e-3, 100.0, 0.0)
        film.add(np.arange(64 * 64), np.tile(grey, (3, 1)).astype(np.float32), (sample,))
    assert film.error() == pytest.approx(true_error(film), rel=0.25)


def test_error_is_unknown_from_one_sample_and_nothing_without_noise():
    assert filled(0.5, 1).error() == float("inf")
    assert np.isinf(filled(0.5, 1).pixel_error()).all()
    assert filled(0.0, 2).error() == 0


def test_chunks_of_samples_give_the_same_bits():
    rng = np.random.default_rng(1)
    samples = rng.random((8, 3, 100)).astype(np.float32)
    one, many = Film(10, 10), Film(10, 10)
    for number, block in enumerate(samples):
        one.add(np.arange(100), block.copy(), (number,))
    many.add(np.arange(100), np.stack(samples, axis=2).reshape(3, -1), range(8))
    np.testing.assert_array_equal(one.image(), many.image())
    assert one.error() == many.error()


def test_nonfinite_samples_are_counted_and_count_as_black():
    film = Film(2, 1)
    radiance = np.array([[np.nan, 1], [1, 1], [np.inf, 1]], np.float32)
    assert film.add(np.array([0, 1]), radiance, (0,)) == 1
    np.testing.assert_array_equal(film.image()[0, :, :3], [[0, 0, 0], [1, 1, 1]])


# -- what remains of the variance --------------------------------------------------------------------------------------


@pytest.mark.parametrize("count", [2, 3, 5, 16, 24, 100])
def test_independent_samples_lose_variance_by_their_number(count):
    """The last doubling, to n or to m below it, gained as much as then was left."""
    half = estimate.half_of(count)
    left = half * 2 if count == half * 2 else half
    assert estimate.remaining(count, 0.5) == pytest.approx(left / count)


def test_remaining_of_nested_nets_by_simulation():
    """A sum of three nets, each half the size of the one before, of points that balance each other."""
    rng, count, pixels = np.random.default_rng(7), 28, 20000
    shift = rng.integers(0, 1 << 32, pixels, np.uint32)
    points = [(np.uint32(reverse_int(k)) ^ shift) * 2.0**-32 - 0.5 for k in range(32)]
    sums = np.cumsum(points, axis=0)
    variance = {n: np.mean((sums[n - 1] / n) ** 2) for n in (8, 16, 28)}
    # Points of one dimension: each doubling quarters the variance.
    assert variance[16] / variance[8] == pytest.approx(0.25, rel=0.05)
    gained = variance[8] - variance[16]
    assert gained * estimate.remaining(count, 0.25) == pytest.approx(variance[28], rel=0.1)
    # What 12 more samples changed tells the same as the doubling before them.
    changed = np.mean((sums[count - 1] / count - sums[15] / 16) ** 2)
    known, since = estimate.shares(count, 0.25)
    assert known == pytest.approx(0.25)
    assert changed * since == pytest.approx(0.75 * gained, rel=0.1)


@pytest.mark.parametrize("count", [3, 5, 20, 24, 100])
def test_independent_samples_change_a_mean_by_their_number(count):
    half = estimate.half_of(count)
    done = (count - half) / half
    assert estimate.shares(count, 0.5) == pytest.approx((1 - done, done * count / (count - half)))


def test_fireflies_since_the_last_doubling_are_seen():
    """16 samples of grey, then 8 of which some are bright in a few pixels."""
    rng = np.random.default_rng(2)
    samples = 1 + 0.1 * rng.standard_normal((24, 3, 32 * 32)).astype(np.float32)
    calm, stormy = Film(32, 32), Film(32, 32)
    for number, block in enumerate(samples):
        calm.add(np.arange(1024), block.copy(), (number,))
        if number >= 16:
            block[:, rng.random(1024) < 0.01] += 20
        stormy.add(np.arange(1024), block, (number,))
    assert stormy.error() > 5 * calm.error()


def test_doublings_of_a_line():
    for ratio in (0.3, 0.4, 0.45):
        told = estimate.doublings([ratio**k for k in range(5)])
        assert told.ratio == pytest.approx((2 * ratio + 0.46) / 3)
        assert told.level == pytest.approx(1.0)


def test_gains_that_alternate_are_drawn_to_their_line():
    up, down = (estimate.doublings([0.45**k * 1.2 ** (k % 2 == odd) for k in range(6)]) for odd in (0, 1))
    assert up.level > 1 > down.level
    assert up.level / down.level == pytest.approx(1.2**0.5, rel=0.1)


def test_gains_that_do_not_fall_end_as_independent():
    assert estimate.doublings([1.0, 2.0, 3.0]).ratio == pytest.approx((0.5 + 0.46) / 2)


def test_gains_of_any_size():
    assert estimate.doublings([1.0]) == estimate.doublings([1.0, 0.0]) == estimate.Doublings()
    for gains in ((1e300, 5e-324), (5e-324, 1e300), (5e-324, 1e300, 1e300), (1e300, 5e-324, 1e300)):
        told = estimate.doublings(gains)
        assert 0 < told.ratio <= 0.5, gains
        assert 0.5 <= told.level <= 2, gains


# -- of a scene --------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_estimated_error_of_a_scene():
    """Root mean square over some pictures, against a reference of 64 times their samples."""
    runs = np.stack([film_of(cornell(), 512, 64, seed=100 + k).image()[..., :3] for k in range(2)])
    weight = weights(runs.mean(axis=0))
    films = [film_of(cornell(), 16, 64, seed=seed) for seed in range(6)]
    true = np.sqrt(np.mean([relative_rmse(film.image()[..., :3], runs, weight) ** 2 for film in films]))
    told = np.sqrt(np.mean([film.error() ** 2 for film in films]))
    assert told == pytest.approx(true, rel=0.15)
    assert 1.3 * told != pytest.approx(true, rel=0.15)


def test_a_noise_without_differences_is_no_overflow():
    """The mean of pixels that are all alike, where doublings changed much."""
    flat = np.ones((3, 8, 8))
    np.testing.assert_allclose(estimate.noisy_weights(flat, np.full((8, 8), 8.0), 3.0), 1 / (3 + 3 * FLOOR**2))


@pytest.mark.parametrize(("most", "count"), [(1, np.uint8), (255, np.uint8), (256, np.uint16), (65_536, np.int32)])
def test_a_film_of_few_samples_takes_less_memory_for_the_same_bytes(most, count):
    rng, pixels = np.random.default_rng(4), 40 * 30
    samples = min(most, 256)
    shape = (7, pixels, samples)
    sample = (rng.standard_normal(shape) * 10.0 ** rng.integers(-20, 20, shape)).astype(np.float32)
    sample[1, 5, 0] = np.nan
    order = rng.permutation(pixels)
    films = [Film(40, 30, True, order, extra=1, behind=2, compose=_composed, most=limit) for limit in (None, most)]
    for film in films:
        for part in (slice(0, 700), slice(700, pixels)):
            assert film.add(part, sample[:, part].reshape(7, -1).copy(), range(samples)) == (part.start == 0)
    plain, small = films
    assert small._sums.nbytes * (2 if most == 1 else 1) == plain._sums.nbytes
    assert small._counts.dtype == count
    for told in (Film.image, Film.mean, Film.counts, Film.error, Film.variance, lambda f: f.extra(0, 1)):
        ours, truth = np.asarray(told(small)), np.asarray(told(plain))
        assert ours.dtype == truth.dtype
        assert ours.tobytes() == truth.tobytes()


def _composed(means):
    return means[:4] + means[2:6] / 3
