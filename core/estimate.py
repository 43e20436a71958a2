# SPDX-License-Identifier: GPL-3.0-or-later
"""The error of a picture from its own samples.

A pixel's first n samples are a net of Sobol points, and so are the first and the second half of them. Let v(n) be the
variance of the mean of n. As both halves are made alike::

    E (mean of n/2 - mean of n)² = v(n/2) - v(n)

whatever the correlation between the halves: the difference tells what the last doubling gained. What remains is what
all further doublings would gain. Each gains r times what the one before did (1/2 for independent samples, less for
balanced ones)::

    v(n) = (v(n/2) - v(n)) (r + r² + r³ + ...) = (v(n/2) - v(n)) r / (1 - r)

r is told by a line through the logarithms of all gains seen. How, was chosen by measurement: docs/error.md.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .neighbours import neighbours_mean
from .report.error import FLOOR, trimmed_mean

_USUAL_RATIO = 0.46  # sample scenes have 0.40 to 0.5
_DRAWN = 0.25  # of the way to the line that a gain is drawn
_LEAST_RATIO, _INDEPENDENT = 0.1, 0.5
_REACH = 2  # pixels to each side that tell how bright a noisy one is
_LEAST_SQUARE = 1e-200  # of a brightness: below float32's, and its inverse times any variance is finite


class Doublings(NamedTuple):
    """What doublings of the samples gain.

    Attributes
    ----------
    ratio : float
        r: of a gain to the one before.
    level : float
        What the last gain should have been, over what it was.
    """

    ratio: float = _USUAL_RATIO
    level: float = 1.0


def doublings(gains):
    """What is to be expected after these gains, the oldest first.

    Their logarithms lie about a line. Its slope tells the ratio, which is drawn to the usual one as long as few gains
    were seen, and is never above that of independent samples: gains that do not fall are those of fireflies that come
    to new pixels, which ends. The last gain is drawn to the line: Sobol points are in better balance at every other
    power of two, so gains alternate.
    """
    if len(gains) < 2 or min(gains) <= 0:
        return Doublings()
    seen = np.log2(gains)
    slope, first = np.polynomial.polynomial.polyfit(np.arange(seen.size), seen, 1)[::-1]
    ratio = 2.0 ** min(max(slope, math.log2(_LEAST_RATIO)), math.log2(_INDEPENDENT))
    trust = 1 - 2 / (seen.size + 1)
    drawn = _DRAWN * (first + slope * (seen.size - 1) - seen[-1])
    return Doublings(trust * ratio + (1 - trust) * _USUAL_RATIO, 2.0 ** min(max(drawn, -1.0), 1.0))


def half_of(count):
    """The largest power of two below `count`, at least 1."""
    return 1 << max(count - 1, 1).bit_length() - 1


def remaining(count, ratio):
    """v(n) in units of what a doubling gained: that to n where `count` n is a power of two, else to `half_of(n)`."""
    if count < 2:
        return math.inf
    known = count if count & (count - 1) == 0 else half_of(count)
    return ratio / (1 - ratio) * _variance(count, ratio) / _variance(known, ratio)


def shares(count, ratio):
    """Weights of two estimates of what the doubling to m = `half_of(n)` gained, where `count` n is no power of two.

    Of what it did gain, and of the square of what the samples since then changed. Their mean is one of n - m samples
    that lie where the m would be doubled (`_variance`), so it is known what this should be::

        E (mean of m - mean of n)² = (1 - m/n)² (v(m) + v(n - m) - 2 (2 r - 1) v(m))

    The second weighs as much as the doubling to 2m is done. Fireflies that came since m are seen by it alone.
    """
    half = half_of(count)
    done = count / half - 1
    known = _variance(half, ratio)
    gained = known / ratio - known
    change = (1 - half / count) ** 2 * ((3 - 4 * ratio) * known + _variance(count - half, ratio))
    return 1 - done, done * gained / change


def _variance(count, ratio):
    """v(n) in units of v(1).

    The mean of n is one of nets of falling sizes b₁ + b₂ + ... = n, each of which lies where the net before it would be
    doubled, so that the two have the covariance 2 v(2b) - v(b)::

        n² v(n) = Σ b² v(b) + 2 Σ b (b' + b'' + ...) (2 v(2b) - v(b)),    v(2b) = r v(b)
    """
    total, rest = 0.0, count
    while rest:
        net = 1 << rest.bit_length() - 1
        rest -= net
        total += (net * net + 2 * net * rest * (2 * ratio - 1)) * ratio ** math.log2(net)
    return total / count**2


def noisy_weights(picture, noise, mean_square):
    """As `report.error.weights`, (P,), from a part of a picture that has noise.

    A pixel is taken to be as bright as its neighbours say, as far as its noise explains why it differs from them: what
    makes a firefly err must not make it bright, or its relative error would look small.

    Parameters
    ----------
    picture : (3, H, W) or (3, H, W, K) float64
        One block of pixels, or several of one size.
    noise : (H, W) or (H, W, K) float64
        What a doubling of its samples changed in each pixel, squared and summed over the channels.
    mean_square : float
        Of the whole picture, as the floor wants it.
    """
    means = [neighbours_mean(channel, _REACH) for channel in picture]
    apart = sum(np.square(own - mean) for own, mean in zip(picture, means, strict=True))
    # The quotient stays below 1.
    keep = 1 - np.minimum(noise, apart) / np.maximum(apart, np.finfo(np.float64).tiny)
    square = sum(np.square(mean + keep * (own - mean)) for own, mean in zip(picture, means, strict=True))
    return 1 / np.maximum(square.ravel() + FLOOR**2 * mean_square, _LEAST_SQUARE)


def relative_error(variance, weight):
    """Estimate of `report.error.relative_rmse`."""
    return math.sqrt(trimmed_mean(variance * weight))


def of_counts(counts, function):
    """`function` of each count (P,) of samples, asked once for each value; (P, ...) as it returns."""
    asked = np.flatnonzero(np.bincount(counts))
    found = np.array([function(int(count)) for count in asked])
    values = np.zeros((asked[-1] + 1, *found.shape[1:]))
    values[asked] = found
    return values[counts]


def is_doubled(counts):
    """Whether counts (P,) of samples are powers of two above 1."""
    return (counts > 1) & (counts & (counts - 1) == 0)
