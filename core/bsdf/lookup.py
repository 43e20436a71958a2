# SPDX-License-Identifier: GPL-3.0-or-later
"""Interpolation in tables with equal steps from 0 to 1."""

from __future__ import annotations

import numpy as np


def bilinear(table, y, x, arena):
    """Bilinear interpolation of K tables (K, rows, columns) at `y` (1,) or (N,), `x` (N,), as a list of K arrays (N,).

    A constant `y` leaves a row of each table.
    """
    rows, columns = table.shape[1:]
    low, share = cell(y, rows)
    if low.size == 1:
        row = table[:, low[0]] + (table[:, low[0] + 1] - table[:, low[0]]) * share
        return [linear(values, x, arena) for values in row]
    column, along = cell(x, columns)
    corner = low * columns + column
    found = []
    for values in table.reshape(len(table), -1):
        near, far = (
            values[corner + step] + (values[corner + step + 1] - values[corner + step]) * along for step in (0, columns)
        )
        found.append(near + (far - near) * share)
    return found


def linear(values, x, arena):
    """Linear interpolation of `values` (K,) at `x`, clamped to [0, 1], of the shape of `x`."""
    out, last = arena.empty(x.shape), values.size - 1
    with arena.frame():
        t, floor, low = arena.empty(x.shape), arena.empty(x.shape), arena.empty(x.shape, np.intp)
        np.clip(x, 0.0, 1.0, out=t)
        np.multiply(t, float(last), out=t)
        np.floor(t, out=floor)
        np.minimum(floor, last - 1.0, out=floor)
        np.subtract(t, floor, out=t)
        np.copyto(low, floor, casting="unsafe")
        np.take(values[1:] - values[:-1], low, out=out, mode="clip")
        np.multiply(out, t, out=out)
        np.take(values, low, out=t, mode="clip")
        np.add(out, t, out=out)
    return out


def cell(x, size):
    """Lower index (int32) and fraction of coordinates `x`, clamped to [0, 1], in a table of `size` entries.

    NaN counts as 0.
    """
    scaled = np.fmin(np.fmax(x, 0.0), 1.0) * np.float32(size - 1)
    low = np.minimum(scaled.astype(np.int32), size - 2)
    return low, scaled - low.astype(np.float32)
