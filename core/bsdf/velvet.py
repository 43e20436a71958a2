# SPDX-License-Identifier: GPL-3.0-or-later
"""Ashikhmin's velvet: facets that stand up like fibres.

Parameters: `sigma` (N,) or (1,), the spread of the fibres. The density of facets' normals is
exp(-cot²θ/σ²)/(π σ² sin⁴θ), the masking that of Torrance and Sparrow.

Source: Ashikhmin, Premoze and Shirley, "A Microfacet-based BRDF Generator", SIGGRAPH 2000, as Cycles has it.
"""

from __future__ import annotations

import math

import numpy as np

from ..sampling import warp
from ..vecmath import dot, frame, lanes, to_world
from .base import Lobe, LobeSample

flags = Lobe.REFLECTION | Lobe.DIFFUSE

_LEAST_SIGMA = 0.01
_TINY = 1e-10


def sample(params, n, wo, uc, u0, u1, arena):
    """A uniform direction of the hemisphere."""
    count = u0.shape[-1]
    wi, pdf = arena.empty((3, count)), arena.full(count, warp.INV_TWO_PI)
    weight = arena.empty(count)
    with arena.frame():
        s, t = frame(n, arena)
        local = warp.square_to_uniform_cone(u0, u1, 1.0, arena)
        np.copyto(wi, to_world(local, s, t, n, arena))
        np.multiply(_value(params, n, wo, wi, arena), 2.0 * math.pi, out=weight)
        np.copyto(pdf, 0.0, where=weight == 0.0)
    return LobeSample(wi, weight, pdf)


def eval_pdf(params, n, wo, wi, arena):
    """f·cosθ and 1/2π."""
    f, pdf = arena.empty(lanes(wo, wi)), arena.empty(lanes(wo, wi))
    with arena.frame():
        np.copyto(f, _value(params, n, wo, wi, arena))
        np.multiply(f > 0.0, warp.INV_TWO_PI, out=pdf)
    return f, pdf


def albedo(params, n, wo, arena):
    """An estimate: most is reflected where the view grazes the fibres."""
    cosine = np.clip(dot(n, wo, arena), 0.0, 1.0)
    return np.maximum(1.0 - cosine, 0.1) * 0.5


def _value(params, n, wo, wi, arena):
    """D G/(4 cosθo), 0 where a direction is below the surface, (N,)."""
    sigma = np.maximum(params["sigma"], _LEAST_SIGMA)
    spread = 1.0 / (sigma * sigma)
    cos_o, cos_i = dot(n, wo, arena), dot(n, wi, arena)
    both = np.minimum(cos_o, cos_i, out=arena.empty(cos_i.shape))
    h = np.add(wo, wi, out=arena.empty(wi.shape))
    length2 = np.maximum(dot(h, h, arena), _TINY)
    along = dot(h, n, arena)
    across = np.subtract(h, n * along, out=h)  # 1 - cos² would be noise where the half vector is near the normal
    sin2 = np.maximum(dot(across, across, arena) / length2, _TINY)
    cos2 = np.minimum(along * along / length2, 1.0)
    density = np.exp(-cos2 / sin2 * spread) * spread * warp.INV_PI / (sin2 * sin2)
    # 2 (n·h) cos/(o·h), with both dot products scaled by |h| and 2 (o·h) = |h| for the sum of unit vectors.
    masking = np.minimum(4.0 * along * both / length2, 1.0)
    value = density * masking * 0.25 / np.maximum(cos_o, 1e-5)
    return np.where(both > 0.0, value, np.float32(0.0))
