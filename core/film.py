# SPDX-License-Identifier: GPL-3.0-or-later
"""Where samples are summed: the mean picture and how large its error is.

Sums are float64: a million samples of one value keep their mean.
"""

from __future__ import annotations

from threading import Lock

import numpy as np

from .sampling.color import luminance

_PART = 1 << 16  # pixels


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
        self._lock = Lock()
        self._sums = np.zeros((4 if alpha else 3, height * width))
        # The luminance of one half of the samples, which tells the error of the mean of both.
        self._half = np.zeros(height * width)
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
        in_half = [sample.bit_count() & 1 == 0 for sample in samples]
        with self._lock:
            for channel, rows in zip(self._sums, radiance, strict=True):
                _accumulate(channel, pixels, rows, [True] * len(in_half))
            _accumulate(self._half, pixels, luminance(radiance), in_half)
            self._counts[0][pixels] += sum(in_half)
            self._counts[1][pixels] += len(in_half) - sum(in_half)
        return bad.size

    def mean(self):
        """Mean radiance (C, H·W) float64, 0 where no sample fell. May be asked while workers add."""
        with self._lock:
            return self._sums / np.maximum(self._counts.sum(axis=0), 1)

    def counts(self):
        """Samples of each pixel, (H·W,) int32."""
        with self._lock:
            return self._counts.sum(axis=0)

    def image(self):
        """The picture, (H, W, 4) float32, row 0 at the bottom, linear, alpha premultiplied."""
        out = np.ones((self.height * self.width, 4), np.float32)
        with self._lock:
            for part in self._parts():
                count = np.maximum(self._counts[:, part].sum(axis=0), 1)
                out[part, : len(self._sums)] = (self._sums[:, part] / count).T
        return out.reshape(self.height, self.width, 4)

    def pixel_error(self):
        """Estimated standard error (H, W) of each pixel's luminance; infinite where a half has no sample."""
        error = np.zeros(self.height * self.width)
        with self._lock:
            for part in self._parts():
                error[part] = self._halves(part)[0]
        return error.reshape(self.height, self.width)

    def error(self):
        """Estimated relative RMSE: root mean square of the pixels' errors over the picture's mean luminance.

        Infinite before both halves hold a sample; 0 for a black picture without error.
        """
        square = level = 0.0
        with self._lock:
            for part in self._parts():
                error, mean = self._halves(part)
                square, level = square + float(np.sum(error**2)), level + float(np.sum(mean))
        count = self.height * self.width
        if not np.isfinite(square):
            return float("inf")
        rmse, level = (square / count) ** 0.5, level / count
        return rmse / level if level > 0 else (0.0 if rmse == 0 else float("inf"))

    def _parts(self):
        """Slices of the pixels, so that what is computed from them stays small."""
        total = self.height * self.width
        return [slice(start, min(start + _PART, total)) for start in range(0, total, _PART)]

    def _halves(self, part):
        """Half the difference of both halves' mean luminance, infinite where one has no sample; and the whole's."""
        counts, whole, half = self._counts[:, part], luminance(self._sums[:, part]), self._half[part]
        one, other = np.maximum(counts, 1)
        error = np.abs(half / one - (whole - half) / other) / 2
        error[np.min(counts, axis=0) == 0] = np.inf
        return error, whole / np.maximum(counts.sum(axis=0), 1)


def _accumulate(total, pixels, rows, chosen):
    """Add the `chosen` blocks of `rows` to `total`, one after the other, so that the chunk's size changes no bit."""
    own = total[pixels]
    for k, is_chosen in enumerate(chosen):
        if is_chosen:
            own += rows[k * pixels.size : (k + 1) * pixels.size]
    total[pixels] = own
