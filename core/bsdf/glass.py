# SPDX-License-Identifier: GPL-3.0-or-later
"""A boundary between two dielectrics: reflection and refraction by Fresnel's equations.

Parameters: `eta` (N,) or (1,), the relative index η_t/η_i seen from `wo`'s side; `Rough` takes `alpha`. Optional, for
Principled's transmission: `f0` (3, ·), a tinted reflectance at normal incidence, and `tint` (3, ·), the colour of what
is refracted; with one of them f and weight are (3, N).

Radiance is not scaled by 1/η² where it crosses the boundary, as in Cycles: scenes are lit from outside, where both
conventions agree, and Blender's users expect a lamp within glass to look as there. So a path's weight is its share of
energy as it stands, roulette needs no correction, and `eta` of the samples is None.
"""

from __future__ import annotations

import numpy as np

from ..limits import at_least
from ..vecmath import dot, lanes
from . import fresnel, microfacet
from .base import Lobe, LobeSample

_TINY = 1e-20
_EQUAL_INDEX = 1e-4  # closer to 1, refraction is a straight passage


def split(params, cosine, arena):
    """How light divides at a facet: reflected and transmitted share, probability of reflection, refracted cosine.

    The shares are (N,), or (3, N) with `f0` or `tint`.
    """
    eta = params["eta"]
    reflected, cos_t = fresnel.dielectric(cosine, eta, arena)
    if "f0" not in params and "tint" not in params:
        return reflected, np.subtract(1.0, reflected, out=arena.empty(reflected.shape)), reflected, cos_t
    if "f0" in params:
        reflected = fresnel.mix_to_white(params["f0"], fresnel.interpolation(reflected, eta, arena), arena)
    transmitted = arena.empty((3, cosine.size))
    np.subtract(1.0, reflected, out=transmitted)
    np.multiply(transmitted, params.get("tint", 1.0), out=transmitted)
    probability = arena.empty(cosine.shape)
    with arena.frame():
        r, t = arena.empty(cosine.shape), arena.empty(cosine.shape)
        np.mean(np.broadcast_to(reflected, transmitted.shape), axis=0, out=r)
        np.mean(transmitted, axis=0, out=t)
        np.add(r, t, out=t)
        at_least(t, _TINY, t)
        np.divide(r, t, out=probability)
    return reflected, transmitted, probability, cos_t


def albedo(params, n, wo, arena):
    """1, or with a tint the sum of both shares at the macroscopic normal."""
    if "f0" not in params and "tint" not in params:
        return 1.0
    cosine = dot(n, wo, arena)
    at_least(cosine, 0.0, cosine)
    reflected, transmitted, _, _ = split(params, cosine, arena)
    return np.add(reflected, transmitted, out=transmitted)


def _bend(wo, h, cos_h, cos_t, eta, reflects, arena):
    """Directions wo reflected at `h` or refracted through it, (3, N)."""
    wi = arena.empty(wo.shape)
    with arena.frame():
        along, back, straight = arena.empty(cos_h.shape), arena.empty(cos_h.shape), arena.empty(wo.shape)
        np.divide(cos_h, eta, out=along)
        np.subtract(along, cos_t, out=along)
        np.add(cos_h, cos_h, out=along, where=reflects)
        np.divide(1.0, eta, out=back)
        np.copyto(back, 1.0, where=reflects)
        np.multiply(h, along, out=wi)
        np.multiply(wo, back, out=straight)
        np.subtract(wi, straight, out=wi)
    return wi


def _choose(reflects, a, b, arena):
    """`a` where the lane reflects, else `b`."""
    out = arena.empty(np.broadcast_shapes(a.shape, b.shape, reflects.shape))
    np.copyto(out, b)
    np.copyto(out, a, where=reflects)
    return out


def _weigh_choice(weight, pdf, reflected, transmitted, probability, reflects, arena):
    """`weight` times share/probability of the way taken, which is 1 when the shares are the probabilities.

    Where the share is 0, so becomes `pdf`: the sample failed.
    """
    if reflected is probability:
        return weight
    share = _choose(reflects, reflected, transmitted, arena)
    with arena.frame():
        q = _choose(reflects, probability, np.subtract(1.0, probability), arena)
        at_least(q, _TINY, q)
        np.divide(share, q, out=share)
    np.multiply(share, weight, out=share)
    np.copyto(pdf, 0.0, where=np.logical_not(share.reshape(-1, pdf.size).any(axis=0)))
    return share


def _jacobian(cos_h, cos_t, eta, arena):
    """4 (o·h) dω_h/dω_i of refraction: it turns a density of reflection D G1/(4 cos) into one of refraction.

    dω_h/dω_i = η² |i·h|/(o·h + η i·h)². Source: Walter et al. 2007, eq. 17.
    """
    out = arena.empty(cos_h.shape)
    with arena.frame():
        t = arena.empty(cos_h.shape)
        np.multiply(cos_t, eta, out=t)
        np.multiply(t, cos_h, out=out)
        np.multiply(out, eta, out=out)
        np.multiply(out, 4.0, out=out)
        np.subtract(cos_h, t, out=t)
        np.multiply(t, t, out=t)
        at_least(t, _TINY, t)
        np.divide(out, t, out=out)
    return out


