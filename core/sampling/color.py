# SPDX-License-Identifier: GPL-3.0-or-later
"""Colour arithmetic."""

from __future__ import annotations

import numpy as np

LUMINANCE = (0.2126, 0.7152, 0.0722)  # Rec.709


def luminance(color):
    """Rec.709 luminance of linear `color` (3, ...)."""
    return color[0] * LUMINANCE[0] + color[1] * LUMINANCE[1] + color[2] * LUMINANCE[2]


def srgb_to_linear(value):
    """Inverse of the sRGB transfer function (IEC 61966-2-1), any shape, float32."""
    value = np.asarray(value, np.float32)
    low = value * np.float32(1 / 12.92)
    high = ((np.maximum(value, 0) + np.float32(0.055)) * np.float32(1 / 1.055)) ** np.float32(2.4)
    return np.where(value <= 0.04045, low, high)
