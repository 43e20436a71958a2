# SPDX-License-Identifier: GPL-3.0-or-later
"""Where samples are summed: the mean picture and how large its error is.

Sums are float64: a million samples of one value keep their mean; one sample alone is float32. Beside them stand the
means at the last powers of two of samples, from which the error is told (`core.estimate`). All stand in the order in
which pixels are traced, so that a task adds to one piece of memory.
"""

from __future__ import annotations

import math
from functools import cached_property, partial
from threading import Lock
from typing import NamedTuple

import numpy as np

from . import estimate
from .arena import zeros_on_demand
from .neighbours import box
from .pixel_set import BLOCK, BLOCKS, PixelSet, spread
from .report.error import weights
from .sampling.color import luminance

_PART = 1 << 16  # pixels
_FLOOR_STRIDE = 5  # of the pixels that tell how bright a picture is; odd, so that it meets every column of a tile
_REACH = 2  # pixels to each side that share their errors' squares
_SMALL = 1 << 18  # pixels up to which a picture keeps the marks of all
_GRID = 1 << 17  # pixels, at most, of a larger one's grid

INTERVAL_95 = 2.06
"""A pixel's mean ± this many `pixel_error` holds the truth in 95% of pixels: Student's t of 25 pixels' squares."""


class Step(NamedTuple):
    """What a film was after a pass: samples of a pixel, seconds since the start, estimated relative error."""

    samples: float
    seconds: float
    error: float


