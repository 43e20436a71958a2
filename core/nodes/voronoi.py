# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Voronoi Texture.

Each cell of a lattice holds one point; a lane sees the points of the cells around its own. Sources: Worley, "A Cellular
Texture Basis Function", SIGGRAPH 1996; Quilez, "Smooth Voronoi" and "Voronoi edges"; Blender manual, "Voronoi Texture
Node", and Cycles for the order of cells, which decides ties and smooth minima.
"""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np

from .base import Operation
from .texture import vector_of
from .voronoi_cells import LOOKUP3, PCG, offsets

_SHARP = 1e-6  # smoothness of lanes that have none beside others that have some
_SAME_POINT = 1e-4  # squared distance below which two points have no edge between them
_FARTHEST = 8.0  # no edge is farther away


class Metric(NamedTuple):
    """How far points are: `kind` in Blender's words, `exponent` (1,) or (N,) of Minkowski's.

    Points are ordered by what is cheaper than their distance. With `by_length` they are by the distance, as before
    Blender 4.5: where it is infinite (exponent 0), no point is nearest then.
    """

    kind: str
    exponent: np.ndarray
    by_length: bool = False

    def bound(self, vector, arena):
        """What orders `vector` (D, N) as its length does, (N,)."""
        out = arena.zeros(vector.shape[-1])
        with arena.frame():
            t = arena.empty(out.size)
            for row in vector:
                if self.kind == "EUCLIDEAN":
                    np.multiply(row, row, out=t)
                else:
                    np.abs(row, out=t)
                if self.kind == "MINKOWSKI":
                    np.power(t, self.exponent, out=t)
                (np.maximum if self.kind == "CHEBYCHEV" else np.add)(out, t, out=out)
        return out

    def length(self, vector, arena):
        """Length of `vector` (D, N), (N,)."""
        out = self.bound(vector, arena)
        if self.kind == "EUCLIDEAN":
            np.sqrt(out, out=out)
        elif self.kind == "MINKOWSKI":
            np.power(out, np.divide(np.float32(1), self.exponent), out=out)
        return out


_EUCLIDEAN = Metric("EUCLIDEAN", np.float32([1]))


class Octave(NamedTuple):
    """What is known of lanes: `distance` (N,), `color` (3, N), `position` (D, N)."""

    distance: np.ndarray
    color: np.ndarray
    position: np.ndarray


class Lattice:
    """Cells around lanes.

    Parameters
    ----------
    p : (D, N) float32
        Where the lanes are.
    randomness : (1,) or (N,)
        How far a point may be from its cell's corner.
    hash_ : PCG or LOOKUP3
    """

    def __init__(self, p, randomness, hash_, arena):
        self.arena, self._randomness, self._hash = arena, randomness, hash_
        self.cell, self._local = np.floor(p, out=arena.empty(p.shape)), arena.empty(p.shape)
        np.subtract(p, self.cell, out=self._local)

    def offsets(self, reach=1):
        """Cells up to `reach` from a lane's own, (count, D, 1)."""
        return offsets(len(self.cell), reach)[..., None]

    def vector(self, offset):
        """From the lanes to the points of the cells at `offset` (D, 1) or (D, N), (D, N)."""
        out = self.point(offset)
        return np.subtract(out, self._local, out=out)

    def point(self, offset):
        """The points of the cells at `offset`, from the lane's own corner, (D, N)."""
        arena = self.arena
        out = arena.empty(self.cell.shape)
        with arena.frame():
            cell = np.add(self.cell, offset, out=arena.empty(out.shape))
            np.multiply(self._hash.point(cell, arena), self._randomness, out=out)
        return np.add(out, offset, out=out)

    def color(self, offset):
        """Colours of the cells at `offset`, (3, N)."""
        cell = np.add(self.cell, offset, out=self.arena.empty(self.cell.shape))
        return self._hash.color(cell, self.arena)

    def nearest(self, metric, second=False):
        """Offsets (D, N) of the cells whose points are nearest to the lanes, or next to nearest."""
        arena, n = self.arena, self.cell.shape[-1]
        around = self.offsets()
        number = arena.full((2, n), len(around) // 2, np.int32)  # the lane's own cell
        measure = metric.length if metric.by_length else metric.bound
        with arena.frame():
            least, closer = arena.full((2, n), np.finfo(np.float32).max), arena.empty(n, bool)
            for k, offset in enumerate(around):
                with arena.frame():
                    bound = measure(self.vector(offset), arena)
                    np.less(bound, least[0], out=closer)
                    if second:
                        _push_down(bound, least, number, closer, k, arena)
                    np.copyto(number[0], k, where=closer)
                    np.copyto(least[0], bound, where=closer)
        return arena.take(around[..., 0].T, number[1 if second else 0])


def _push_down(bound, least, number, closer, k, arena):
    """Make the nearest the second where another is `closer`, or the other where it is second."""
    np.copyto(number[1], number[0], where=closer)
    np.copyto(least[1], least[0], where=closer)
    after = np.less(bound, least[1], out=arena.empty(bound.size, bool))
    np.greater(after, closer, out=after)
    np.copyto(number[1], k, where=after)
    np.copyto(least[1], bound, where=after)


# -- features of one octave --------------------------------------------------------------------------------------------


def _of_one_cell(lattice, metric, smoothness, second):
    arena = lattice.arena
    offset = lattice.nearest(metric, second)
    distance = metric.length(lattice.vector(offset), arena)
    position = lattice.point(offset)
    if metric.by_length:
        none = np.isinf(distance)
        distance[none], position[:, none] = np.finfo(np.float32).max, 0.0
    return Octave(distance, lattice.color(offset), np.add(position, lattice.cell, out=position))


def _smooth_f1(lattice, metric, smoothness):
    """A smooth minimum over all cells, one after another: the result depends on their order."""
    arena, (dimensions, n) = lattice.arena, lattice.cell.shape
    smoothness = np.maximum(smoothness, _SHARP)
    # Distance, colour and position are mixed alike, but for how far the mixture is pulled down.
    mean = arena.zeros((4 + dimensions, n))
    pull = np.ones((4 + dimensions, smoothness.size), np.float32)
    pull[1:] /= 1 + 3 * smoothness
    for k, offset in enumerate(lattice.offsets(2)):
        with arena.frame():
            own, h, t = arena.empty(mean.shape), arena.empty(n), arena.empty(n)
            own[0] = metric.length(lattice.vector(offset), arena)
            own[1:4] = lattice.color(offset)
            own[4:] = lattice.point(offset)
            if k == 0:
                np.copyto(mean, own)
                continue
            np.subtract(mean[0], own[0], out=h)
            np.divide(h, smoothness, out=h)
            np.multiply(h, 0.5, out=h)
            np.add(h, 0.5, out=h)
            _smoothstep(h, t)
            np.subtract(own, mean, out=own)
            np.multiply(own, h, out=own)
            np.add(mean, own, out=mean)
            np.subtract(1.0, h, out=t)
            np.multiply(t, h, out=t)
            np.multiply(t, smoothness, out=t)
            np.subtract(mean, np.multiply(t, pull, out=own), out=mean)
    return Octave(mean[0], mean[1:4], np.add(mean[4:], lattice.cell, out=mean[4:]))


def _smoothstep(x, t):
    """x²(3 - 2x) of `x` kept in [0, 1], in place."""
    np.clip(x, 0.0, 1.0, out=x)
    np.multiply(x, -2.0, out=t)
    np.add(t, 3.0, out=t)
    np.multiply(x, x, out=x)
    np.multiply(x, t, out=x)


def _distance_to_edge(lattice):
    """Distance to the nearest of the planes halfway between the nearest point and the others, (N,)."""
    arena, n = lattice.arena, lattice.cell.shape[-1]
    least = arena.full(n, np.finfo(np.float32).max)
    with arena.frame():
        nearest = lattice.vector(lattice.nearest(_EUCLIDEAN))
        if len(nearest) == 1:
            return _distance_to_middle(lattice, least)
        for offset in lattice.offsets():
            with arena.frame():
                point = lattice.vector(offset)
                across, distance, t = arena.empty(point.shape), arena.zeros(n), arena.empty(n)
                np.subtract(point, nearest, out=across)
                np.add(point, nearest, out=point)
                for a, b in zip(point, across, strict=True):
                    np.add(distance, np.multiply(a, b, out=t), out=distance)
                length = _EUCLIDEAN.bound(across, arena)
                apart = np.greater(length, _SAME_POINT, out=arena.empty(n, bool))
                np.sqrt(length, out=length)
                np.divide(distance, length, out=distance, where=apart)
                np.multiply(distance, 0.5, out=distance)
                np.less(distance, least, out=apart, where=apart)
                np.copyto(least, distance, where=apart)
    return least


def _distance_to_middle(lattice, least):
    """On a line: distance to the nearer of the middles between the own cell's point and its neighbours', (N,)."""
    own, *others = (lattice.vector(np.float32([[k]])) for k in (0, -1, 1))
    for other in others:
        np.add(other, own, out=other)
        np.abs(other, out=other)
        np.multiply(other, 0.5, out=other)
        np.minimum(least, other[0], out=least)
    return least


def _n_sphere_radius(lattice):
    """Half the distance from the nearest point to the point nearest to it, (N,)."""
    arena = lattice.arena
    least = arena.full(lattice.cell.shape[-1], np.finfo(np.float32).max)
    center = lattice.nearest(_EUCLIDEAN)
    point = lattice.point(center)
    for offset in lattice.offsets():
        if offset.any():
            with arena.frame():
                other = lattice.point(np.add(center, offset, out=arena.empty(center.shape)))
                np.subtract(other, point, out=other)
                np.minimum(least, _EUCLIDEAN.bound(other, arena), out=least)
    np.sqrt(least, out=least)
    return np.multiply(least, 0.5, out=least)


# -- octaves -----------------------------------------------------------------------------------------------------------


class Settings(NamedTuple):
    """Inputs of the node, each (1,) or (N,), kept within Blender's limits, and its `metric` and `normalize`."""

    detail: np.ndarray
    roughness: np.ndarray
    lacunarity: np.ndarray
    smoothness: np.ndarray
    randomness: np.ndarray
    metric: Metric
    normalize: bool


def _octaves(settings):
    """Yield (scale, amplitude, share) of each octave; the last one counts by the fraction of the detail."""
    scale, amplitude = np.float32([1]), np.float32([1])
    for k in range(int(np.ceil(settings.detail.max())) + 1):
        yield scale, amplitude, np.clip(settings.detail - np.float32(k - 1), 0, 1) if k else np.float32([1])
        scale, amplitude = scale * settings.lacunarity, amplitude * settings.roughness


def _fractal(p, feature, settings, hash_, arena):
    """Octaves of F1, smooth F1 or F2: distances and colours are added, positions mixed."""
    total = Octave(arena.zeros(p.shape[-1]), arena.zeros((3, p.shape[-1])), arena.zeros(p.shape))
    highest = np.float32([0])
    for scale, amplitude, share in _octaves(settings):
        with arena.frame():
            lattice = Lattice(np.multiply(p, scale, out=arena.empty(p.shape)), settings.randomness, hash_, arena)
            octave, weight = feature(lattice, settings.metric, settings.smoothness), amplitude * share
            highest = highest + weight
            np.add(total.distance, np.multiply(octave.distance, weight, out=octave.distance), out=total.distance)
            np.add(total.color, np.multiply(octave.color, weight, out=octave.color), out=total.color)
            np.divide(octave.position, scale, out=octave.position)
            np.subtract(octave.position, total.position, out=octave.position)
            np.multiply(octave.position, weight, out=octave.position)
            np.add(total.position, octave.position, out=total.position)
    if settings.normalize:
        corner = np.broadcast_to(0.5 + 0.5 * settings.randomness, (p.shape[0], settings.randomness.size))
        farthest = settings.metric.length(corner, arena) * np.float32(2 if feature is _FEATURES["F2"] else 1)
        np.divide(total.distance, highest * farthest, out=total.distance)
        np.divide(total.color, highest, out=total.color)
    return total


def _fractal_edge(p, settings, hash_, arena):
    """Octaves of the distance to edges: the finer ones cut in where they are nearer."""
    total = arena.full(p.shape[-1], _FARTHEST)
    farthest = 0.5 + 0.5 * settings.randomness
    highest = farthest
    for scale, amplitude, share in _octaves(settings):
        with arena.frame():
            lattice = Lattice(np.multiply(p, scale, out=arena.empty(p.shape)), settings.randomness, hash_, arena)
            distance, weight = _distance_to_edge(lattice), amplitude * share
            highest = highest + weight * (farthest / scale - highest)
            np.minimum(total, np.divide(distance, scale, out=distance), out=distance)
            np.subtract(distance, total, out=distance)
            np.add(total, np.multiply(distance, weight, out=distance), out=total)
    return np.divide(total, highest, out=total) if settings.normalize else total


# -- the node ----------------------------------------------------------------------------------------------------------

_FEATURES = {
    "F1": partial(_of_one_cell, second=False),
    "F2": partial(_of_one_cell, second=True),
    "SMOOTH_F1": _smooth_f1,
}


def _voronoi(context, inputs, properties, hash_):
    arena = context.arena
    dimensions = int(properties.get("voronoi_dimensions", "3D")[0])
    inputs = dict(inputs)
    if dimensions > 1:
        inputs["vector"] = vector_of(context, inputs)
    n = max(value.shape[-1] for value in inputs.values())
    out = {"distance": arena.zeros(n), "color": arena.zeros((3, n)), "position": arena.zeros((3, n))}
    out |= {"w": arena.zeros(n), "radius": arena.zeros(n)}
    # What is no number stays none, and powers of 0 are Blender's.
    with np.errstate(all="ignore"), arena.frame():
        _fill(out, inputs, dimensions, properties, hash_, arena)
    return out


def _fill(out, inputs, dimensions, properties, hash_, arena):
    """Write the outputs that the node's feature has; the others are 0."""
    n, scale = out["w"].size, inputs["scale"]
    p = arena.empty((dimensions, n))
    if dimensions > 1:
        p[:3] = inputs["vector"][:dimensions]
    if dimensions in (1, 4):
        p[-1] = inputs["w"]
    np.multiply(p, scale, out=p)
    settings, feature = _settings(inputs, dimensions, properties), properties.get("feature", "F1")
    if feature == "DISTANCE_TO_EDGE":
        out["distance"][...] = _fractal_edge(p, settings, hash_, arena)
    elif feature == "N_SPHERE_RADIUS":
        out["radius"][...] = _n_sphere_radius(Lattice(p, settings.randomness, hash_, arena))
    else:
        if feature == "SMOOTH_F1" and not settings.smoothness.any():
            feature = "F1"
        octaves = _fractal(p, _FEATURES[feature], settings, hash_, arena)
        out["distance"][...], out["color"][...] = octaves.distance, octaves.color
        position = np.divide(octaves.position, scale, out=arena.zeros(p.shape), where=scale != 0)
        if dimensions > 1:
            out["position"][: min(dimensions, 3)] = position[:3]
        if dimensions in (1, 4):
            out["w"][...] = position[-1]


def _settings(inputs, dimensions, properties):
    metric = "EUCLIDEAN" if dimensions == 1 else properties.get("distance", "EUCLIDEAN")
    return Settings(
        detail=np.nan_to_num(np.clip(inputs["detail"], 0, 15)),
        roughness=np.clip(inputs["roughness"], 0, 1),
        lacunarity=inputs["lacunarity"],
        smoothness=np.clip(inputs["smoothness"] * np.float32(0.5), 0, 0.5),
        randomness=np.clip(inputs["randomness"], 0, 1),
        metric=Metric(metric, inputs["exponent"], "order" in properties.get("older", ())),
        normalize=bool(properties.get("normalize", False)),
    )


_INPUTS = {
    "vector": None,
    "w": 0.0,
    "scale": 5.0,
    "detail": 0.0,
    "roughness": 0.5,
    "lacunarity": 2.0,
    "smoothness": 1.0,
    "exponent": 0.5,
    "randomness": 1.0,
}

OPERATIONS = {
    name: Operation(partial(_voronoi, hash_=hash_), _INPUTS, foldable=False)
    for name, hash_ in (("voronoi", PCG), ("voronoi_4", LOOKUP3))
}
