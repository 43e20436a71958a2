# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair BSDF and Principled Hair BSDF."""

from __future__ import annotations

import numpy as np

from .. import vecmath
from ..bsdf import hair, principled_hair
from ..geometry import CORNERS
from ..interaction import corner_values_at
from ..vecmath import cross, dot, normalize
from . import spaces
from .closure import Closure, is_black

_RANDOM = 3  # column of the strands' table
_WIDEST = np.ones(1, np.float32)  # what the classic methods take for the lobes' width
_HUANG = "Principled Hair by Huang is shown by Chiang's model; its aspect ratio and lobes' weights are ignored"


def _fibre_tangent(context, corner):
    """Unit vectors (3, N) along the strands; of triangles those from the first corner to the `corner`-th.

    Elsewhere any across the normal. On the inside all are turned round, as the normal is.
    """
    s, arena, geometry = context.surface, context.arena, context.geometry
    out = arena.empty((3, context.count))
    out[:] = vecmath.frame(s.ng, arena)[0]
    flat = np.flatnonzero(s.prim < geometry.triangle_count)
    if flat.size:
        rows = geometry.facets[s.prim[flat]]
        mirrored = np.broadcast_to(spaces.of_object(context, geometry.objects.mirrored)[0], (context.count,))[flat]
        end = np.where(mirrored[:, None], rows[:, CORNERS[3 - corner]], rows[:, CORNERS[corner]])
        side = np.ascontiguousarray((end - rows[:, CORNERS[0]]).T)
        out[:, flat] = normalize(side, arena) * np.where(s.front[flat], np.float32(1), np.float32(-1))
    lanes = np.flatnonzero(geometry.on_strand(s.prim))
    if lanes.size:
        along = geometry.strands.along(s.prim[lanes] - geometry.first_segment, s.u[lanes], arena)
        out[:, lanes] = along * np.where(s.front[lanes], np.float32(1), np.float32(-1))
    return out


# -- Hair --------------------------------------------------------------------------------------------------------------


def _hair_lobes(constants, properties):
    if is_black(constants):
        return {}
    return {"hair": hair.Transmission if properties.get("component") == "Transmission" else hair.Reflection}


def _hair(context, inputs, lobes, properties):
    """Without a tangent of its own, what is no strand has no offset. Source: Cycles."""
    arena, offset, tangent = context.arena, -inputs["offset"], inputs.get("tangent")
    if tangent is None:
        tangent = _fibre_tangent(context, 2)
        offset = offset * context.geometry.on_strand(context.surface.prim)
    else:
        tangent = normalize(np.array(np.broadcast_to(tangent, (3, context.count))), arena)
    params = {"tangent": tangent, "offset": offset, "alpha": _WIDEST}
    params |= {"roughness_u": inputs["roughnessu"], "roughness_v": inputs["roughnessv"]}
    return [(lobes["hair"], inputs["color"], params, None)]


# -- Principled Hair ---------------------------------------------------------------------------------------------------


def _principled_lobes(constants, properties):
    """The layer's name tells programs apart."""
    return {f"{properties.get('model')} {properties.get('parametrization')}": principled_hair}


def _principled(context, inputs, lobes, properties):
    """Light that passes through the fibre leaves it where it came in: the model knows the whole of it."""
    s, arena = context.surface, context.arena
    random = _random(context, inputs) - np.float32(0.5)
    varied = 1.0 + 2.0 * random * inputs["random_roughness"]
    roughness = inputs["roughness"] * varied
    is_huang = properties.get("model") == "HUANG"
    radial = roughness if is_huang else inputs["radial_roughness"] * varied
    tangent = _fibre_tangent(context, 1)
    across = cross(tangent, cross(tangent, s.wo, arena), arena)
    normalize(across, arena, out=across)
    params = {
        "tangent": tangent,
        "h": np.clip(dot(cross(s.ng, tangent, arena), across, arena), -1.0, 1.0),
        "sigma": _sigma(inputs, radial, random, properties),
        "roughness": roughness,
        "radial": radial,
        "coat": np.zeros(1, np.float32) if is_huang else inputs["coat"],
        "tilt": inputs["offset"],
        "ior": np.maximum(inputs["ior"], 1e-3),
        "alpha": _WIDEST,
    }
    return [(principled_hair, np.ones((3, 1), np.float32), params, s.ng)]


def _random(context, inputs):
    """What `random` is linked to; where it is left at 0, the strand's own number, 0 where there is no strand."""
    given = inputs["random"]
    if given.size > 1 or given[0] != 0:
        return given
    table = context.geometry.corner_values.get("strand")
    if table is None:
        return given
    s = context.surface
    return corner_values_at(table, s.prim, s.u, s.v, context.arena)[_RANDOM]


def _sigma(inputs, radial, random, properties):
    """Absorption, (3, ·), by the way in which the user gives it."""
    way = properties.get("parametrization", "COLOR")
    if way == "ABSORPTION":
        return np.maximum(inputs["absorption_coefficient"], 0)
    if way == "COLOR":
        return principled_hair.sigma_of_color(inputs["color"], radial)
    melanin = inputs["melanin"] * (1.0 + 2.0 * random * np.clip(inputs["random_color"], 0, 1))
    sigma = principled_hair.sigma_of_melanin(melanin, inputs["melanin_redness"])
    return sigma + principled_hair.sigma_of_color(inputs["tint"], radial)


def _notes(constants, linked, properties):
    if properties.get("model") == "HUANG":
        yield _HUANG


def takes_random(node):
    """Whether a node asks the strands for their random numbers."""
    if node.op != "principled_hair" or node.inputs.get("random", 0.0) != 0.0:
        return False
    return any(node.inputs.get(name, 0.0) != 0.0 for name in ("random_color", "random_roughness"))


CLOSURES = (
    Closure(
        "hair",
        {"color": (0.8, 0.8, 0.8), "offset": 0.0, "roughnessu": 0.1, "roughnessv": 1.0, "tangent": None},
        _hair_lobes,
        _hair,
    ),
    Closure(
        "principled_hair",
        {"color": (0.017513, 0.005763, 0.002059), "melanin": 0.8, "melanin_redness": 1.0, "tint": (1.0, 1.0, 1.0)}
        | {"absorption_coefficient": (0.245531, 0.52, 1.365), "roughness": 0.3, "radial_roughness": 0.3, "coat": 0.0}
        | {"ior": 1.55, "offset": 0.034907, "random_color": 0.0, "random_roughness": 0.0, "random": 0.0},
        _principled_lobes,
        _principled,
        notes=_notes,
    ),
)
