# SPDX-License-Identifier: GPL-3.0-or-later
"""Multiple importance sampling of two techniques.

Source: Veach and Guibas, "Optimally Combining Sampling Techniques for Monte Carlo Rendering", SIGGRAPH 1995.
"""

from __future__ import annotations

import numpy as np

from ..limits import at_least, at_most

_LARGEST = 3e38  # stands for inf: a delta density against a finite one
_LARGEST_OTHER = 1e30  # so that of two infinite densities the first wins
_SMALLEST = 1e-37


def weight(pa, pb, arena, out=None):
    """Power heuristic 1/(1 + (pb/pa)²) of a sample drawn with density `pa`, (N,).

    Both densities are first divided by the larger one, so no square overflows or vanishes.

    Parameters
    ----------
    pa, pb : (N,) float32
        Density of the technique that drew the sample and of the other one, in [0, inf].

    Returns
    -------
    (N,) float32
        1 where `pa` is infinite or `pb` is 0; 0 where `pa` is 0.
    """
    n = max(pa.shape[-1], pb.shape[-1])
    if out is None:
        out = arena.empty(n)
    with arena.frame():
        b, scale = arena.empty(n), arena.empty(n)
        at_most(pa, _LARGEST, out)
        at_most(pb, _LARGEST_OTHER, b)
        np.maximum(out, b, out=scale)
        at_least(scale, _SMALLEST, scale)
        np.divide(out, scale, out=out)
        np.divide(b, scale, out=b)
        np.multiply(out, out, out=out)
        np.multiply(b, b, out=b)
        np.add(out, b, out=b)
        at_least(b, _SMALLEST, b)
        np.divide(out, b, out=out)
    return out
