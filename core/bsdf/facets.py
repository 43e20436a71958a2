# SPDX-License-Identifier: GPL-3.0-or-later
"""Microfacets in a local frame: distributions that may be stretched along a tangent, and reflection by them.

`microfacet` is the isotropic GGX of most surfaces, made to be fast; this is everything else. Parameters: `alpha`, the
geometric mean of the two widths; optionally `stretch`, by which the width along `tangent` (3, N) is larger than the
mean and that across smaller. Without `tangent` the surface is isotropic.

A distribution is a class with

    sample(wo, ax, ay, u0, u1, arena) -> h (3, N)   unit normals that wo sees, in the local frame
    density(h, ax, ay, arena) -> (N,)               D of unit normals
    projected(w, ax, ay, arena) -> (N,)             σ(w) = cosθ/G1(w), the area of facets that w sees

With them, reflection has pdf D/(4 σ_o), and f·cosθ/pdf is G2/G1 = σ_o cos_i/(σ_o cos_i + σ_i cos_o - cos_o cos_i),
which no grazing angle makes infinite. Source: Heitz, "Understanding the Masking-Shadowing Function", JCGT 3(2), 2014.
"""

from __future__ import annotations

import functools

import numpy as np

from .. import vecmath
from ..limits import at_least, within
from ..vecmath import dot
from . import beckmann, microfacet, tangents
from .base import Lobe, LobeSample

_TINY = 1e-20


class GGX:
    """Trowbridge and Reitz' distribution."""

    @staticmethod
    def sample(wo, ax, ay, u0, u1, arena):
        """Visible normals."""
        return microfacet.sample_visible_normal(wo, ax, ay, u0, u1, arena)

    @staticmethod
    def density(h, ax, ay, arena):
        """1/(π αx αy ((x/αx)² + (y/αy)² + z²)²)."""
        return microfacet.distribution(stretched(h, 1.0 / ax, 1.0 / ay, arena), h[2] * h[2], ax * ay, arena)

    @staticmethod
    def projected(w, ax, ay, arena):
        """(cosθ + sqrt(cos²θ + (αx x)² + (αy y)²))/2."""
        out = stretched(w, ax, ay, arena)
        np.add(out, w[2] * w[2], out=out)
        np.sqrt(out, out=out)
        np.add(out, w[2], out=out)
        return np.multiply(out, 0.5, out=out)


class Beckmann:
    """Beckmann and Spizzichino's distribution: slopes are normal."""

    sample = staticmethod(beckmann.sample_visible_normal)
    projected = staticmethod(beckmann.projected)
    density = staticmethod(beckmann.density)


def stretched(v, x, y, arena):
    """(x v_x)² + (y v_y)², (N,)."""
    out, t = arena.empty(v.shape[-1]), arena.empty(v.shape[-1])
    np.multiply(v[0], x, out=out)
    np.multiply(out, out, out=out)
    np.multiply(v[1], y, out=t)
    np.multiply(t, t, out=t)
    return np.add(out, t, out=out)


def axes(params):
    """Widths along the tangent and across it."""
    alpha = params["alpha"]
    if "tangent" not in params:
        alpha = microfacet.clamp_alpha(alpha)
        return alpha, alpha
    stretch = params["stretch"]
    return tuple(np.clip(a, microfacet.MIN_ALPHA, 1.0) for a in (alpha * stretch, alpha / stretch))


def mean_alpha(params):
    """The isotropic width that loses as much energy."""
    ax, ay = axes(params)
    return np.sqrt(ax * ay)


def basis(params, n, arena):
    """(s, t): along the tangent, if there is one."""
    if "tangent" in params:
        return tangents.along(n, params["tangent"], arena)
    return vecmath.frame(n, arena)


@functools.cache
def reflection(facets, reflectance=None):
    """The lobe of `facets` that reflect ``reflectance(params, cosine, arena)``, (N,) or (3, N); None reflects all."""
    body = {"facets": facets, "__doc__": f"Reflection by {facets.__name__} facets."}
    if reflectance is not None:
        body["reflectance"] = staticmethod(reflectance)
    return type("Rough", (_Rough,), body)


