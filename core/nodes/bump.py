# SPDX-License-Identifier: GPL-3.0-or-later
"""The Bump node, and displacement that is shown as a bump.

Source: Blender manual, "Bump Node"; M. S. Mikkelsen, "Bump Mapping Unparametrized Surfaces on the GPU", JGT 15(1),
2010, whose surface gradient is taken from heights one step aside along two axes across the geometric normal.
"""

from __future__ import annotations

import numpy as np

from ..interaction import corner_values_at
from ..spaces import transform_direction
from ..vecmath import cross, dot, normalize
from . import spaces
from .base import Operation
from .displaced import axes

DISPLACEMENT_WIDTH = 0.1  # footprints between the heights of a displacement, as in Cycles


def _bump(context, inputs, properties):
    arena = context.arena
    if context.surface is None:
        return {"normal": np.zeros((3, 1), np.float32)}
    n = inputs.get("normal", context.surface.ns)
    rise = [np.subtract(inputs[f"height_{axis}"], inputs["height"]) for axis in "xy"]
    distance = inputs["distance"] * np.float32(-1 if properties.get("invert") else 1)
    out = arena.empty((3, context.count))
    with arena.frame():
        turned = bumped_normal(context, n, rise, distance, properties["width"])
        strength = np.maximum(inputs["strength"], 0)
        np.multiply(turned, strength, out=out)
        np.add(out, n * (1 - strength), out=out)
        normalize(out, arena, out=out)
    return {"normal": out}


def bumped_normal(context, n, rise, distance, width):
    """Unit normals (3, N) of a surface raised along its normals.

    Parameters
    ----------
    n : (3, N) or (3, 1)
        Of the flat surface.
    rise : pair of (N,)
        Height one step aside minus the height here, for both axes.
    distance : (N,) or (1,)
        By which heights are multiplied.
    width : float
        The step, in footprints.
    """
    arena = context.arena
    ng = context.surface.ng
    out = arena.empty((3, context.count))
    with arena.frame():
        n = np.broadcast_to(n, out.shape)
        a, b = axes(ng, arena)
        facing = dot(ng, n, arena)
        step = np.maximum(spaces.footprint(context) * np.float32(width), np.float32(1e-30))
        slope = distance / step * np.sign(facing)
        gradient = cross(b, n, arena) * rise[0] + cross(n, a, arena) * rise[1]
        np.multiply(n, np.abs(facing), out=out)
        np.subtract(out, gradient * slope, out=out)
        good = np.isfinite(out).all(0) & out.any(0)
        np.copyto(out, n, where=~good)
        normalize(out, arena, out=out)
    return out


def _displacement(context, inputs, properties):
    """Along the normal, in metres or in the object's units."""
    amount = (inputs["height"] - inputs["midlevel"]) * inputs["scale"]
    n = inputs.get("normal", spaces.shading_normal(context))
    if properties.get("space", "OBJECT") == "OBJECT" and context.surface is not None:
        local = spaces.normal_to_object(context, n)
        n = transform_direction(spaces.of_object(context, context.geometry.objects.to_world), local, context.arena)
    return {"displacement": n * amount}


def _vector_displacement(context, inputs, properties):
    """A vector of the world, of the object, or of tangent space: along the tangent, the normal and the bitangent."""
    vector = (inputs["vector"] - inputs["midlevel"]) * inputs["scale"]
    space = properties.get("space", "TANGENT")
    if space == "WORLD" or context.surface is None:
        return {"displacement": vector}
    s, arena, objects = context.in_place().surface, context.arena, context.geometry.objects
    if space == "TANGENT":
        frame = corner_values_at(context.geometry.corner_values["tangent", ""], s.prim, s.u, s.v, arena)
        n = spaces.normal_to_object(context, s.ns)
        bitangent = normalize(cross(n, frame[:3], arena), arena) * np.sign(frame[3])
        vector = frame[:3] * vector[0] + n * vector[1] + bitangent * vector[2]
    return {"displacement": transform_direction(spaces.of_object(context, objects.to_world), vector, arena)}


def _displaced_normal(context, inputs, properties):
    """The shading normal of a surface that is moved by `displacement`."""
    n = spaces.shading_normal(context)
    if context.surface is None:
        return {"normal": n}
    here, *aside = (dot(n, inputs["displacement" + axis], context.arena) for axis in ("", "_x", "_y"))
    rise = [height - here for height in aside]
    return {"normal": bumped_normal(context, n, rise, np.ones(1, np.float32), properties["width"])}


OPERATIONS = {
    "bump": Operation(
        _bump,
        {"strength": 1.0, "distance": 1.0, "filter_width": 1.0, "normal": None}
        | dict.fromkeys(("height", "height_x", "height_y"), 1.0),
        foldable=False,
        displaced="height",
    ),
    "displacement": Operation(
        _displacement, {"height": 0.0, "midlevel": 0.5, "scale": 1.0, "normal": None}, foldable=False
    ),
    "vector_displacement": Operation(
        _vector_displacement, {"vector": (0.0, 0.0, 0.0), "midlevel": 0.0, "scale": 1.0}, foldable=False
    ),
    "displaced_normal": Operation(
        _displaced_normal,
        {"filter_width": DISPLACEMENT_WIDTH}
        | dict.fromkeys(("displacement", "displacement_x", "displacement_y"), (0.0, 0.0, 0.0)),
        foldable=False,
        displaced="displacement",
    ),
}
