# SPDX-License-Identifier: GPL-3.0-or-later
"""Maps from the unit square to shapes, area preserving, and their densities.

Local frames have their pole along +Z. Numbers in are float32 in [0, 1); results come from the arena or go to `out`.
"""

from __future__ import annotations

import math

import numpy as np

from ..limits import at_least

INV_PI = 1.0 / math.pi
INV_TWO_PI = 0.5 / math.pi
INV_FOUR_PI = 0.25 / math.pi


def square_to_uniform_disk_concentric(u0, u1, arena, out=None):
    """Uniform points of the unit disk, (2, N); neighbours in the square stay neighbours.

    Source: Shirley and Chiu, "A Low Distortion Map Between Disk and Square", JGT 2(3), 1997.
    """
    n = u0.shape[-1]
    if out is None:
        out = arena.empty((2, n))
    with arena.frame():
        x, y, r, phi = (arena.empty(n) for _ in range(4))
        np.multiply(u0, 2.0, out=x)
        np.subtract(x, 1.0, out=x)
        np.multiply(u1, 2.0, out=y)
        np.subtract(y, 1.0, out=y)
        wide = np.greater(np.abs(x, out=r), np.abs(y, out=phi), out=arena.empty(n, bool))
        tall = np.logical_not(wide, out=arena.empty(n, bool))
        np.copyto(r, y)
        np.copyto(r, x, where=wide)
        np.copyto(x, y, where=wide)  # now x is the shorter coordinate
        np.copyto(phi, 1.0)
        np.copyto(phi, r, where=r != 0.0)
        np.divide(x, phi, out=phi)
        np.multiply(phi, math.pi / 4, out=phi)
        np.subtract(math.pi / 2, phi, out=phi, where=tall)
        circle(phi, r, out[0], out[1])
    return out


def circle(phi, r, x, y):
    """Write r cosφ and r sinφ. `phi` must not lie beside `x` or `y` in memory: numpy's fast loops then step aside."""
    np.cos(phi, out=x)
    np.sin(phi, out=y)
    np.multiply(x, r, out=x)
    np.multiply(y, r, out=y)


def disk_to_square_concentric(p):
    """Inverse of `square_to_uniform_disk_concentric`, (2, N) float64."""
    x, y = np.asarray(p, np.float64)
    r = np.hypot(x, y)
    phi = np.arctan2(y, x)
    phi = np.where(phi < -math.pi / 4, phi + 2 * math.pi, phi)
    quarter = np.floor((phi + math.pi / 4) / (math.pi / 2)).astype(int) % 4
    offset = (phi - quarter * (math.pi / 2)) * r / (math.pi / 4)
    a = np.choose(quarter, [r, -offset, -r, offset])
    b = np.choose(quarter, [offset, r, -offset, -r])
    return np.stack([(a + 1) / 2, (b + 1) / 2])


def square_to_cosine_hemisphere(u0, u1, arena, out=None):
    """Unit vectors of the upper hemisphere with density cosθ/π, (3, N).

    Source: Malley's method; PBRT, 4th ed., A.5.3.
    """
    if out is None:
        out = arena.empty((3, u0.shape[-1]))
    square_to_uniform_disk_concentric(u0, u1, arena, out=out[:2])
    with arena.frame():
        t = arena.empty(u0.shape[-1])
        np.multiply(out[0], out[0], out=t)
        np.subtract(1.0, t, out=out[2])
        np.multiply(out[1], out[1], out=t)
        np.subtract(out[2], t, out=out[2])
        at_least(out[2], 0.0, out[2])
        np.sqrt(out[2], out=out[2])
    return out


def cosine_hemisphere_pdf(cosine, arena, out=None):
    """Density of `square_to_cosine_hemisphere`, 0 below the horizon, (N,)."""
    if out is None:
        out = arena.empty(cosine.shape)
    at_least(cosine, 0.0, out)
    return np.multiply(out, INV_PI, out=out)


def square_to_uniform_sphere(u0, u1, arena, out=None, radius=1.0):
    """Uniform points of the sphere of `radius` (float), (3, N); the density is `INV_FOUR_PI` on the unit sphere.

    sinθ comes from 2 sqrt(u (1 - u)), exact near the poles.
    """
    n = u0.shape[-1]
    if out is None:
        out = arena.empty((3, n))
    x, y, z = out
    with arena.frame():
        r, phi = arena.empty(n), arena.empty(n)
        np.subtract(1.0, u0, out=r)
        np.multiply(r, u0, out=r)
        np.sqrt(r, out=r)
        np.multiply(r, 2.0 * radius, out=r)
        np.multiply(u0, -2.0 * radius, out=z)
        np.add(z, radius, out=z)
        np.multiply(u1, 2.0 * math.pi, out=phi)
        circle(phi, r, x, y)
    return out


def square_to_uniform_triangle(u0, u1, arena, out=None):
    """Barycentric coordinates (b0, b1) of uniform points of a triangle, (2, N); the third is 1 - b0 - b1.

    Source: Heitz, "A Low-Distortion Map Between Triangle and Square", 2019.
    """
    n = u0.shape[-1]
    if out is None:
        out = arena.empty((2, n))
    with arena.frame():
        half = arena.empty(n)
        np.minimum(u0, u1, out=half)
        np.multiply(half, 0.5, out=half)
        np.subtract(u0, half, out=out[0])
        np.subtract(u1, half, out=out[1])
    return out


def one_minus_cosine(sine, cosine):
    """1 - cosθ of an angle below π/2 as s²/(1 + c), exact for tiny angles."""
    return sine * sine / (1.0 + cosine)


def square_to_uniform_cone(u0, u1, cap, arena, out=None):
    """Uniform unit vectors within a cone around +Z, (3, N).

    Parameters
    ----------
    cap : float or (N,)
        1 - cosθmax, from `one_minus_cosine`: the cosine itself cannot tell tiny cones apart.
    """
    n = u0.shape[-1]
    if out is None:
        out = arena.empty((3, n))
    x, y, z = out
    with arena.frame():
        h, r, phi = arena.empty(n), arena.empty(n), arena.empty(n)
        np.multiply(u0, cap, out=h)  # 1 - cosθ
        np.subtract(2.0, h, out=r)
        np.multiply(r, h, out=r)
        np.sqrt(r, out=r)
        np.subtract(1.0, h, out=z)
        np.multiply(u1, 2.0 * math.pi, out=phi)
        circle(phi, r, x, y)
    return out


def uniform_cone_pdf(cap):
    """Density of `square_to_uniform_cone` inside the cone: 1/(2π(1 - cosθmax))."""
    return INV_TWO_PI / cap
