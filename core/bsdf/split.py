# SPDX-License-Identifier: GPL-3.0-or-later
"""A mixture that also tells what of its light is diffuse.

Two parts are enough: what is not diffuse was reflected on the viewer's side of the surface and transmitted on the
other, because no lobe leaks.
"""

from __future__ import annotations

import numpy as np

from .base import Lobe


class SplitMixture:
    """Does what `mixture` does, bit for bit, and tells the diffuse part beside it.

    Parameters
    ----------
    mixture : Mixture
    """

    def __init__(self, mixture):
        self._mixture = mixture
        self.lobes, self.is_smooth = mixture.lobes, mixture.is_smooth
        self.shares = mixture.shares
        diffuse = [Lobe.DIFFUSE in lobe.flags for lobe in mixture.lobes]
        self._all, self._any = all(diffuse), any(diffuse)

    def eval_pdf(self, entries, surface, wi, arena, shares=None):
        """f·|cosθ| (2, 3, N), of all lobes and of the diffuse ones, and the density (N,) of all."""
        both = arena.empty((2, *wi.shape))
        f, pdf = self._mixture.eval_pdf(entries, surface, wi, arena, shares)
        both[0] = f
        if self._all:
            both[1] = f
        elif self._any:
            both[1] = self._mixture.eval_diffuse(entries, surface, wi, arena)
        else:
            both[1] = 0
        return both, pdf

    def sample(self, entries, surface, uc, u0, u1, arena, shares=None, with_flags=False):
        """A `BSDFSample` with `diffuse`; directions of delta lobes, whose density is infinite, have no such part."""
        sample = self._mixture.sample(entries, surface, uc, u0, u1, arena, shares, with_flags)
        if self._all or not self._any:
            return sample._replace(diffuse=arena.full(sample.wi.shape, float(self._all)))
        part = self._mixture.eval_diffuse(entries, surface, sample.wi, arena)
        with arena.frame():
            density = arena.zeros(sample.pdf.shape)
            np.copyto(density, sample.pdf, where=np.isfinite(sample.pdf))
            share_of(part, np.multiply(sample.weight, density, out=arena.empty(part.shape)), out=part)
        return sample._replace(diffuse=part)


def share_of(part, whole, out):
    """Share in [0, 1] that `part` is of `whole`, 0 where that is nothing."""
    there = whole != 0
    np.divide(part, whole, out=out, where=there)
    np.copyto(out, 0.0, where=~there)
    return np.clip(out, 0.0, 1.0, out=out)
