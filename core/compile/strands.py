# SPDX-License-Identifier: GPL-3.0-or-later
"""Curves to the segments of `core.strands`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..diagnostics import SceneError
from ..strands import INDEX_PADDING, POSITION, Strands

SLIMMEST = 1000.0
"""Length of a segment, in its radii, from which on Embree's round curves err: by up to 0.6% at 1,000 and 13% at 10,000,
as the processor's instructions are."""

_CUT = 250.0  # radii, of what a longer segment is cut into
_MOST_CUTS, _MOST_MORE = 1 << 13, 1 << 20  # of a segment, and of all
_TO_POWERS = POSITION.T.astype(np.float64)  # from control points to coefficients of 1, u, u², u³
_BINOMIAL = np.array([[1, 1, 1, 1], [0, 1, 2, 3], [0, 0, 1, 3], [0, 0, 0, 1]])


class Segments(NamedTuple):
    """C segments of all the strands of a scene."""

    strands: Strands | None
    owner: np.ndarray  # (C,) number of the Curves
    start: np.ndarray  # (C,) number of the point at its root's side; the other is the next one
    shares: np.ndarray | None  # (2, C) of the way between them, from where to where; None is from 0 to 1
    lost: np.ndarray  # owners (L,) of segments that were left out
    slim: np.ndarray  # owners of segments that rays partly miss


class Placed(NamedTuple):
    """The points of all curves, one after the other, in the world; float64."""

    points: np.ndarray  # (N, 3)
    radii: np.ndarray  # (N,)
    counts: np.ndarray  # (S,) of all strands
    owner: np.ndarray  # (S,)


def place_curves(curves):
    """All curves of a scene in the world, checked, a `Placed`."""
    points, radii, counts = [np.zeros((0, 3))], [np.zeros(0)], [np.zeros(0, np.intp)]
    for one in curves:
        matrix = np.asarray(one.transform, np.float64)
        local, radius, count = np.asarray(one.points, np.float64), np.asarray(one.radii), np.asarray(one.counts)
        if matrix.shape != (4, 4) or local.shape != (len(radius), 3) or count.ndim != 1 or count.sum() != len(radius):
            raise SceneError(
                f"curves '{one.name}' have points {local.shape}, radii {np.shape(radius)}, {count.sum()} points in "
                f"strands and a transform {matrix.shape}; make them (N, 3), (N,), N and (4, 4)"
            )
        with np.errstate(invalid="ignore", over="ignore"):  # what is not finite is left out later
            points.append(local @ matrix[:3, :3].T + matrix[:3, 3])
            radii.append(radius * abs(np.linalg.det(matrix[:3, :3])) ** (1 / 3))
        counts.append(count.astype(np.intp))
    owner = np.repeat(np.arange(len(curves)), [len(c) for c in counts[1:]])
    return Placed(np.concatenate(points), np.concatenate(radii), np.concatenate(counts), owner)


def write_segments(placed, origin):
    """The `Segments` of what is `placed`, relative to `origin`; without `strands` where nothing can be hit.

    Left out are segments with a control point that is not finite, and those without radius at both ends.
    """
    points = np.concatenate([placed.points - origin, np.maximum(placed.radii, 0)[:, None]], axis=1)
    strand = np.repeat(np.arange(len(placed.counts)), placed.counts)
    first = np.cumsum(placed.counts) - placed.counts
    # Each strand has two more control points than points.
    vertices = np.zeros((len(points) + 2 * len(placed.counts) + 1, 4), np.float32)
    vertices[np.arange(len(points)) + 2 * strand + 1] = points
    several = placed.counts >= 2
    root, tip = first[several], (first + placed.counts - 1)[several]
    vertices[root + 2 * np.flatnonzero(several)] = points[root]
    vertices[tip + 2 * np.flatnonzero(several) + 2] = points[tip]

    start = np.flatnonzero(strand[:-1] == strand[1:])
    index = start + 2 * strand[start]
    finite = np.isfinite(vertices).all(axis=1)
    good = np.logical_and.reduce([finite[index + k] for k in range(4)])
    good &= (vertices[index + 1, 3] > 0) | (vertices[index + 2, 3] > 0)
    owner = placed.owner[strand[start]]
    lost, owner, start, index = owner[~good], owner[good], start[good], index[good]
    if not index.size:
        return Segments(None, owner, start, None, lost, owner)
    apart = vertices[index + 1, :3] - vertices[index + 2, :3]
    radius = np.maximum(vertices[index + 1, 3], vertices[index + 2, 3])
    radii_long = np.sqrt((apart**2).sum(axis=1, dtype=np.float64)) / radius
    follows, cuts = np.diff(index, prepend=-2) == 1, _cuts(radii_long)
    slim, shares = owner[radii_long > SLIMMEST * cuts], None
    if cuts.max() > 1:
        piece = np.repeat(np.arange(cuts.size), cuts)
        number = np.arange(piece.size) - (np.cumsum(cuts) - cuts)[piece]
        vertices, index = _cut(vertices, index[piece], number, cuts[piece])
        follows, owner, start = follows[piece] | (number > 0), owner[piece], start[piece]
        shares = np.stack([number, number + 1]) / cuts[piece]
    index = np.append(index, np.zeros(INDEX_PADDING, np.intp)).astype(np.uint32)[: index.size]
    return Segments(Strands(vertices, index, follows), owner, start, shares, lost, slim)


def _cuts(radii_long):
    """Into how many segments each (C,) is cut, so that Embree meets them as they are."""
    cuts = np.ones(radii_long.size, np.intp)
    slim = radii_long > SLIMMEST
    cuts[slim] = np.ceil(np.minimum(radii_long[slim] / _CUT, _MOST_CUTS))
    return cuts if cuts.sum() - cuts.size <= _MOST_MORE else np.ones_like(cuts)


def _cut(vertices, index, number, cuts):
    """Control points and the index where segments `index` (C,) are share `number` of `cuts` equal ones.

    A share is a cubic too, and so has control points of its own.
    """
    own = np.flatnonzero(cuts > 1)
    width, powers = 1.0 / cuts[own], np.arange(4)
    begin = number[own] * width
    exponent = np.maximum(powers - powers[:, None], 0)
    moved = _BINOMIAL * begin[:, None, None] ** exponent * (width[:, None] ** powers)[:, :, None]
    points = vertices[index[own][:, None] + powers].astype(np.float64)
    points = np.linalg.inv(_TO_POWERS) @ (moved @ (_TO_POWERS @ points))  # in this order nothing else is as large
    index = index.copy()
    index[own] = len(vertices) + 4 * np.arange(own.size)
    return np.concatenate([vertices, points.reshape(-1, 4).astype(np.float32)]), index
