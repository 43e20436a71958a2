# SPDX-License-Identifier: GPL-3.0-or-later
"""Light of a clear sky at many azimuths, from its values at a few.

Around the zenith, what a simulated sky scatters is an even and smooth function of the azimuth from the sun, once the
phase functions, which peak at the sun, are left out: a short cosine series. Of 32 terms, skies of a sun above the
horizon differ from those without a series by less than 2e-4 of their brightest texel.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

TERMS = 32
_ORDERS = np.arange(TERMS)
_FEW = math.pi / (TERMS - 1) * _ORDERS
_TERMS_OF_VALUES = np.linalg.inv(np.cos(np.outer(_FEW, _ORDERS)))


def few_azimuths(azimuth):
    """Azimuths (K,) rad to evaluate, and a function from what was found there (K, ...) to `azimuth` (N,)."""
    if azimuth.size <= TERMS:
        return azimuth, lambda values: values
    return _FEW, _summed_at(azimuth.tobytes())


@lru_cache(maxsize=4)
def _summed_at(azimuth):
    """The function for the bytes of an array of azimuths, float64."""
    weights = np.cos(np.outer(np.frombuffer(azimuth), _ORDERS)) @ _TERMS_OF_VALUES
    return lambda values: weights @ values
