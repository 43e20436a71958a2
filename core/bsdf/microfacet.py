# SPDX-License-Identifier: GPL-3.0-or-later
"""The GGX microfacet distribution with height-correlated Smith masking, safe in float32 from α = 1e-4 on.

With s(w) = sqrt(cos² + α² sin²), Smith's terms need no division by a vanishing cosine:

    G1(o)/(4 cos_o) = 1/(2 (cos_o + s_o))
    G2(o, i)/(4 cos_o) = cos_i/(2 (cos_i s_o + cos_o s_i))
    G2/G1 = cos_i (cos_o + s_o)/(cos_i s_o + cos_o s_i)

Sources: Walter et al., "Microfacet Models for Refraction through Rough Surfaces", EGSR 2007; Heitz, "Understanding the
Masking-Shadowing Function", JCGT 3(2), 2014; Dupuy and Benyoub, "Sampling Visible GGX Normals with Spherical Caps",
2023.
"""

from __future__ import annotations

import math

import numpy as np

from .. import vecmath
from ..limits import at_least, at_most
from ..sampling import warp
from ..vecmath import dot

MIN_ALPHA = 1e-4
"""Rough lobes clamp α to it."""

SMOOTH_ALPHA = 7e-4
"""A constant α up to it is a mirror: the lobe is narrower than 0.1° (Cycles' limit is α² = 5e-7)."""

_TINY = 1e-20


def clamp_alpha(alpha):
    """α kept where the distribution is exact in float32; constants stay (1,)."""
    return np.maximum(alpha, MIN_ALPHA)


def distribution(stretched2, cos2, alpha2, arena, out=None):
    """GGX density of normals in the sum-of-squares form 1/(π αx αy (stretched² + cos²)²), (N,).

    `stretched2` is (x/αx)² + (y/αy)² of the unit half vector, `cos2` its z², `alpha2` the product αx αy.
    """
    if out is None:
        out = arena.empty(max(stretched2.size, alpha2.size))
    np.add(stretched2, cos2, out=out)
    np.multiply(out, out, out=out)
    np.multiply(out, alpha2, out=out)
    at_least(out, _TINY, out)
    return np.divide(1.0 / math.pi, out, out=out)


def distribution_about(n, h, along, length2, alpha, arena, out):
    """`distribution`, isotropic, of half vectors `h` (3, N) of any length around the normals `n`, (N,).

    `along` (N,) is h·n, which is overwritten, and `length2` (N,) is h·h. sin² comes from the part of `h` across the
    normal: 1 - cos² would be noise at small α.
    """
    with arena.frame():
        across, a2 = arena.empty(h.shape), np.multiply(alpha, alpha)
        np.multiply(n, along, out=across)
        np.subtract(h, across, out=across)
        stretched2 = dot(across, across, arena)
        np.divide(stretched2, a2, out=stretched2)
        np.multiply(along, along, out=along)
        distribution(stretched2, along, a2, arena, out=out)
        np.multiply(out, length2, out=out)
        np.multiply(out, length2, out=out)
    return out


def sample_visible_normal(wo, alpha_x, alpha_y, u0, u1, arena):
    """Unit microfacet normals that `wo` sees, in the local frame, (3, N).

    Parameters
    ----------
    wo : (3, N)
        Viewing direction in the local frame, z >= 0.

    The view is stretched to the hemisphere configuration, where visible normals are half vectors between the view and
    a uniform point of a spherical cap. Source: Dupuy and Benyoub 2023, listing 3.
    """
    n = u0.shape[-1]
    h = arena.empty((3, n))
    x, y, z = h
    with arena.frame():
        view = arena.empty((3, n))
        np.multiply(wo[0], alpha_x, out=view[0])
        np.multiply(wo[1], alpha_y, out=view[1])
        np.copyto(view[2], wo[2])
        vecmath.normalize(view, arena, out=view)
        top, sine = arena.empty(n), arena.empty(n)
        np.add(view[2], 1.0, out=top)
        np.multiply(top, u1, out=top)  # 1 - z of the cap's point
        np.subtract(2.0, top, out=sine)
        np.multiply(sine, top, out=sine)
        at_least(sine, 0.0, sine)
        np.sqrt(sine, out=sine)
        np.subtract(1.0, top, out=z)
        np.multiply(u0, 2.0 * math.pi, out=top)
        warp.circle(top, sine, x, y)
        np.add(h, view, out=h)
        np.multiply(x, alpha_x, out=x)
        np.multiply(y, alpha_y, out=y)
        at_least(z, 1e-7, z)
    return vecmath.normalize(h, arena, out=h)


