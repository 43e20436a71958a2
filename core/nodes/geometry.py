# SPDX-License-Identifier: GPL-3.0-or-later
"""The Geometry, Tangent and Wireframe nodes: what the surface is like where a ray met it.

Source: Blender manual, "Geometry Node", "Tangent Node", "Wireframe Node"; Cycles for the tangents' axes.
"""

from __future__ import annotations

import numpy as np

from ..geometry import CORNERS
from ..interaction import corner_values_at, interpolate_rows
from ..spaces import transform_normal
from ..vecmath import cross, dot, normalize
from . import spaces
from .base import Operation, Outputs
from .coordinates import lookup_generated
from .displaced import axes


def lookup_tangent(context):
    """Unit tangents (3, N) around the Z axis of each object's generated coordinates, across the shading normal."""
    return radial_tangent(context, "Z")


def radial_tangent(context, axis):
    """Unit tangents (3, N) around an axis ("X", "Y", "Z") of the generated coordinates, across the shading normal."""
    generated = lookup_generated(context)
    i, j = {"X": (1, 2), "Y": (0, 2), "Z": (0, 1)}[axis]
    around = context.arena.zeros(generated.shape)
    np.subtract(0.5, generated[j], out=around[i])
    np.subtract(generated[i], 0.5, out=around[j])
    return _across_normal(context, around)


def _across_normal(context, local):
    """Unit vectors across the shading normal nearest to `local` (3, N), which is in object space."""
    arena = context.arena
    n = spaces.shading_normal(context)
    objects = context.geometry.objects if context.surface is not None else None
    if objects is not None:  # nobody asked for them where what was linked is a loop, which is cut
        local = transform_normal(spaces.of_object(context, objects.to_object), local, arena)
    side = cross(local, n, arena)
    return cross(n, normalize(side, arena, out=side), arena)


def _parametric(context):
    s = context.surface
    out = context.arena.zeros((3, context.count))
    if s is None:
        out[0] = 1
        return out
    np.subtract(1, s.u, out=out[0])
    np.subtract(out[0], s.v, out=out[0])
    mirrored = spaces.of_object(context, context.geometry.objects.mirrored)[0]
    np.copyto(out[1], np.where(mirrored, s.v, s.u))
    return out


def _surface_tangent(context):
    return np.zeros((3, 1), np.float32) if context.surface is None else lookup_tangent(context.in_place())


def _backfacing(context):
    out = context.arena.zeros(context.count)
    if context.surface is not None:
        np.logical_not(context.surface.front, out=out, casting="unsafe")
    return out


def _of_corners(key):
    """A function that reads the first column of a table of the corners."""

    def read(context):
        s = context.surface
        if s is None:
            return np.zeros(1, np.float32)
        return corner_values_at(context.geometry.corner_values[key], s.prim, s.u, s.v, context.arena)[0]

    return read


def _random_per_island(context):
    """A hash, so it must not be rounded by interpolation."""
    s = context.surface
    if s is None:
        return np.zeros(1, np.float32)
    table = context.geometry.corner_values["island"]
    out = context.arena.zeros(context.count)
    on_triangle = np.flatnonzero(s.prim < len(table))
    out[on_triangle] = table[s.prim[on_triangle], 0]
    return out


_OUTPUTS = {
    "position": spaces.world_position,
    "normal": spaces.shading_normal,
    "tangent": _surface_tangent,
    "true_normal": spaces.true_normal,
    "incoming": spaces.incoming,
    "parametric": _parametric,
    "backfacing": _backfacing,
    "pointiness": _of_corners("pointiness"),
    "random_per_island": _random_per_island,
}


def _geometry(context, inputs, properties):
    return Outputs(_OUTPUTS, context)


def _tangent(context, inputs, properties):
    context = context.in_place()
    if properties.get("direction_type", "RADIAL") == "RADIAL":
        return {"tangent": radial_tangent(context, properties.get("axis", "Z"))}
    s = context.surface
    if s is None:
        return {"tangent": np.zeros((3, 1), np.float32)}
    table = context.geometry.corner_values["tangent", properties.get("uv_map", "")]
    return {"tangent": _across_normal(context, corner_values_at(table, s.prim, s.u, s.v, context.arena)[:3])}


def _wireframe(context, inputs, properties):
    """1 within half of `size` of a side of the triangle, in metres or in pixels of the camera."""
    s, arena = context.surface, context.arena
    fac = arena.zeros(context.count)
    if s is None or not context.geometry.triangle_count:
        return {"fac": fac}
    with arena.frame():
        size = 0.5 * inputs["size"]
        if properties.get("use_pixel_size"):
            size = size * _pixel_width(context)
        zero, one = arena.zeros(s.u.shape), arena.full(s.u.shape, 1.0)
        prim = np.minimum(s.prim, context.geometry.triangle_count - 1)
        places = (zero, zero), (one, zero), (zero, one)
        corners = [interpolate_rows(context.geometry.facets, CORNERS, prim, *at, arena) for at in places]
        p = spaces.position(context)
        for a, b in zip(corners, (*corners[1:], corners[0]), strict=True):
            edge, away = b - a, p - a
            area = cross(edge, away, arena)
            near = dot(area, area, arena) < dot(edge, edge, arena) * (size * size)
            np.copyto(fac, 1.0, where=near & (s.prim < context.geometry.triangle_count))
    return {"fac": fac}


def _pixel_width(context):
    """Mean width (N,) of a pixel's footprint as the ray sees it."""
    arena = context.arena
    wo = spaces.incoming(context)
    across = [np.sqrt(np.maximum(1 - np.square(dot(a, wo, arena)), 0)) for a in axes(context.surface.ng, arena)]
    return spaces.footprint(context) * (across[0] + across[1]) * np.float32(0.5)


OPERATIONS = {
    "geometry": Operation(_geometry, foldable=False),
    "tangent": Operation(_tangent, foldable=False),
    "wireframe": Operation(_wireframe, {"size": 0.01}, foldable=False),
}
