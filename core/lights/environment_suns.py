# SPDX-License-Identifier: GPL-3.0-or-later
"""Discs of an environment in which most of its light is: too small for the cells of its grid."""

from __future__ import annotations

import math

import numpy as np

from ..arena import Arena
from ..sampling.color import luminance
from ..sampling.warp import uniform_cone_pdf
from .cap import distance_to_axis, sample_cap

_MARGIN = 1e-3  # of a disc's radius: what float32 directions take for its edge is inside
_BELOW_ONE = np.float32(1 - 2**-24)
_RINGS, _SPOKES = 64, 64  # of the directions in which a disc's light is measured


class EnvironmentSuns:
    """Discs that are sampled uniformly, brighter ones more often.

    Parameters
    ----------
    radiance : callable
        Of the environment, ``radiance(d, arena, averaged)``; what it has of the discs is left out where `averaged`.
    suns : sequence of (axis, angle)
        Unit vectors (3,) and full angles, rad.

    Attributes
    ----------
    axis : (3, K) float32
        Of the discs that shine.
    irradiance : (3, K)
        That they give a surface which faces them.
    power : float
        Luminance of all irradiance.
    """

    def __init__(self, radiance, suns):
        axis = np.array([axis for axis, _ in suns], np.float32).reshape(-1, 3).T
        cap = np.array([2.0 * math.sin(0.25 * angle * (1.0 + _MARGIN)) ** 2 for _, angle in suns], np.float32)
        irradiance = np.stack([_irradiance(radiance, a[:, None], c) for a, c in zip(axis.T, cap, strict=True)], axis=1)
        brightness = np.maximum(luminance(irradiance), 0.0)
        lit = brightness > 0.0
        self.axis, self._cap, self.irradiance = np.ascontiguousarray(axis[:, lit]), cap[lit], irradiance[:, lit]
        self.power = float(brightness.sum())
        self._share = (brightness[lit] / max(self.power, 1e-300)).astype(np.float32)
        self._until = np.cumsum(self._share)[:-1].astype(np.float32)

    def sample(self, u0, u1, arena):
        """Directions (3, N) in the discs."""
        wi = arena.empty((3, u0.size))
        with arena.frame():
            disc = np.searchsorted(self._until, u0, side="right")
            start = np.append(np.float32(0), self._until)[disc]
            u0 = np.minimum((u0 - start) / self._share[disc], _BELOW_ONE)
            np.copyto(wi, sample_cap(arena.take(self.axis, disc), arena.take(self._cap, disc), u0, u1, arena))
        return wi

    def density(self, d, arena):
        """Solid-angle density of `sample` at `d` (3, N), (N,)."""
        out = arena.zeros(d.shape[-1])
        with arena.frame():
            for k, (cap, share) in enumerate(zip(self._cap, self._share.tolist(), strict=True)):
                inside = distance_to_axis(d, self.axis[:, k : k + 1], arena) <= cap
                np.add(out, float(uniform_cone_pdf(cap)) * share, out=out, where=inside)
        return out


def _irradiance(radiance, axis, cap):
    """What a disc gives to a surface that faces it, (3,) float64."""
    arena = Arena()
    u0, u1 = np.meshgrid((np.arange(_RINGS) + 0.5) / _RINGS, (np.arange(_SPOKES) + 0.5) / _SPOKES)
    u0, u1 = u0.astype(np.float32).ravel(), u1.astype(np.float32).ravel()
    d = sample_cap(np.repeat(axis, u0.size, axis=1), np.full(u0.size, cap), u0, u1, arena)
    light = radiance(d, arena).astype(np.float64) - radiance(d, arena, averaged=True)
    cosine = (d * axis).sum(axis=0)
    return (light * cosine).mean(axis=1) * (2.0 * math.pi * float(cap))
