# SPDX-License-Identifier: GPL-3.0-or-later
"""The ways in which Blender's Mix node blends two colours.

Each function takes the factor (N,) and two colours (3, N) and returns the blend; constants may be (1,) and (3, 1).

Source: Blender manual, "Color Blend Modes"; Cycles, `kernel/svm/color_util.h`.
"""

from __future__ import annotations

import numpy as np

from .color_space import hsv_to_rgb, rgb_to_hsv


def _towards(t, a, b):
    return a + t * (b - a)


def _mix(t, a, b):
    return _towards(t, a, b)


def _add(t, a, b):
    return a + t * b


def _multiply(t, a, b):
    return _towards(t, a, a * b)


def _subtract(t, a, b):
    return a - t * b


def _divide(t, a, b):
    """Channels of `b` that are 0 leave `a` as it is."""
    return np.where(b == 0, a, (1 - t) * a + t * (a / b))


def _screen(t, a, b):
    return 1 - (1 - t * b) * (1 - a)


def _overlay(t, a, b):
    return np.where(a < 0.5, a * (1 - t + 2 * t * b), 1 - (1 - t + 2 * t * (1 - b)) * (1 - a))


def _difference(t, a, b):
    return _towards(t, a, np.abs(a - b))


def _exclusion(t, a, b):
    return np.maximum(_towards(t, a, a + b - 2 * a * b), 0)


def _darken(t, a, b):
    return _towards(t, a, np.minimum(a, b))


def _lighten(t, a, b):
    return _towards(t, a, np.maximum(a, b))


def _dodge(t, a, b):
    """`a` over what `b` leaves, 1 at most; black stays black."""
    left = 1 - t * b
    return np.where(a == 0, a, np.where(left <= 0, 1, np.minimum(a / left, 1)))


def _burn(t, a, b):
    """The negative of dodging, 0 to 1."""
    left = 1 - t + t * b
    return np.where(left <= 0, 0, np.clip(1 - (1 - a) / left, 0, 1))


def _soft_light(t, a, b):
    screen = 1 - (1 - b) * (1 - a)
    return (1 - t) * a + t * ((1 - a) * b * a + a * screen)


def _linear_light(t, a, b):
    return a + t * (2 * b - 1)


def _hue(t, a, b):
    """The hue of `b`; a grey `b` has none, so `a` stays."""
    of_b, h = rgb_to_hsv(b), rgb_to_hsv(a)
    hue, saturation, _ = of_b
    given = hsv_to_rgb(np.stack(np.broadcast_arrays(hue, h[1], h[2])))
    return np.where(saturation != 0, _towards(t, a, given), a)


def _saturation(t, a, b):
    """The saturation of both; a grey `a` stays grey."""
    h = rgb_to_hsv(a)
    saturation = _towards(t, h[1], rgb_to_hsv(b)[1])
    return np.where(h[1] != 0, hsv_to_rgb(np.stack(np.broadcast_arrays(h[0], saturation, h[2]))), a)


def _value(t, a, b):
    h = rgb_to_hsv(a)
    value = _towards(t, h[2], rgb_to_hsv(b)[2])
    return hsv_to_rgb(np.stack(np.broadcast_arrays(h[0], h[1], value)))


def _color(t, a, b):
    """Hue and saturation of `b`; a grey `b` leaves `a` as it is."""
    hue, saturation, _ = rgb_to_hsv(b)
    given = hsv_to_rgb(np.stack(np.broadcast_arrays(hue, saturation, rgb_to_hsv(a)[2])))
    return np.where(saturation != 0, _towards(t, a, given), a)


BLEND = {
    "MIX": _mix,
    "DARKEN": _darken,
    "MULTIPLY": _multiply,
    "BURN": _burn,
    "LIGHTEN": _lighten,
    "SCREEN": _screen,
    "DODGE": _dodge,
    "ADD": _add,
    "OVERLAY": _overlay,
    "SOFT_LIGHT": _soft_light,
    "LINEAR_LIGHT": _linear_light,
    "DIFFERENCE": _difference,
    "EXCLUSION": _exclusion,
    "SUBTRACT": _subtract,
    "DIVIDE": _divide,
    "HUE": _hue,
    "SATURATION": _saturation,
    "COLOR": _color,
    "VALUE": _value,
}
