# SPDX-License-Identifier: GPL-3.0-or-later
"""Points of the aperture through which a camera with depth of field sees."""

from __future__ import annotations

import math

import numpy as np

from .sampling.warp import square_to_uniform_disk_concentric

LEAST_FOCUS = 1e-5  # a camera that focuses on its own lens has no direction to look along


def aperture_points(lens, u, arena):
    """Points of the aperture, evenly spread; the middle of the unit square is the middle of the lens.

    Parameters
    ----------
    lens : core.camera_description.ThinLens
    u : (2, N) float32
        In [0, 1).

    Returns
    -------
    (2, N) float32
        To the right and upwards, in world units.

    Notes
    -----
    A disk's points become those of a polygon sector by sector: the angle within the sector says where between two
    corners, the radius how far out. Both parts keep areas in proportion. The middle of side number k stands at the
    angle `rotation` + 2πk / blades, as in Cycles.
    """
    out = square_to_uniform_disk_concentric(u[0], u[1], arena)
    if lens.blades >= 3:
        _disk_to_polygon(out, lens.blades, lens.rotation, arena)
    np.multiply(out[0], lens.radius / max(lens.ratio, 1e-6), out=out[0])
    np.multiply(out[1], lens.radius, out=out[1])
    return out


def _disk_to_polygon(p, corners, rotation, arena):
    """Move points `p` (2, N) of the unit disk into the polygon with its corners on the circle."""
    n = p.shape[1]
    sector = 2 * math.pi / corners
    angles = np.arange(corners + 2) * sector + (rotation - 0.5 * sector)
    with arena.frame():
        radius, place, t = (arena.empty(n) for _ in range(3))
        np.hypot(p[0], p[1], out=radius)
        np.arctan2(p[1], p[0], out=place)
        np.multiply(place, 1 / sector, out=place)
        np.add(place, 0.5 * corners, out=place)
        np.maximum(place, 0, out=place)
        number = place.astype(np.int32)
        np.subtract(place, number, out=place)
        for row, corner in zip(p, (np.cos(angles), np.sin(angles)), strict=True):
            first = corner[:-1].astype(np.float32)
            np.take((corner[1:] - corner[:-1]).astype(np.float32), number, out=t, mode="clip")
            np.multiply(t, place, out=t)
            np.take(first, number, out=row, mode="clip")
            np.add(row, t, out=row)
            np.multiply(row, radius, out=row)
