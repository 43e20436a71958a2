# SPDX-License-Identifier: GPL-3.0-or-later
"""Clear skies as formulas of the angles to the zenith and to the sun.

Sources: Preetham, Shirley and Smits, "A Practical Analytic Model for Daylight", SIGGRAPH 1999, appendix A.2 (Perez's
distribution); Hošek and Wilkie, "An Analytic Model for Full Spectral Sky-Dome Radiance", SIGGRAPH 2012, whose
coefficients stand in `sky_hosek.npz` under their own licence, `sky_hosek.txt`.
"""

from __future__ import annotations

import math
from functools import cache
from pathlib import Path

import numpy as np

_HORIZON = math.cos(0.5 * math.pi - 0.001)  # lower directions look like the horizon
_DATA = Path(__file__).with_name("sky_hosek.npz")

# Of turbidity: coefficients A to E of luminance Y and chromaticities x and y, each a slope and a constant.
_PEREZ = np.array(
    [
        [(0.1787, -1.4630), (-0.3554, 0.4275), (-0.0227, 5.3251), (0.1206, -2.5771), (-0.0670, 0.3703)],
        [(-0.0193, -0.2592), (-0.0665, 0.0008), (-0.0004, 0.2125), (-0.0641, -0.8989), (-0.0033, 0.0452)],
        [(-0.0167, -0.2608), (-0.0950, 0.0092), (-0.0079, 0.2102), (-0.0441, -1.6537), (-0.0109, 0.0529)],
    ]
)
# Chromaticities x and y of the zenith: by powers of turbidity (2, 1, 0) and of the sun's angle to it (3, 2, 1, 0).
_ZENITH = np.array(
    [
        [
            (0.00166, -0.00375, 0.00209, 0.0),
            (-0.02903, 0.06377, -0.03202, 0.00394),
            (0.11693, -0.21196, 0.06052, 0.25886),
        ],
        [
            (0.00275, -0.00610, 0.00317, 0.0),
            (-0.04214, 0.08970, -0.04153, 0.00516),
            (0.15346, -0.26756, 0.06670, 0.26688),
        ],
    ]
)
_PREETHAM_SCALE = 0.06  # Cycles' unit
_HOSEK_SCALE = 2.0 * math.pi / 683.0


class Preetham:
    """Daylight of a `turbidity` under a sun in unit `direction`."""

    def __init__(self, direction, turbidity):
        self._sun = np.array(direction, np.float32)[:, None]
        theta = math.acos(max(-1.0, min(1.0, direction[2])))
        self._coefficients = _PEREZ @ (turbidity, 1.0)
        chi = (4.0 / 9.0 - turbidity / 120.0) * (math.pi - 2.0 * theta)
        luminance = (4.0453 * turbidity - 4.9710) * math.tan(chi) - 0.2155 * turbidity + 2.4192
        chromaticity = _ZENITH @ (theta**3, theta**2, theta, 1.0) @ (turbidity**2, turbidity, 1.0)
        zenith = np.array([luminance * _PREETHAM_SCALE, *chromaticity])
        self._zenith = zenith / self._distribution(np.ones(1), np.full(1, theta))[:, 0]

    def radiance(self, direction, arena, with_sun):
        """Colour XYZ (3, N) from `direction` (3, N)."""
        luminance, x, y = self._zenith[:, None].astype(np.float32) * self._distribution(*_angles(direction, self._sun))
        scale = np.divide(luminance, y, out=np.zeros_like(y), where=y != 0)
        return np.stack([scale * x, luminance, scale * (1 - x - y)])

    def _distribution(self, cosine, gamma):
        """Perez's F of luminance and chromaticities, (3, N)."""
        a, b, c, d, e = self._coefficients.T[..., None].astype(cosine.dtype)
        return (1 + a * np.exp(b / cosine)) * (1 + c * np.exp(d * gamma) + e * np.cos(gamma) ** 2)


class HosekWilkie:
    """Daylight of a `turbidity` under a sun in unit `direction`, over ground of `albedo`."""

    def __init__(self, direction, turbidity, albedo):
        self._sun = np.array(direction, np.float32)[:, None]
        elevation = math.asin(max(0.0, min(1.0, direction[2])))
        coefficients, radiances = _coefficients()
        self._coefficients = _interpolated(coefficients, turbidity, albedo, elevation)
        self._radiances = _interpolated(radiances, turbidity, albedo, elevation) * _HOSEK_SCALE

    def radiance(self, direction, arena, with_sun):
        """Colour XYZ (3, N) from `direction` (3, N)."""
        cosine, gamma = _angles(direction, self._sun)
        a, b, c, d, e, f, g, i, h = self._coefficients.T[..., None].astype(np.float32)
        cosine_gamma = np.cos(gamma)
        square = cosine_gamma**2
        mie = (1 + square) / (1 + h * h - 2 * h * cosine_gamma) ** np.float32(1.5)
        glow = c + d * np.exp(e * gamma) + f * square + g * mie + i * np.sqrt(cosine)
        return self._radiances[:, None].astype(np.float32) * (1 + a * np.exp(b / (cosine + np.float32(0.01)))) * glow


def _angles(direction, sun):
    """Cosine of the angle to the zenith, kept above the horizon, and the angle to `sun` (3, 1); float32, (N,) each."""
    direction = _on_sphere(direction)
    cosine_gamma = (direction * sun).sum(axis=0)
    return np.maximum(direction[2], np.float32(_HORIZON)), np.arccos(np.clip(cosine_gamma, -1, 1))


def _on_sphere(direction):
    """Unit vectors of the same height and azimuth: what Blender goes by where a vector is not unit."""
    x, y, z = direction
    z = np.clip(z, -1, 1)
    flat = np.hypot(x, y)
    scale = np.divide(np.sqrt(1 - z * z), flat, out=np.zeros_like(flat), where=flat > 0)
    return np.stack([x * scale, y * scale, z])


@cache
def _coefficients():
    """Coefficients (2, 10, 6, 3, 9) and radiances (2, 10, 6, 3): by albedo, turbidity, elevation, colour XYZ."""
    with np.load(_DATA) as data:
        return data["coefficients"], data["radiances"]


def _interpolated(table, turbidity, albedo, elevation):
    """What `table` gives: linear in albedo and turbidity, a quintic Bézier curve in the elevation's cube root."""
    turbidity = max(1.0, min(10.0, turbidity))
    low = min(int(turbidity), 9)
    share = turbidity - low
    table = table[0] * (1.0 - albedo) + table[1] * albedo
    table = table[low - 1] * (1.0 - share) + table[low] * share
    t = (2.0 * elevation / math.pi) ** (1.0 / 3.0)
    weights = [math.comb(5, k) * t**k * (1.0 - t) ** (5 - k) for k in range(6)]
    return np.tensordot(weights, table, 1)
