# SPDX-License-Identifier: GPL-3.0-or-later
"""How far pictures are from each other, and how many samples an error takes.

The error of a picture is its relative RMSE with a floor and a trim. With I the picture, R the reference, summed over
the channels of pixel p::

    e²_p = |I_p - R_p|² / (|R_p|² + (0.1 m)²),   m² = mean over pixels of |R_p|²

The floor keeps dark pixels from ruling; without the thousandth of the pixels that err most, a handful of fireflies
does not decide (the untrimmed error is given beside it). The reference's own noise is known from its independent runs
and is subtracted, so that a reference of finite length does not lengthen the error.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

FLOOR = 0.1
TRIM = 1e-3

# -- agreement of two sets of independent renders ----------------------------------------------------------------------


def block_means(runs, size=8):
    """Mean of every `size` × `size` block of pixels, and its standard error.

    Parameters
    ----------
    runs : (R, H, W, C)
        Independent renders, at least two. What does not fill a block is left out.

    Returns
    -------
    mean, error : (H // size, W // size, C) float64
        The error is that of the mean over all runs. Two runs say little about one block, so the variance is averaged
        over the block and its neighbours.
    """
    count, height, width, channels = runs.shape
    rows, columns = height // size, width // size
    whole = runs[:, : rows * size, : columns * size].astype(np.float64)
    blocks = whole.reshape(count, rows, size, columns, size, channels).mean(axis=(2, 4))
    variance = blocks.var(axis=0, ddof=1) / count
    padded = np.pad(variance, ((1, 1), (1, 1), (0, 0)), mode="edge")
    around = [padded[i : i + rows, j : j + columns] for i in range(3) for j in range(3)]
    return blocks.mean(axis=0), np.sqrt(np.mean(around, axis=0))


def misfit(ours, theirs, tolerance=0.02, sigmas=3.0):
    """By how much blocks differ beyond what is allowed, (rows, columns): at most 1 agrees.

    Allowed are `tolerance` of the reference and `sigmas` standard errors of the difference. A block is as good as its
    worst channel; a channel below a thousandth of the picture's mean counts as that bright.
    """
    (a, error_a), (b, error_b) = block_means(ours), block_means(theirs)
    scale = np.maximum(np.abs(b), 1e-3 * b.mean())
    return (np.abs(a - b) / (tolerance * scale + sigmas * np.hypot(error_a, error_b))).max(axis=-1)


def agreement(ours, theirs, tolerance=0.02, sigmas=3.0):
    """Share of blocks that agree, see `misfit`; independent renders of both, (R, H, W, C)."""
    return float((misfit(ours, theirs, tolerance, sigmas) <= 1.0).mean())


def power(ours, theirs, shift=1.05, tolerance=0.02, sigmas=3.0):
    """Share of blocks that would be told apart if ours were `shift` times as bright: what an agreement is worth."""
    return 1.0 - agreement(np.asarray(ours) * shift, theirs, tolerance, sigmas)


# -- error of a picture ------------------------------------------------------------------------------------------------


def weights(reference):
    """What squared differences are multiplied by, (H, W): one over the reference's square, with its floor."""
    square = (np.asarray(reference, np.float64) ** 2).sum(axis=-1)
    return 1.0 / np.maximum(square + FLOOR**2 * square.mean(), np.finfo(np.float64).tiny)


def trimmed_mean(values, trim=TRIM):
    """Mean without the `trim` largest of `values`, a share."""
    values = np.ravel(values)
    kept = max(1, values.size - math.floor(trim * values.size))
    return float(np.partition(values, kept - 1)[:kept].mean(dtype=np.float64))


def noise(runs, weight, trim=TRIM):
    """Mean squared relative error of one of `runs` (R, H, W, C) about their common mean: their variance."""
    return trimmed_mean(np.var(np.asarray(runs, np.float64), axis=0, ddof=1).sum(axis=-1) * weight, trim)


def relative_rmse(picture, runs, weight, trim=TRIM):
    """Relative RMSE of a picture against the mean of independent runs of another making.

    Parameters
    ----------
    picture : (H, W, C)
    runs : (R, H, W, C)
        The reference's runs, at least two; none may share random numbers with the picture.
    weight : (H, W)
        Of `weights`.
    trim : float
        Share of the pixels left out, those that err most.

    Returns
    -------
    float
        0 where the picture differs by less than the reference's own noise.
    """
    runs = np.asarray(runs, np.float64)
    squares = ((picture - runs.mean(axis=0)) ** 2).sum(axis=-1) * weight
    return math.sqrt(max(0.0, trimmed_mean(squares, trim) - noise(runs, weight, trim) / len(runs)))


# -- error over samples and time ---------------------------------------------------------------------------------------


class Line(NamedTuple):
    """``start + each · n`` through measured times, and how straight they stand (R²)."""

    start: float
    each: float
    r2: float

    def at(self, n):
        """Seconds of `n`."""
        return self.start + self.each * n


def line(counts, seconds):
    """Fit a `Line` to times; every point counts by its relative deviation. It starts at 0 where it would fall below.

    So it does where it would not rise, as noisy times of too few samples may not.
    """
    n, t = np.asarray(counts, float), np.asarray(seconds, float)
    each, start = np.polyfit(n, t, 1, w=1 / t)
    if start < 0 or each <= 0:
        each, start = float((n / t).sum() / ((n / t) ** 2).sum()), 0.0
    spread = float(((t - t.mean()) ** 2).sum())
    r2 = 1.0 - float(((t - start - each * n) ** 2).sum()) / spread if spread else 1.0
    return Line(float(start), float(each), r2)


class Reach(NamedTuple):
    """What an error takes: samples of a pixel, seconds, and whether that lies outside of what was measured."""

    samples: float
    seconds: float
    extrapolated: bool


class Convergence:
    """Error and time of a ladder of sample counts.

    Between rungs the error is interpolated on the log-log line from rung to rung. Beyond them it goes on from the
    nearest rung as N^-a, a fitted through the last three rungs and kept within [1/2, 1]: what has a variance converges
    no slower than independent samples in the end, and a few rungs show little of it. Seconds are those of the `Line`
    through the medians.

    Parameters
    ----------
    samples : sequence of int
        Ascending, at least two.
    errors, seconds : sequence of float
        Of each rung, above 0.

    Attributes
    ----------
    slope : float
        a as fitted.
    time : Line
    """

    def __init__(self, samples, errors, seconds):
        if len(samples) < 2 or min(errors) <= 0 or min(seconds) <= 0:
            raise ValueError("a slope takes two rungs at least, with errors and seconds above 0")
        self._n, self._e = np.log(samples), np.log(errors)
        self.slope = -float(np.polyfit(self._n[-3:], self._e[-3:], 1)[0])
        self.time = line(samples, seconds)

    def samples_to(self, error):
        """(Samples of a pixel, whether extrapolated) for a relative RMSE; at least 1."""
        target = math.log(error)
        if target <= self._e[-1]:
            at, outside = len(self._e) - 1, target < self._e[-1]
        elif target >= self._e[0]:
            at, outside = 0, target > self._e[0]
        else:
            below = int(np.argmax(self._e <= target))
            share = (target - self._e[below - 1]) / (self._e[below] - self._e[below - 1])
            return math.exp(self._n[below - 1] + share * (self._n[below] - self._n[below - 1])), False
        slope = min(max(self.slope, 0.5), 1.0)
        return max(1.0, math.exp(self._n[at] - (target - self._e[at]) / slope)), outside

    def reach(self, error):
        """The `Reach` of a relative RMSE."""
        samples, outside = self.samples_to(error)
        return Reach(samples, self.time.at(samples), outside)


def geometric_mean(values):
    """Of positive numbers; None of none."""
    values = [v for v in values if v]
    return math.exp(sum(map(math.log, values)) / len(values)) if values else None
