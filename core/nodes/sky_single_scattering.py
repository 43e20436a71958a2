# SPDX-License-Identifier: GPL-3.0-or-later
"""Light that the atmosphere scattered once: Nishita's sky.

Sources: Nishita et al., "Display of the Earth Taking into Account Atmospheric Scattering", SIGGRAPH 1993; Cornette and
Shanks, "Physically Reasonable Analytic Expression for the Single-Scattering Phase Function", 1992; the atmosphere's
constants, the steps and the quadrature are those of Cycles, `intern/sky`.
"""

from __future__ import annotations

import math

import numpy as np

from .sky_azimuths import few_azimuths

EARTH, TOP = 6360e3, 6420e3  # radii, m
HIGHEST = 59999.0  # m; above is space

_STEPS = 32
_DEEPEST = -2e4  # m; nothing passes the Earth
_AIR_HEIGHT, _AEROSOL_HEIGHT = 8e3, 1.2e3  # over which the density falls to 1/e, m
_OZONE_CENTER, _OZONE_REACH = 25e3, 15e3  # m
_G = 0.76  # anisotropy of aerosols
_AEROSOL = 2e-5  # scattering, 1/m
_EXTINCTION = 1.11  # of aerosols, over their scattering

# Gauss-Laguerre quadrature of 8 nodes, its last one kept within the ray.
_NODES, _WEIGHTS = np.polynomial.laguerre.laggauss(8)
_WEIGHTS = _WEIGHTS * np.exp(_NODES) / 25.0
_NODES = _NODES / 25.0

# Every 20 nm from 380 to 780 nm: the sun's irradiance, W/(m² nm); scattering by air and absorption by ozone, 1/m.
_BAND = 20.0
_SUN = np.array(
    """
    1.457568 1.565963 1.651484 1.714962 1.757980 1.782564 1.790951 1.785416 1.768156 1.741221 1.706471 1.665561
    1.619934 1.570836 1.519323 1.466285 1.412459 1.358450 1.304749 1.251750 1.199760
    """.split(),
    np.float64,
)
_AIR = 1e-6 * np.array(
    """
    54.24820 44.18550 36.35152 30.17929 25.26320 21.30859 18.09838 15.47057 13.30285 11.50185 9.995574 8.728000
    7.655137 6.742172 5.961341 5.290346 4.711157 4.209105 3.772184 3.390513 3.055916
    """.split(),
    np.float64,
)
_OZONE = 1e-9 * np.array(
    """
    3.251268 5.853954 19.77191 73.09569 200.8456 403.8396 635.5134 967.0704 1547.974 2090.386 2461.281 2735.513
    2151.259 1590.518 1123.562 735.2755 464.5013 330.9608 225.1261 148.7913 168.2862
    """.split(),
    np.float64,
)
# CIE 1931 colour matching functions.
_MATCH = np.array(
    """
    .001368 .000039 .006450  .014310 .000396 .067850  .134380 .004000 .645600  .348280 .023000 1.747060
    .290800 .060000 1.669200  .095640 .139020 .812950  .004900 .323000 .272000  .063270 .710000 .078250
    .290400 .954000 .020300  .594500 .995000 .003900  .916300 .870000 .001650  1.062200 .631000 .000800
    .854450 .381000 .000190  .447900 .175000 .000020  .164900 .061000 0  .046770 .017000 0  .011359 .004102 0
    .002899 .001047 0  .000690 .000249 0  .000166 .000060 0  .000042 .000015 0
    """.split(),
    np.float64,
).reshape(-1, 3)


