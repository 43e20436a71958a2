# SPDX-License-Identifier: GPL-3.0-or-later
"""The upper layers of Blender's Principled BSDF: sheen over coat over all the rest.

Each layer takes what is left of the light, `below` (3, N) or (3, 1), and returns it lessened by what it reflects or
swallows. What a layer reflects is lost to those below in all channels alike, by its brightest.

Source: the Principled node of Cycles 4 and 5, compared by rendering.
"""

from __future__ import annotations

import numpy as np

from ..limits import at_least
from ..vecmath import dot, normalize
from . import dielectric, energy, fresnel, sheen


def facing(n, wo, arena):
    """Cosine of the view, (N,), at least 0."""
    return at_least(dot(n, wo, arena), 0.0, arena.empty(wo.shape[-1]))


def sheen_layer(x, n, wo, below, arena):
    """(lobe, weight, params) of the sheen, and what is left below it."""
    a, b, reflected = sheen.transform(facing(n, wo, arena), x["sheen_roughness"], arena)
    share = x["sheen_weight"] * x["sheen_tint"] * reflected
    return (sheen, below * share, {"a": a, "b": b}), _lessened(below, share)


def coat_layer(lobe, x, n, wo, below, arena, regains=True):
    """(lobe, weight, params) of the coat, and what is left below it; `lobe` is `dielectric.Rough` or `Mirror`.

    A rough coat `regains` the energy that single scattering loses. Before Blender 4.5 it does not, and dims what lies
    below as if it were smooth.
    """
    mu, ior = facing(n, wo, arena), np.maximum(x["coat_ior"], 1.0)
    f0 = fresnel.f0_from_ior(ior)
    params, weight = {"eta": ior, "f0": f0}, below * x["coat_weight"]
    if lobe is dielectric.Rough:
        params["alpha"] = alpha = np.square(x["coat_roughness"])
    if lobe is dielectric.Rough and regains:
        e, average = energy.reflection(mu, alpha, arena)
        factor = energy.compensation(e, average, fresnel.dielectric_average(ior))
        reflected = factor * e * (f0 + (1.0 - f0) * energy.schlick(mu, alpha, ior, arena))
        weight = weight * factor
    else:
        reflected, _ = fresnel.dielectric(mu, ior, arena)
    below = _lessened(below, (x["coat_weight"] * reflected).reshape(1, -1))
    return (lobe, weight, params), _tinted(x, mu, ior, below)


def sheen_normal(x, n, coat_normal, arena):
    """Normal of the sheen, (3, N): the coat's as far as there is coat, else `n`; neither raised, as in Cycles."""
    if coat_normal is None:
        return n
    return normalize(n + (coat_normal - n) * np.clip(x.get("coat_weight", 0.0), 0.0, 1.0), arena)


def _tinted(x, mu, ior, below):
    """`below` through a tinted coat: the tint is that of light straight down and up again.

    On slanted ways it is deeper by 1/cosθ of the refracted ray, by Beer's law.
    """
    tint = x["coat_tint"]
    if bool((tint == 1.0).all()):
        return below
    cos_t = np.sqrt(1.0 - (1.0 - mu * mu) / (ior * ior))
    through = np.power(np.maximum(tint, 0.0), 1.0 / np.maximum(cos_t, 1e-4))
    return below * (1.0 + x["coat_weight"] * (through - 1.0))


def _lessened(below, share):
    """`below` less the largest channel of `share` (C, N)."""
    return below * np.maximum(1.0 - share.max(axis=0), 0.0)
