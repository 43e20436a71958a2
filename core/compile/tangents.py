# SPDX-License-Identifier: GPL-3.0-or-later
"""Tangent frames of a UV map, as normal maps are baked in them.

Source: M. S. Mikkelsen, "Simulation of Wrinkled Surfaces Revisited", 2008, section on tangent spaces, whose averaging
(corners of equal position, normal and UV, weighted by angle) Blender follows. Corners that touch in a vertex alone are
averaged here too.
"""

from __future__ import annotations

import numpy as np


def corner_frames(position, normal, uv, met=None):
    """Tangents and their signs at the corners of T triangles.

    Parameters
    ----------
    position, normal : (T, 3, 3) float64
        Of each corner; normals of unit length.
    uv : (T, 3, 2) float64
    met : (T, 3, 2) float64, optional
        In the place of `uv` where corners are told apart.

    Returns
    -------
    tangent : (T, 3, 3) float64
        Along increasing u, unit, across the normal.
    sign : (T, 3) float64
        -1 where the map is mirrored: the bitangent is sign · normal × tangent.
    """
    tangent, area = _triangle_tangents(position, uv)
    number = _welded(position, normal, uv if met is None else met)
    # Mirrored and plain triangles that meet in a corner are averaged apart.
    group = 2 * number + (area < 0)[:, None]
    across = _unit(tangent[:, None] - normal * (normal * tangent[:, None]).sum(-1, keepdims=True))
    weighted = across * (_angles(position, normal) * (area != 0)[:, None])[..., None]
    total = np.stack(
        [np.bincount(group.reshape(-1), weighted[..., k].reshape(-1), 2 * number.max() + 2) for k in range(3)], axis=-1
    )
    # A triangle without area in the map takes the frame of a neighbour.
    other = (area == 0)[:, None] & ~total[group].any(-1)
    group = np.where(other, group ^ 1, group)
    found = _unit(total[group])
    found[~total[group].any(-1)] = (1.0, 0.0, 0.0)
    return found, 1.0 - 2.0 * (group & 1)


def _triangle_tangents(position, uv):
    """Directions (T, 3) of increasing u, unit, and twice the signed areas (T,) in the map."""
    edge, other = position[:, 1] - position[:, 0], position[:, 2] - position[:, 0]
    (u1, v1), (u2, v2) = (uv[:, 1] - uv[:, 0]).T, (uv[:, 2] - uv[:, 0]).T
    area = u1 * v2 - v1 * u2
    return _unit(v2[:, None] * edge - v1[:, None] * other) * np.sign(area)[:, None], area


def _welded(position, normal, uv):
    """Numbers (T, 3), equal for corners that agree in all."""
    keys = np.concatenate([position, normal, uv], axis=-1).astype(np.float32).reshape(-1, 8) + np.float32(0)
    rows = np.ascontiguousarray(keys).view([("", np.void, 32)]).reshape(-1)
    return np.unique(rows, return_inverse=True)[1].reshape(len(position), 3)


def _angles(position, normal):
    """Angles (T, 3) of the triangles' corners, seen along the normals."""
    angles = np.zeros(position.shape[:2])
    for k in range(3):
        n = normal[:, k]
        sides = [position[:, (k + step) % 3] - position[:, k] for step in (1, 2)]
        a, b = (_unit(s - n * (n * s).sum(-1, keepdims=True)) for s in sides)
        angles[:, k] = np.arccos(np.clip((a * b).sum(-1), -1, 1))
    return angles


def _unit(v):
    """Vectors of length 1 along the last axis; zero stays zero."""
    length = np.sqrt((v * v).sum(-1, keepdims=True))
    return np.divide(v, length, out=np.zeros_like(v), where=length > 0)