class SingleScattering:
    """Air, aerosols and ozone around a sun.

    Parameters
    ----------
    elevation : float
        Of the sun, rad.
    altitude : float
        Of the viewer, m.
    air, aerosol, ozone : float
        Densities as multiples of the Earth's.
    """

    def __init__(self, elevation, altitude, air, aerosol, ozone):
        self._up, self._along = math.sin(elevation), math.cos(elevation)
        self._altitude = min(max(altitude, 1.0), HIGHEST)
        self._densities = np.array([air, aerosol, ozone])

    def sky(self, elevation, azimuth):
        """Colour XYZ (3, N) at one `elevation` and at `azimuth` (N,) from the sun, rad."""
        start, up = EARTH + self._altitude, math.sin(elevation)
        step = _to_top(start, up * start) / _STEPS
        t = (np.arange(_STEPS) + 0.5) * step
        density = self._densities[:, None] * _density(_height(start, up * start, t))
        depth = np.cumsum(density, axis=1) * step
        # A sun below the horizon lets the Earth cast a shadow, with an edge that no short series has.
        some, spread = few_azimuths(azimuth) if self._up >= 0.0 else (azimuth, np.asarray)
        towards = self._towards_sun(elevation, some)
        lit, to_sun = self._depth_to_sun(start, up, t[:, None], towards)
        extinction = (-depth[..., None] - to_sun).astype(np.float32).transpose(1, 2, 0) @ _extinctions()
        np.exp(extinction, out=extinction)
        spectrum = np.zeros((azimuth.size, _SUN.size))
        cosine = self._towards_sun(elevation, azimuth)
        for scattering, share in zip((_AIR, np.full(_SUN.size, _AEROSOL)), density[:2], strict=True):
            through = np.einsum("sn,snw->nw", lit * (share[:, None] * step).astype(np.float32), extinction)
            phase = _rayleigh(cosine) if scattering is _AIR else _cornette_shanks(cosine)
            spectrum += phase[:, None] * scattering * spread(through)
        return _xyz(spectrum * _SUN)

    def _towards_sun(self, elevation, azimuth):
        """Cosine of the angle to the sun."""
        return math.sin(elevation) * self._up + math.cos(elevation) * self._along * np.cos(azimuth)

    def sun(self, elevation):
        """Irradiance XYZ (3,) on a surface that faces the sun, seen at `elevation`; ozone does not dim it."""
        start, up = EARTH + self._altitude, math.sin(max(elevation, 0.0))
        depth = _depth(start, up * start)
        depth[2] = 0.0
        return _xyz(_SUN * np.exp(-(depth * self._densities) @ _extinctions()))

    def _depth_to_sun(self, start, up, t, towards):
        """Which of points `t` (S, 1) on rays are not in the Earth's shade, (S, N), and depths to the sun, (3, S, N)."""
        radius = EARTH + _height(start, up * start, t)
        along = start * self._up + t * towards
        # As in Cycles, a sun below the horizon is hidden behind the Earth on either side of it.
        lit = np.ones(along.shape, bool)
        if self._up < 0.0:
            lit = along**2 < radius**2 - EARTH**2
        return lit, self._densities[:, None, None] * _depth(radius, along)


def _density(height):
    """Of air, aerosols and ozone at `height`, as shares of the highest, (3, ...)."""
    height = np.maximum(height, _DEEPEST)
    ozone = np.maximum(0.0, 1.0 - np.abs(height - _OZONE_CENTER) / _OZONE_REACH)
    return np.stack([np.exp(-height / _AIR_HEIGHT), np.exp(-height / _AEROSOL_HEIGHT), ozone])


def _depth(radius, along):
    """Densities summed from points at `radius` to space, (3, ...), m; `along` is radius times the zenith's cosine."""
    length = _to_top(radius, along)
    nodes = (float(x) * length for x in _NODES)
    return sum(w * _density(_height(radius, along, t)) for w, t in zip(_WEIGHTS, nodes, strict=True)) * length


def _to_top(radius, along):
    """Length of rays out of the atmosphere."""
    return -along + np.sqrt(along**2 - radius**2 + TOP**2)


def _height(radius, along, t):
    """Height over the ground after `t` on rays."""
    return np.sqrt(radius**2 + t * (t + 2.0 * along)) - EARTH


def _extinctions():
    """Of air, aerosols and ozone, (3, bands)."""
    return np.stack([_AIR, np.full(_SUN.size, _EXTINCTION * _AEROSOL), _OZONE]).astype(np.float32)


def _rayleigh(cosine):
    return 3.0 / (16.0 * math.pi) * (1.0 + cosine**2)


def _cornette_shanks(cosine):
    shape = (1.0 - _G**2) / (2.0 + _G**2) * 3.0 / (8.0 * math.pi)
    return shape * (1.0 + cosine**2) / (1.0 + _G**2 - 2.0 * _G * cosine) ** 1.5


def _xyz(spectrum):
    """Colour of spectra (..., bands), its components first."""
    return np.moveaxis(spectrum @ _MATCH * _BAND, -1, 0)
