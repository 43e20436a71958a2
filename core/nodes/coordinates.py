# SPDX-License-Identifier: GPL-3.0-or-later
"""Texture coordinates: the Texture Coordinate, UV Map and Camera Data nodes.

Source: Blender manual, "Texture Coordinate Node"; Cycles for what is left open there.
"""

from __future__ import annotations

import numpy as np

from ..interaction import corner_values_at, uv_at
from ..spaces import rows_of, transform_point
from ..vecmath import dot, normalize, reflect
from . import spaces
from .base import Operation, Outputs


def lookup_uv(context, name):
    """UV map `name` of the lanes, (3, N) with a zero third row; "" is each mesh's active map. A world's are zero."""
    out = context.arena.zeros((3, context.count))
    s = context.surface
    if s is not None:
        out[:2] = uv_at(context.geometry, name, s.prim, s.u, s.v, context.arena)
    return out


def lookup_generated(context):
    """Generated coordinates of the lanes, (3, N): what a texture without a linked vector takes.

    A mesh's texture space is 0 to 1, as a rule its box before deformation. A world's are its directions; a sphere's
    and a plane's their position in the world; a strand's those of its root.
    """
    if context.direction is not None:
        return context.direction
    s, geometry = context.surface, context.geometry
    table = geometry.corner_values.get("generated")
    if table is None:  # nobody asked: what was linked is a loop, which is cut
        return context.arena.zeros((3, context.count))
    out = corner_values_at(table, s.prim, s.u, s.v, context.arena)
    if geometry.count > geometry.triangle_count:
        without = (s.prim >= geometry.triangle_count) & ~geometry.on_strand(s.prim)
        np.copyto(out, spaces.world_position(context), where=without)
    return out


def _uv_map(context, inputs, properties):
    if properties.get("from_instancer"):
        return {"uv": _of_instancer(context, "uv")}
    return {"uv": lookup_uv(context, properties.get("uv_map", ""))}


def _of_instancer(context, name):
    """Coordinates of the instancer where the lanes' objects stand; zero in a world."""
    if context.surface is None:
        return np.zeros((3, 1), np.float32)
    return spaces.of_object(context, getattr(context.geometry.objects, name))


def _generated(context, properties):
    return _of_instancer(context, "generated") if properties.get("from_instancer") else lookup_generated(context)


def _normal(context, properties):
    return spaces.normal_to_object(context, spaces.shading_normal(context))


def _uv(context, properties):
    return _of_instancer(context, "uv") if properties.get("from_instancer") else lookup_uv(context, "")


def _object(context, properties):
    """Of the lanes' own objects, or in the space whose inverse the property `matrix` is (16 numbers)."""
    if "matrix" not in properties:
        return spaces.object_position(context)
    rows = rows_of(np.reshape(properties["matrix"], (4, 4)))
    return transform_point(rows, spaces.world_position(context), context.arena)


def _camera(context, properties):
    return spaces.camera_position(context)


def _window(context, properties):
    """Of lanes that are moved aside by as many pixels as footprints, where `window_step` is ``"PIXEL"``."""
    view = spaces.view_of(context)
    if context.unmoved is None or properties.get("window_step") != "PIXEL":
        return view.raster(spaces.camera_position(context), context.arena)
    out = view.raster(spaces.camera_position(context.in_place()), context.arena)
    for row, step, pixel in zip(out, context.step, view.pixel, strict=False):
        np.add(row, step * pixel, out=row)
    return out


def _reflection(context, properties):
    if context.surface is None:
        return spaces.incoming(context)
    return reflect(context.surface.wo, context.surface.ns, context.arena)


_COORDINATES = {
    "generated": _generated,
    "normal": _normal,
    "uv": _uv,
    "object": _object,
    "camera": _camera,
    "window": _window,
    "reflection": _reflection,
}


def _tex_coord(context, inputs, properties):
    return Outputs(_COORDINATES, context, properties)


def _camera_data(context, inputs, properties):
    arena = context.arena
    if context.surface is None:  # Cycles takes a world's directions for positions here
        view = spaces.view_of(context)
        p = transform_point(view.to_camera, context.direction - view.origin, arena)
    else:
        p = spaces.camera_position(context)
    distance = dot(p, p, arena)
    np.sqrt(distance, out=distance)
    return {"view_vector": normalize(p, arena), "view_z_depth": p[2], "view_distance": distance}


OPERATIONS = {
    "uv_map": Operation(_uv_map, foldable=False),
    "tex_coord": Operation(_tex_coord, foldable=False),
    "camera_data": Operation(_camera_data, foldable=False),
}
