# SPDX-License-Identifier: GPL-3.0-or-later
"""Glass under a thin film.

Parameters as of `glass`, and `film`, `thickness`, `film_fitted` as of `metal`; all is (3, N).
"""

from __future__ import annotations

import numpy as np

from ..vecmath import dot
from . import fresnel, glass, thin_film

_TINY = 1e-20


def split(params, cosine, arena):
    """How light divides at a facet, as `glass.split` tells it."""
    eta = params["eta"]
    _, cos_t = fresnel.dielectric(cosine, eta, arena)
    fitted = "film_fitted" in params
    reflected = thin_film.over_dielectric(cosine, eta, params["film"], params["thickness"], arena, fitted)
    if "f0" in params:
        reflected = thin_film.tinted(reflected, params["f0"], eta)
    np.copyto(reflected, 1.0, where=cos_t <= 0.0)
    transmitted = (1.0 - reflected) * params.get("tint", 1.0)
    r, t = reflected.mean(axis=0), transmitted.mean(axis=0)
    return reflected, transmitted, r / np.maximum(r + t, _TINY), cos_t


def albedo(params, n, wo, arena):
    """The sum of both shares at the macroscopic normal."""
    cosine = dot(n, wo, arena)
    reflected, transmitted, _, _ = split(params, np.maximum(cosine, 0.0, out=cosine), arena)
    return reflected + transmitted


class Rough(glass.Rough):
    """GGX microfacets."""

    split = staticmethod(split)
    albedo = staticmethod(albedo)


class Smooth(glass.Smooth):
    """A clear boundary."""

    split = staticmethod(split)
    albedo = staticmethod(albedo)
