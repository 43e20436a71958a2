# SPDX-License-Identifier: GPL-3.0-or-later
"""Light that the atmosphere scattered any number of times, in four wavelengths.

The first order is integrated along each ray; what comes from the ground and from further orders is a fit. Sources:
García Liñán, "Spectral sky rendering", 2024 (the model, its fits, the wavelengths and their colours), as in Cycles,
`intern/sky`; Hillaire, "Physically Based Sky, Atmosphere and Cloud Rendering in Frostbite", 2016 (the integration).
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from .sky_azimuths import few_azimuths

EARTH, THICKNESS = 6371.0, 100.0  # km
TOP = EARTH + THICKNESS
HIGHEST = 99999.0  # m; above is space

_STEPS = 64
_COSINES, _HEIGHTS = 256, 64  # of the table of transmittances
_DARKEST = 1e-30  # transmittance
_PAIR = np.arange(2)  # what is below and above
_ALBEDO = 0.3
_G = 0.8  # anisotropy of aerosols

# At 630, 560, 490 and 430 nm: irradiance of the sun, W/(m² nm); coefficients, 1/km, and cross sections.
_SUN = np.array([1.679, 1.828, 1.986, 1.307])
_AIR = np.array([6.605e-3, 1.067e-2, 1.842e-2, 3.156e-2])
_OZONE = 334.5 * np.array([3.472e-25, 3.914e-25, 1.349e-25, 1.103e-26])  # of the mean column, in Dobson units
_AEROSOL = np.array([1.5908e-22, 1.7711e-22, 2.0942e-22, 2.4033e-22])
_AEROSOL_ABSORPTION = np.array([2.8722e-24, 4.6168e-24, 7.9706e-24, 1.3578e-23])
_AEROSOL_DENSITY, _AEROSOL_BACKGROUND, _AEROSOL_HEIGHT = 1.3681e20, 2e6, 0.73  # of a city
_FURTHER = np.float32(0.02) * np.array([0.217, 0.347, 0.594, 1.0], np.float32)  # orders of scattering, in full daylight
_XYZ = np.array(
    [
        (53.386917738564668, 43.904844466369358, 1.6137278251608962, 20.762668673810577),
        (22.981337506691025, 71.347795700053394, 18.422960591455485, 2.3614213523314369),
        (0.0, 0.10250686796574131, 31.742921188390806, 110.48009643252140),
    ]
)


class MultipleScattering:
    """Air, aerosols and ozone around a sun; parameters as of `SingleScattering`."""

    def __init__(self, elevation, altitude, air, aerosol, ozone):
        self._up, self._along = math.sin(elevation), math.cos(elevation)
        self._altitude = min(max(altitude, 1.0), HIGHEST) * 1e-3
        self._densities = air, aerosol, ozone
        self._table = _transmittances(self._densities)

    def sky(self, elevation, azimuth):
        """Colour XYZ (3, N) at one `elevation` and at `azimuth` (N,) from the sun, rad."""
        start, up = EARTH + self._altitude, math.sin(elevation)
        step = _length(start, up) / _STEPS
        t = (np.arange(_STEPS) + 0.5) * step
        height = np.maximum(_height(start, up, t), 0.0)
        some, spread = few_azimuths(azimuth) if self._up >= 0.0 else (azimuth, np.asarray)
        towards = self._towards_sun(elevation, some)
        zenith = (start * self._up + t[:, None] * towards) / (EARTH + height)[:, None]
        air, aerosol, extinction = _coefficients(self._densities, height)
        # Light that is scattered evenly along a step, dimmed on the way out of it and then to the viewer.
        opacity = -np.expm1(-step * extinction)
        before = np.exp(-step * (np.cumsum(extinction, axis=0) - extinction))
        seen = _SUN * before * opacity / np.maximum(extinction, 1e-7)
        rows, (column, share) = self._rows(height), _columns(zenith)
        sun = _between(rows[np.arange(_STEPS)[:, None], _PAIR[:, None, None] + column], share)
        ground = _between(self._table[0][_PAIR[:, None, None] + column], share)
        ground *= (self._table[0, -1] / np.maximum(rows[:, -1], _DARKEST))[:, None]  # dimmed on the way up
        towards = self._towards_sun(elevation, azimuth)
        light = _rayleigh(towards)[:, None] * spread(_summed(seen * air, sun))
        light += _henyey_greenstein(towards)[:, None] * spread(_summed(seen * aerosol, sun))
        light += spread(_summed(seen * (air + aerosol), _further(height, zenith, ground)))
        return _XYZ @ light.T

    def _towards_sun(self, elevation, azimuth):
        """Cosine of the angle to the sun."""
        return math.sin(elevation) * self._up + math.cos(elevation) * self._along * np.cos(azimuth)

    def sun(self, elevation):
        """Irradiance XYZ (3,) on a surface that faces the sun, seen at `elevation`."""
        return _XYZ @ (_SUN * _transmittance(self._densities, np.float64(math.sin(elevation)), self._altitude))

    def _rows(self, height):
        """Transmittances to space at `height` (S,), (S, _COSINES, 4), linearly between the table's."""
        y = np.clip(height / THICKNESS, 0.0, 1.0) * (_HEIGHTS - 1)
        low = np.minimum(y.astype(int), _HEIGHTS - 2)
        return _between(self._table[_PAIR[:, None] + low], (y - low)[:, None, None].astype(np.float32))