class Film:
    """Sums of a region of pixels.

    Parameters
    ----------
    width, height : int
        Of the region.
    alpha : bool
        Whether samples carry a fourth channel; else alpha is 1.
    places : (H·W,) int or TileOrder, optional
        Which pixel of the region, ``y * width + x``, is traced when; None is in this order.
    extra : int
        Further channels of a sample, which are no part of the picture.
    behind, compose : int, callable
        Channels between these, and what makes the picture of them: as of `core.methods.wavefront.Wavefront`.
    pixel_errors : bool
        Whether the error of every pixel can be asked for. Else a large picture keeps what is needed for the whole's,
        and of every `error_step`-th pixel of every `error_step`-th row, at a tenth of the memory.
    most : int, optional
        The most samples that a pixel gets, where that is known. Few take less memory: bytes count up to 255, and
        float32 holds the sums of one as well.
    shared : bool
        Whether processes that are forked later may add to it, after `share`.

    Attributes
    ----------
    samples : int
        Of every pixel, after the last whole pass.
    error_step : int
        Distance of the pixels whose own error can be told.
    history : list of Step
        After each pass.
    stats : dict
    """

    def __init__(
        self,
        width,
        height,
        alpha=False,
        places=None,
        extra=0,
        behind=0,
        compose=None,
        pixel_errors=True,
        most=None,
        shared=False,
    ):
        self.width, self.height = width, height
        self.samples = 0
        self._lock = Lock()
        self._zeros = partial(zeros_on_demand, shared=shared)
        total = height * width
        self._places = places
        self._channels = 4 if alpha else 3
        self._behind, self._compose = behind, compose
        self._sums = self._zeros((self._channels + behind + extra, total), np.float32 if most == 1 else np.float64)
        self.error_step = 1 if pixel_errors or total <= _SMALL else math.ceil(math.sqrt(total / _GRID))
        self._counts = self._zeros((total,), np.min_scalar_type(most) if most and most < 1 << 16 else np.int32)
        self._gains_seen = {}  # of the whole picture, by the doubled number of samples
        self._doublings = None  # of `estimate`, once they were seen
        self.nonfinite = 0
        self.history = []
        self.stats = {}

    @cached_property
    def _order(self):
        """Where each pixel of the region stands in the order of tracing, found while that goes on."""
        order = np.arange(self.height * self.width, dtype=np.int32)
        if self._places is not None:
            for part in _parts(order.size):  # numpy copies the index, at twice its size
                order[self._places[part]] = np.arange(part.start, part.stop, dtype=np.int32)
        return order

    def share(self, lock):
        """Let processes that are forked after this add, each while it holds `lock`."""
        self._lock = lock
        _ = self._marks, self._eighths  # which forks must not make each for itself

    def unshare(self):
        """Forget that lock, which a process that has ended may hold."""
        self._lock = Lock()

    def add(self, where, radiance, samples):
        """Add samples of pixels, in the order of their numbers.

        Parameters
        ----------
        where : slice or (P,) int
            Which pixels, by their numbers in the order of tracing; unique.
        radiance : (C, P · len(samples)) float32
            A pixel's samples follow one another.
        samples : sequence of int
            Sample numbers, ascending; each pixel's follow one another from 0.

        Returns
        -------
        int
            Non-finite lanes, which were set to zero.
        """
        finite = np.isfinite(radiance)
        bad = np.zeros(0, np.intp) if finite.all() else np.flatnonzero(~finite.all(axis=0))
        radiance[:, bad] = 0
        marked = {k: number for k, number in enumerate(samples) if number and number & (number - 1) == 0}
        with self._lock:
            # Block after block, so that the chunk's size changes no bit.
            for channel, rows in enumerate(radiance):
                own = self._sums[channel][where]
                for k, block in enumerate(rows.reshape(-1, len(samples)).T):
                    if k in marked and channel < 3:
                        self._mark(channel, where, marked[k], own)
                    own += block
                if not isinstance(where, slice):  # of a slice, `own` is a view
                    self._sums[channel][where] = own
            self._counts[where] += len(samples)
        return bad.size

    def _mark(self, channel, where, number, sums):
        half, quarter = self._marks[:, channel]
        rows, own = self._marked.among(where)
        if number >= 4:  # before, there is nothing to move
            older, judged = self._judged.among(where)
            self._eighths[channel, older] = quarter[rows] if self._judged is self._marked else quarter[where][judged]
        if number >= 2:
            quarter[rows] = half[rows]
        half[rows] = sums[own] / number

    @cached_property
    def _blocks(self):
        """Pixels that tell the error, as of `spread`, by their numbers in the order of tracing."""
        return spread(self._order.reshape(self.height, self.width))

    @cached_property
    def _grid(self):
        """Pixels at even distances, by their numbers in the order of tracing; None where all keep their marks."""
        step = self.error_step
        return None if step == 1 else np.sort(self._order.reshape(self.height, self.width)[::step, ::step], axis=None)

    @cached_property
    def _marked(self):
        """`PixelSet` of pixels whose means at the last powers of two are kept."""
        return PixelSet(None if self._grid is None else np.union1d(self._blocks, self._grid))

    @cached_property
    def _judged(self):
        """`PixelSet` of pixels of which the oldest of these is: of others nobody asks for it."""
        if self._grid is not None:
            return self._marked
        return PixelSet(None if self._blocks.size == self._order.size else np.unique(self._blocks))

    @cached_property
    def _marks(self):
        """The mean colour of the first n/2 and n/4 samples, n the power of two that a pixel fills."""
        return self._zeros((2, 3, self._marked.count(self._order.size)), np.float32)

    @cached_property
    def _eighths(self):
        """That of the first n/8."""
        return self._zeros((3, self._judged.count(self._order.size)), np.float32)

    def mean(self):
        """Mean radiance (C, H·W) float64, 0 where no sample fell. May be asked while workers add."""
        with self._lock:
            return _means(self._sums[: self._channels], self._counts)[:, self._order]

    def extra(self, first, stop):
        """Means of the further channels `first` to `stop`, (stop - first, H·W) float32."""
        with self._lock:
            start = self._channels + self._behind
            sums = self._sums[start + first : start + stop]
            return _means(sums, self._counts)[:, self._order].astype(np.float32)

    def counts(self):
        """Samples of each pixel, (H·W,) int32."""
        with self._lock:
            return self._counts[self._order].astype(np.int32, copy=False)

    def image(self, rows=slice(None)):
        """The picture, (H, W, 4) float32, row 0 at the bottom, linear, alpha premultiplied; or some `rows` of it."""
        order = self._order.reshape(self.height, self.width)[rows].reshape(-1)
        out = np.ones((order.size, 4), np.float32)
        for part in _parts(order.size):
            pixels = order[part]
            with self._lock:
                sums = self._sums[: self._channels + self._behind, pixels]
                means = _means(sums, self._counts[pixels])
            out[part, : self._channels] = (means if self._compose is None else self._compose(means)).T
        return out.reshape(-1, self.width, 4)

    # -- the error -----------------------------------------------------------------------------------------------------

    def error(self):
        """Estimate of the picture's relative RMSE as `core.report.error` measures it.

        Infinite before every pixel has two samples; 0 for a black picture without error. Large pictures are judged by
        small blocks spread over them.
        """
        with self._lock:
            if self._counts.min() < 2:
                return math.inf
        picture, gains, counts = self._gains(_colour, self._blocks.ravel())
        shape = self._blocks.shape
        weight = estimate.noisy_weights(picture.reshape(3, *shape), gains[0].reshape(shape), self._mean_square())
        self._see_doublings(gains, weight, counts)
        return estimate.relative_error(gains[0] * self._remaining(counts), weight)

    def _mean_square(self):
        """Mean over the picture of |R|², by two independent means of each pixel, so that noise adds nothing.

        More pixels tell it than are judged: a small bright lamp may rule it.
        """
        some = self._grid
        if some is None:
            some = slice(None, None, _FLOOR_STRIDE if self._order.size > _FLOOR_STRIDE * BLOCK**2 * BLOCKS else 1)
        with self._lock:
            if isinstance(some, slice):
                counts, sums, first = self._counts[some], self._sums[:3, some], self._marks[0][:, some]
            else:
                counts, sums = self._counts.take(some), self._sums[:3].take(some, axis=1)
                first = self._marks[0].take(self._marked.rows(some), axis=1)
            halves = estimate.of_counts(counts, estimate.half_of)
            second = (sums - halves * first) / (counts - halves)
            return max(0.0, float(np.vdot(first, second)) / counts.size)

    def variance(self):
        """Estimated variance (H·W,) of each pixel's luminance from its own samples alone; infinite below two.

        One pixel's says little; on the mean over many it is right.

        Raises
        ------
        ValueError
            If the film does not keep every pixel's (`error_step`).
        """
        self._check_step(1)
        return self._variance(self._order)

    def pixel_error(self):
        """Estimated standard error (H, W) of each pixel's luminance; infinite below two samples.

        The root of the mean variance of 5 × 5 pixels. See `INTERVAL_95`.
        """
        return _standard_error(self.variance().reshape(self.height, self.width))

    def relative_pixel_error(self, step=1):
        """`pixel_error` over the luminance, of every `step`-th pixel of every `step`-th row as if there were no others.

        (⌈H/step⌉, ⌈W/step⌉); 0 below two samples, and a floor below the luminance as in `core.report.error`.

        Raises
        ------
        ValueError
            If `step` is no multiple of `error_step`.
        """
        self._check_step(step)
        pixels = self._order.reshape(self.height, self.width)[::step, ::step]
        with self._lock:
            bright = luminance(self._sums[:3].take(pixels, axis=1)) / np.maximum(self._counts.take(pixels), 1)
        error = _standard_error(self._variance(pixels.ravel()).reshape(pixels.shape))
        return np.where(np.isfinite(error), error, 0.0) * np.sqrt(weights(bright[..., None]))

    def _check_step(self, step):
        if step % self.error_step:
            told = f"every {self.error_step}th pixel of every {self.error_step}th row"
            raise ValueError(f"the film tells the error of {told} alone; make it with pixel_errors=True")

    def _variance(self, pixels):
        """`variance` of `pixels` (P,), by their numbers in the order of tracing."""
        if self._doublings is None:
            self.error()
        out = np.zeros(pixels.size)
        for part in _parts(pixels.size):
            _, gains, counts = self._gains(_luminance, pixels[part], oldest=False)
            out[part] = np.where(counts < 2, np.inf, gains[0] * self._remaining(counts))
        return out

    def _gains(self, squares, pixels, oldest=True):
        """What the last doublings of the samples of `pixels` (P,) gained, by one sample each.

        Parameters
        ----------
        squares : callable
            From a difference of colours (3, P) to its square (P,).
        pixels : (P,) int
            By their numbers in the order of tracing.
        oldest : bool
            Whether the oldest gain is asked for, which is known of pixels by which the error is judged; else it is 0.

        Returns
        -------
        picture : (3, P) float64
        gains : (3, P) float64
            The latest first: that of the doubling which `estimate.remaining` names.
        counts : (P,) int32
        """
        with self._lock:  # `take` is three times as fast as an index
            counts = self._counts.take(pixels)
            picture = self._sums[:3].take(pixels, axis=1)
            half, quarter = self._marks.take(self._marked.rows(pixels), axis=2)
            eighth = self._eighths.take(self._judged.rows(pixels), axis=1) if oldest else quarter
        picture /= np.maximum(counts, 1)
        gains = np.zeros((4, pixels.size))
        for gain, first, second in zip(gains, (half, quarter, eighth), (picture, half, quarter), strict=False):
            gain[:] = squares(np.subtract(first, second, dtype=np.float64))
        return picture, np.where(estimate.is_doubled(counts), gains[:3], self._between(gains, counts)), counts

    def _between(self, gains, counts):
        """The last gains (3, P) of pixels between two doublings, of what has changed since and the gains before."""
        ratio = (self._doublings or estimate.Doublings()).ratio
        known, changed = estimate.of_counts(counts, lambda n: estimate.shares(n, ratio) if n > 1 else (0, 0)).T
        return np.stack((changed * gains[0] + known * gains[1], gains[2], gains[3]))

    def _see_doublings(self, gains, weight, counts):
        """Learn what doublings gain from the pixels that have just completed one, where they are many."""
        known, several = np.flatnonzero(estimate.is_doubled(counts) & (counts >= 4)), True
        if known.size == counts.size:
            known = slice(None)
        elif 4 * known.size < counts.size:
            if self._doublings is not None or counts.min() < 5:
                return
            known, several = slice(None), False  # between two doublings, of which none was seen
        least, most = counts[known].min(), counts[known].max()
        means = [estimate.trimmed_mean(gain[known] * weight[known]) for gain in gains]
        means = means if several and least >= 8 else means[:2]
        if several and least == most:
            self._gains_seen.update((int(most) >> k, mean) for k, mean in enumerate(means))
            means = [self._gains_seen[count] for count in sorted(self._gains_seen, reverse=True)]
        self._doublings = estimate.doublings(means[::-1])

    def _remaining(self, counts):
        """`estimate.remaining` of each pixel, 0 below two samples."""
        ratio, level = self._doublings or estimate.Doublings()
        return estimate.of_counts(counts, lambda count: level * estimate.remaining(count, ratio) if count > 1 else 0.0)


def _parts(total):
    """Slices of `total` pixels, so that what is computed from them stays small."""
    return [slice(start, min(start + _PART, total)) for start in range(0, total, _PART)]


def _means(sums, counts):
    return np.divide(sums, np.maximum(counts, 1), dtype=np.float64)


def _standard_error(variance):
    """Root of the mean `variance` (H, W) of the square around each pixel; infinite where its own is."""
    known = np.isfinite(variance)
    total = box(np.where(known, variance, 0), _REACH) / np.maximum(box(known.astype(np.float64), _REACH), 1)
    return np.where(known, np.sqrt(total), np.inf)


def _colour(difference):
    np.square(difference, out=difference)
    return difference[0] + difference[1] + difference[2]


def _luminance(difference):
    return np.square(luminance(difference))
