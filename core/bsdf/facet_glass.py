# SPDX-License-Identifier: GPL-3.0-or-later
"""Glass and refraction by microfacets of any distribution, isotropic: Beckmann's, where Blender offers it.

Parameters as of `glass`. Source: Walter et al., "Microfacet Models for Refraction through Rough Surfaces", EGSR 2007.
"""

from __future__ import annotations

import functools

import numpy as np

from .. import vecmath
from ..limits import at_least, within
from ..vecmath import dot
from . import facets as microfacets
from . import glass, refraction
from .base import Lobe, LobeSample

_TINY = 1e-20
_EQUAL_INDEX = 1e-4  # closer to 1, refraction is a straight passage


@functools.cache
def rough(facets, kind=glass):
    """The lobe of `facets` that divides light as `kind` does: `glass`, `glass_film` or `refraction`."""
    flags = Lobe.TRANSMISSION | Lobe.GLOSSY
    if kind is not refraction:
        flags |= Lobe.REFLECTION
    body = {"facets": facets, "flags": flags, "split": staticmethod(kind.split), "albedo": staticmethod(kind.albedo)}
    return type("Rough", (_Rough,), body | {"__doc__": f"{facets.__name__} facets of {kind.__name__}."})


class _Rough:
    """A visible half vector, then reflection or refraction."""

    @classmethod
    def sample(cls, params, n, wo, uc, u0, u1, arena):
        count = uc.size
        wi, weight, pdf = arena.empty((3, count)), arena.empty((3, count)), arena.empty(count)
        with arena.frame():
            (alpha, _), eta = microfacets.axes(params), params["eta"]
            s, t = vecmath.frame(n, arena)
            o = vecmath.to_local(wo, s, t, n, arena)
            below = o[2] <= 0.0
            at_least(o[2], 0.0, o[2])
            h = cls.facets.sample(o, alpha, alpha, u0, u1, arena)
            cos_h = np.maximum(dot(o, h, arena), 0.0)
            reflected, transmitted, p, cos_t = cls.split(params, cos_h, arena)
            reflects = (uc < p) | (cos_h == 0.0) | below
            i = _bent(o, h, cos_h, cos_t, eta, reflects)
            vecmath.normalize(i, arena, out=i)
            np.copyto(wi, vecmath.to_world(i, s, t, n, arena))
            through = ~reflects & (np.abs(eta - 1.0) < _EQUAL_INDEX)
            cls._weigh(o, i, h, cos_h, cos_t, eta, alpha, reflects, arena, weight[0], pdf)
            np.multiply(pdf, np.where(reflects, p, 1.0 - p), out=pdf)
            np.copyto(pdf, np.inf, where=through & (pdf > 0.0))
            share = np.where(reflects, reflected, transmitted) / np.maximum(np.where(reflects, p, 1.0 - p), _TINY)
            ratio = np.where(through, np.float32(1.0), weight[0]) * ((pdf > 0.0) & ~below)
            np.multiply(share, ratio, out=weight)
            np.multiply(pdf, ~below & weight.any(axis=0), out=pdf, where=np.isfinite(pdf))
        return LobeSample(wi, weight, pdf)

    @classmethod
    def eval_pdf(cls, params, n, wo, wi, arena):
        count = vecmath.lanes(wo, wi)
        f, pdf = arena.empty((3, count)), arena.empty(count)
        with arena.frame():
            (alpha, _), eta = microfacets.axes(params), params["eta"]
            s, t = vecmath.frame(n, arena)
            o, i = vecmath.to_local(wo, s, t, n, arena), vecmath.to_local(wi, s, t, n, arena)
            reflects = i[2] > 0.0
            h = o + i * np.where(reflects, np.float32(1.0), eta)
            length = np.sqrt(np.maximum(dot(h, h, arena), _TINY))
            np.divide(h, np.copysign(length, h[2]), out=h)
            cos_h = dot(o, h, arena)
            # `wo` must see the facet's front, and a refracted `wi` its back.
            seen = (cos_h > 0.0) & (reflects | (dot(i, h, arena) < 0.0))
            within(cos_h, 0.0, 1.0, cos_h)
            reflected, transmitted, p, cos_t = cls.split(params, cos_h, arena)
            cls._weigh(o, i, h, cos_h, cos_t, eta, alpha, reflects, arena, f[0], pdf)
            np.multiply(pdf, seen & (reflects | (np.abs(eta - 1.0) >= _EQUAL_INDEX)), out=pdf)
            share = np.where(reflects, reflected, transmitted)
            np.multiply(pdf, share.reshape(-1, count).any(axis=0), out=pdf)  # samples without a share fail
            np.multiply(share, f[0] * pdf, out=f)
            np.multiply(pdf, np.where(reflects, p, 1.0 - p), out=pdf)
        return f, pdf

    @classmethod
    def _weigh(cls, o, i, h, cos_h, cos_t, eta, alpha, reflects, arena, ratio, pdf):
        """Write G2/G1 and the density, without the choice of the way; both 0 where a direction is on the wrong side."""
        side = np.where(reflects, i[2], -i[2])
        above = (o[2] > 0.0) & (side > 0.0)
        at_least(o[2], 0.0, o[2])
        mirrored = np.array(i)
        at_least(side, 0.0, mirrored[2])
        np.copyto(ratio, microfacets.masking(cls.facets, o, mirrored, alpha, alpha, arena))
        seen = cls.facets.density(h, alpha, alpha, arena) / cls.facets.projected(o, alpha, alpha, arena)
        np.multiply(seen, np.where(reflects, np.float32(0.25), _jacobian(cos_h, cos_t, eta)), out=pdf)
        np.multiply(pdf, above, out=pdf)
        np.multiply(ratio, above & (pdf > 0.0), out=ratio)


def _bent(o, h, cos_h, cos_t, eta, reflects):
    """`o` reflected at `h`, or refracted through it."""
    along = np.where(reflects, 2.0 * cos_h, cos_h / eta - cos_t)
    return h * along - o * np.where(reflects, np.float32(1.0), 1.0 / eta)


def _jacobian(cos_h, cos_t, eta):
    """(o·h) dω_h/dω_i of refraction, η² |i·h| (o·h)/(o·h + η i·h)². Source: Walter et al. 2007, eq. 17."""
    bend = cos_h - eta * cos_t
    return eta * eta * cos_t * cos_h / np.maximum(bend * bend, _TINY)
