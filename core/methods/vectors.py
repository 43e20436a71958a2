# SPDX-License-Identifier: GPL-3.0-or-later
"""Where what is seen was a frame before, and will be a frame later, in pixels: Cycles' motion vectors.

A point keeps its place on its object; a mesh whose vertices move takes it along between its triangle's corners. What
the other frame does not have, or has with other triangles, moves as its object does, if that has a transform. Signs
are Cycles', measured: the place before less that of now, then that of now less the place after; X to the right, Y up.
"""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from ..scene import IDENTITY
from ..spaces import View, rows_of, transform_direction, transform_point


class Vectors:
    """Motion between three frames.

    Parameters
    ----------
    compiled : CompiledScene
    scene : core.scene.Scene
        That was compiled.
    around : pair of core.scene.Scene
        A frame before and a frame after.
    settings : Settings
    """

    def __init__(self, compiled, scene, around, settings):
        self._geometry = compiled.geometry
        self._size = np.array([[settings.width], [settings.height]], np.float32)
        self._before, self._after = (_Frame(compiled.geometry, scene, other, settings) for other in around)

    def add(self, met, sums, arena):
        """Add the vectors of the surfaces `met` to `sums` (5, N), whose last row counts them."""
        now = self._seen(self._geometry.view, met.surface.p, arena)
        for rows, frame, sign in ((sums[:2], self._before, 1), (sums[2:4], self._after, -1)):
            there = self._seen(frame.view, frame.moved(met.surface, arena), arena)
            rows[:, met.lane] += sign * (there - now)
        sums[4, met.lane] += 1

    def add_background(self, seen, met, d, sums, arena):
        """Add the vectors of the background in the directions `d` (3, N) of lanes that are `seen` (N,) and not `met`.

        Notes
        -----
        Of perspective cameras they are times the cosine to the view axis of each frame, for a direction is projected
        without the division by its depth. Source: Cycles (`camera_motion_vector_direction`, `kernel/camera/camera.h`).
        """
        lane = np.setdiff1d(np.flatnonzero(seen), met, assume_unique=True)
        if lane.size == 0:
            return
        d = arena.take(d, lane)
        now = self._seen_direction(self._geometry.view, d, arena)
        for rows, frame, sign in ((sums[:2], self._before, 1), (sums[2:4], self._after, -1)):
            rows[:, lane] += sign * (self._seen_direction(frame.view, d, arena) - now)
        sums[4, lane] += 1

    def _seen_direction(self, view, d, arena):
        """Pixels (2, n) of directions, of a perspective camera times their depth."""
        there = transform_direction(view.to_camera, d, arena)
        pixels = view.raster(there, arena)[:2] * self._size
        return pixels * there[2] if view.is_perspective else pixels

    def _seen(self, view, p, arena):
        """Pixels (2, n) in which points are seen."""
        return view.raster(transform_point(view.to_camera, p, arena), arena)[:2] * self._size


class _Frame:
    """One of the frames beside."""

    def __init__(self, geometry, scene, other, settings):
        self._geometry = geometry
        self.view = View(other.camera, settings.width, settings.height, geometry.origin)
        found = defaultdict(list)
        for x in reversed(other.objects):
            found[x.name].append(x)
        pairs = [(x, found[x.name].pop() if found[x.name] else x) for x in scene.objects]
        shift = _translation(geometry.origin)
        self._moves = rows_of([shift @ _move(a, b) @ np.linalg.inv(shift) for a, b in pairs] or [IDENTITY])
        counts = [len(x.mesh.triangles) for x in scene.instances]
        self._first = np.concatenate([[0], np.cumsum(counts, dtype=np.int64)])
        with np.errstate(all="ignore"):  # what is not finite is not seen
            self._deformed = {
                number: (b.mesh, rows_of(shift @ b.transform), _is_mirrored(a))
                for number, (a, b) in enumerate(pairs[: len(counts)])
                if _is_deformed(a.mesh, b.mesh)
            }

    def moved(self, surface, arena):
        """Where the points of `surface` are, (3, n)."""
        number = arena.take(self._geometry.object, surface.prim)
        p = transform_point(self._moves[:, number], surface.p, arena)
        for k, deformed in self._deformed.items():
            own = np.flatnonzero(number == k)
            if own.size:
                p[:, own] = self._on_mesh(k, *deformed, surface, own, arena)
        return p

    def _on_mesh(self, k, mesh, to_world, mirrored, surface, lanes, arena):
        prim, (u, v) = surface.prim[lanes], (surface.u[lanes], surface.v[lanes])
        own = self._geometry.own_number
        triangle = prim - self._first[k] if own is None else own[prim]
        if mirrored:  # the second and third corner have changed places
            u, v = v, u
        corners = np.asarray(mesh.vertices, np.float32)[np.asarray(mesh.triangles)[triangle]].transpose(1, 2, 0)
        return transform_point(to_world, (1 - u - v) * corners[0] + u * corners[1] + v * corners[2], arena)


def mean(sums):
    """The vectors (4, N) of what `Vectors.add` summed, 0 where nothing was met."""
    return sums[:4] / np.maximum(sums[4], 1)


def _move(one, other):
    """What takes the world's points from one frame to the other, (4, 4)."""
    a, b = (np.asarray(getattr(x, "transform", IDENTITY), np.float64) for x in (one, other))
    if np.array_equal(a, b) or not (np.isfinite(a).all() and np.isfinite(b).all()):
        return IDENTITY
    try:
        return b @ np.linalg.inv(a)
    except np.linalg.LinAlgError:  # scaled to nothing, and not seen
        return IDENTITY


def _translation(origin):
    """The (4, 4) matrix from the world to the tables."""
    matrix = np.eye(4)
    matrix[:3, 3] = -np.asarray(origin, np.float64)
    return matrix


def _is_mirrored(instance):
    return np.linalg.det(np.asarray(instance.transform, np.float64)[:3, :3]) < 0


def _is_deformed(one, other):
    if one is other or len(one.vertices) != len(other.vertices) or len(one.triangles) != len(other.triangles):
        return False
    return np.array_equal(one.triangles, other.triangles) and not np.array_equal(one.vertices, other.vertices)
