# SPDX-License-Identifier: GPL-3.0-or-later
"""Refraction alone: all light passes, but where it would be reflected totally nothing does.

Parameters as for `glass`: `eta`, and `alpha` for `Rough`.
"""

from __future__ import annotations

import numpy as np

from ..limits import at_least
from ..vecmath import dot
from . import fresnel, glass
from .base import Lobe


def split(params, cosine, arena):
    """All is transmitted, nothing reflected; nothing at all at total reflection. See `glass.split`."""
    reflected, cos_t = fresnel.dielectric(cosine, params["eta"], arena)
    transmitted = np.less(reflected, 1.0, out=arena.empty(cosine.shape))
    probability = np.subtract(1.0, transmitted, out=reflected)  # failed samples have the mirrored direction
    return arena.zeros(cosine.shape), transmitted, probability, cos_t


def albedo(params, n, wo, arena):
    """1 where the macroscopic normal lets light pass, else 0."""
    cosine = dot(n, wo, arena)
    at_least(cosine, 0.0, cosine)
    return split(params, cosine, arena)[1]


class Rough(glass.Rough):
    """GGX microfacets that refract."""

    flags = Lobe.TRANSMISSION | Lobe.GLOSSY
    split = staticmethod(split)
    albedo = staticmethod(albedo)


class Smooth(glass.Smooth):
    """A clear boundary without reflection."""

    flags = Lobe.TRANSMISSION | Lobe.DELTA
    split = staticmethod(split)
    albedo = staticmethod(albedo)
