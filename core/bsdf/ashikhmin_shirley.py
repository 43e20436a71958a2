# SPDX-License-Identifier: GPL-3.0-or-later
"""Ashikhmin and Shirley's anisotropic Phong model, without its Fresnel factor and diffuse part.

Parameters: `alpha` as of `glossy.Rough`; with anisotropy also `stretch` and `tangent`, see `facets`. The exponents are
2/α² - 2. With D = sqrt((nx + 1)(ny + 1)) (n·h)^(nx cos²φ + ny sin²φ), the value is

    f = D/(8π) / ((o·h) max(n·o, n·i))

and half vectors are drawn with density D (n·h)/2π; so f·cosθ/pdf = min(1, n·i/n·o).

Source: Ashikhmin and Shirley, "An Anisotropic Phong BRDF Model", JGT 5(2), 2000.
"""

from __future__ import annotations

import math

import numpy as np

from .. import vecmath
from ..vecmath import dot
from . import facets
from .base import Lobe, LobeSample

flags = Lobe.REFLECTION | Lobe.GLOSSY

_TINY = 1e-20


def sample(params, n, wo, uc, u0, u1, arena):
    """Reflection at a half vector drawn from the lobe."""
    count = u0.shape[-1]
    wi, weight, pdf = arena.empty((3, count)), arena.empty(count), arena.empty(count)
    with arena.frame():
        nx, ny = _exponents(params)
        s, t = facets.basis(params, n, arena)
        h = vecmath.to_world(_half(u0, u1, nx, ny, arena), s, t, n, arena)
        np.copyto(wi, vecmath.reflect(wo, h, arena))
        cos_o, cos_i = dot(n, wo, arena), dot(n, wi, arena)
        local = vecmath.to_local(h, s, t, n, arena)
        _density(local, dot(wo, h, arena), nx, ny, arena, out=pdf)
        kept = (np.minimum(cos_o, cos_i) > 0.0) & (pdf > 0.0)
        np.minimum(np.divide(cos_i, np.maximum(cos_o, _TINY), out=weight), 1.0, out=weight)
        np.multiply(weight, kept, out=weight)
        np.multiply(pdf, kept, out=pdf)
    return LobeSample(wi, weight, pdf)


def eval_pdf(params, n, wo, wi, arena):
    """f·cosθ and the density."""
    count = vecmath.lanes(wo, wi)
    f, pdf = arena.empty(count), arena.empty(count)
    with arena.frame():
        nx, ny = _exponents(params)
        s, t = facets.basis(params, n, arena)
        h = np.add(wo, wi, out=arena.empty(wi.shape))
        vecmath.normalize(h, arena, out=h)
        cos_o, cos_i = dot(n, wo, arena), dot(n, wi, arena)
        _density(vecmath.to_local(h, s, t, n, arena), dot(wo, h, arena), nx, ny, arena, out=pdf)
        np.multiply(pdf, np.minimum(cos_o, cos_i) > 0.0, out=pdf)
        np.minimum(np.divide(cos_i, np.maximum(cos_o, _TINY), out=f), 1.0, out=f)
        np.multiply(f, pdf, out=f)
    return f, pdf


def albedo(params, n, wo, arena):
    """1: an estimate."""
    return 1.0


def _exponents(params):
    """Phong exponents along the two axes, (N,) or (1,) each."""
    return tuple(np.maximum(2.0 / (alpha * alpha) - 2.0, 0.0) for alpha in facets.axes(params))


def _half(u0, u1, nx, ny, arena):
    """Half vectors of the upper hemisphere, (3, N).

    Within a quadrant tan φ = sqrt((nx + 1)/(ny + 1)) tan(2π u); then cosθ = v^(1/(e + 1)), with e the exponent at φ.
    sin²θ is formed by `expm1`, since exponents reach 1e8.
    """
    h = arena.empty((3, u0.shape[-1]))
    phi = u0 * (2.0 * math.pi)
    x, y = np.cos(phi) * np.sqrt(ny + 1.0), np.sin(phi) * np.sqrt(nx + 1.0)
    length = np.hypot(x, y)
    x, y = x / length, y / length
    power = np.log(np.maximum(1.0 - u1, 1e-12)) / (nx * x * x + ny * y * y + 1.0)
    np.exp(power, out=h[2])
    sine = np.sqrt(-np.expm1(2.0 * power))
    np.multiply(x, sine, out=h[0])
    np.multiply(y, sine, out=h[1])
    return h


def _density(h, cos_h, nx, ny, arena, out):
    """D/(8π (o·h)) of local unit half vectors, 0 where the view does not see them."""
    x2, y2 = h[0] * h[0], h[1] * h[1]
    sin2 = np.minimum(x2 + y2, 1.0 - 1e-7)
    # (n·h)^e with e = (nx x² + ny y²)/sin²: ln(n·h) = log1p(-sin²)/2.
    slope = np.where(sin2 > 1e-6, np.log1p(-sin2) / np.maximum(sin2, 1e-6), np.float32(-1.0))
    np.exp(0.5 * slope * (nx * x2 + ny * y2), out=out)
    np.multiply(out, np.sqrt((nx + 1.0) * (ny + 1.0)) * (0.125 / math.pi), out=out)
    np.divide(out, np.maximum(cos_h, 1e-6), out=out)
    return np.multiply(out, cos_h > 0.0, out=out)
