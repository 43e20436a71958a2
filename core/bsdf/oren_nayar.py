# SPDX-License-Identifier: GPL-3.0-or-later
"""Rough diffuse reflection: Fujii's improvement of the qualitative Oren-Nayar model, with interreflections.

Parameters: `roughness` (N,) or (1,) in [0, 1]; `color` (3, N) or (3, 1), which the light between the facets takes on at
each bounce. f and weight are (3, N). The lobe's colour itself stays with the mixture, as everywhere.

Sources: Fujii, "A tiny improvement of Oren-Nayar reflectance model"; the interreflection term of the OpenPBR
specification, section "Diffuse reflection"; constants as Cycles has them.
"""

from __future__ import annotations

import math

import numpy as np

from ..limits import at_least, within
from ..sampling import warp
from ..vecmath import dot
from . import diffuse
from .base import Lobe, LobeSample

flags = Lobe.REFLECTION | Lobe.DIFFUSE


def sample(params, n, wo, uc, u0, u1, arena):
    """Direction with density cosθ/π."""
    wi, _, pdf, _ = diffuse.sample(params, n, wo, uc, u0, u1, arena)
    weight = arena.empty(wi.shape)
    with arena.frame():
        np.multiply(_reflectance(params, n, wo, wi, arena), math.pi, out=weight)
    return LobeSample(wi, weight, pdf)


def eval_pdf(params, n, wo, wi, arena):
    """f·cosθ (3, N) and cosθ/π (N,)."""
    f, pdf = arena.empty(wi.shape), arena.empty(wi.shape[-1])
    with arena.frame():
        warp.cosine_hemisphere_pdf(dot(n, wi, arena), arena, out=pdf)
        np.multiply(_reflectance(params, n, wo, wi, arena), math.pi, out=f)
        np.multiply(f, pdf, out=f)
    return f, pdf


def albedo(params, n, wo, arena):
    """1: about all is reflected."""
    return 1.0


def _reflectance(params, n, wo, wi, arena):
    """The BRDF without cosine, (3, N)."""
    sigma, color = params["roughness"], params["color"]
    a = 1.0 / (math.pi + sigma * (math.pi / 2 - 2 / 3))
    b = sigma * a
    cos_i, cos_o = dot(n, wi, arena), dot(n, wo, arena)
    at_least(cos_i, 0.0, cos_i)
    at_least(cos_o, 0.0, cos_o)
    t, denominator = dot(wi, wo, arena), arena.empty(cos_i.shape)
    np.multiply(cos_i, cos_o, out=denominator)
    np.subtract(t, denominator, out=t)
    np.maximum(cos_i, cos_o, out=denominator)
    at_least(denominator, 1e-20, denominator)
    np.divide(t, denominator, out=t, where=t > 0.0)
    np.multiply(t, b, out=t)
    np.add(t, a, out=t)
    average = math.pi * a + ((2 * math.pi - 5.6) / 3) * b
    between = color * color / math.pi * (average / np.maximum(1.0 - average, 1e-6)) / (1.0 - color * (1.0 - average))
    lost = _lost(cos_i, a, b, arena)
    np.multiply(lost, _lost(cos_o, a, b, arena), out=lost)
    f = arena.empty((3, cos_i.size))
    np.multiply(between, lost, out=f)
    return np.add(f, t, out=f)


def _lost(cosine, a, b, arena):
    """1 - E(cosθ): what single scattering does not return from a direction, (N,)."""
    out = arena.empty(cosine.shape)
    with arena.frame():
        c, s, g = arena.empty(cosine.shape), arena.empty(cosine.shape), arena.empty(cosine.shape)
        within(cosine, 1e-4, 1.0, c)
        np.multiply(c, c, out=s)
        np.subtract(1.0, s, out=s)
        np.sqrt(s, out=s)
        np.arccos(c, out=g)
        np.multiply(s, c, out=out)
        np.subtract(g, out, out=g)
        np.subtract(g, 2 / 3, out=g)
        np.multiply(g, s, out=g)  # sinθ (θ - 2/3 - sinθ cosθ)
        np.multiply(s, s, out=out)
        np.multiply(out, s, out=out)
        np.subtract(1.0, out, out=out)
        np.multiply(out, s, out=out)
        np.divide(out, c, out=out)
        np.multiply(out, 2 / 3, out=out)  # 2/3 tanθ (1 - sin³θ)
        np.add(out, g, out=out)
        np.multiply(out, b, out=out)
        np.subtract(1.0 - math.pi * a, out, out=out)
    return out
