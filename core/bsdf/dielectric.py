# SPDX-License-Identifier: GPL-3.0-or-later
"""The reflecting surface of a dielectric over something else, e.g. the varnish over Principled's diffuse base.

Parameters: `eta` (η_t/η_i); `f0`, the reflectance at normal incidence, (1,), (N,) or tinted (3, ·), to which the exact
curve of `eta` is carried over; `Rough` takes `alpha`. f and weight are (N,) or (3, N), as `f0` is.
"""

from __future__ import annotations

from . import fresnel, glossy


def reflectance(params, cosine, arena):
    """Exact reflectance between `f0` and white, (N,) or (3, N)."""
    eta = params["eta"]
    exact, _ = fresnel.dielectric(cosine, eta, arena)
    return fresnel.mix_to_white(params["f0"], fresnel.interpolation(exact, eta, arena, out=exact), arena)


class Rough(glossy.Rough):
    """GGX microfacets."""

    reflectance = staticmethod(reflectance)


class Mirror(glossy.Mirror):
    """A smooth surface."""

    reflectance = staticmethod(reflectance)
