# SPDX-License-Identifier: GPL-3.0-or-later
"""Other errors of a picture, which the literature gives, beside the relative RMSE of `error`; and what an error is of.

The error of a picture is noise, which more samples take away, and bias, which they do not. `noise_and_bias` tells them
apart: two renders of one making differ by noise alone, and in the mean over a block of pixels most noise is gone.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .error import TRIM, block_means, noise, trimmed_mean, weights

BLOCK = 8  # pixels


def relative_mse(picture, reference, epsilon=0.01):
    """Mean of (I - R)² / (R² + `epsilon`) over pixels and channels, (H, W, C) both.

    Source: Rousselle, Knaus and Zwicker, "Adaptive Sampling and Reconstruction using Greedy Error Minimization", 2011,
    section 6.
    """
    picture, reference = np.asarray(picture, np.float64), np.asarray(reference, np.float64)
    return float(np.mean((picture - reference) ** 2 / (reference**2 + epsilon)))


def displayed(picture):
    """Linear colours (H, W, C) as an sRGB screen shows them, float32 in [0, 1]. Source: IEC 61966-2-1."""
    linear = np.clip(np.nan_to_num(np.asarray(picture, np.float32)), 0.0, 1.0)
    bent = 1.055 * np.power(linear, np.float32(1 / 2.4)) - 0.055
    return np.where(linear <= 0.0031308, 12.92 * linear, bent).astype(np.float32)


def psnr(shown, reference):
    """Peak signal-to-noise ratio in dB of pictures in [0, 1] (`displayed`); infinite where they are equal."""
    square = float(np.mean((np.asarray(shown, np.float64) - reference) ** 2))
    return -10.0 * math.log10(square) if square else math.inf


def flip(shown, reference):
    """Mean FLIP of pictures in [0, 1] (`displayed`): 0 looks equal, 1 is as different as can be.

    None where the package flip-evaluator is not installed. Source: Andersson et al., "FLIP: A Difference Evaluator for
    Alternating Images", HPG 2020; the package is its authors' own.
    """
    try:
        from flip_evaluator import evaluate
    except ImportError:
        return None
    return float(evaluate(reference, shown, "LDR", applyMagma=False)[1])


class Parts(NamedTuple):
    """What an error is made of, each a relative RMSE: noise of one picture, and bias of all alike."""

    noise: float
    bias: float


def noise_and_bias(runs, reference, size=BLOCK, trim=TRIM):
    """Tell noise and bias apart.

    Parameters
    ----------
    runs, reference : (R, H, W, C)
        Independent renders, two at least of each; none of one shares random numbers with one of the other.
    size : int
        Side of the blocks. What is wrong about smaller things and right in the mean of a block is not counted as bias.

    Returns
    -------
    Parts
        Bias is 0 where blocks differ by less than their own noise.
    """
    runs, reference = np.asarray(runs, np.float64), np.asarray(reference, np.float64)
    size, weight = min(size, *runs.shape[1:3]), weights(reference.mean(axis=0))
    # Weighted before the mean over a block is taken, so that the bias is at most the error.
    scale = np.sqrt(weight)[..., None]
    (ours, ours_error), (theirs, theirs_error) = block_means(runs * scale, size), block_means(reference * scale, size)
    squares = ((ours - theirs) ** 2 - ours_error**2 - theirs_error**2).sum(axis=-1)
    return Parts(math.sqrt(noise(runs, weight, trim)), math.sqrt(max(0.0, trimmed_mean(squares, trim))))
