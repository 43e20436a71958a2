# SPDX-License-Identifier: GPL-3.0-or-later
"""Normals that a shader asks for, made fit to shade with."""

from __future__ import annotations

import numpy as np

from ..limits import at_most
from ..vecmath import dot, normalize

_LEAST_RISE = 0.01  # cosine to the geometric normal that a mirrored ray keeps, as in Cycles
_LEAST_SHARE = 0.9  # of the viewer's own cosine, where that is smaller


def unit_normal(n, fallback, arena):
    """`n` (3, N) or (3, 1) as unit vectors (3, N); `fallback` (3, N) where it is zero or not finite."""
    out = arena.empty(fallback.shape)
    with arena.frame():
        np.copyto(out, n)
        with np.errstate(over="ignore", invalid="ignore"):
            normalize(out, arena, out=out)
            good = np.isfinite(out).all(0) & out.any(0)
        np.copyto(out, fallback, where=~good)
    return out


def lifted_normal(n, ng, wo, arena):
    """Unit normals (3, N) turned towards `ng` where a mirror would send the viewer's ray below the surface.

    Where no lane is turned it is `n` itself.

    Notes
    -----
    In the plane of `ng` and `n` let the normal be at angle a, and the viewer's direction (x, z) = r (sin φ, cos φ). The
    mirrored ray's height is r cos(2a - φ), which is at least t where abs(2a - φ) <= arccos(t / r). So a is limited to
    that. The height t is that of Cycles.
    """
    out = arena.empty(n.shape)
    with arena.frame():
        z, up = dot(wo, ng, arena), dot(n, ng, arena)
        least = np.multiply(z, _LEAST_SHARE, out=arena.empty(z.shape))
        at_most(least, _LEAST_RISE, least)
        rise = dot(n, wo, arena)
        np.multiply(rise, up, out=rise)
        np.subtract(np.add(rise, rise, out=rise), z, out=rise)
        low = np.flatnonzero(np.less(rise, least, out=arena.empty(z.shape, bool)))
        if low.size == 0:
            return n
        np.copyto(out, n)
        n, ng, wo, z, up, least = (arena.take(a, low) for a in (n, ng, wo, z, up, least))
        x_axis = n - up * ng
        normalize(x_axis, arena, out=x_axis)
        x = dot(wo, x_axis, arena)
        radius = np.maximum(np.hypot(x, z), np.float32(1e-20))
        reach = np.arccos(np.clip(least / radius, -1, 1))
        middle = np.arctan2(x, z)
        twice = np.clip(2 * np.arccos(np.clip(up, -1, 1)), middle - reach, middle + reach)
        out[:, low] = np.sin(twice / 2) * x_axis + np.cos(twice / 2) * ng
    return out
