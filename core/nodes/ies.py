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
        return {"table": _Interpolated(parse(properties.get("text", "")))}
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


class _Interpolated:
    """Catmull-Rom splines between the angles of a `Photometry`; 0 beyond them.

    What would be the next angle beyond an end is the last one; beyond the last plane the one before it, as in Cycles,
    whose tests of closed circles fail by rounding.
    """

    def __init__(self, photometry):
        self._around, self._down = photometry.horizontal, photometry.vertical
        self._strength = np.ascontiguousarray(photometry.strength)
        self._planes = _neighbours(self._around.size, 0, -2)
        above = 1 if self._down[0] < 1e-7 else 0  # through the pole the strength is taken to be symmetric
        self._rows = _neighbours(self._down.size, above, -1)

    def at(self, around, down):
        """Strengths (N,) in the directions of angles (N,)."""
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
    inner = np.arange(count)
    padded = np.concatenate([[before % count], inner, [after % count]])
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
