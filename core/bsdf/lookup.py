# SPDX-License-Identifier: GPL-3.0-or-later
"""Interpolation in tables with equal steps from 0 to 1."""

from __future__ import annotations

import numpy as np

from ..limits import within


def bilinear(table, y, x, arena):
    """Bilinear interpolation of K tables (K, rows, columns) at `y` (1,) or (N,), `x` (N,), as a list of K arrays (N,).

    A constant `y` leaves a row of each table; as one lane looks like it, both ways must round alike.
    """
    low, share = cell(y, table.shape[1])
    if low.size == 1:
        row = table[:, low[0]] + (table[:, low[0] + 1] - table[:, low[0]]) * share
        return [linear(values, x, arena) for values in row]
    y = np.broadcast_to(y, x.shape)
    return [multilinear(values, (y, x), arena) for values in table]


def multilinear(table, coordinates, arena):
    """Multilinear interpolation of `table`, contiguous, at one coordinate (N,) for each of its axes, (N,)."""
    count, stride = coordinates[0].size, table.size
    out = arena.empty(count)
    with arena.frame():
        first, shares, corners = arena.zeros(count, np.int32), [], [0]
        for x, size in zip(coordinates, table.shape, strict=True):
            stride //= size
            low, share = arena.empty(count, np.int32), arena.empty(count)
            np.fmax(x, 0.0, out=share)  # NaN counts as 0
            np.fmin(share, 1.0, out=share)
            np.multiply(share, float(size - 1), out=share)
            np.copyto(low, share, casting="unsafe")
            np.minimum(low, np.int32(size - 2), out=low)
            np.subtract(share, low, out=share, casting="unsafe", dtype=np.float32)
            np.multiply(low, np.int32(stride), out=low)
            np.add(first, low, out=first)
            shares.append(share)
            corners = [c + step for c in corners for step in (0, stride)]
        flat = table.reshape(-1)
        values = [np.take(flat[c:], first, out=arena.empty(count), mode="clip") for c in corners]
        for share in shares:  # the first axis' corners are the halves of the list
            half = len(values) // 2
            values = [_between(low, high, share) for low, high in zip(values[:half], values[half:], strict=True)]
        np.copyto(out, values[0])
    return out


def _between(low, high, share):
    """Where `share` lies between both, into `high`."""
    np.subtract(high, low, out=high)
    np.multiply(high, share, out=high)
    return np.add(high, low, out=high)


def linear(values, x, arena):
    """Linear interpolation of `values` (K,) at `x`, clamped to [0, 1], of the shape of `x`."""
    out, last = arena.empty(x.shape), values.size - 1
    with arena.frame():
        t, floor, low = arena.empty(x.shape), arena.empty(x.shape), arena.empty(x.shape, np.intp)
        within(x, 0.0, 1.0, t)
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
