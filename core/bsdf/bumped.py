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

    Not `is_soft`, it only loses the light from behind the surface.
    """

    def __init__(self, lobe, is_soft=True):
        self._lobe, self._share = lobe, softening if is_soft else before
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
def bumped(lobe, is_soft=True):
    """The `Bumped` of a lobe, always the same one."""
    return Bumped(lobe, is_soft)


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
