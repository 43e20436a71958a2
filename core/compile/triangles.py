# SPDX-License-Identifier: GPL-3.0-or-later
"""Instances of meshes to vertices, index, facets and shading normals.

World positions are computed in float64 and recentred before the cast to float32. Everything is done in blocks that stay
in the cache, and that threads share; no block knows of another, so their number changes nothing. First vertices,
normals and index are written, by blocks of a mesh's instances; then facets and the normals at their corners, by blocks
of triangles, whatever meshes they are of. So neither many small objects nor a large one costs a loop.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import NamedTuple

import numpy as np

from ..arena import Arena, uninitialised
from ..geometry import BLOCK, FACET_COLUMNS, INDEX_PADDING, NORMAL, NORMAL_ROW, fill_facets
from .placing import check_length, corner_index, turn

# More threads only wait for memory.
_MOST_THREADS = 8

# Corner normals this near to the face's are the face's: the shading of a flat triangle.
_FLAT = np.float32(1e-4)


class Triangles(NamedTuple):
    """Tables of `core.geometry.Geometry` for T triangles, and which of them are triangles indeed."""

    vertices: np.ndarray
    index: np.ndarray
    facets: np.ndarray
    normals: np.ndarray
    good: np.ndarray  # (T,) bool


def write_triangles(groups, count, origin):
    """The tables of all triangles, positions relative to `origin`.

    Parameters
    ----------
    groups : list of Placed
    count : int
        T.
    origin : (3,) float64

    Returns
    -------
    Triangles
        What is no triangle is still among them, so that rows are those of `groups`.
    """
    vertices = uninitialised((_vertex_count(groups), 4))
    index = uninitialised((count + INDEX_PADDING, 3), np.uint32)
    index[count:] = 0
    index = index[:count]
    tasks = [task for g in groups for task in _placing(g, origin, vertices, index)]
    normals = _Normals(groups, count, index)
    _run([*tasks, *normals.tasks()], count)
    facets, good = uninitialised((count, FACET_COLUMNS)), np.zeros(count, bool)
    _run(
        [
            partial(_write_facets, vertices, index[rows], facets[rows], good[rows], normals, rows)
            for rows in _parts(count, BLOCK)
        ],
        count,
    )
    return Triangles(vertices, index, facets, normals.table(facets), good)


def _vertex_count(groups):
    return sum(len(g.numbers) * len(g.vertices) for g in groups)


def _placing(group, origin, vertices, index):
    """Tasks that write a group's vertices and its rows of the index."""
    count, size = len(group.numbers), len(group.vertices)
    linear, move = group.matrix[:, :3, :3], group.matrix[:, :3, 3] - origin
    placed = vertices[group.first_vertex :][: count * size].reshape(count, size, 4)
    for some, part in _blocks(count, size):
        yield partial(_write_vertices, group.vertices[part], linear[some], move[some], placed[some, part])
    yield from _indexing(group, group.triangles, group.first_vertex, size, index)


def _indexing(group, numbers, first, size, index):
    """Tasks that write `numbers` (T, 3) of a mesh into `index` for instances whose tables have `size` rows each."""
    first = (first + size * np.arange(len(group.numbers))).astype(np.uint32)
    index = index[group.rows].reshape(len(first), -1, 3)
    for some, part in _blocks(*index.shape[:2]):
        yield partial(_write_index, numbers[part], first[some], group.flipped[some], index[some, part])


def _write_vertices(points, linear, move, out, arena):
    world = _turned(points, linear, arena)
    for k in range(3):
        np.add(world[..., k], move[:, k, None], out=out[..., k], casting="same_kind")
    out[..., 3] = 0


def _turned(vectors, matrices, arena):
    """Vectors (n, 3) as float64, multiplied by each of the matrices (I, 3, 3), which large meshes often do without."""
    out = arena.empty((len(matrices), *vectors.shape), np.float64)
    if (matrices == np.eye(3)).all():
        np.copyto(out, vectors)
        return out
    return np.matmul(vectors, matrices.transpose(0, 2, 1), out=out)


def _write_index(numbers, first, flipped, out, arena):
    np.add(numbers, first[:, None, None], out=out)
    turn(out, 1, 2, flipped)


def _write_facets(vertices, index, facets, good, normals, rows, arena):
    with arena.frame():
        good[:] = fill_facets(facets, vertices, index, arena)
    normals.write(rows, facets, arena)


# -- shading normals ---------------------------------------------------------------------------------------------------


