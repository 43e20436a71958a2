# SPDX-License-Identifier: GPL-3.0-or-later
"""A diffuse lobe whose normal was turned away from the surface's own, softened towards the shadow's edge.

A turned normal lets light arrive up to where the true surface is in its own shadow, and the edge there is hard. The
surface is therefore taken for one of facets that are as steep as the normal is turned, and light is lessened by what
they mask. Source: Conty Estevez, Lecocq and Stein, "A Microfacet-Based Shadowing Function to Solve the Bump Terminator
Problem", Ray Tracing Gems, 2019.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from ..vecmath import dot
from .base import LobeSample

SMOOTH = "smooth_normal"  # name of the parameter that is the surface's own shading normal


class Bumped:
    """`lobe` with the softening; its parameters have one more, `SMOOTH`.

    Not `is_soft`, it only loses the light from behind the surface; `is_older`, it is softened as before Blender 4.5.
    """

    def __init__(self, lobe, is_soft=True, is_older=False):
        soft = older_softening if is_older else softening
        self._lobe, self._share = lobe, soft if is_soft else before
        self.flags = lobe.flags

    def sample(self, params, n, wo, uc, u0, u1, arena):
        """As of the lobe."""
        s = self._lobe.sample(params, n, wo, uc, u0, u1, arena)
        return LobeSample(s.wi, s.weight * self._share(params[SMOOTH], n, s.wi, arena), s.pdf, s.eta)

    def eval_pdf(self, params, n, wo, wi, arena):
        """As of the lobe."""
        f, pdf = self._lobe.eval_pdf(params, n, wo, wi, arena)
        return f * self._share(params[SMOOTH], n, wi, arena), pdf

    def albedo(self, params, n, wo, arena):
        """As of the lobe."""
        return self._lobe.albedo(params, n, wo, arena)


@cache
def bumped(lobe, is_soft=True, is_older=False):
    """The `Bumped` of a lobe, always the same one."""
    return Bumped(lobe, is_soft, is_older)


def before(smooth, n, wi, arena):
    """1 (N,) where `wi` is on the side of the normals `smooth` on which it is of the turned ones `n`, elsewhere 0."""
    out = arena.empty(wi.shape[-1])
    with arena.frame():
        np.copyto(out, dot(smooth, wi, arena) * dot(smooth, n, arena) * dot(n, wi, arena) >= 0)
    return out


def softening(smooth, n, wi, arena):
    """Share (N,) of the light from `wi` that arrives at a surface with normals `smooth` that were turned to `n`."""
    out = arena.empty(wi.shape[-1])
    with arena.frame():
        incident, turned = dot(smooth, wi, arena), dot(smooth, n, arena)
        behind = incident * turned * dot(n, wi, arena) < 0
        np.minimum(np.square(incident, out=incident), 1, out=incident)
        np.minimum(np.square(turned, out=turned), 1, out=turned)
        np.maximum(incident, np.float32(1e-12), out=incident)
        np.maximum(turned, np.float32(1e-12), out=turned)
        alpha_squared = np.minimum(0.125 * (1 / turned - 1), 1)
        np.divide(2, 1 + np.sqrt(1 + alpha_squared * (1 / incident - 1)), out=out)
        np.copyto(out, 0, where=behind)
    return out


def older_softening(smooth, n, wi, arena):
    """`softening` as it was before Blender 4.5.

    With g, the cosine of light on the smooth normal over the product of those of light and of the smooth normal on the
    turned one, it is -g³ + g² + g between 0 and 1, where it reaches 0 and 1. Source: Chiang, Li and Burley, "Taming the
    Shadow Terminator", SIGGRAPH 2019 Talks.
    """
    out = arena.empty(wi.shape[-1])
    with arena.frame():
        turned = dot(n, wi, arena) * dot(smooth, n, arena)
        g = dot(smooth, wi, arena) * np.sign(turned) / np.maximum(np.abs(turned), np.float32(1e-12))
        np.clip(g, 0, 1, out=g)
        np.multiply(g, 1 + g * (1 - g), out=out)
    return out
