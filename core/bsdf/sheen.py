# SPDX-License-Identifier: GPL-3.0-or-later
"""Sheen of cloth: fibres that scatter light several times, as a linearly transformed cosine.

Parameters: `a`, `b` (N,) of the transform, from `transform`. The lobe's value is its density, so it returns all light;
what a surface of the given roughness reflects is the third result of `transform` and belongs in the lobe's colour.

With x along the view's projection on the surface, the cosine lobe z/π is seen through M⁻¹ = [[a, 0, b], [0, a, 0],
[0, 0, 1]], so f·cosθ = z/π (a/((a x + b z)² + (a y)² + z²))². It is not reciprocal.

Source: Zeltner, Burley and Chiang, "Practical Multiple-Scattering Sheen Using Linearly Transformed Cosines", SIGGRAPH
Talks 2022. The table `sheen.npz` (a, b, reflectance over roughness and cosθ) was measured from Cycles' renders, by
`tests/addon/nodes/measure_sheen.py`.
"""

from __future__ import annotations

import functools
import os

import numpy as np

from .. import vecmath
from ..limits import at_least
from ..sampling import warp
from . import tangents
from .base import Lobe, LobeSample
from .lookup import bilinear

flags = Lobe.REFLECTION | Lobe.DIFFUSE

_LEAST_ROUGHNESS = 1e-3


@functools.cache
def _table():
    """(a, b, reflectance), roughness, cosθ: (3, 32, 32) float32."""
    with np.load(os.path.join(os.path.dirname(__file__), "sheen.npz")) as stored:
        return stored["ltc"]


def transform(mu, roughness, arena):
    """(a, b, reflectance), (N,) each, of sheen seen at cosines `mu` (N,)."""
    return bilinear(_table(), np.maximum(roughness, _LEAST_ROUGHNESS), mu, arena)


def sample(params, n, wo, uc, u0, u1, arena):
    """A direction of the cosine hemisphere, transformed."""
    a, b = params["a"], params["b"]
    count = u0.shape[-1]
    wi, pdf = arena.empty((3, count)), arena.empty(count)
    weight = arena.empty(count)
    with arena.frame():
        s, t = tangents.along(n, wo, arena)
        local = warp.square_to_cosine_hemisphere(u0, u1, arena)
        shear = np.multiply(local[2], b, out=arena.empty(count))
        np.subtract(local[0], shear, out=local[0])
        np.multiply(local[2], a, out=local[2])
        vecmath.normalize(local, arena, out=local)
        np.copyto(wi, vecmath.to_world(local, s, t, n, arena))
        _density(local, a, b, arena, out=pdf)
        np.greater(pdf, 0.0, out=weight)
    return LobeSample(wi, weight, pdf)


def eval_pdf(params, n, wo, wi, arena):
    """f·cosθ = pdf, one array for both."""
    pdf = arena.empty(vecmath.lanes(wo, wi))
    with arena.frame():
        s, t = tangents.along(n, wo, arena)
        _density(vecmath.to_local(wi, s, t, n, arena), params["a"], params["b"], arena, out=pdf)
    return pdf, pdf


def albedo(params, n, wo, arena):
    """1: the reflectance is in the colour."""
    return 1.0


def _density(local, a, b, arena, out):
    """z/π (a/|M⁻¹ w|²)² of unit vectors w, 0 below the horizon."""
    x, y, z = local
    with arena.frame():
        t = arena.empty(out.shape)
        np.multiply(x, a, out=out)
        np.multiply(z, b, out=t)
        np.add(out, t, out=out)
        np.multiply(out, out, out=out)
        np.multiply(y, a, out=t)
        np.multiply(t, t, out=t)
        np.add(out, t, out=out)
        np.multiply(z, z, out=t)
        np.add(out, t, out=out)
        np.divide(a, out, out=out)
        np.multiply(out, out, out=out)
        at_least(z, 0.0, t)
        np.multiply(t, warp.INV_PI, out=t)
    return np.multiply(out, t, out=out)
