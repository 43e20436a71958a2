# SPDX-License-Identifier: GPL-3.0-or-later
"""Metals: reflection with the F82-tint Fresnel curve.

Parameters: `f0` (3, N) or (3, 1), the reflectance at normal incidence; `tint`, alike, what scales Schlick's curve near
82°; `Rough` takes `alpha`. f and weight are (3, N).
"""

from __future__ import annotations

from . import fresnel, glossy


def reflectance(params, cosine, arena):
    """F82-tint reflectance, (3, N)."""
    f0 = params["f0"]
    return fresnel.f82_tint(cosine, f0, fresnel.f82_drop(f0, params["tint"]), arena)


class Rough(glossy.Rough):
    """GGX microfacets of metal."""

    reflectance = staticmethod(reflectance)


class Mirror(glossy.Mirror):
    """Polished metal."""

    reflectance = staticmethod(reflectance)
