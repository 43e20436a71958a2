# SPDX-License-Identifier: GPL-3.0-or-later
"""Functions given by equally spaced samples, as Cycles holds colour ramps and curves.

Source: Cycles, `kernel/svm/ramp.h`.
"""

from __future__ import annotations

from weakref import WeakValueDictionary

import numpy as np

_KNOWN = WeakValueDictionary()


class Table:
    """Samples over 0 to 1, one row a channel.

    Parameters
    ----------
    rows : (C, S) float32
        C-contiguous.
    """

    def __init__(self, rows):
        self.rows = rows

    @classmethod
    def of(cls, rows):
        """The table of `rows` (C, S); equal rows give the same object, so that their materials share a program."""
        rows = np.array(rows, np.float32, order="C")
        key = rows.shape, rows.tobytes()
        table = _KNOWN.get(key)
        if table is None:
            _KNOWN[key] = table = cls(rows)
        return table

    def look_up(self, x, out, first=0, interpolate=True, extrapolate=False):
        """Rows from number `first` on at `x` (N,), into `out` (C, N), whose first row may be `x`; NaN counts as 0.

        Parameters
        ----------
        interpolate : bool
            Else the sample below counts.
        extrapolate : bool
            Beyond 0 to 1 by the slope of the outermost samples; else these count.
        """
        last = self.rows.shape[1] - 1
        with np.errstate(all="ignore"):
            share = np.fmax(x, 0) * np.float32(last)
            np.minimum(share, last, out=share)
            below = share.astype(np.int32)
            above = np.minimum(below + 1, last)
            np.subtract(share, below, out=share)
            outside = (np.minimum(x, 0), np.maximum(x - 1, 0)) if extrapolate else None
            for row, samples in zip(out, self.rows[first:], strict=False):
                np.copyto(row, np.take(samples, below, mode="clip"))
                if interpolate:
                    rise = np.take(samples, above, mode="clip")
                    np.subtract(rise, row, out=rise)
                    np.add(row, np.multiply(rise, share, out=rise), out=row)
                if extrapolate:
                    slopes = (samples[1] - samples[0]) * last, (samples[-1] - samples[-2]) * last
                    for slope, distance in zip(slopes, outside, strict=True):
                        np.add(row, distance * slope, out=row)
        return out
