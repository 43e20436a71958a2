# SPDX-License-Identifier: GPL-3.0-or-later
"""Lambert transmission: diffuse light on the other side of a thin sheet."""

from __future__ import annotations

import numpy as np

from ..sampling import warp
from ..vecmath import dot
from . import diffuse
from .base import Lobe, LobeSample

flags = Lobe.TRANSMISSION | Lobe.DIFFUSE


def sample(params, n, wo, uc, u0, u1, arena):
    """Direction below the surface with density |cosθ|/π."""
    wi, weight, pdf, _ = diffuse.sample(params, n, wo, uc, u0, u1, arena)
    np.negative(wi, out=wi)
    return LobeSample(wi, weight, pdf)


def eval_pdf(params, n, wo, wi, arena):
    """f·|cosθ| = pdf = |cosθ|/π below the surface, one array for both."""
    pdf = dot(n, wi, arena)
    np.negative(pdf, out=pdf)
    warp.cosine_hemisphere_pdf(pdf, arena, out=pdf)
    return pdf, pdf


def albedo(params, n, wo, arena):
    """1: all is transmitted."""
    return 1.0
