# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that move in a scene that is edited: only their rows of the tables are written again, and their trees built.

The tables are changed in place. What was compiled before shares them, so it is of no use afterwards.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..geometry import NORMAL, NORMAL_ROW
from .again import moved
from .geometry import centre
from .objects import compile_objects
from .placing import place
from .triangles import write_triangles

FEWEST_TRIANGLES = 1 << 15
"""Of a scene whose objects get trees of their own; fewer are compiled anew as fast as anybody looks."""

_MOST_PARTS = 256


def parts_of(geometry):
    """First triangles of the parts of a geometry that get a tree each, ascending; None where one tree is enough.

    A part is one object, or several small ones.
    """
    count = geometry.triangle_count
    if count < FEWEST_TRIANGLES:
        return None
    objects = geometry.object[:count]
    starts = np.append(0, np.flatnonzero(objects[1:] != objects[:-1]) + 1)
    _, first = np.unique(starts // -(-count // _MOST_PARTS), return_index=True)
    return starts[first] if len(first) > 1 else None


def move(before, scene, needs):
    """The geometry of a compiled scene after some of its meshes were moved, and `before.accel` brought up to date.

    Parameters
    ----------
    before : CompiledScene
    scene : Scene
    needs : Needs

    Returns
    -------
    Geometry or None
        None, with nothing changed, where more must be made anew. The tables' zero stays where it is, so that another
        scene's picture may differ from this one's by rounding.
    """
    geometry = before.geometry
    if before.accel.parts is None:
        return None
    numbers = moved(before.described, scene)
    if numbers is None:
        return None
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        groups, _ = place(scene.instances)
        if not _is_near(geometry, groups, scene):
            return None
        some, vertex_rows, first = _only(groups, numbers)
        fresh = write_triangles(some, some[-1].rows.stop if some else 0, geometry.origin)
    rows = _write(geometry, fresh, vertex_rows, first)
    if rows is None:
        return None
    before.accel.rebuild(rows)
    objects = compile_objects(scene, geometry.origin, geometry.materials) if needs.objects else None
    return replace(geometry, objects=objects)


def _is_near(geometry, groups, scene):
    """Whether the tables' zero is still near the middle of the scene."""
    strands = geometry.strands.vertices if geometry.strands is not None else np.zeros((0, 4), np.float32)
    points = np.concatenate([geometry.centers.T, strands[:, :3]]) + geometry.origin
    radii = np.concatenate([geometry.radii, strands[:, 3]])
    middle, reach = centre(groups, points, radii, scene)
    return bool(np.abs(middle - geometry.origin).max() <= 0.5 * reach)


def _only(groups, numbers):
    """Groups of the instances `numbers` alone.

    Returns
    -------
    groups : list of Placed
        Whose rows are those of tables of their own.
    vertex_rows : (V,) int
        Rows of their vertices in the table of all.
    first : dict
        The first row of each instance's triangles in their own tables.
    """
    chosen, vertex_rows, first = [], [np.zeros(0, np.intp)], {}
    first_vertex = count = 0
    for group in groups:
        k = np.flatnonzero(np.isin(group.numbers, numbers))
        if not k.size:
            continue
        sizes = len(group.vertices), len(group.triangles)
        part = group._replace(
            numbers=group.numbers[k],
            matrix=group.matrix[k],
            normal_matrix=group.normal_matrix[k],
            flipped=group.flipped[k],
            rows=slice(count, count + k.size * sizes[1]),
            first_vertex=first_vertex,
        )
        chosen.append(part)
        first |= zip(part.numbers.tolist(), range(count, part.rows.stop, sizes[1]), strict=True)
        first_vertex, count = first_vertex + k.size * sizes[0], part.rows.stop
        vertex_rows.append((group.first_vertex + sizes[0] * k[:, None] + np.arange(sizes[0])).reshape(-1))
    return chosen, np.concatenate(vertex_rows), first


def _write(geometry, fresh, vertex_rows, first):
    """Write the `Triangles` of what moved, and tell their rows.

    None, and nothing is written, where other triangles than before are good or smooth.
    """
    objects = geometry.object[: geometry.triangle_count]
    first_of = np.full(int(objects.max()) + 1, -1)
    first_of[list(first)] = list(first.values())
    rows = np.flatnonzero(first_of[objects] >= 0)
    # Some of a mesh's triangles may have been left out.
    chosen = slice(None) if geometry.own_number is None else first_of[objects[rows]] + geometry.own_number[rows]
    good = np.zeros(len(fresh.good), bool)
    good[chosen] = True
    facets, had = fresh.facets[chosen], geometry.facets.view(np.int32)[rows, NORMAL_ROW]
    if not np.array_equal(good, fresh.good):
        return None
    if not np.array_equal(vertex_rows[fresh.index[chosen]], geometry.index[rows]):  # mirrored
        return None
    has = facets.view(np.int32)[:, NORMAL_ROW]
    if (has[had < 0] >= 0).any():
        return None
    smooth, both = had >= 0, (had >= 0) & (has >= 0)
    geometry.normals[had[smooth]] = np.tile(facets[smooth][:, NORMAL], 3)  # what became flat
    geometry.normals[had[both]] = fresh.normals[has[both]]
    has[:] = had
    geometry.facets[rows] = facets
    geometry.vertices[vertex_rows] = fresh.vertices
    return rows
