# SPDX-License-Identifier: GPL-3.0-or-later
"""The Object Info node, and those that tell of particles, curves and points.

Source: Blender manual, "Object Info Node", "Particle Info Node", "Curves Info Node", "Point Info Node". On surfaces
that are no such thing these give 0.
"""

from __future__ import annotations

import numpy as np

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


def _constant(numbers, vectors):
    """An operation whose outputs are all 0."""
    outputs = dict.fromkeys(numbers, _NUMBER) | dict.fromkeys(vectors, _VECTOR)
    return lambda context, inputs, properties: outputs


def _absent(what, outputs):
    """What the user is told of outputs that are not there."""
    return dict.fromkeys(outputs, f"{what} are not known to nodes; 0 is used")


def _particle_info(context, inputs, properties):
    """Of what is no particle: all 0, and the random number of particle 0."""
    outputs = dict.fromkeys(_PARTICLE, _NUMBER) | dict.fromkeys(("location", "velocity", "angular_velocity"), _VECTOR)
    return outputs | {"random": hash_to_unit([np.zeros(1, np.uint32)] * 2, context.arena)}


_PARTICLE = ("index", "random", "age", "lifetime", "location", "size", "velocity", "angular_velocity")
_HAIR = ("intercept", "length", "thickness", "tangent_normal", "random")
_POINT = ("random",)


def _point_info(context, inputs, properties):
    """Centre and radius of the spheres of a point cloud."""
    s, arena, geometry = context.surface, context.arena, context.geometry
    position, radius = arena.zeros((3, context.count)), arena.zeros(context.count)
    if s is not None and geometry.sphere_count:
        number = s.prim - geometry.triangle_count
        lanes = np.flatnonzero((number >= 0) & (number < geometry.sphere_count))
        origin = geometry.origin.astype(np.float32).reshape(3, 1)
        position[:, lanes] = geometry.centers[:, number[lanes]] + origin
        radius[lanes] = geometry.radii[number[lanes]]
    return {"position": position, "radius": radius, "random": _NUMBER}


OPERATIONS = {
    "object_info": Operation(_object_info, foldable=False),
    "particle_info": Operation(_particle_info, unsupported=_absent("particles", _PARTICLE)),
    "hair_info": Operation(
        _constant(("is_strand", "intercept", "length", "thickness", "random"), ("tangent_normal",)),
        unsupported=_absent("curves", _HAIR),
    ),
    "point_info": Operation(_point_info, foldable=False, unsupported=_absent("random numbers of points", _POINT)),
}