class Rough:
    """GGX microfacets of glass. Where the indices are equal, refraction passes straight on as a delta lobe."""

    flags = Lobe.REFLECTION | Lobe.TRANSMISSION | Lobe.GLOSSY
    split = staticmethod(split)
    albedo = staticmethod(albedo)

    @classmethod
    def sample(cls, params, n, wo, uc, u0, u1, arena):
        """A visible half vector, then reflection where `uc` < the probability of reflection."""
        alpha, eta = microfacet.clamp_alpha(params["alpha"]), params["eta"]
        weight, pdf = arena.empty(uc.shape), arena.empty(uc.shape)
        h, d = microfacet.sample_half(n, wo, alpha, u0, u1, arena)
        cos_h = at_least(dot(wo, h, arena), 0.0, arena.empty(uc.shape))
        reflected, transmitted, p, cos_t = cls.split(params, cos_h, arena)
        reflects = np.less(uc, p, out=arena.empty(uc.shape, bool))
        np.logical_or(reflects, cos_h == 0.0, out=reflects)  # seen from below: fails, but with a unit direction
        wi = _bend(wo, h, cos_h, cos_t, eta, reflects, arena)
        with arena.frame():
            cos_i = dot(n, wi, arena)
            np.negative(cos_i, out=cos_i, where=np.logical_not(reflects, out=arena.empty(uc.shape, bool)))
            microfacet.smith(dot(n, wo, arena), cos_i, alpha, arena, pdf, weight)
            np.multiply(pdf, d, out=pdf)
            factor = _jacobian(cos_h, cos_t, eta, arena)
            q = np.subtract(1.0, p, out=arena.empty(uc.shape))
            np.multiply(factor, q, out=factor)
            np.copyto(factor, p, where=reflects)
            np.multiply(pdf, factor, out=pdf)
            straight = np.less(np.abs(eta - 1.0), _EQUAL_INDEX)
            if straight.any():
                through = straight & ~reflects & (pdf > 0.0)
                np.copyto(pdf, np.inf, where=through)
                np.copyto(weight, 1.0, where=through)
            np.multiply(weight, pdf > 0.0, out=weight)
        return LobeSample(wi, _weigh_choice(weight, pdf, reflected, transmitted, p, reflects, arena), pdf)

    @classmethod
    def eval_pdf(cls, params, n, wo, wi, arena):
        """f·|cosθ| and the density, reflection above `n` and refraction below."""
        count = lanes(wo, wi)
        alpha, eta = microfacet.clamp_alpha(params["alpha"]), params["eta"]
        f, pdf = arena.empty(count), arena.empty(count)
        cos_o, cos_i = dot(n, wo, arena), dot(n, wi, arena)
        reflects = np.greater(cos_i, 0.0, out=arena.empty(count, bool))
        h, d, cos_h, factor = arena.empty((3, count)), arena.empty(count), arena.empty(count), arena.empty(count)
        with arena.frame():
            scale, length = arena.empty(count), arena.empty(count)
            np.copyto(scale, eta)
            np.copyto(scale, 1.0, where=reflects)
            np.multiply(wi, scale, out=h)
            np.add(h, wo, out=h)
            dot(h, h, arena, out=length)
            at_least(length, _TINY, length)
            np.sqrt(length, out=length)
            along = dot(h, n, arena)
            np.copysign(length, along, out=length)
            np.divide(h, length, out=h)
            np.divide(along, length, out=along)
            microfacet.distribution_about(n, h, along, np.float32(1), alpha, arena, out=d)
            dot(wo, h, arena, out=cos_h)
            # `wo` must see the facet's front, and a refracted `wi` its back: η i·h = |wo + η wi| - o·h < 0.
            facing = np.less(length, cos_h, out=arena.empty(count, bool))
            np.logical_or(facing, reflects, out=facing)
            np.logical_and(facing, np.greater(cos_h, 0.0), out=facing)
            at_least(cos_h, 0.0, cos_h)
            np.abs(cos_i, out=cos_i)
            microfacet.smith(cos_o, cos_i, alpha, arena, pdf, f)
            np.multiply(d, facing, out=d)
            np.multiply(pdf, d, out=pdf)
        reflected, transmitted, p, cos_t = cls.split(params, cos_h, arena)
        np.copyto(factor, _jacobian(cos_h, cos_t, eta, arena))
        np.copyto(factor, 0.0, where=np.less(np.abs(eta - 1.0), _EQUAL_INDEX))
        np.copyto(factor, 1.0, where=reflects)
        np.multiply(pdf, factor, out=pdf)
        np.multiply(f, pdf, out=f)
        share = _choose(reflects, reflected, transmitted, arena)
        if reflected is not p:  # samples without a share fail
            np.multiply(pdf, share.reshape(-1, count).any(axis=0), out=pdf)
        np.multiply(share, f, out=share)
        q = np.subtract(1.0, p, out=arena.empty(count))
        np.copyto(q, p, where=reflects)
        return share, np.multiply(pdf, q, out=pdf)


class Smooth:
    """Clear glass."""

    flags = Lobe.REFLECTION | Lobe.TRANSMISSION | Lobe.DELTA
    split = staticmethod(split)
    albedo = staticmethod(albedo)

    @classmethod
    def sample(cls, params, n, wo, uc, u0, u1, arena):
        """Reflection where `uc` < the probability of reflection, else refraction."""
        cos_o = dot(n, wo, arena)
        above = np.greater(cos_o, 0.0, out=arena.empty(uc.shape, bool))
        at_least(cos_o, 0.0, cos_o)
        reflected, transmitted, p, cos_t = cls.split(params, cos_o, arena)
        reflects = np.less(uc, p, out=arena.empty(uc.shape, bool))
        np.logical_or(reflects, cos_o == 0.0, out=reflects)  # seen from below: fails, but with a unit direction
        wi = _bend(wo, n, cos_o, cos_t, params["eta"], reflects, arena)
        weight, pdf = arena.zeros(uc.shape), arena.zeros(uc.shape)
        np.copyto(weight, 1.0, where=above)
        np.copyto(pdf, np.inf, where=above)
        return LobeSample(wi, _weigh_choice(weight, pdf, reflected, transmitted, p, reflects, arena), pdf)
