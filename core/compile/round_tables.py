# SPDX-License-Identifier: GPL-3.0-or-later
"""What shader nodes read of spheres and strands, as further rows of the tables of triangles' corners.

A sphere has the same value at all three corners. A segment's three are those of its ends, root, tip and root again:
with barycentrics (u, v) that is (1 - u) root + u tip, whatever v. So what looks up triangles finds these too.

Keys beside those of `core.compile.corners`: ``"strand"`` (intercept, length, thickness, random number of a strand) and
``"point"`` (random number of a point).
"""

from __future__ import annotations

import numpy as np

from ..arena import Arena
from ..diagnostics import SceneError
from ..nodes.hashing import hash_to_unit
from .corners import as_colors, missing_color


def append_rows(table, key, scene, spheres, segments):
    """`table` (T, 3 C) with a row for each sphere and segment.

    Parameters
    ----------
    key : str or tuple
        Of a table of corner values, or ``("uv", name)``.
    spheres : (S,) int
        Which of the scene's spheres are rendered, counted through.
    segments : Segments or None
    """
    columns = table.shape[1] // 3
    parts = [table, np.tile(_of_points(key, scene.spheres, columns, _sphere_count)[spheres], 3)]
    if segments is not None:
        values = _of_points(key, scene.curves, columns, _point_count)
        root, tip = values[segments.start], values[segments.start + 1]
        if segments.shares is not None:
            with np.errstate(invalid="ignore", over="ignore"):  # of what is not finite, such as a radius
                root, tip = (root + (tip - root) * np.float32(share)[:, None] for share in segments.shares)
        parts.append(np.concatenate([root, tip, root], axis=1))
    return np.concatenate(parts)


def _sphere_count(spheres):
    return len(spheres.radii)


def _point_count(curves):
    return len(curves.radii)


def _of_points(key, things, columns, count):
    """Values (N, columns) at the points of all `things`."""
    values = [np.zeros((0, columns), np.float32)]
    for thing in things:
        found = _values(key, thing, count(thing))
        values.append(np.zeros((count(thing), columns)) if found is None else np.asarray(found)[:, :columns])
    return np.concatenate(values).astype(np.float32)


def _values(key, thing, count):
    """Values (count, C) of one of Spheres or Curves; None where it has none."""
    is_hair = hasattr(thing, "counts")
    kind, name = key if isinstance(key, tuple) else (key, None)
    if kind in ("attribute", "color"):
        return _attribute(thing, kind, name, count)
    if kind == "uv":
        return _uv(thing, name) if is_hair else None
    if kind == "strand" and is_hair:
        return _strand(thing)
    if kind == "generated" and is_hair:
        return _generated(thing)
    return _random(count)[:, None] if kind == "point" and not is_hair else None


def _attribute(thing, kind, name, count):
    found = thing.attributes.get(name)
    if found is None:
        uv = _uv(thing, name) if name and hasattr(thing, "counts") and name in thing.uvs else None
        return np.tile(missing_color(kind), (count, 1)) if uv is None else as_colors(uv)
    values = np.asarray(found.values, np.float32)
    if found.domain == "strand":
        values = _spread(thing, values)
    elif found.domain == "mesh":
        values = np.repeat(values[:1], count, axis=0)
    if values.ndim != 2 or len(values) != count:
        raise SceneError(f"attribute '{name}' of '{thing.name}' has shape {values.shape}; make it ({count}, C)")
    return as_colors(values)


def _uv(curves, name):
    key = name or curves.active_uv or next(iter(curves.uvs), "")
    return _spread(curves, np.asarray(curves.uvs[key], np.float32)) if key in curves.uvs else None


def _spread(curves, values):
    """Values of strands at all their points."""
    if len(values) != len(curves.counts):
        raise SceneError(
            f"curves '{curves.name}' need values for {len(curves.counts)} strands; there are {len(values)}"
        )
    return np.repeat(values, curves.counts, axis=0)


def _random(count):
    """A number in [0, 1] by number of the point or strand, Blender's."""
    words = np.arange(count, dtype=np.uint32), np.zeros(1, np.uint32)
    return np.array(hash_to_unit(words, Arena(1 << 16)))


def intercepts(points, counts):
    """Share of its strand's length at which each point stands (N,), and the lengths of the strands (S,).

    The length is that of straight lines from point to point. Points of a strand without length stand at 0; steps from
    or to points that are not finite have none.
    """
    points, counts = np.asarray(points, np.float64), np.asarray(counts)
    steps = np.zeros(len(points))
    with np.errstate(invalid="ignore", over="ignore"):
        steps[1:] = np.sqrt((np.diff(points, axis=0) ** 2).sum(axis=1))
    steps[~np.isfinite(steps)] = 0
    first = (np.cumsum(counts) - counts)[counts > 0]
    steps[first] = 0
    run = np.cumsum(steps)
    start, length = np.zeros(len(counts)), np.zeros(len(counts))
    start[counts > 0] = run[first]
    length[counts > 0] = run[first + counts[counts > 0] - 1] - run[first]
    run -= np.repeat(start, counts)
    return np.divide(
        run, np.repeat(length, counts), out=np.zeros_like(run), where=np.repeat(length, counts) > 0
    ), length


def _strand(curves):
    share, length = intercepts(curves.points, curves.counts)
    scale = abs(np.linalg.det(np.asarray(curves.transform, np.float64)[:3, :3])) ** (1 / 3)
    columns = (
        share,
        np.repeat(length, curves.counts),
        2 * scale * np.asarray(curves.radii),
        np.repeat(_random(len(curves.counts)), curves.counts),
    )
    return np.stack(columns, axis=1)


def _generated(curves):
    """That of its root for each strand."""
    points, counts = np.asarray(curves.points, np.float64), np.asarray(curves.counts)
    if curves.texture_space is None:
        finite = points[np.isfinite(points).all(axis=1)]
        low, high = (finite.min(axis=0), finite.max(axis=0)) if len(finite) else np.zeros((2, 3))
        location, size = (low + high) / 2, (high - low) / 2
    else:
        location, size = (np.asarray(x, np.float64) for x in (curves.texture_space.location, curves.texture_space.size))
    root = np.zeros((len(counts), 3))
    root[counts > 0] = points[(np.cumsum(counts) - counts)[counts > 0]]
    scale = np.divide(0.5, size, out=np.zeros(3), where=size != 0)
    return _spread(curves, (root - location) * scale + 0.5)
