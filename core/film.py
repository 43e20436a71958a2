# SPDX-License-Identifier: GPL-3.0-or-later
"""Where samples are summed: the mean picture and how large its error is.

Sums are float64: a million samples of one value keep their mean.
"""

from __future__ import annotations

from threading import Lock

import numpy as np

from .sampling.color import luminance


class Film:
    """Sums of a region of pixels.

    Parameters
    ----------
    width, height : int
        Of the region.
    alpha : bool
        Whether samples carry a fourth channel; else alpha is 1.
    """

    def __init__(self, width, height, alpha=False):
        self.width, self.height = width, height
        self.samples = 0
        # Two half pictures, whose difference tells the error of their mean.
        self._lock = Lock()
        self._sums = np.zeros((2, 4 if alpha else 3, height * width))
        self._counts = np.zeros((2, height * width), np.int32)
        self.nonfinite = 0
        self.stats = {}

    def add(self, pixels, radiance, samples):
        """Add samples of pixels, in the order of their numbers.

        Parameters
        ----------
        pixels : (P,) int
            Numbers in the region, unique.
        radiance : (C, len(samples) · P) float32
            One block of P lanes for each sample.
        samples : sequence of int
            Sample numbers, ascending.

        Returns
        -------
        int
            Non-finite lanes, which were set to zero.
        """
        bad = np.flatnonzero(~np.isfinite(radiance).all(axis=0))
        if bad.size:
            radiance[:, bad] = 0
        for half in (0, 1):
            numbers = [k for k, sample in enumerate(samples) if sample.bit_count() & 1 == half]
            if numbers:
                with self._lock:
                    self._add_half(half, pixels, radiance, numbers)
        return bad.size

    def _add_half(self, half, pixels, radiance, numbers):
        for channel, rows in zip(self._sums[half], radiance, strict=True):
            total = channel[pixels]
            for k in numbers:  # one after the other, so that the chunk's size changes no bit
                total += rows[k * pixels.size : (k + 1) * pixels.size]
            channel[pixels] = total
        self._counts[half][pixels] += len(numbers)

    def mean(self):
        """Mean radiance (C, H·W) float64, 0 where no sample fell. May be asked while workers add."""
        with self._lock:
            return self._sums.sum(axis=0) / np.maximum(self._counts.sum(axis=0), 1)

    def counts(self):
        """Samples of each pixel, (H·W,) int32."""
        with self._lock:
            return self._counts.sum(axis=0)

    def image(self):
        """The picture, (H, W, 4) float32, row 0 at the bottom, linear, alpha premultiplied."""
        out = np.ones((self.height * self.width, 4), np.float32)
        mean = self.mean()
        out[:, : mean.shape[0]] = mean.T
        return out.reshape(self.height, self.width, 4)

    def pixel_error(self):
        """Estimated standard error (H, W) of each pixel's luminance; infinite where a half has no sample."""
        with self._lock:
            a, b = (luminance(s) / np.maximum(n, 1) for s, n in zip(self._sums, self._counts, strict=True))
            unknown = np.min(self._counts, axis=0) == 0
        error = np.abs(a - b) / 2
        error[unknown] = np.inf
        return error.reshape(self.height, self.width)

    def error(self):
        """Estimated relative RMSE: root mean square of the pixels' errors over the picture's mean luminance.

        Infinite before both halves hold a sample; 0 for a black picture without error.
        """
        error = self.pixel_error()
        if not np.isfinite(error).all():
            return float("inf")
        rmse = float(np.sqrt(np.mean(error**2)))
        level = float(np.mean(luminance(self.mean())))
        return rmse / level if level > 0 else (0.0 if rmse == 0 else float("inf"))
