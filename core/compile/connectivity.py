# SPDX-License-Identifier: GPL-3.0-or-later
"""What a mesh's edges tell: how pointed its vertices are, and which parts hang together."""

from __future__ import annotations

import numpy as np

from ..arena import Arena
from ..nodes.hashing import hash_to_unit


def pointiness(vertices, triangles, edges, normals=None):
    """Mean angle between a vertex's normal and its edges, divided by pi, blurred once over its neighbours: (V,).

    0.5 is flat, more is convex. Vertices in one place count as one, as in Blender. `normals` (V, 3) are computed
    where None.

    Notes
    -----
    Source: Blender manual, "Geometry Node"; Cycles' definition of the attribute.
    """
    place = np.unique(vertices.astype(np.float32) + np.float32(0), axis=0, return_inverse=True)[1].reshape(-1)
    count = int(place.max()) + 1
    points = np.zeros((count, 3))
    points[place] = vertices
    normal = _unit(_summed(place, vertex_normals(vertices, triangles) if normals is None else normals, count))
    pairs = np.unique(np.sort(place[edges], axis=1), axis=0)
    a, b = pairs.T
    along = _unit(points[b] - points[a])
    ends = np.concatenate([a, b])
    number = np.bincount(ends, minlength=count)
    mean = _summed(ends, np.concatenate([along, -along]), count) / np.maximum(number, 1)[:, None]
    angle = np.arccos(np.clip((normal * mean).sum(-1), -1, 1)) / np.pi * (number > 0)
    around = np.bincount(ends, angle[np.concatenate([b, a])], count)
    return ((angle + around) / (number + 1))[place].astype(np.float32)


def vertex_normals(vertices, triangles):
    """Unit normals (V, 3) of the vertices, each the mean of its triangles' weighted by their angle there."""
    corners = vertices[triangles]
    face = _unit(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    total = np.zeros_like(vertices)
    for k in range(3):
        a, b = (_unit(corners[:, (k + step) % 3] - corners[:, k]) for step in (1, 2))
        angle = np.arccos(np.clip((a * b).sum(-1), -1, 1))
        total += _summed(triangles[:, k], face * angle[:, None], len(vertices))
    return _unit(total)


def island_random(triangles, edges, count):
    """A number in [0, 1] for each triangle (T,), the same for all that hang together.

    Notes
    -----
    It is the hash of a vertex of the island. To be Blender's number, it must be the vertex that union by rank over the
    edges in their order leaves as the root, so the edges are gone through one by one.
    """
    parent, rank = list(range(count)), [0] * count

    def root_of(x):
        while parent[x] != x:
            parent[x] = x = parent[parent[x]]
        return x

    for x, y in edges.tolist():
        x, y = root_of(x), root_of(y)
        if x != y:
            if rank[x] < rank[y]:
                x, y = y, x
            parent[y] = x
            rank[x] += rank[x] == rank[y]
    first = triangles[:, 0]
    roots = np.array([root_of(v) for v in np.unique(first).tolist()], np.uint32)
    words = roots[np.searchsorted(np.unique(first), first)]
    return np.array(hash_to_unit([words], Arena(1 << 16)))


def triangle_sides(triangles):
    """The sides (E, 2) of triangles, each once."""
    sides = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    return np.unique(np.sort(sides, axis=1), axis=0)


def _summed(index, values, count):
    return np.stack([np.bincount(index, values[:, k], count) for k in range(3)], axis=-1)


def _unit(v):
    length = np.sqrt((v * v).sum(-1, keepdims=True))
    return np.divide(v, length, out=np.zeros_like(v), where=length > 0)
