# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Sky Texture.

Preetham's and Hosek and Wilkie's skies are formulas of the direction. Those that simulate scattering are computed
once, for a table of directions, as Cycles does; its disc of the sun is a formula again.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from .base import Operation
from .sky_analytic import HosekWilkie, Preetham
from .sky_multiple_scattering import MultipleScattering
from .sky_single_scattering import SingleScattering
from .texture import vector_of

COLUMNS, ROWS = 512, 256  # of the table
_SMALLEST_SUN = 0.0005  # rad, as in Cycles
_LIMB = 0.6  # by how much the edge of the disc is darker than its centre
_EARTH = 6371e3  # m

XYZ_TO_RGB = np.array(  # from the primaries of Rec.709 and a white at D65
    [
        (3.24096994, -1.53738318, -0.49861076),
        (-0.96924364, 1.87596750, 0.04155506),
        (0.05563008, -0.20397696, 1.05697151),
    ],
    np.float32,
)


class Sun(NamedTuple):
    """A disc in the sky: unit `axis` (3,) towards its centre, full `angle`, rad."""

    axis: np.ndarray
    angle: float


def suns_of(nodes):
    """The discs that sky textures among `nodes` (`core.scene.Node`) may show, a list of `Sun`."""
    return [_sun(node.properties) for node in nodes if node.op == "sky" and _shows_sun(node.properties)]


def _shows_sun(properties):
    return _type(properties) in _SCATTERING and bool(properties.get("sun_disc", True))


def _sun(properties):
    elevation, rotation = _position(properties)
    across = math.cos(elevation)
    axis = np.array([across * math.sin(rotation), across * math.cos(rotation), math.sin(elevation)])
    return Sun(axis, max(properties.get("sun_size", 0.009512), _SMALLEST_SUN))


def _position(properties):
    """The sun's elevation in [-π/2, π/2] and its rotation; beyond the zenith it comes down on the other side."""
    elevation, rotation = properties.get("sun_elevation", math.radians(15)), properties.get("sun_rotation", 0.0)
    if math.cos(elevation) < 0.0:
        rotation += math.pi
    return math.asin(max(-1.0, min(1.0, math.sin(elevation)))), rotation