class _Rough:
    """Reflection at visible normals."""

    flags = Lobe.REFLECTION | Lobe.GLOSSY
    facets = None
    reflectance = None

    @classmethod
    def sample(cls, params, n, wo, uc, u0, u1, arena):
        count = u0.shape[-1]
        wi, weight, pdf, cos_h = arena.empty((3, count)), arena.empty(count), arena.empty(count), arena.empty(count)
        with arena.frame():
            ax, ay = axes(params)
            s, t = basis(params, n, arena)
            o = vecmath.to_local(wo, s, t, n, arena)
            below = o[2] <= 0.0
            at_least(o[2], 0.0, o[2])
            h = cls.facets.sample(o, ax, ay, u0, u1, arena)
            at_least(dot(o, h, arena), 0.0, cos_h)
            i = np.subtract(h * (2.0 * cos_h), o, out=arena.empty((3, count)))
            vecmath.normalize(i, arena, out=i)
            np.copyto(wi, vecmath.to_world(i, s, t, n, arena))
            cls._weigh(o, i, h, ax, ay, arena, weight, pdf)
            np.copyto(weight, 0.0, where=below)
            np.copyto(pdf, 0.0, where=below)
        return LobeSample(wi, cls._reflected(params, weight, cos_h, arena), pdf)

    @classmethod
    def eval_pdf(cls, params, n, wo, wi, arena):
        count = vecmath.lanes(wo, wi)
        f, pdf, cos_h = arena.empty(count), arena.empty(count), arena.empty(count)
        with arena.frame():
            ax, ay = axes(params)
            s, t = basis(params, n, arena)
            o, i = vecmath.to_local(wo, s, t, n, arena), vecmath.to_local(wi, s, t, n, arena)
            h = np.add(o, i, out=arena.empty((3, count)))
            vecmath.normalize(h, arena, out=h)
            within(dot(o, h, arena), 0.0, 1.0, cos_h)
            cls._weigh(o, i, h, ax, ay, arena, f, pdf)
            np.multiply(f, pdf, out=f)
        return cls._reflected(params, f, cos_h, arena), pdf

    @classmethod
    def albedo(cls, params, n, wo, arena):
        """The reflectance at the macroscopic normal: an estimate."""
        if cls.reflectance is None:
            return 1.0
        cosine = dot(n, wo, arena)
        return cls.reflectance(params, within(cosine, 0.0, 1.0, cosine), arena)

    @classmethod
    def _weigh(cls, o, i, h, ax, ay, arena, ratio, pdf):
        """Write G2/G1 and the density of local unit directions; both are 0 where one is not above the surface."""
        above = np.minimum(o[2], i[2]) > 0.0
        for w in (o, i):
            at_least(w[2], 0.0, w[2])
        np.copyto(ratio, masking(cls.facets, o, i, ax, ay, arena))
        np.divide(cls.facets.density(h, ax, ay, arena), 4.0 * cls.facets.projected(o, ax, ay, arena), out=pdf)
        np.multiply(ratio, above, out=ratio)
        np.multiply(pdf, above, out=pdf)
        np.multiply(ratio, pdf > 0.0, out=ratio)

    @classmethod
    def _reflected(cls, params, value, cosine, arena):
        if cls.reflectance is None:
            return value
        reflectance = cls.reflectance(params, cosine, arena)
        return np.multiply(reflectance, value, out=arena.empty(reflectance.shape))


def masking(facets, o, i, ax, ay, arena):
    """G2/G1 of directions on the same side, in local frames with z >= 0, (N,)."""
    out = arena.empty(o.shape[-1])
    with arena.frame():
        seen_o, seen_i = facets.projected(o, ax, ay, arena), facets.projected(i, ax, ay, arena)
        np.multiply(seen_o, i[2], out=out)
        np.multiply(np.subtract(seen_i, i[2], out=seen_i), o[2], out=seen_i)
        np.add(seen_i, out, out=seen_i)
        np.divide(out, at_least(seen_i, _TINY, seen_i), out=out)
    return out
