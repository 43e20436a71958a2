# SPDX-License-Identifier: GPL-3.0-or-later
"""The error of a picture from its own samples.

A pixel's first n samples are a net of Sobol points, and so are the first and the second half of them. Let v(n) be the
variance of the mean of n. As both halves are made alike::

    E (mean of n/2 - mean of n)² = v(n/2) - v(n)

whatever the correlation between the halves: the difference tells what the last doubling gained. What remains is what
all further doublings would gain. Each gains r times what the one before did (1/2 for independent samples, less for
balanced ones)::

    v(n) = (v(n/2) - v(n)) (r + r² + r³ + ...) = (v(n/2) - v(n)) r / (1 - r)

How r is told from the last three gains, `ratio_of`, was chosen by measurement: docs/error.md.
"""

from __future__ import annotations

import math

import numpy as np

from .neighbours import neighbours_mean
from .report.error import FLOOR, trimmed_mean

UNSEEN_RATIO = 0.45
"""r before two doublings were seen; sample scenes have 0.40 to 0.5 between 1 and 8 samples."""

_INDEPENDENT = 0.5
_LEAST_RATIO = 0.1
_BARELY = 1e-9  # of a gain that another is compared with: its square and its inverse are finite
_UNSEEN_SQUARE = 0.21  # of r, before three doublings were seen
_SPREADING = 0.3, 0.4  # what the square of r is above where fireflies still come to new pixels
_REACH = 2  # pixels to each side that tell how bright a noisy one is
_LEAST_SQUARE = 1e-200  # of a brightness: below float32's, and its inverse times any variance is finite


def ratio_of(last, before, oldest=None):
    """How doublings compare, from what the last three gained, the latest first; `oldest` None where there were but two.

    Two answers are averaged. One compares the last gain with the one before, and goes halfway to independence, to
    which samples tend as they get many. The other compares the last with the oldest, and adds up two gains at a time:
    in two dimensions Sobol points are in better balance at every other power of two, so gains alternate. It is not
    asked where gains do not fall: the trimmed error stands still while fireflies come to new pixels.
    """
    if not (last > 0 and before > 0):
        return UNSEEN_RATIO
    seen = min(max(last / before, _BARELY), 1 / _BARELY)
    ratio = (min(max(seen, _LEAST_RATIO), _INDEPENDENT) + _INDEPENDENT) / 2
    square = last / oldest if oldest else _UNSEEN_SQUARE
    falls = min(max((_SPREADING[1] - (square if oldest else seen**2)) / (_SPREADING[1] - _SPREADING[0]), 0.0), 1.0)
    square = min(max(square, _LEAST_RATIO**2), _INDEPENDENT**2)
    by_one, by_two = ratio / (1 - ratio), (1 + 1 / seen) * square / (1 - square)
    remains = min(by_one ** (1 - falls / 2) * by_two ** (falls / 2), 1.0)
    return remains / (1 + remains)


def half_of(count):
    """The largest power of two below `count`, at least 1."""
    return 1 << max(count - 1, 1).bit_length() - 1


def remaining(count, ratio):
    """v(n) in units of what a doubling gained.

    Of the doubling to n where `count` n is a power of two, else of that to m = `half_of(n)`. Such a mean is one of
    nets of falling sizes b₁ + b₂ + ... = n, each of which lies where the net before it would be doubled, so that the
    two have the covariance 2 v(2b) - v(b)::

        n² v(n) = Σ b² v(b) + 2 Σ b (b' + b'' + ...) (2 v(2b) - v(b)),    v(2b) = r v(b)
    """
    if count < 2:
        return math.inf
    half = half_of(count)
    own = ratio / (1 - ratio)
    if count == 2 * half:
        return own
    total, rest = 0.0, count
    while rest:
        net = 1 << rest.bit_length() - 1
        rest -= net
        total += (net * net + 2 * net * rest * (2 * ratio - 1)) * ratio ** math.log2(net / half)
    return own * total / count**2


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
