# SPDX-License-Identifier: GPL-3.0-or-later
"""Which pixels need more samples than others.

With σ the noise of one sample and R the radiance of a pixel, n samples leave the relative error σ/(R √n). The sum of
its squares is least, for the same number of samples in all, where n is proportional to σ/R. A pixel's share is told by
its neighbours and never by its own samples: a pixel that stops when its own samples happen to agree would be biased.
"""

from __future__ import annotations

import numpy as np

from .neighbours import neighbours_mean
from .sampling.color import luminance

LEAST_SAMPLES = 16  # of every pixel before any is judged
_REACH = 4  # pixels to each side that judge; one estimate is worth little, eighty are worth a lot
_FLOOR = 0.1  # share of the picture's brightness below which darkness asks for no more samples
_LEAST_SHARE, _LARGEST_SHARE = 0.25, 8.0  # of the mean number of samples: no pixel starves, fireflies do not rule


def importance(film):
    """How many samples each pixel of a `Film` deserves, (H·W,) float64 with mean near 1."""
    noise = _around(np.sqrt(film.variance() * film.counts()), film)
    square = _around(np.square(luminance(film.mean())), film)
    share = noise / np.sqrt(square + max(_FLOOR**2 * float(square.mean()), np.finfo(np.float64).tiny))
    for _ in range(4):  # limiting moves the mean
        mean = float(share.mean())
        share = np.clip(share / mean, _LEAST_SHARE, _LARGEST_SHARE) if mean > 0 else np.ones_like(share)
    return share.reshape(-1)


def targets(counts, share, samples):
    """Samples that each pixel has after the next pass, (P,) int32; none less than in `counts`.

    Parameters
    ----------
    counts : (P,) int
        Samples so far.
    share : (P,) float
        Of `importance`.
    samples : int
        Mean over all pixels to be reached, from below.
    """
    low, high = 0.0, 2.0 * samples
    for _ in range(24):
        middle = 0.5 * (low + high)
        fits = np.maximum(counts, _balanced(middle * share)).mean() <= samples
        low, high = (middle, high) if fits else (low, middle)
    return np.maximum(counts, _balanced(low * share)).astype(np.int32)


def _balanced(samples):
    """The nearest of 2, 3, 4, 6, 8, 12, ... below: Sobol points are balanced there, and pixels fall in few groups."""
    power = np.exp2(np.floor(np.log2(np.maximum(samples, 2))))
    return np.where(samples >= 1.5 * power, 1.5 * power, power)


def _around(values, film):
    """Mean of every pixel's neighbours, (H, W), without the pixel itself."""
    return neighbours_mean(values.reshape(film.height, film.width), _REACH)
