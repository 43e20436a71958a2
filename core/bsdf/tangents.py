# SPDX-License-Identifier: GPL-3.0-or-later
"""Bases of a surface whose first axis has a meaning: along a tangent, or towards the viewer."""

from __future__ import annotations

import math

import numpy as np

from .. import vecmath
from ..vecmath import cross, dot, normalize

_TINY = 1e-20


def along(n, tangent, arena):
    """(s, t), unit, right-handed with the unit normals `n`: s is `tangent` (3, N) or (3, 1) put square to `n`.

    Any basis where the tangent is zero or parallel to the normal.
    """
    count = vecmath.lanes(n, tangent)
    s, t = arena.empty((3, count)), arena.empty((3, count))
    with arena.frame():
        across = cross(n, tangent, arena)
        length = dot(across, across, arena)
        lost = np.flatnonzero(length < _TINY)
        normalize(across, arena, out=t)
        if lost.size:
            t[:, lost] = vecmath.frame(np.ascontiguousarray(n[:, lost]), arena)[1]
        np.copyto(s, cross(t, n, arena))
    return s, t


def rotated(tangent, n, turns, arena):
    """`tangent` turned about `n` by a share of a full circle, `turns` (1,) or (N,): (3, N).

    Source: Rodrigues' formula.
    """
    angle = turns * (2.0 * math.pi)
    sine, cosine = np.sin(angle), np.cos(angle)
    along_n = dot(tangent, n, arena)
    out = arena.empty((3, along_n.size))
    np.multiply(cross(n, tangent, arena), sine, out=out)
    np.add(out, tangent * cosine, out=out)
    return np.add(out, n * (along_n * (1.0 - cosine)), out=out)