class ScatteredSky:
    """Light of a simulated atmosphere, with a sun or without.

    Parameters
    ----------
    table : (3, ROWS · COLUMNS) float32
        Colours XYZ; rows from nadir to zenith are closer together at the horizon, the sun is above the middle.
    properties : mapping
        Of the node.
    colors : (2, 3)
        Radiance XYZ of the lowest and the highest point of the sun that are seen.
    """

    def __init__(self, table, properties, colors):
        self._table = table
        self._rotation = _position(properties)[1]
        self._sun = _sun(properties) if _shows_sun(properties) else None
        self._colors = np.asarray(colors) * properties.get("sun_intensity", 1.0)
        altitude = properties.get("altitude", 100.0)
        self._horizon = math.asin(_EARTH / (_EARTH + max(altitude, 0.0))) - 0.5 * math.pi
        elevation, radius = _position(properties)[0], 0.5 * _sun(properties).angle
        self._lowest, self._highest = elevation - radius, elevation + radius
        self._is_nishita = _type(properties) == "NISHITA"
        if self._is_nishita:
            # Before Blender 5.0 the horizon cut the disc off.
            self._horizon, self._lowest = 0.0, max(self._lowest, 0.0)

    def radiance(self, direction, arena, with_sun):
        """Colour XYZ (3, N) from `direction` (3, N), which need not be unit."""
        x, y, z = direction
        out = arena.empty(direction.shape)
        with arena.frame():
            elevation, azimuth = arena.empty(x.shape), arena.empty(x.shape)
            np.hypot(x, y, out=elevation)
            np.arctan2(z, elevation, out=elevation)
            np.arctan2(y, x, out=azimuth)
            self._look_up(elevation, azimuth, arena, out)
            if self._is_nishita:
                fade = np.clip(1.0 + 2.5 * z, 0.0, 1.0) ** 3
                np.multiply(out, fade, out=out)
            if with_sun and self._sun is not None:
                self._add_sun(direction, elevation, arena, out)
        return out

    def _look_up(self, elevation, azimuth, arena, out):
        column, row = arena.empty(elevation.shape), arena.empty(elevation.shape)
        np.subtract((-0.5 * math.pi - self._rotation) % (2.0 * math.pi), azimuth, out=column)
        np.multiply(column, 0.5 / math.pi, out=column)
        np.subtract(column, np.floor(column, out=row), out=column)
        np.abs(elevation, out=row)
        np.multiply(row, 2.0 / math.pi, out=row)
        np.sqrt(row, out=row)
        np.copysign(row, elevation, out=row)
        np.multiply(row, 0.5, out=row)
        np.add(row, 0.5, out=row)
        _bilinear(self._table, column, row, arena, out)

    def _add_sun(self, direction, elevation, arena, out):
        """The disc where it is above the Earth's edge; from its lowest to its highest point colours are mixed."""
        axis, angle = self._sun
        away = direction - axis.astype(np.float32)[:, None]
        away = 2.0 * np.arcsin(np.minimum(0.5 * np.sqrt((away * away).sum(axis=0)), 1.0))
        lanes = np.flatnonzero((away < 0.5 * angle) & (elevation > self._horizon))
        if lanes.size:
            if self._is_nishita:
                out[:, lanes] = 0.0  # its disc hides the sky
            share = (elevation[lanes] - self._lowest) / (self._highest - self._lowest)
            limb = 1.0 - _LIMB * (1.0 - np.sqrt(1.0 - (away[lanes] / (0.5 * angle)) ** 2))
            for row, (low, high) in zip(out, self._colors.T.tolist(), strict=True):
                row[lanes] += (low + (high - low) * share) * limb


def _bilinear(table, x, y, arena, out):
    """Write what `table` (3, ROWS · COLUMNS) shows at `x`, `y` (N,) in [0, 1], which are spoilt, to `out` (3, N)."""
    n = x.size
    corners = []
    for at, size in ((x, COLUMNS), (y, ROWS)):
        low, index = arena.empty(n), arena.empty((2, n), np.int32)
        np.multiply(at, size, out=at)
        np.subtract(at, 0.5, out=at)
        np.fmax(np.fmin(at, size - 1, out=at), 0, out=at)
        np.floor(at, out=low)
        np.subtract(at, low, out=at)
        np.copyto(index[0], low, casting="unsafe")
        np.minimum(np.add(index[0], 1, out=index[1]), size - 1, out=index[1])
        corners.append(index)
    columns, rows = corners
    np.multiply(rows, COLUMNS, out=rows)
    index, texel, lower = arena.empty(n, np.int32), arena.empty(n), arena.empty(n)
    for channel, total in zip(table, out, strict=True):
        for row, mixed in zip(rows, (lower, total), strict=True):
            np.take(channel, np.add(row, columns[0], out=index), out=mixed, mode="clip")
            np.take(channel, np.add(row, columns[1], out=index), out=texel, mode="clip")
            np.subtract(texel, mixed, out=texel)
            np.add(mixed, np.multiply(texel, x, out=texel), out=mixed)
        np.subtract(total, lower, out=total)
        np.multiply(total, y, out=total)
        np.add(total, lower, out=total)


# -- tables ------------------------------------------------------------------------------------------------------------


@lru_cache(maxsize=8)
def _tables(kind, elevation, size, altitude, *densities):
    """Table of the sky and the two colours of the sun, (3, ROWS · COLUMNS) float32 and (2, 3)."""
    model = (MultipleScattering if kind == "MULTIPLE_SCATTERING" else SingleScattering)(elevation, altitude, *densities)
    table = _multiple(model) if kind == "MULTIPLE_SCATTERING" else _single(model, kind == "NISHITA")
    table = np.concatenate((table, table[..., ::-1]), axis=2)
    # Cycles rounds this one: its sun of the usual size is 0.13% too dim, smaller ones more.
    solid_angle = 4.0 * math.pi * math.sin(0.25 * size) ** 2
    ends = [elevation - 0.5 * size, elevation + 0.5 * size]
    if kind != "MULTIPLE_SCATTERING" and ends[1] <= 0.0:
        return table.reshape(3, -1).astype(np.float32), np.zeros((2, 3))
    return table.reshape(3, -1).astype(np.float32), np.array([model.sun(e) for e in ends]) / solid_angle


