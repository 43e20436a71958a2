# SPDX-License-Identifier: GPL-3.0-or-later
"""Colours as hue, saturation and value or lightness, (3, N) each.

Values beyond 0 to 1 follow Cycles: a hue that is out of range counts as the last sixth of the circle.

Source: Smith, "Color Gamut Transform Pairs", SIGGRAPH 1978; Cycles, `util/color.h`.
"""

from __future__ import annotations

import numpy as np


def rgb_to_hsv(rgb):
    """Hue, saturation, value of `rgb`."""
    high, low = rgb.max(axis=0), rgb.min(axis=0)
    hsv = np.zeros_like(rgb)
    np.divide(high - low, high, out=hsv[1], where=high != 0)
    _hue(rgb, high, high - low, hsv[0])
    hsv[2] = high
    return hsv


def hsv_to_rgb(hsv):
    """The inverse of `rgb_to_hsv`."""
    h, s, v = hsv
    sixth = np.where(h == 1, np.float32(0), h) * np.float32(6)
    outside = (sixth < 0) | (sixth >= 6)
    sixth = np.where(outside, 5 + sixth - np.floor(sixth), sixth)
    rgb = np.zeros(hsv.shape, np.float32)
    for row, start in zip(rgb, (5, 3, 1), strict=True):
        # Each channel is a trapezium over the circle: down for two sixths, up for two.
        k = sixth + start
        np.subtract(k, 6, out=k, where=k >= 6)
        np.multiply(v, 1 - s * np.clip(np.minimum(k, 4 - k), 0, 1), out=row)
    return rgb


def rgb_to_hsl(rgb):
    """Hue, saturation, lightness of `rgb`."""
    high, low = rgb.max(axis=0), rgb.min(axis=0)
    hsl = np.zeros_like(rgb)
    lightness = np.minimum((high + low) * np.float32(0.5), 1)
    reach = np.where(lightness > 0.5, 2 - high - low, high + low)
    np.divide(high - low, reach, out=hsl[1], where=(high != low) & (reach != 0))
    _hue(rgb, high, high - low, hsl[0])
    hsl[2] = lightness
    return hsl


def hsl_to_rgb(hsl):
    """The inverse of `rgb_to_hsl`."""
    h, s, lightness = hsl
    sixth = h * np.float32(6)
    chroma = (1 - np.abs(2 * lightness - 1)) * s
    rgb = np.zeros(hsl.shape, np.float32)
    shares = (np.abs(sixth - 3) - 1, 2 - np.abs(sixth - 2), 2 - np.abs(sixth - 4))
    for row, share in zip(rgb, shares, strict=True):
        np.multiply(np.clip(share, 0, 1) - np.float32(0.5), chroma, out=row)
        np.add(row, lightness, out=row)
    return rgb


def _hue(rgb, high, reach, out):
    """Where on the circle `rgb` stands, 0 to 1, into `out`, which is 0 before."""
    r, g, b = rgb
    away = np.where(r == high, g - b, np.where(g == high, b - r, r - g))
    start = np.where(r == high, np.float32(0), np.where(g == high, np.float32(2), np.float32(4)))
    colored = reach != 0
    np.divide(away, reach, out=out, where=colored)
    np.add(out, start, out=out, where=colored)
    np.divide(out, 6, out=out)
    np.add(out, 1, out=out, where=out < 0)