def _coefficients(densities, height):
    """Scattering by air and by aerosols and all extinction, (..., 4) each, at `height`, km."""
    air, aerosol, ozone = densities
    height = np.asarray(height, np.float64)[..., None]
    air_scattering = air * _AIR * np.exp(-0.07771971 * height**1.16364243)
    density = aerosol * (_AEROSOL_DENSITY * np.exp(-height / _AEROSOL_HEIGHT) + _AEROSOL_BACKGROUND)
    log = np.log(np.maximum(height, 1e-4))
    absorption = ozone * _OZONE * 3.78547397e20 * np.exp(-((log - 3.22261) ** 2) * 5.55555555 - log)
    scattering = density * _AEROSOL
    return air_scattering, scattering, air_scattering + scattering + absorption + density * _AEROSOL_ABSORPTION


def _transmittance(densities, cosine, height):
    """From `height` to space in the direction of a zenith's `cosine`, (..., 4); the ground is no obstacle."""
    radius = EARTH + height
    step = (-radius * cosine + np.sqrt((radius * cosine) ** 2 - radius**2 + TOP**2)) / _STEPS
    depth = 0.0
    for k in range(_STEPS):
        extinction = _coefficients(densities, np.maximum(_height(radius, cosine, (k + 0.5) * step), 0.0))[2]
        depth = depth + extinction * step[..., None]
    return np.exp(-depth)


@lru_cache(maxsize=4)
def _transmittances(densities):
    """Table (_HEIGHTS, _COSINES, 4) of transmittances to space; wherever the sun stands, it is the same."""
    cosine, share = np.linspace(-1.0, 1.0, _COSINES), np.linspace(0.0, 1.0, _HEIGHTS)
    return _transmittance(densities, cosine, share[:, None] * THICKNESS).astype(np.float32)


def _further(height, cosine, ground):
    """Radiance of all further orders of scattering, over the sun's irradiance, (S, N, 4).

    `ground` (S, N, 4) is the transmittance from the sun to the ground and up to the points.
    """
    daylight = (1.0 / (1.0 + 5.0 * np.exp(-17.92 * cosine))).astype(np.float32)
    # The ground fills a cap of the directions.
    cap = 0.5 * (1.0 - np.sqrt(np.maximum(1.0 - (EARTH / (EARTH + height)) ** 2, 0.0)))
    reflected = (_ALBEDO / math.pi * cap[:, None] * cosine).astype(np.float32)
    return _FURTHER * daylight[..., None] + ground * reflected[..., None]


def _summed(weight, light):
    """Sum over steps of `weight` (S, 4) times `light` (S, N, 4), (N, 4)."""
    return np.einsum("sw,snw->nw", weight.astype(np.float32), light)


def _columns(cosine):
    """Column of the table below `cosine`, and how far it is from there to the next, (..., 1)."""
    x = np.clip(0.5 * cosine + 0.5, 0.0, 1.0) * (_COSINES - 1)
    low = np.minimum(x.astype(int), _COSINES - 2)
    return low, (x - low).astype(np.float32)[..., None]


def _between(pair, share):
    """`pair` (2, ...) mixed by `share`, in place."""
    low, high = pair
    np.subtract(high, low, out=high)
    np.multiply(high, share, out=high)
    return np.add(low, high, out=low)


def _length(radius, cosine):
    """Length of a ray to the ground, or else out of the atmosphere."""
    along = radius * cosine
    reach = along**2 - radius**2 + EARTH**2
    if along < 0.0 and reach >= 0.0:
        return -along - math.sqrt(reach)
    return -along + math.sqrt(along**2 - radius**2 + TOP**2)


def _height(radius, cosine, t):
    """Height over the ground after `t` on rays, km."""
    return np.sqrt(radius**2 + t * (t + 2.0 * radius * cosine)) - EARTH


def _rayleigh(cosine):
    return 3.0 / (16.0 * math.pi) * (1.0 + cosine**2)


def _henyey_greenstein(cosine):
    return (1.0 - _G**2) / (4.0 * math.pi) / (1.0 + _G**2 - 2.0 * _G * cosine) ** 1.5
