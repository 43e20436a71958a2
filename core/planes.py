# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays against infinite planes and against spheres, in closed form.

Planes are Zraka's own: Embree has none. Spheres are here for the day Embree's cannot be reached (`core.accel`).
"""

from __future__ import annotations

import numpy as np

from .vecmath import dot


def plane_distance(point, normal, o, d, arena):
    """Distance in units of |d| at which rays meet the plane through `point`; inf where they do not.

    Parameters
    ----------
    point, normal : (3,) float32
    o, d : (3, N) float32

    Returns
    -------
    (N,) float32
        ``n·(q - o) / n·d``; inf for a ray that is parallel to the plane, in it, or leaves it behind. A ray that starts
        on the plane meets it at 0, as it does with Embree's surfaces.
    """
    t = arena.full(o.shape[1], np.inf)
    with arena.frame(), np.errstate(over="ignore", invalid="ignore"):
        to_plane, meets = arena.empty(o.shape), arena.empty(t.shape, bool)
        np.subtract(point[:, None], o, out=to_plane)
        height = dot(to_plane, normal[:, None], arena)
        speed = dot(d, normal[:, None], arena)
        # A ray that lies in the plane must not divide 0 by 0.
        np.not_equal(speed, 0.0, out=meets)
        np.divide(height, speed, out=t, where=meets)
        np.greater_equal(t, 0.0, out=meets)
        np.logical_not(meets, out=meets)
        np.copyto(t, np.float32(np.inf), where=meets)
    return t


def sphere_distance(center, radius, o, d, arena):
    """Smallest distance >= 0 in units of |d| at which rays meet a sphere; inf where they do not.

    A ray from inside meets the far side; a tangent meets at its double root.

    Notes
    -----
    The roots are found from the ray's point nearest to the centre, which keeps the digits that ``b² - 4ac`` loses for
    small or far spheres: Haines et al., "Precision Improvements for Ray/Sphere Intersection", Ray Tracing Gems, 2019.
    """
    t = arena.empty(o.shape[1])
    with arena.frame(), np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        c, nearest, far = arena.empty(o.shape), arena.empty(o.shape), arena.empty(t.shape)
        np.subtract(center[:, None], o, out=c)
        dd = dot(d, d, arena)
        middle = dot(c, d, arena)
        np.divide(middle, dd, out=middle)
        np.multiply(d, middle, out=nearest)
        np.subtract(c, nearest, out=nearest)
        half = dot(nearest, nearest, arena)
        np.subtract(float(radius) ** 2, half, out=half)
        np.divide(half, dd, out=half)
        np.sqrt(half, out=half)  # NaN for a ray that passes by, which every comparison below calls a miss
        np.subtract(middle, half, out=t)
        np.add(middle, half, out=far)
        np.copyto(t, far, where=~(t >= 0.0))
        np.copyto(t, np.float32(np.inf), where=~(t >= 0.0))
    return t
