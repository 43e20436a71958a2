# SPDX-License-Identifier: GPL-3.0-or-later
"""The Object Info node, and those that tell of particles, curves and points.

Source: Blender manual, "Object Info Node", "Particle Info Node", "Curves Info Node", "Point Info Node". On surfaces
that are no such thing these give 0.
"""

from __future__ import annotations

import numpy as np

from ..interaction import corner_values_at
from ..vecmath import dot, normalize
from . import spaces
from .base import Operation, Outputs
from .hashing import hash_to_unit

_NUMBER, _VECTOR = np.zeros(1, np.float32), np.zeros((3, 1), np.float32)


def _material_index(context, objects):
    arena = context.arena
    return arena.take(objects.material_index[0], arena.take(context.geometry.material, context.surface.prim))


_OUTPUTS = {
    "location": lambda context, objects: spaces.of_object(context, objects.location),
    "color": lambda context, objects: spaces.of_object(context, objects.color)[:3],
    "alpha": lambda context, objects: spaces.of_object(context, objects.color)[3],
    "object_index": lambda context, objects: spaces.of_object(context, objects.index)[0],
    "material_index": _material_index,
    "random": lambda context, objects: spaces.of_object(context, objects.random)[0],
}


def _object_info(context, inputs, properties):
    if context.surface is None:
        return dict.fromkeys(_OUTPUTS, _NUMBER) | {"location": _VECTOR, "color": _VECTOR}
    return Outputs(_OUTPUTS, context, context.geometry.objects)


def _absent(what, outputs):
    """What the user is told of outputs that are not there."""
    return dict.fromkeys(outputs, f"{what} are not known to nodes; 0 is used")


def _particle_info(context, inputs, properties):
    """Of what is no particle: all 0, and the random number of particle 0."""
    outputs = dict.fromkeys(_PARTICLE, _NUMBER) | dict.fromkeys(("location", "velocity", "angular_velocity"), _VECTOR)
    return outputs | {"random": hash_to_unit([np.zeros(1, np.uint32)] * 2, context.arena)}


_PARTICLE = ("index", "random", "age", "lifetime", "location", "size", "velocity", "angular_velocity")
_STRAND = ("intercept", "length", "thickness", "random")  # columns of the table


def _strand_info(column):
    def read(context):
        s = context.surface
        return corner_values_at(context.geometry.corner_values["strand"], s.prim, s.u, s.v, context.arena)[column]

    return read


def _is_strand(context):
    out = context.arena.empty(context.count)
    np.copyto(out, context.geometry.on_strand(context.surface.prim), casting="unsafe")
    return out


def _tangent_normal(context):
    """Across the strand, towards the viewer, (3, N)."""
    s, arena, geometry = context.surface, context.arena, context.geometry
    out = arena.zeros((3, context.count))
    lanes = np.flatnonzero(geometry.on_strand(s.prim))
    if lanes.size:
        along = geometry.strands.along(s.prim[lanes] - geometry.first_segment, s.u[lanes], arena)
        wo = arena.take(s.wo, lanes)
        across = wo - along * dot(wo, along, arena)
        out[:, lanes] = normalize(across, arena, out=across)
    return out


_CURVES = {"is_strand": _is_strand, "tangent_normal": _tangent_normal}
_CURVES |= {name: _strand_info(column) for column, name in enumerate(_STRAND)}


def _curves_info(context, inputs, properties):
    if context.surface is None:
        return dict.fromkeys(_CURVES, _NUMBER) | {"tangent_normal": _VECTOR}
    return Outputs(_CURVES, context)


def _point_info(context, inputs, properties):
    """Centre, radius and random number of the spheres of a point cloud."""
    s, arena, geometry = context.surface, context.arena, context.geometry
    position, radius = arena.zeros((3, context.count)), arena.zeros(context.count)
    if s is not None and geometry.sphere_count:
        number = s.prim - geometry.triangle_count
        lanes = np.flatnonzero((number >= 0) & (number < geometry.sphere_count))
        origin = geometry.origin.astype(np.float32).reshape(3, 1)
        position[:, lanes] = geometry.centers[:, number[lanes]] + origin
        radius[lanes] = geometry.radii[number[lanes]]
    random, table = _NUMBER, None if s is None else geometry.corner_values.get("point")
    if table is not None:
        random = corner_values_at(table, s.prim, s.u, s.v, arena)[0]
    return {"position": position, "radius": radius, "random": random}


OPERATIONS = {
    "object_info": Operation(_object_info, foldable=False),
    "particle_info": Operation(_particle_info, unsupported=_absent("particles", _PARTICLE)),
    "hair_info": Operation(_curves_info, foldable=False),
    "point_info": Operation(_point_info, foldable=False),
}
