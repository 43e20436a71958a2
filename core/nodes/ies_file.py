# SPDX-License-Identifier: GPL-3.0-or-later
"""IES files: how strongly a luminaire shines in each direction.

Source: IES LM-63-2002; Cycles (`util/ies.cpp`) for what it makes of files that keep less of it, and for the watts.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

_WATTS = 0.0706650768394  # 4π over the 177.83 lm/W of D65: candelas to the power of a lamp that shines alike all around
_CLOSE = 1e-4  # degrees
_HEADER = 13  # numbers before the angles
_TYPES = "C", "B", "A"


@dataclass(frozen=True, eq=False)
class Photometry:
    """Strengths (H, V) at horizontal angles (H,), 0 to 2π, and vertical ones (V,), 0 at straight down, ascending."""

    horizontal: np.ndarray
    vertical: np.ndarray
    strength: np.ndarray


@lru_cache(maxsize=64)
def parse(text):
    """The `Photometry` of an IES file's `text`; a ValueError says in a few words what is wrong with it."""
    tilt = re.search(r"^TILT=(.*)$", text, re.MULTILINE)
    if tilt is None:
        raise ValueError("it has no line TILT=")
    numbers = _numbers(text[tilt.end() :])
    if tilt[1].strip() == "INCLUDE":
        _expect(numbers.size >= 2, "it ends early")
        numbers = numbers[2 + 2 * max(int(numbers[1]), 0) :]
    _expect(numbers.size >= _HEADER, "it ends early")
    rows, columns, kind = (int(v) for v in numbers[3:6])
    _expect(rows > 1 and columns > 0, "it has too few angles")
    _expect(1 <= kind <= len(_TYPES), "it is of no known photometric type")
    body = numbers[_HEADER:]
    _expect(body.size >= rows + columns + rows * columns, "it ends early")
    vertical, horizontal, body = np.split(body[: rows + columns + rows * columns], (rows, rows + columns))
    strength = body.reshape(columns, rows) * (numbers[2] * numbers[10] * numbers[11] * _WATTS)
    horizontal, vertical, strength = _AS_TYPE_C[_TYPES[kind - 1]](horizontal, vertical, strength)
    _expect(bool((np.diff(horizontal) > 0).all() and (np.diff(vertical) > 0).all()), "its angles do not ascend")
    return Photometry(*(a.astype(np.float32) for a in (np.radians(horizontal), np.radians(vertical), strength)))


def _numbers(text):
    try:
        numbers = np.array(text.replace(",", " ").split(), np.float64)
    except ValueError:
        raise ValueError("it has a word where a number should be") from None
    _expect(bool(np.isfinite(numbers).all()), "its numbers are not finite")
    return numbers


def _expect(holds, otherwise):
    if not holds:
        raise ValueError(otherwise)


def _type_c(horizontal, vertical, strength):
    if _is(horizontal[0], 90):
        horizontal = horizontal - 90
    if horizontal.size == 1:
        return np.array([0.0, 360.0]), vertical, np.concatenate([strength, strength])
    for end in (90, 180):
        if _is(horizontal[-1], end):
            horizontal = np.concatenate([horizontal, 2 * end - horizontal[-2::-1]])
            strength = np.concatenate([strength, strength[-2::-1]])
    gap = 360 - horizontal[-1]
    if _is(horizontal[0], 0) and not _is(gap, 0) and any(_is(np.diff(horizontal)[k], gap) for k in (0, -1)):
        horizontal, strength = np.append(horizontal, 360.0), np.concatenate([strength, strength[:1]])
    return horizontal, vertical, strength


def _type_b(horizontal, vertical, strength):
    """With a level axis: the angles change places, as in Cycles, and go from 0 to 180 degrees both."""
    around, strength = _from_middle(vertical, strength.T)
    down, strength = _from_middle(horizontal, strength.T)
    return around, down, strength.T


def _from_middle(angles, strength):
    """Angles from -90 to 90 degrees as 0 to 180, those from 0 on mirrored; rows of `strength` with them."""
    if not _is(angles[0], 0):
        return angles + 90, strength
    return np.concatenate([90 - angles[:0:-1], 90 + angles]), np.concatenate([strength[:0:-1], strength])


def _type_a(horizontal, vertical, strength):
    around, turned = 180 - horizontal[::-1], strength[::-1]
    if _is(horizontal[0], 0):
        around, turned = np.append(around, 180 + horizontal[1:]), np.concatenate([turned, strength[1:]])
    return around, vertical + 90, turned


def _is(angle, degrees):
    return abs(angle - degrees) < _CLOSE


_AS_TYPE_C = {"A": _type_a, "B": _type_b, "C": _type_c}
