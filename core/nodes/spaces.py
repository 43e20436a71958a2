# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the lanes of a program are, in the spaces that nodes measure in: world, object and camera.

Positions are relative to the geometry's origin, which the matrices of `core.spaces` take into account; only
`world_position` adds it.
"""

from __future__ import annotations

import numpy as np

from ..geometry import CORNERS
from ..interaction import interpolate_rows
from ..spaces import transform_direction, transform_normal, transform_point
from ..vecmath import normalize


def of_object(context, column):
    """Values (C, N) of each lane's object in a column of `Objects`; (C, 1) in a scene of one object."""
    if column.shape[1] == 1:
        return column
    arena = context.arena
    return arena.take(column, arena.take(context.geometry.object, context.surface.prim))


def position(context):
    """Positions (3, N) of the lanes, relative to the geometry's origin; a world's are its directions."""
    if context.direction is not None:
        return context.direction
    s = context.surface
    p = getattr(s, "p", None)
    if p is not None:
        return p
    return interpolate_rows(context.geometry.facets, CORNERS, s.prim, s.u, s.v, context.arena)


def world_position(context):
    """Positions (3, N) of the lanes in the world."""
    p = position(context)
    if context.direction is not None or not context.geometry.origin.any():
        return p
    origin = context.geometry.origin.astype(np.float32).reshape(3, 1)
    return np.add(p, origin, out=context.arena.empty(p.shape))


def view_of(context):
    """The `View` of the scene, None where nobody looks."""
    return context.view if context.geometry is None else context.geometry.view


def camera_position(context):
    """Positions (3, N) of the lanes in camera space; a world's are its directions."""
    view = view_of(context)
    turn = transform_point if context.direction is None else transform_direction
    return turn(view.to_camera, position(context), context.arena)


def incoming(context):
    """Unit vectors (3, N) to where the ray comes from."""
    if context.direction is not None:
        return np.negative(context.direction, out=context.arena.empty(context.direction.shape))
    return context.surface.wo


def shading_normal(context):
    """Shading normals (3, N), turned to the viewer; a world's face the viewer."""
    return incoming(context) if context.direction is not None else context.surface.ns


def true_normal(context):
    """Geometric normals (3, N), turned to the viewer; a world's face the viewer."""
    return incoming(context) if context.direction is not None else context.surface.ng


def object_position(context):
    """Positions (3, N) of the lanes in their objects' spaces."""
    if context.direction is not None:
        return context.direction
    return transform_point(of_object(context, context.geometry.objects.to_object), position(context), context.arena)


def normal_to_object(context, n):
    """Unit normals (3, N) of the world in the lanes' objects' spaces."""
    if context.direction is not None:
        return n
    out = transform_normal(of_object(context, context.geometry.objects.to_world), n, context.arena)
    return normalize(out, context.arena, out=out)


def normal_to_world(context, n):
    """Unit normals (3, N) of the lanes' objects' spaces in the world."""
    if context.direction is not None:
        return n
    out = transform_normal(of_object(context, context.geometry.objects.to_object), n, context.arena)
    return normalize(out, context.arena, out=out)


def footprint(context):
    """Radius (N,) of a pixel's footprint at the lanes.

    Measured along the straight line from the camera, also where the ray has been reflected on its way.
    """
    arena = context.arena
    out = arena.empty(context.count)
    with arena.frame():
        np.copyto(out, view_of(context).footprint(camera_position(context), context.surface.prim, arena))
    return out
