# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's arithmetic, number by number: what math on numbers and on vectors share.

Each function takes arrays that broadcast together and fills `out`, which may not be one of them unless said. Where
mathematics gives no answer, Blender gives 0. Callers ignore numpy's floating point errors; NaN stays in its lane.

Source: Blender manual, "Math Node"; Cycles, `util/math_base.h`.
"""

from __future__ import annotations

import numpy as np


def divide(a, b, out):
    """The quotient a / b; 0 where b is 0."""
    np.divide(a, b, out=out)
    np.copyto(out, 0, where=b == 0)


def power(a, b, out):
    """The power of a by b; 0 where a is negative and b not whole."""
    np.power(a, b, out=out)
    np.copyto(out, 0, where=(a < 0) & (b != np.trunc(b)))


def modulo(a, b, out):
    """What is left of a / b truncated; it has the sign of a."""
    np.fmod(a, b, out=out)
    np.copyto(out, 0, where=b == 0)


def floored_modulo(a, b, out):
    """What is left of a / b rounded down; it has the sign of b."""
    np.divide(a, b, out=out)
    np.floor(out, out=out)
    np.multiply(out, b, out=out)
    np.subtract(a, out, out=out)
    np.copyto(out, 0, where=b == 0)


def fraction(a, out):
    """What is above the next whole number below."""
    np.floor(a, out=out)
    np.subtract(a, out, out=out)


def round_half_up(a, out):
    """The nearest whole number, the upper one of two."""
    np.add(a, 0.5, out=out)
    np.floor(out, out=out)


def snap(a, b, out):
    """The next multiple of b below."""
    divide(a, b, out)
    np.floor(out, out=out)
    np.multiply(out, b, out=out)


def wrap(a, high, low, out):
    """`a` moved by whole ranges to between `low` and `high`; `low` where the range is empty."""
    reach = high - low
    np.subtract(a, low, out=out)
    np.divide(out, reach, out=out)
    np.floor(out, out=out)
    np.multiply(out, reach, out=out)
    np.subtract(a, out, out=out)
    np.copyto(out, low, where=reach == 0)


def multiply_add(a, b, c, out):
    """The sum a b + c."""
    np.multiply(a, b, out=out)
    np.add(out, c, out=out)


def saturate(a, out):
    """`a` between 0 and 1, NaN as 0; `out` may be `a`."""
    np.fmax(a, 0, out=out)
    np.minimum(out, 1, out=out)
    return out


def lerp(a, b, t, out):
    """From a to b by the share t; `out` may be `b`."""
    np.subtract(b, a, out=out)
    np.multiply(out, t, out=out)
    np.add(out, a, out=out)
    return out
