# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers over lanes kept within limits.

numpy compares two arrays eight numbers at a time, but an array with one number one at a time. So limits are arrays that
hold the same number everywhere, kept from call to call. They are for numbers that stand in the code, of which there are
few: each keeps half a MB.
"""

from __future__ import annotations

import numpy as np

_FEW = 4096  # lanes; so few are compared before an array is found

_held = {}  # arrays by their number


def at_least(x, least, out):
    """`numpy.maximum` of `x` and a number into `out` (N,) or (C, N), float32."""
    return np.maximum(x, _limit(least, out.shape[-1]), out=out)


def at_most(x, most, out):
    """`numpy.minimum` of `x` and a number into `out` (N,) or (C, N), float32."""
    return np.minimum(x, _limit(most, out.shape[-1]), out=out)


def within(x, least, most, out):
    """`numpy.clip` of `x` between two numbers into `out` (N,) or (C, N), float32."""
    return at_most(at_least(x, least, out), most, out)


def _limit(number, count):
    """`number`, as an array (count,) where that is faster."""
    if count < _FEW:
        return np.float32(number)
    held = _held.get(number)
    if held is None or held.size < count:
        held = np.full(1 << (count - 1).bit_length(), number, np.float32)
        held.flags.writeable = False
        _held[number] = held
    return held[:count]
