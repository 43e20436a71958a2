# SPDX-License-Identifier: GPL-3.0-or-later
"""Lambert reflection: the same radiance in all directions."""

from __future__ import annotations

import numpy as np

from ..sampling import warp
from ..vecmath import dot
from .base import Lobe, LobeSample

flags = Lobe.REFLECTION | Lobe.DIFFUSE

# A little smaller than the unit sphere, so that even the point opposite to the normal leaves a direction.
_RADIUS = 1.0 - 1e-6


def sample(params, n, wo, uc, u0, u1, arena):
    """Direction with density cosθ/π: the normal plus a uniform point of the unit sphere, normalised.

    Needs no basis; the length of the sum is 2 cosθ, so the density comes for free.
    """
    wi = arena.empty((3, u0.shape[-1]))
    pdf = arena.empty(u0.shape[-1])
    warp.square_to_uniform_sphere(u0, u1, arena, out=wi, radius=_RADIUS)
    np.add(wi, n, out=wi)
    dot(wi, wi, arena, out=pdf)
    np.sqrt(pdf, out=pdf)
    np.divide(wi, pdf, out=wi)
    np.multiply(pdf, warp.INV_TWO_PI, out=pdf)
    return LobeSample(wi, 1.0, pdf)


def eval_pdf(params, n, wo, wi, arena):
    """f·cosθ = pdf = cosθ/π, one array for both."""
    pdf = dot(n, wi, arena)
    warp.cosine_hemisphere_pdf(pdf, arena, out=pdf)
    return pdf, pdf


def albedo(params, n, wo, arena):
    """1: all is reflected."""
    return 1.0
