# SPDX-License-Identifier: GPL-3.0-or-later
"""The order in which pixels are traced: square after square.

Rays of neighbours meet the same things. The squares are dealt like cards: any piece of the order holds some of
everywhere, so that pieces of equal size take workers about equally long.
"""

from __future__ import annotations

from functools import cached_property
from itertools import pairwise

import numpy as np

_LARGEST = 256  # pixels along a square's side; whole squares are worked out


class TileOrder:
    """Which pixel of a region is traced when.

    It is worked out for the pixels that are asked for, by those who trace them, and takes no memory before. Asked with
    a slice or with numbers in the order of tracing (P,), it gives these pixels' places in the region,
    ``y * width + x``, int32.

    Parameters
    ----------
    region : tuple of int
        x0, y0, x1, y1 in the frame.
    width : int
        Of the frame.
    side : int
        Of a square, at most; all have nearly equal sides, of no more than 256.
    """

    def __init__(self, region, width, side):
        x0, y0, x1, y1 = region
        self._corner, self._widths = (x0, y0), (x1 - x0, width)
        self.size, side = (x1 - x0) * (y1 - y0), min(side, _LARGEST)
        columns, rows = (np.array(ranges(n, -(-n // side)), np.int32) for n in (x1 - x0, y1 - y0))
        row, column = np.divmod(_dealt(len(rows) * len(columns)), len(columns))
        self._shapes = np.stack([np.diff(rows)[row, 0], np.diff(columns)[column, 0]])
        self._first = rows[row, 0] * np.int32(x1 - x0) + columns[column, 0]
        self._ends = np.concatenate([[0], np.cumsum(self._shapes.prod(axis=0))])

    def __getitem__(self, where):
        if not isinstance(where, slice):
            return self._all[where]
        start, stop, _ = where.indices(self.size)
        first, last = np.searchsorted(self._ends, (start, stop - 1), side="right") - (1, 0)
        heights, widths = self._shapes[:, first:last]
        lines = np.repeat(self._first[first:last], heights) + _counted(0, heights) * np.int32(self._widths[0])
        places = _counted(lines, np.repeat(widths, heights))
        return places[start - self._ends[first] : stop - self._ends[first]]

    def pixels(self, where):
        """Numbers of the same pixels in the frame."""
        places, (x0, y0), (own, width) = self[where], self._corner, self._widths
        if own == width:
            return places + np.int32(y0 * width) if y0 else places
        y, x = np.divmod(places, np.int32(own))
        return (y + np.int32(y0)) * np.int32(width) + x + np.int32(x0)

    @cached_property
    def _all(self):
        return self[:]


def _counted(starts, counts):
    """`counts` (R,) numbers each, counted from `starts`, one run after the other, int32."""
    ends = np.cumsum(counts, dtype=np.int32)
    numbers = np.repeat(starts - (ends - counts), counts)
    numbers += np.arange(ends[-1], dtype=np.int32)
    return numbers


def _dealt(count):
    """The numbers below `count` by their bits reversed, the even before the odd and so on."""
    numbers = np.zeros(1, np.int32)
    while numbers.size < count:
        numbers = np.concatenate([2 * numbers, 2 * numbers + 1])
    return numbers[numbers < count]


def ranges(count, number):
    """`count` things in at most `number` ranges of nearly equal size: [(start, stop)]."""
    edges = [count * k // number for k in range(number + 1)]
    return [(a, b) for a, b in pairwise(edges) if b > a]