class _Normals:
    """Shading normals of the smooth triangles.

    First unit normals in the world, and their numbers at the corners of all triangles: those of the vertices where all
    normals are by vertex. Meshes without normals have ones that are no numbers.
    """

    def __init__(self, groups, count, index):
        self._groups = [(g, *_normals_of(g)) for g in groups if g.mesh.normals is not None]
        if not self._groups:
            return
        flat = [g for g in groups if g.mesh.normals is None]
        self._by_vertex = all(n is g.triangles and len(values) == len(g.vertices) for g, values, n in self._groups)
        if self._by_vertex:
            self._index, self._world = index, uninitialised((_vertex_count(groups), 3))
            for g in flat:
                self._world[g.first_vertex :][: _vertex_count([g])] = np.nan
        else:
            self._index = uninitialised((count, 3), np.uint32)
            self._world = uninitialised((1 + sum(len(g.numbers) * len(values) for g, values, _ in self._groups), 3))
            self._world[0] = np.nan
            for g in flat:
                self._index[g.rows] = 0
        self._all_usable = not flat
        self._table = uninitialised((count, 9))
        self._smooth = np.zeros(count, bool)

    def tasks(self):
        """What must be done before `write`."""
        first = 1
        for group, values, numbers in self._groups:
            count, size = len(group.numbers), len(values)
            matrix, kept = _scaled(group.normal_matrix), _interpolated_before(group)
            world = self._world[group.first_vertex if self._by_vertex else first :][: count * size]
            world = world.reshape(count, size, 3)
            for some, part in _blocks(count, size):
                yield partial(self._write_world, values[part], matrix[some], kept[some], world[some, part])
            if not self._by_vertex:
                yield from _indexing(group, numbers, first, size, self._index)
            first += count * size

    def _write_world(self, values, matrix, kept, out, arena):
        _write_normals(values, matrix, kept, out, arena)
        if not np.isfinite(out.sum()):
            self._all_usable = False

    def write(self, rows, facets, arena):
        """Look up the normals of the triangles `rows`, whose `facets` are finished."""
        if not self._groups:
            return
        index, table, smooth = self._index[rows], self._table[rows], self._smooth[rows]
        np.take(self._world, index.reshape(-1), axis=0, out=table.reshape(-1, 3), mode="clip")
        if not self._all_usable:
            _replace_unusable(table, facets)
        _differs(table, facets, smooth, arena)
        np.copyto(facets.view(np.int32)[:, NORMAL_ROW], np.arange(rows.start, rows.stop, dtype=np.int32), where=smooth)

    def table(self, facets):
        """The normals (R, 9) of the smooth triangles; their rows are in the facets."""
        if not self._groups:
            return np.zeros((0, 9), np.float32)
        if self._smooth.all():
            return self._table
        number = np.cumsum(self._smooth, dtype=np.int32)
        number -= 1
        np.copyto(facets.view(np.int32)[:, NORMAL_ROW], number, where=self._smooth)
        return np.take(self._table, np.flatnonzero(self._smooth), axis=0)


def _normals_of(group):
    """A mesh's normals (C, 3) and where they stand at the corners of its triangles (T, 3)."""
    mesh, values = group.mesh, np.asarray(group.mesh.normals)
    index = group.triangles if mesh.normals_domain == "vertex" else corner_index(group)
    check_length(mesh, "normals", values, index, 3)
    return values, index


def _scaled(matrices):
    """Matrices (I, 3, 3) with a largest element of 1, whose images have squares in float32."""
    return matrices / np.abs(matrices).max((1, 2), keepdims=True)


def _interpolated_before(group):
    """Which instances (I,) interpolate normals in object space: those of a shared mesh under an uneven scale.

    Their corners' normals are not brought to unit length in the world, which comes to the same. So does Cycles; a mesh
    that is used once it moves to the world, and interpolates there.
    """
    if not group.is_shared:
        return np.zeros(1, bool)
    square = group.normal_matrix @ group.normal_matrix.transpose(0, 2, 1)
    even = square[:, :1, :1] * np.eye(3)
    return np.abs(square - even).max((1, 2)) > 1e-6 * np.abs(square).max((1, 2))


def _write_normals(values, matrix, kept, out, arena):
    """Normals in the world; of unit length, but for those of the instances `kept`."""
    world = _turned(values, matrix, arena)
    x, y, z = (world[..., k] for k in range(3))
    length = np.sqrt(x * x + y * y + z * z)
    if kept.any():
        length[kept] = length[kept] > 0
    for k in range(3):
        np.divide(world[..., k], length, out=out[..., k], casting="same_kind")


def _replace_unusable(table, facets):
    """A corner without a usable normal takes the face's."""
    for k in range(3):
        corner = table[:, 3 * k : 3 * k + 3]
        unusable = np.flatnonzero(~np.isfinite(corner[:, 0] + corner[:, 1] + corner[:, 2]))
        corner[unusable] = facets[unusable, NORMAL]


def _differs(table, facets, out, arena):
    """Whether a coordinate of the corners' normals (n, 9) is not the face's, (n,) bool."""
    far = np.subtract(table[:, 0], facets[:, NORMAL.start], out=arena.empty(len(table)))
    np.greater(np.abs(far, out=far), _FLAT, out=out)
    alike = np.flatnonzero(~out)  # few, mostly
    corners, normals = np.take(table, alike, axis=0).reshape(-1, 3, 3), np.take(facets, alike, axis=0)[:, None, NORMAL]
    out[alike] = (np.abs(corners - normals) > _FLAT).any((1, 2))


# -- blocks ------------------------------------------------------------------------------------------------------------


def _parts(count, size):
    """Slices of at most `size` that make up ``0..count``."""
    return [slice(start, min(start + size, count)) for start in range(0, count, size)]


def _blocks(instances, size):
    """Pairs of slices, of instances and of a mesh's `size` rows, with about half a block of rows in each.

    The matrix library shares larger products among threads of its own, which wait in a loop.
    """
    half = BLOCK // 2
    if size > half:
        return [(slice(i, i + 1), part) for i in range(instances) for part in _parts(size, half)]
    return [(some, slice(0, size)) for some in _parts(instances, half // max(size, 1))]


def _run(tasks, count):
    """Call every task, which are of `count` triangles, with an arena; in threads where each task is worth it.

    Small arrays would have the threads wait for Python's lock all the time.
    """
    several = 4 <= len(tasks) <= 8 * count / BLOCK
    threads = min(os.cpu_count() or 1, _MOST_THREADS) if several else 1
    waiting = iter(tasks)

    def work(_):
        arena = Arena()
        # What is not finite comes out as NaN and is left out afterwards.
        with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
            for task in waiting:
                with arena.frame():
                    task(arena)

    if threads == 1:
        work(0)
    else:
        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(work, range(threads)))
