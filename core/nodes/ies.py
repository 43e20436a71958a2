# SPDX-License-Identifier: GPL-3.0-or-later
"""The IES Texture: a luminaire's strength by direction.

Source: Blender manual, "IES Texture Node"; Cycles (`kernel/util/ies.h`) for how it is interpolated.
"""

from __future__ import annotations

import math

import numpy as np

from . import spaces
from .base import Operation
from .ies_file import parse

_MISSING = 100.0  # Cycles' strength of a file that it cannot read


def _prepare(properties, diagnostics, place):
    """Read the file's text."""
    name = properties.get("name", "")
    try:
        return {"table": Interpolated(parse(properties.get("text", "")), "ends" in properties.get("older", ()))}
    except ValueError as error:
        diagnostics.warn(f"IES file '{name}' cannot be read, {error}; a strength of {_MISSING:g} is used", place)
        return {}


def _ies(context, inputs, properties):
    table = properties.get("table")
    if table is None:
        return {"fac": inputs["strength"] * np.float32(_MISSING)}
    if "vector" in inputs:
        x, y, z = inputs["vector"]
    else:
        x, y, z = spaces.normal_to_object(context, spaces.shading_normal(context))
    down = np.arctan2(np.hypot(x, y), -z)
    around = np.arctan2(x, y) + np.float32(math.pi)
    return {"fac": inputs["strength"] * table.at(around, down)}


class Interpolated:
    """Catmull-Rom splines between the angles of a `Photometry`; 0 beyond them.

    What would be the next angle beyond an end is the last one; beyond the last plane the one before it, as in Cycles,
    whose tests of closed circles fail by rounding. With `dark_ends` it is 0 there, as in Cycles before 5.0.
    """

    def __init__(self, photometry, dark_ends=False):
        self._around, self._down = photometry.horizontal, photometry.vertical
        self._strength = np.ascontiguousarray(photometry.strength)
        planes, rows = self._strength.shape
        before, after, above, below = 0, planes - 2, 0, rows - 1
        if dark_ends:  # a plane and a row more, of zeros
            self._strength = np.pad(self._strength, ((0, 1), (0, 1)))
            before, after, above, below = planes, planes, rows, rows
        if self._down[0] < 1e-7:  # through the pole the strength is taken to be symmetric
            above = 1
        self._planes = _neighbours(planes, before, after)
        self._rows = _neighbours(rows, above, below)

    def at(self, around, down):
        """Strengths (N,) in the directions of angles (N,)."""
        if min(self._around.size, self._down.size) < 2:  # one plane of type A or B: nothing lies between its angles
            return np.zeros_like(down)
        planes, across = _cell(self._around, around)
        rows, along = _cell(self._down, down)
        total = np.float32(0)
        for plane, weight in zip(self._planes[planes].T, across, strict=True):
            of_plane = sum(self._strength[plane, row] * w for row, w in zip(self._rows[rows].T, along, strict=True))
            total = total + of_plane * weight
        inside = (around >= self._around[0]) & (around <= self._around[-1])
        inside &= (down >= self._down[0]) & (down <= self._down[-1])
        return np.where(inside, np.maximum(total, 0), np.float32(0))


def _neighbours(count, before, after):
    """Numbers (count - 1, 4) of the angles around each interval; `before` and `after` are those beyond the ends."""
    padded = np.concatenate([[before], np.arange(count), [after]])
    return np.stack([padded[k : k + count - 1] for k in range(4)], axis=1)


def _cell(angles, x):
    """The interval of each angle `x` (N,), and the spline's weights of the four angles around it, (N,) each."""
    cell = np.clip(np.searchsorted(angles, x) - 1, 0, angles.size - 2)
    t = (x - angles[cell]) / (angles[cell + 1] - angles[cell])
    half = np.float32(0.5)
    return cell, (
        half * t * (t * (2 - t) - 1),
        half * (t * t * (3 * t - 5) + 2),
        half * t * (t * (4 - 3 * t) + 1),
        half * t * t * (t - 1),
    )


OPERATIONS = {"ies": Operation(_ies, {"vector": None, "strength": 1.0}, foldable=False, prepare=_prepare)}
