# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights that are seen as a circular cap of directions: sampled uniformly within a cone.

A cone is told by its axis and its *cap*, 1 - cosθmax, which stays exact for tiny angles.
"""

from __future__ import annotations

import math

import numpy as np

from ..sampling.warp import square_to_uniform_cone, uniform_cone_pdf
from ..vecmath import frame, to_world

SMALLEST_CAP = 1e-36  # keeps densities finite


def sample_cap(axis, cap, u0, u1, arena):
    """Unit vectors (3, N) uniformly within the cones around `axis` (3, N)."""
    wi = arena.empty((3, u0.shape[-1]))
    with arena.frame():
        local = square_to_uniform_cone(u0, u1, cap, arena)
        s, t = frame(axis, arena)
        np.copyto(wi, to_world(local, s, t, axis, arena))
    return wi


def cap_weight(radiance, cap, arena, count):
    """Le/pdf (3, count): radiance times the solid angle 2π·cap."""
    weight = arena.empty((3, count))
    with arena.frame():
        solid_angle = np.multiply(cap, 2.0 * math.pi, out=arena.empty(cap.shape))
        np.multiply(radiance, solid_angle, out=weight)
    return weight


def cap_pdf(cap, arena, count):
    """Density inside the cones, (count,)."""
    pdf = arena.empty(count)
    pdf[...] = uniform_cone_pdf(cap)
    return pdf


def distance_to_axis(d, axis, arena):
    """1 - cosine between unit vectors as |d - axis|²/2, exact for tiny angles, (N,)."""
    out = arena.zeros(d.shape[-1])
    with arena.frame():
        difference = arena.empty(d.shape[-1])
        for i in range(3):
            np.subtract(d[i], axis[i], out=difference)
            np.multiply(difference, difference, out=difference)
            np.add(out, difference, out=out)
    return np.multiply(out, 0.5, out=out)
