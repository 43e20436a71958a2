# SPDX-License-Identifier: GPL-3.0-or-later
"""Points a little aside of the lanes, for nodes that need the slope of what others compute.

The steps go along two axes across the geometric normal; they are measured in footprints, the radius that a pixel of the
camera has at the lane (`spaces.footprint`). A lane stays on its triangle, whose barycentrics are carried on beyond the
edges, so that everything that is interpolated over it goes on evenly. Normals and tangents stay, as in Cycles.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..geometry import CORNERS
from ..interaction import interpolate_rows
from ..vecmath import cross, dot, normalize
from . import spaces


def axes(n, arena):
    """Two unit vectors (3, N) across unit vectors `n`, which make a right-handed basis with them.

    The first is (1, 1, 1) × n, which is Cycles' choice, so that slopes are measured in the same places.
    """
    a, b = arena.empty(n.shape), None
    for i in range(3):
        np.subtract(n[(i + 2) % 3], n[(i + 1) % 3], out=a[i])
    # Along the diagonal any other direction will do.
    square = dot(a, a, arena)
    poor = np.flatnonzero(square < 1e-12)
    if poor.size:
        x, y, z = n[:, poor]
        a[:, poor] = z - y, x + z, -y - x
    normalize(a, arena, out=a)
    b = cross(n, a, arena)
    return a, b


def beside(context, steps):
    """A `Context` for each of `steps`, pairs (x, y) of footprints along the two axes."""
    s = context.surface
    if s is None:
        return dict.fromkeys(steps, context)
    arena = context.arena
    a, b = axes(s.ng, arena)
    radius = spaces.footprint(context)
    moved = {}
    for step in steps:
        offset = np.multiply(a, step[0], out=arena.empty(a.shape))
        np.add(offset, b * np.float32(step[1]), out=offset)
        np.multiply(offset, radius, out=offset)
        u, v = _barycentrics(context, offset)
        p = np.add(s.p, offset, out=arena.empty(a.shape))
        moved[step] = replace(context, surface=s._replace(p=p, u=u, v=v), unmoved=s, step=step)
    return moved


def _barycentrics(context, offset):
    """Barycentrics of the lanes moved by `offset` (3, N) in the planes of their triangles."""
    s, arena, table = context.surface, context.arena, context.geometry.facets
    u, v = arena.empty(s.u.shape), arena.empty(s.v.shape)
    np.copyto(u, s.u)
    np.copyto(v, s.v)
    if not len(table):
        return u, v
    with arena.frame():
        zero, one = arena.zeros(u.shape), arena.full(u.shape, 1.0)
        prim = np.minimum(s.prim, len(table) - 1, out=arena.empty(s.prim.shape, s.prim.dtype))
        corners = (zero, zero), (one, zero), (zero, one)
        origin, e, f = (interpolate_rows(table, CORNERS, prim, *at, arena) for at in corners)
        np.subtract(e, origin, out=e)
        np.subtract(f, origin, out=f)
        ee, ef, ff = dot(e, e, arena), dot(e, f, arena), dot(f, f, arena)
        oe, of = dot(offset, e, arena), dot(offset, f, arena)
        determinant = ee * ff - ef * ef
        inverse = np.divide(1, determinant, out=zero, where=(determinant > 0) & (s.prim < len(table)))
        # Seen from behind, what is interpolated goes the other way in Cycles: hollows are bumps from there.
        np.negative(inverse, out=inverse, where=~s.front)
        np.add(u, (ff * oe - ef * of) * inverse, out=u)
        np.add(v, (ee * of - ef * oe) * inverse, out=v)
    return u, v
