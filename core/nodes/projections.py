# SPDX-License-Identifier: GPL-3.0-or-later
"""From vectors to coordinates of a picture.

Source: Cycles (`util/math_float3.h`, `kernel/camera/projection.h`, `kernel/svm/image.h`). Where a direction is none,
coordinates are 0.
"""

from __future__ import annotations

import math

import numpy as np


def sphere(vector, arena):
    """Coordinates u, v (N,) of points (3, N) of the box from 0 to 1, seen from its middle: longitude and latitude.

    u is 1/2 along +Y and falls towards +X; v rises from -Z to +Z.
    """
    x, y, z = vector
    u, v = arena.empty(vector.shape[1]), arena.empty(vector.shape[1])
    with arena.frame():
        a, b, c = (_centred(row, arena) for row in (x, y, z))
        np.arctan2(a, b, out=u)
        np.multiply(u, -0.5 / math.pi, out=u)
        np.add(u, 0.5, out=u)
        np.hypot(a, b, out=a)
        np.copyto(u, np.float32(0), where=a == 0)
        np.arctan2(a, c, out=v)
        np.multiply(v, -1.0 / math.pi, out=v)
        np.add(v, 1.0, out=v)
        np.copyto(v, np.float32(0), where=(a == 0) & (c == 0))
    return u, v


def tube(vector, arena):
    """Coordinates u, v (N,) of points (3, N) of the box from 0 to 1: longitude, as of `sphere`, and height."""
    x, y, z = vector
    u, v = arena.empty(vector.shape[1]), arena.empty(vector.shape[1])
    with arena.frame():
        a, b = (_centred(row, arena) for row in (x, y))
        np.arctan2(a, b, out=u)
        np.multiply(u, -0.5 / math.pi, out=u)
        np.add(u, 0.5, out=u)
        np.copyto(v, z)
        axis = (a == 0) & (b == 0)
        np.copyto(u, np.float32(0), where=axis)
        np.copyto(v, np.float32(0), where=axis)
    return u, v


def equirectangular(direction, arena):
    """Coordinates u, v (N,) in [0, 1] of directions (3, N) of any length.

    u is 1/2 along +X and falls towards +Y, v rises from -Z to +Z: u = 1/2 - φ/2π, v = 1 - θ/π.
    """
    x, y, z = direction
    u, v = arena.empty(x.shape), arena.empty(x.shape)
    np.arctan2(y, x, out=u)
    np.multiply(u, -0.5 / math.pi, out=u)
    np.add(u, 0.5, out=u)
    # The angle to the pole by its tangent: its cosine is blind near the poles.
    np.hypot(x, y, out=v)
    np.arctan2(v, z, out=v)
    np.multiply(v, -1.0 / math.pi, out=v)
    np.add(v, 1.0, out=v)
    return u, v


def mirror_ball(direction, arena):
    """Coordinates u, v (N,) of directions (3, N) of any length, in the picture of a mirrored ball seen along +Y.

    The ball's normal is halfway between the direction and the way back to the viewer, -Y.
    """
    x, y, z = direction
    u, v = arena.empty(x.shape), arena.empty(x.shape)
    with arena.frame():
        length, half = arena.empty(x.shape), arena.empty(x.shape)
        np.hypot(x, z, out=length)
        np.hypot(length, y, out=length)
        np.subtract(y, length, out=half)
        np.hypot(half, x, out=half)
        np.hypot(half, z, out=half)
        np.maximum(half, 1e-30, out=half)
        np.divide(0.5, half, out=half)
        for out, component in ((u, x), (v, z)):
            np.multiply(component, half, out=out)
            np.add(out, 0.5, out=out)
    return u, v


def box(vector, normal, arena):
    """[(u, v)] of points (3, N) on the sides of a box across X, Y, Z; no side shows the picture mirrored."""
    x, y, z = vector
    with np.errstate(invalid="ignore"):
        return (
            (_from(1.0, y, normal[0] < 0, arena), z),
            (_from(1.0, x, normal[1] > 0, arena), z),
            (_from(1.0, y, normal[2] > 0, arena), x),
        )


def box_weights(normal, blend, arena):
    """Shares (3, N) of a box' sides where the surface has `normal` (3, N), not of unit length, in object space.

    Three components that add up to 1 are a point of an equilateral triangle, whose corners are the sides. Near a
    corner there is its side alone; `blend` in [0, 1] is how far sides run into each other.

    Notes
    -----
    Between sides i and j, away from the third, a share is (n_i / (n_i + n_j) - (1 - blend) / 2) / blend. In the
    middle, where all three meet, it is ((2 - l) n_i + l - 1) / (2 l - 1), with l = (1 + blend) / 2.
    """
    weights = arena.zeros((3, normal.shape[1]))
    with arena.frame():
        n = np.abs(normal, out=arena.empty(normal.shape))
        total = np.add(n[0], n[1], out=arena.empty(n.shape[1]))
        np.add(total, n[2], out=total)
        np.divide(n, total, out=n, where=total > 0)
        limit = 0.5 * (1 + blend)
        left = np.ones(n.shape[1], bool)
        for i, j, k in ((0, 1, 2), (1, 0, 2), (2, 0, 1)):
            alone = left & (n[i] > limit * (n[i] + n[j])) & (n[i] > limit * (n[i] + n[k]))
            weights[i][alone] = 1
            left &= ~alone
        if blend <= 0:
            weights[0][left] = 1
            return weights
        for i, j, k in ((0, 1, 2), (1, 2, 0), (0, 2, 1)):
            pair = np.flatnonzero(left & (n[k] < (1 - limit) * (n[i] + n[j])))
            share = n[i][pair] / (n[i][pair] + n[j][pair])
            share = np.clip((share - np.float32(0.5 * (1 - blend))) / np.float32(blend), 0, 1)
            weights[i][pair], weights[j][pair] = share, 1 - share
            left[pair] = False
        for weight, component in zip(weights, n, strict=True):
            middle = ((2 - limit) * component[left] + (limit - 1)) / (2 * limit - 1)
            weight[left] = middle
    return weights


def _centred(row, arena):
    """A coordinate of the box from 0 to 1, from -1 to 1."""
    out = np.subtract(row, 0.5, out=arena.empty(row.size))
    return np.multiply(out, 2.0, out=out)


def _from(end, row, turned, arena):
    """`row`, or `end` less it where `turned`."""
    out = arena.empty(row.size)
    np.copyto(out, row)
    np.subtract(end, row, out=out, where=turned)
    return out
