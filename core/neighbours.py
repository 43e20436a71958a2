# SPDX-License-Identifier: GPL-3.0-or-later
"""Sums over the square of pixels around each pixel."""

from __future__ import annotations

from functools import lru_cache

import numpy as np


def box(values, reach):
    """Sum of `values` (H, W, ...) over the square of 2 `reach` + 1 pixels around each, as large; outside is 0."""
    return _along_columns(_along_rows(values, reach), reach)


def neighbours_mean(values, reach):
    """Mean of every pixel's neighbours, (H, W, ...), without the pixel itself; its own value where it has none."""
    number = _number(values.shape, reach, values.dtype)
    total = box(values, reach)
    total -= values
    return np.where(number > 0, total / np.maximum(number, 1), values)


@lru_cache(maxsize=2)
def _number(shape, reach, dtype):
    """How many neighbours each pixel has."""
    return box(np.ones(shape, dtype), reach) - 1


def _along_rows(values, reach):
    """Sums along rows. Shifted copies are added: sums of sums would cost digits."""
    total = values.copy()
    for k in range(1, min(reach, values.shape[1] - 1) + 1):
        total[:, k:] += values[:, :-k]
        total[:, :-k] += values[:, k:]
    return total


def _along_columns(values, reach):
    total = values.copy()
    for k in range(1, min(reach, values.shape[0] - 1) + 1):
        total[k:] += values[:-k]
        total[:-k] += values[k:]
    return total
