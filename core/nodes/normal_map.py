# SPDX-License-Identifier: GPL-3.0-or-later
"""The Normal Map node, and the Bevel and Ambient Occlusion nodes as far as they go without tracing rays.

Source: Blender manual, "Normal Map Node"; the tangent space is that of `core.compile.tangents`, interpolated without
making unit vectors of it, as normal maps are baked; since Blender 5.1 its normal is a unit vector (`unit_normal`).
"""

from __future__ import annotations

import numpy as np

from ..interaction import corner_values_at
from ..spaces import transform_normal
from ..vecmath import cross, normalize
from . import spaces
from .base import Operation


def _normal_map(context, inputs, properties):
    context = context.in_place()
    arena = context.arena
    ns = spaces.shading_normal(context)
    if context.surface is None:
        return {"normal": ns}
    space = properties.get("space", "TANGENT")
    out = arena.empty((3, context.count))
    with arena.frame():
        local = 2 * np.broadcast_to(inputs["color"], (3, context.count)) - np.float32(1)
        if properties.get("convention") == "DIRECTX":
            local[1] = -local[1]
        if space == "TANGENT":
            found = _from_tangent_space(context, local, inputs["strength"], properties)
        else:
            found = _from_space(context, local, inputs["strength"], space)
        normalize(found, arena, out=out)
        np.copyto(out, ns, where=~(np.isfinite(out).all(0) & out.any(0)))
    return {"normal": out}


def _from_tangent_space(context, local, strength, properties):
    """Normals (3, N) in the world, zero where the mesh has no such UV map."""
    s, arena = context.surface, context.arena
    table = context.geometry.corner_values["tangent", properties.get("uv_map", "")]
    frame = corner_values_at(table, s.prim, s.u, s.v, arena)
    tangent, sign, normal = frame[:3], frame[3], frame[4:]
    if properties.get("unit_normal"):
        normal = normalize(normal, arena)
    bitangent = cross(normal, tangent, arena)
    np.multiply(bitangent, np.sign(sign), out=bitangent)
    up = 1 + (local[2] - 1) * np.clip(strength, 0, 1)
    n = tangent * (local[0] * strength) + bitangent * (local[1] * strength) + normal * up
    n = transform_normal(spaces.of_object(context, context.geometry.objects.to_object), n, arena)
    return np.where(s.front, n, -n)


def _from_space(context, local, strength, space):
    """Normals (3, N) in the world, from object or world space, blended with the shading normal."""
    s, arena = context.surface, context.arena
    if space.startswith("BLENDER"):  # the older baking's axes
        local[1:] = -local[1:]
    if space.endswith("OBJECT"):
        n = spaces.normal_to_world(context, local)
    else:
        n = normalize(local, arena)
    n = np.where(s.front, n, -n)
    strength = np.maximum(strength, 0)
    return s.ns + (n - s.ns) * strength


OPERATIONS = {
    "normal_map": Operation(_normal_map, {"strength": 1.0, "color": (0.5, 0.5, 1.0)}, foldable=False),
}
