# SPDX-License-Identifier: GPL-3.0-or-later
"""Where samples are summed: the mean picture and how large its error is.

Sums are float64: a million samples of one value keep their mean. They stand in the order in which pixels are traced, so
that a task adds to one piece of memory.
"""

from __future__ import annotations

from threading import Lock

import numpy as np

from .arena import uninitialised
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
    places : (H·W,) int, optional
        Which pixel of the region, ``y * width + x``, is traced when; None is in this order.
    """

    def __init__(self, width, height, alpha=False, places=None):
        self.width, self.height = width, height
        self.samples = 0
        self._lock = Lock()
        self._places = np.arange(height * width) if places is None else places
        self._sums = _zeros((4 if alpha else 3, height * width))
        # The luminance of one half of the samples, which tells the error of the mean of both.
        self._half = _zeros((height * width,))
        self._counts = _zeros((2, height * width), np.int32)
        self.nonfinite = 0
        self.stats = {}

    def add(self, where, radiance, samples):
        """Add samples of pixels, in the order of their numbers.

        Parameters
        ----------
        where : slice or (P,) int
            Which pixels, by their numbers in the order of `places`; unique.
        radiance : (C, len(samples) · P) float32
            One block of P lanes for each sample.
        samples : sequence of int
            Sample numbers, ascending.

        Returns
        -------
        int
            Non-finite lanes, which were set to zero.
        """
        finite = np.isfinite(radiance)
        bad = np.zeros(0, np.intp) if finite.all() else np.flatnonzero(~finite.all(axis=0))
        radiance[:, bad] = 0
        in_half = [sample.bit_count() & 1 == 0 for sample in samples]
        light = luminance(radiance)
        with self._lock:
            for channel, rows in zip(self._sums, radiance, strict=True):
                _accumulate(channel, where, rows, [True] * len(in_half))
            _accumulate(self._half, where, light, in_half)
            self._counts[0][where] += sum(in_half)
            self._counts[1][where] += len(in_half) - sum(in_half)
        return bad.size

    def mean(self):
        """Mean radiance (C, H·W) float64, 0 where no sample fell. May be asked while workers add."""
        with self._lock:
            return self._placed(self._sums / np.maximum(self._counts.sum(axis=0), 1))

    def counts(self):
        """Samples of each pixel, (H·W,) int32."""
        with self._lock:
            return self._placed(self._counts.sum(axis=0, dtype=np.int32))

    def image(self):
        """The picture, (H, W, 4) float32, row 0 at the bottom, linear, alpha premultiplied."""
        out = np.ones((self.height * self.width, 4), np.float32)
        with self._lock:
            for part in self._parts():
                count = np.maximum(self._counts[:, part].sum(axis=0), 1)
                out[self._places[part], : len(self._sums)] = (self._sums[:, part] / count).T
        return out.reshape(self.height, self.width, 4)

    def pixel_error(self):
        """Estimated standard error (H, W) of each pixel's luminance; infinite where a half has no sample."""
        error = np.zeros(self.height * self.width)
        with self._lock:
            for part in self._parts():
                error[part] = self._halves(part)[0]
        return self._placed(error).reshape(self.height, self.width)

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

    def _placed(self, values):
        """Values (..., H·W) of the pixels in the order of the region."""
        out = np.zeros_like(values)
        out[..., self._places] = values
        return out

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


def _accumulate(total, where, rows, chosen):
    """Add the `chosen` blocks of `rows` to `total`, one after the other, so that the chunk's size changes no bit."""
    own = total[where]
    for k, is_chosen in enumerate(chosen):
        if is_chosen:
            own += rows[k * own.size : (k + 1) * own.size]
    if not isinstance(where, slice):  # of a slice, `own` is a view
        total[where] = own


def _zeros(shape, dtype=np.float64):
    """Written at once, for which numpy asks huge pages; `numpy.zeros` would get small ones as it is filled."""
    out = uninitialised(shape, dtype)
    out.fill(0)
    return out
