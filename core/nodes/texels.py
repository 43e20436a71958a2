# SPDX-License-Identifier: GPL-3.0-or-later
"""Pixels of images as tables of texels, and how they are looked up.

Texels stay in the type that they were stored in. All channels of a texel are gathered as one word, and what is made
linear is made so after the lookup. Source: Cycles' kernel (`kernel/device/cpu/image.h`), which interpolates images as
stored, colours times alpha, and does not filter: there are no mip maps, so that a picture is the same in both.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property
from itertools import pairwise

import numpy as np

from ..sampling.color import srgb_to_linear

# One number as wide as a texel of four channels.
_WORDS = {np.uint8: np.uint32, np.uint16: np.uint64, np.float16: np.uint64, np.float32: np.complex128}
_STEPS = 65535  # of the table of linear values; between two of them they differ by less than 4e-5
_ABOVE_ONE = 1 + 1e-4  # colours are, where they are more than their alpha and divided by it
_FAR = 2.0**20  # coordinates beyond it are as good as it


@dataclass(frozen=True, eq=False)
class Texels:
    """A picture.

    Parameters
    ----------
    values : (height · width, C) uint8, uint16, float16 or float32
        Row 0 at the bottom; integers stand for 0 to 1. One channel is a grey without alpha, else there are four.
    width, height : int
    encoded : bool
        Whether colours are stored by the sRGB transfer function.
    straight : bool
        Whether colours may be divided by alpha: not where alpha is a channel like any other.
    """

    values: np.ndarray
    width: int
    height: int
    encoded: bool = False
    straight: bool = True

    @classmethod
    def of(cls, pixels, encoded=False, straight=True):
        """Texels of `pixels` (H, W, 1 or 4), which are not copied where they are contiguous."""
        height, width, channels = pixels.shape
        return cls(np.ascontiguousarray(pixels).reshape(-1, channels), width, height, encoded, straight)

    @property
    def nbytes(self):
        """Memory of the values."""
        return self.values.nbytes

    @cached_property
    def opaque(self):
        """Whether alpha is 1 everywhere."""
        return self.values.shape[1] == 1 or bool((self.values[:, 3] == _one(self.values.dtype)).all())

    @cached_property
    def _words(self):
        dtype = self.values.dtype
        return self.values.view(dtype if self.values.shape[1] == 1 else _WORDS[dtype.type])[:, 0]

    def sample(self, x, y, interpolation, extension, arena, out, unassociate=False):
        """Write scene-linear colours to `out` (3, N), or with alpha (4, N).

        Parameters
        ----------
        x, y : (N,) float32
            Coordinates, in [0, 1] within the picture.
        interpolation : {"Linear", "Closest", "Cubic", "Smart"}
        extension : {"REPEAT", "EXTEND", "CLIP", "MIRROR"}
        unassociate : bool
            Whether colours are divided by alpha; `out` then has four rows.
        """
        grey = self.values.shape[1] == 1
        alpha = len(out) == 4 and not grey and not (self.opaque and extension != "CLIP")
        stored = out[:1] if grey else out[: 4 if alpha else 3]
        with arena.frame():
            self._interpolate(x, y, interpolation, extension, arena, stored)
        if alpha and unassociate and self.straight:
            visible = stored[3] != 0
            for row in stored[:3]:
                np.divide(row, stored[3], out=row, where=visible)
        if self.encoded:
            self._decode(stored[:3], arena)
        if grey:
            out[1:3] = out[0]
        if len(out) == 4 and not alpha:
            out[3].fill(1)

    def averaged(self, columns, rows):
        """The linear picture, without alpha, in at most `columns` × `rows` texels: means of those they stand for."""
        columns, rows = min(columns, self.width), min(rows, self.height)
        values = self.values.reshape(self.height, self.width, -1)
        first = np.arange(rows + 1) * self.height // rows
        start = np.arange(columns) * self.width // columns
        length = np.diff(np.append(start, self.width)).astype(np.float32)[:, None]
        means = np.ones((rows, columns, 4), np.float32)
        for row, (begin, end) in enumerate(pairwise(first.tolist())):
            line = self._linear(values[begin:end]).mean(axis=0)
            means[row, :, :3] = np.add.reduceat(line, start, axis=0) / length
        return Texels.of(means)

    def _interpolate(self, x, y, interpolation, extension, arena, out):
        """Write values as stored, integers divided by their largest, to `out` (C, N)."""
        n = out.shape[-1]
        columns = _taps(x, self.width, interpolation, extension, arena)
        lines = _taps(y, self.height, interpolation, extension, arena)
        gathered = arena.empty(n, self._words.dtype)
        texel = gathered.view(self.values.dtype).reshape(n, -1)
        index, weight, part = arena.empty(n, np.intp), arena.empty(n), arena.empty(n)
        first = True
        for line, wy in lines:
            np.multiply(line, self.width, out=line)
            np.multiply(wy, 1.0 / float(_one(self.values.dtype)), out=wy)
            for column, wx in columns:
                np.add(line, column, out=index)
                np.take(self._words, index, out=gathered, mode="clip")
                np.multiply(wx, wy, out=weight)
                for channel, total in enumerate(out):
                    if first:
                        np.multiply(texel[:, channel], weight, out=total)
                    else:
                        np.multiply(texel[:, channel], weight, out=part)
                        np.add(total, part, out=total)
                first = False

    def _decode(self, rows, arena):
        """Make stored colours linear, in place; by a table unless they may be out of its range."""
        if self.values.dtype.kind == "f" or rows.max(initial=0) > _ABOVE_ONE:
            rows[:] = srgb_to_linear(np.maximum(rows, 0))
            return
        with arena.frame():
            index = arena.empty(rows.shape[-1], np.intp)
            for row in rows:
                np.multiply(row, float(_STEPS), out=row)
                np.add(row, 0.5, out=row)
                np.copyto(index, row, casting="unsafe")
                np.take(_linear_table(_STEPS), index, out=row, mode="clip")

    def _linear(self, values):
        """Linear colours (..., 3) float32 of stored `values` (..., C)."""
        values = values[..., :3]
        if values.dtype.kind == "u" and self.encoded:
            linear = _linear_table(int(_one(values.dtype)))[values]
        else:
            linear = values.astype(np.float32) / np.float32(_one(values.dtype))
            if self.encoded:
                linear = srgb_to_linear(np.maximum(linear, 0))
        return np.broadcast_to(linear, (*linear.shape[:-1], 3))


def _one(dtype):
    """What stands for 1."""
    return np.iinfo(dtype).max if dtype.kind == "u" else 1


@cache
def _linear_table(steps):
    """Linear values of 0 to `steps` equal steps from 0 to 1, stored by the sRGB transfer function."""
    return srgb_to_linear(np.arange(steps + 1, dtype=np.float32) / np.float32(steps))


def _taps(coordinate, size, interpolation, extension, arena):
    """[(texel numbers (N,), weights (N,))] along one axis; texel centres are at half integers."""
    t = np.multiply(_bounded(coordinate, arena), float(size), out=arena.empty(coordinate.size))
    if interpolation == "Closest":
        np.floor(t, out=t)
        return [_tap(t, arena.full(t.size, 1.0), size, extension, arena)]
    np.subtract(t, 0.5, out=t)
    base = np.floor(t, out=arena.empty(t.size))
    np.subtract(t, base, out=t)
    weights = (_linear_weights if interpolation == "Linear" else _cubic_weights)(t, arena)
    shift = 1 - len(weights) // 2
    return [
        _tap(np.add(base, shift + k, out=arena.empty(t.size)), weight, size, extension, arena)
        for k, weight in enumerate(weights)
    ]


def _bounded(coordinate, arena):
    """`coordinate` (N,) without what is no number or too large to be told from its neighbours."""
    if -_FAR < coordinate.min(initial=0) and coordinate.max(initial=0) < _FAR:
        return coordinate
    out = np.fmax(coordinate, -_FAR, out=arena.empty(coordinate.size))
    return np.fmin(out, _FAR, out=out)


def _linear_weights(t, arena):
    return np.subtract(1.0, t, out=arena.empty(t.size)), t


def _cubic_weights(t, arena):
    """Weights of the uniform cubic B-spline at `t` in [0, 1) after the second of four texels, which smooths."""
    polynomials = ((-1 / 6, 0.5, -0.5, 1 / 6), (0.5, -1.0, 0.0, 2 / 3), (-0.5, 0.5, 0.5, 1 / 6), (1 / 6, 0.0, 0.0, 0.0))
    weights = []
    for leading, *others in polynomials:
        value = arena.full(t.size, leading)
        for coefficient in others:
            np.multiply(value, t, out=value)
            np.add(value, coefficient, out=value)
        weights.append(value)
    return weights


def _tap(number, weight, size, extension, arena):
    """Texel number (N,) within the picture of an unbounded one (float32), which is spoilt, and its weight."""
    if extension in ("REPEAT", "MIRROR"):
        period = float(size if extension == "REPEAT" else 2 * size)
        with arena.frame():
            turns = np.divide(number, period, out=arena.empty(number.size))
            np.floor(turns, out=turns)
            np.multiply(turns, period, out=turns)
            np.subtract(number, turns, out=number)
            if extension == "MIRROR":
                np.subtract(2.0 * size - 1.0, number, out=turns)
                np.minimum(number, turns, out=number)
    else:
        if extension == "CLIP":
            np.multiply(weight, (number >= 0) & (number < size), out=weight)
        np.maximum(number, 0.0, out=number)
        np.minimum(number, size - 1.0, out=number)
    index = arena.empty(number.size, np.intp)
    np.copyto(index, number, casting="unsafe")
    return index, weight
