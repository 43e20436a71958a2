# SPDX-License-Identifier: GPL-3.0-or-later
"""Far sides of emitting bodies: light that the body itself hides, which shadow rays find out only so exactly."""

from __future__ import annotations

import numpy as np

from ..interaction import SHADOW_EPSILON
from ..vecmath import dot
from .base import rows_of

_ROUNDED = 5e-7  # share of its length by which a shadow ray's end is rounded, with room
_SMALL = 1e-4  # bound on the points' error over a body's size, from which on the rim lost to it counts
_CELLS = 10_000  # along a body's size: corners in one cell are one


class FarSides:
    """What hides the far sides of bodies made of emitting triangles.

    Parameters
    ----------
    outward : (3, count)
        Unit normals of the lights, zero on what is no body.
    clearance : (count,)
        Bound on the points' error along the normal.
    hidden_from : (count,), optional
        Distance (m) from which on the body hides its far side for certain; inf where only a shadow ray can tell. None
        where all are.
    """

    def __init__(self, outward, clearance, hidden_from=None):
        self._outward = np.ascontiguousarray(outward, np.float32)
        self._clearance = np.ascontiguousarray(clearance, np.float32)
        self._hidden_from = None if hidden_from is None else np.ascontiguousarray(hidden_from, np.float32)

    def of(self, lights):
        """Those of some of the lights."""
        hidden_from = None if self._hidden_from is None else self._hidden_from[lights]
        return FarSides(self._outward[:, lights], self._clearance[lights], hidden_from)

    def of_pairs(self, first):
        """Those of lights of two triangles each, `first` and the next one, which lie in one plane of one object."""
        hidden_from = None if self._hidden_from is None else self._hidden_from[first]
        clearance = np.maximum(self._clearance[first], self._clearance[first + 1])
        return FarSides(self._outward[:, first], clearance, hidden_from)

    def hide(self, rows, wi, distance, weight, arena):
        """Change `distance` (N,) to points on far sides, so that shadow rays end close before them.

        Shadow rays end a share of their length early, which may be more than a whole small body: its far side would
        shine through the near one. Where points are seen from the outside they are left as they are. What is hidden for
        certain gets the `weight` (3, N) zero.

        Parameters
        ----------
        rows : int or (N,)
            The lights.
        wi : (3, N)
            Unit directions to the points.
        """
        n = distance.size
        with arena.frame():
            outward, clearance = rows_of(self._outward, rows, arena), rows_of(self._clearance, rows, arena)
            away, end, most = dot(wi, outward, arena), arena.empty(n), arena.empty(n)
            far = np.greater(away, 0.0, out=arena.empty(n, bool))
            if self._hidden_from is not None:
                hidden = np.greater(distance, rows_of(self._hidden_from, rows, arena), out=arena.empty(n, bool))
                np.copyto(weight, np.float32(0), where=np.logical_and(hidden, far, out=hidden))
            np.divide(clearance, np.maximum(away, 1e-6, out=away), out=end)
            np.minimum(end, np.multiply(distance, 0.5, out=most), out=end)
            np.multiply(distance, 1.0 - _ROUNDED, out=most)
            np.subtract(most, end, out=end)
            np.multiply(end, 1.0 / (1.0 - SHADOW_EPSILON), out=end)
            np.copyto(distance, end, where=far)


def far_sides(corners, group, outward, clearance, shades):
    """The `FarSides` of triangles, or None where none belongs to a body.

    Parameters
    ----------
    corners : (9, T) float64
    group : (T,) int
        The object each belongs to.
    outward : (3, T)
        From `core.lights.triangle`.
    clearance : (T,)
    shades : callable
        Which of the triangles numbered (n,) surely end the shadow rays to their body, (n,) bool; asked of small bodies.

    Notes
    -----
    Seen at a grazing angle, the error of a sampled point reaches through a body's rim, whose far side then shines
    through: by clearance/size, 1% for a ball of the size of a hundred times the bound. Bodies so small are looked at
    closely: from the outside nobody sees the far side of an opaque closed surface.
    """
    if not outward.any():
        return None
    bodies, body = np.unique(group, return_inverse=True)
    points = np.asarray(corners, np.float64).reshape(3, 3, -1)
    low, high, blur = np.full((3, bodies.size), np.inf), np.full((3, bodies.size), -np.inf), np.zeros(bodies.size)
    for k in range(3):
        np.minimum.at(low[k], body, points[:, k].min(axis=0))
        np.maximum.at(high[k], body, points[:, k].max(axis=0))
    np.maximum.at(blur, body, clearance)
    size = np.linalg.norm(high - low, axis=0)
    small = _all_of(body, outward.any(axis=0)) & (blur > _SMALL * size)
    if not small.any():
        return FarSides(outward, clearance)
    kept = np.flatnonzero(small[body])
    own = body[kept]
    cells = np.rint((points[..., kept] - low[:, own]) / size[own] * _CELLS).astype(np.int64)
    number = np.unique(own, return_inverse=True)[1]
    hides = _sealed(cells, number, outward[:, kept]) & _all_of(number, shades(kept))
    hidden_from = np.full(body.size, np.inf)
    hidden_from[kept] = np.where(hides[number], size[own], np.inf)
    return FarSides(outward, clearance, hidden_from if hides.any() else None)


def _all_of(body, true):
    """For which bodies `true` holds of all triangles, (B,) bool."""
    return np.bincount(body, ~true) == 0


def _sealed(cells, body, outward):
    """Which bodies are closed, each part with the side `outward` outside, (B,) bool.

    cells (3, 3, n) int64: corners, coordinates, triangles; body (n,) int; outward (3, n).
    """
    key = body
    for k in range(3):
        key = key * (_CELLS + 1) + cells[:, k]
    corner = np.unique(key, return_inverse=True)[1].reshape(3, -1)
    a, b = corner.ravel(), np.roll(corner, -1, axis=0).ravel()
    # Every side must be there in both directions equally often.
    sides, side = np.unique(np.minimum(a, b) * (corner.max() + 1) + np.maximum(a, b), return_inverse=True)
    balance = np.bincount(side, np.sign(b - a), sides.size)
    closed = _all_of(np.tile(body, 3), balance[side] == 0)
    part = _parts(a, b)[corner[0]]
    v0, v1, v2 = cells.astype(np.float64)
    across = np.cross(v1 - v0, v2 - v0, axis=0)
    across *= np.sign((across * outward).sum(axis=0))
    volume = np.bincount(part, (across * (v0 + v1 + v2)).sum(axis=0))
    return closed & _all_of(body, volume[part] > 0)


def _parts(a, b):
    """The least number that each is connected to, (V,) int, of the sides from `a` to `b`."""
    part = np.arange(max(a.max(), b.max()) + 1)
    while (part[a] != part[b]).any():
        least = np.minimum(part[a], part[b])
        np.minimum.at(part, part[a], least)
        np.minimum.at(part, part[b], least)
        part = part[part]
    return part