def sample_half(n, wo, alpha, u0, u1, arena):
    """Visible half vectors around `n` in world space (3, N) and their density of normals D (N,), isotropic."""
    count = u0.shape[-1]
    h, d = arena.empty((3, count)), arena.empty(count)
    with arena.frame():
        s, t = vecmath.frame(n, arena)
        local = vecmath.to_local(wo, s, t, n, arena)
        at_least(local[2], 0.0, local[2])
        local_h = sample_visible_normal(local, alpha, alpha, u0, u1, arena)
        np.copyto(h, vecmath.to_world(local_h, s, t, n, arena))
        np.multiply(local_h, local_h, out=local_h)
        across, a2 = arena.empty(count), np.multiply(alpha, alpha)
        np.add(local_h[0], local_h[1], out=across)
        np.divide(across, a2, out=across)
        distribution(across, local_h[2], a2, arena, out=d)
    return h, d


def slant(cosine, a2, rest, arena):
    """Return s = sqrt(cos² + α² (1 - cos²)), (N,), of `a2` = α² and `rest` = 1 - α²."""
    out = np.multiply(cosine, cosine, out=arena.empty(max(cosine.size, a2.size)))
    np.multiply(out, rest, out=out)
    np.add(out, a2, out=out)
    return np.sqrt(out, out=out)


def smith(cos_o, cos_i, alpha, arena, g1, ratio):
    """Write G1/(4 cos_o) to `g1` and G2/G1 to `ratio`, (N,) each; both are 0 where a cosine is not positive.

    The cosines are clamped to >= 0 in place.
    """
    with arena.frame():
        keep = np.minimum(cos_o, cos_i, out=arena.empty(cos_o.shape))
        keep = np.greater(keep, 0.0, out=arena.empty(cos_o.shape, bool))
        at_least(cos_o, 0.0, cos_o)
        at_least(cos_i, 0.0, cos_i)
        a2 = np.multiply(alpha, alpha, out=arena.empty(alpha.shape))
        rest = np.subtract(1.0, a2, out=arena.empty(alpha.shape))
        s_o, s_i = slant(cos_o, a2, rest, arena), slant(cos_i, a2, rest, arena)
        np.add(cos_o, s_o, out=g1)
        np.multiply(g1, cos_i, out=ratio)
        np.multiply(s_o, cos_i, out=s_o)
        np.multiply(s_i, cos_o, out=s_i)
        np.add(s_o, s_i, out=s_o)
        at_least(s_o, _TINY, s_o)
        np.divide(ratio, s_o, out=ratio)
        np.divide(0.5, g1, out=g1)
        np.multiply(ratio, keep, out=ratio)
        np.multiply(g1, keep, out=g1)


def sample_reflection(n, wo, alpha, u0, u1, arena):
    """Reflection at visible normals: wi (3, N), weight G2/G1, pdf and dot(wo, h), (N,) each; F is the caller's."""
    count = u0.shape[-1]
    wi, weight, pdf, cos_h = arena.empty((3, count)), arena.empty(count), arena.empty(count), arena.empty(count)
    with arena.frame():
        alpha = clamp_alpha(alpha)
        h, d = sample_half(n, wo, alpha, u0, u1, arena)
        dot(wo, h, arena, out=cos_h)
        at_least(cos_h, 0.0, cos_h)
        np.add(cos_h, cos_h, out=pdf)
        np.multiply(h, pdf, out=wi)
        np.subtract(wi, wo, out=wi)
        smith(dot(n, wo, arena), dot(n, wi, arena), alpha, arena, pdf, weight)
        np.multiply(pdf, d, out=pdf)
    return wi, weight, pdf, cos_h


def eval_reflection(n, wo, wi, alpha, arena):
    """f·cosθ with F = 1, pdf and dot(wo, h) of `sample_reflection` at given directions, (N,) each."""
    count = vecmath.lanes(wo, wi)
    f, pdf, cos_h = arena.empty(count), arena.empty(count), arena.empty(count)
    with arena.frame():
        alpha = clamp_alpha(alpha)
        cos_o, cos_i = dot(n, wo, arena), dot(n, wi, arena)
        h, d, along = arena.empty((3, count)), arena.empty(count), arena.empty(count)
        np.add(wo, wi, out=h)
        np.add(cos_o, cos_i, out=along)
        dot(h, h, arena, out=cos_h)
        distribution_about(n, h, along, cos_h, alpha, arena, out=d)
        np.sqrt(cos_h, out=cos_h)  # |wo + wi| = 2 dot(wo, h)
        np.multiply(cos_h, 0.5, out=cos_h)
        at_most(cos_h, 1.0, cos_h)
        smith(cos_o, cos_i, alpha, arena, pdf, f)
        np.multiply(pdf, d, out=pdf)
        np.multiply(f, pdf, out=f)
    return f, pdf, cos_h


def mirror(n, wo, arena):
    """Ideal reflection: wi (3, N), weight 1, pdf inf and dot(wo, n) (N,); 0 where `wo` is below `n`."""
    wi = vecmath.reflect(wo, n, arena)
    cosine = dot(n, wo, arena)
    above = np.greater(cosine, 0.0, out=arena.empty(cosine.shape, bool))
    weight, pdf = arena.zeros(cosine.shape), arena.zeros(cosine.shape)
    np.copyto(weight, 1.0, where=above)
    np.copyto(pdf, np.inf, where=above)
    at_least(cosine, 0.0, cosine)
    return wi, weight, pdf, cosine
