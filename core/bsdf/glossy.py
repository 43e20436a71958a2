# SPDX-License-Identifier: GPL-3.0-or-later
"""Reflection: a mirror, or GGX microfacets that are mirrors.

`Rough` takes `alpha` (N,) or (1,), the square of Blender's roughness. Here nothing is lost at the facets; `conductor`
and `dielectric` put a Fresnel curve in the place of `reflectance`.
"""

from __future__ import annotations

import numpy as np

from ..limits import at_least
from ..vecmath import dot
from . import microfacet
from .base import Lobe, LobeSample


def _all(params, cosine, arena):
    """F = 1: no factor."""
    return None


class _Reflection:
    """What rough and polished surfaces share.

    ``reflectance(params, cosine, arena)`` gives F (N,) or (3, N) at cosines (N,) to the facet, None for 1.
    """

    reflectance = staticmethod(_all)

    @classmethod
    def albedo(cls, params, n, wo, arena):
        """F at the macroscopic normal."""
        cosine = dot(n, wo, arena)
        at_least(cosine, 0.0, cosine)
        reflectance = cls.reflectance(params, cosine, arena)
        return 1.0 if reflectance is None else reflectance

    @classmethod
    def _reflected(cls, params, value, cosine, arena):
        """F times `value` (N,)."""
        reflectance = cls.reflectance(params, cosine, arena)
        return value if reflectance is None else np.multiply(reflectance, value, out=reflectance)


class Rough(_Reflection):
    """GGX reflection."""

    flags = Lobe.REFLECTION | Lobe.GLOSSY

    @classmethod
    def sample(cls, params, n, wo, uc, u0, u1, arena):
        """Reflection at a normal that `wo` sees."""
        wi, weight, pdf, cos_h = microfacet.sample_reflection(n, wo, params["alpha"], u0, u1, arena)
        return LobeSample(wi, cls._reflected(params, weight, cos_h, arena), pdf)

    @classmethod
    def eval_pdf(cls, params, n, wo, wi, arena):
        """f·cosθ and the density of `sample`."""
        f, pdf, cos_h = microfacet.eval_reflection(n, wo, wi, params["alpha"], arena)
        return cls._reflected(params, f, cos_h, arena), pdf


class Mirror(_Reflection):
    """Ideal reflection."""

    flags = Lobe.REFLECTION | Lobe.DELTA

    @classmethod
    def sample(cls, params, n, wo, uc, u0, u1, arena):
        """The mirrored direction."""
        wi, weight, pdf, cosine = microfacet.mirror(n, wo, arena)
        return LobeSample(wi, cls._reflected(params, weight, cosine, arena), pdf)