def _multiple(model):
    azimuth = 2.0 * math.pi * (np.arange(COLUMNS // 2) + 0.5) / COLUMNS - math.pi
    level = (2.0 * np.arange(ROWS) + 1.0) / ROWS - 1.0
    rows = [model.sky(float(e), azimuth) for e in np.copysign(level**2, level) * (0.5 * math.pi)]
    return np.stack(rows, axis=1)


def _single(model, nishita):
    """Rows and columns are half a texel off, as in Cycles; under the horizon its light fades away.

    Before Blender 5.0 the rows were a little farther apart, and light under the horizon faded with the height of the
    direction instead: there the table holds that of the horizon.
    """
    azimuth = 2.0 * math.pi * np.arange(COLUMNS // 2) / COLUMNS - math.pi
    level = np.arange(ROWS // 2) * (2.0 / ROWS)
    elevation = level**2 * (0.5 * math.pi) * (1.0 + 1.0 / ROWS if nishita else 1.0)
    upper = np.stack([model.sky(float(e), azimuth) for e in elevation], axis=1)
    fade = np.ones(ROWS // 2)
    if not nishita:
        fade = np.maximum(1.0 - 2.5 * np.sin((1.0 - level) ** 2 * (0.5 * math.pi)), 0.0) ** 3
    return np.concatenate((upper[:, :1] * fade[:, None], upper), axis=1)


# -- the node ----------------------------------------------------------------------------------------------------------

_SCATTERING = ("SINGLE_SCATTERING", "MULTIPLE_SCATTERING", "NISHITA")


def _type(properties):
    return properties.get("sky_type", "MULTIPLE_SCATTERING")


def _prepare(properties, diagnostics, place):
    """Compute the table."""
    kind = _type(properties)
    if kind == "PREETHAM":
        return {"sky": Preetham(_direction(properties), properties.get("turbidity", 2.2))}
    if kind == "HOSEK_WILKIE":
        numbers = (properties.get("turbidity", 2.2), properties.get("ground_albedo", 0.3))
        return {"sky": HosekWilkie(_direction(properties), *numbers)}
    if kind not in _SCATTERING:
        diagnostics.warn(f"sky type {kind} is not supported; multiple scattering is used", place)
        properties = {**properties, "sky_type": "MULTIPLE_SCATTERING"}
    densities = (properties.get(name, 1.0) for name in ("air_density", "aerosol_density", "ozone_density"))
    size, altitude = _sun(properties).angle, properties.get("altitude", 100.0)
    table, colors = _tables(_type(properties), _position(properties)[0], size, altitude, *densities)
    return {"sky": ScatteredSky(table, properties, colors)}


def _direction(properties):
    """Unit vector to the sun of a formula."""
    direction = properties.get("sun_direction", (0.0, 0.0, 1.0))
    length = math.hypot(*direction)
    return tuple(v / length for v in direction) if length > 0.0 else (0.0, 0.0, 1.0)


def _sky(context, inputs, properties):
    arena = context.arena
    color = arena.empty((3, context.count))
    with arena.frame(), np.errstate(all="ignore"):
        direction = np.broadcast_to(vector_of(context, inputs), color.shape)
        xyz = properties["sky"].radiance(direction, arena, with_sun=not context.averaged)
        np.matmul(XYZ_TO_RGB, xyz, out=color)
        np.maximum(color, 0.0, out=color)
    return {"color": color}


OPERATIONS = {"sky": Operation(_sky, {"vector": None}, foldable=False, prepare=_prepare)}
