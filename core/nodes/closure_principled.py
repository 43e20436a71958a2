# SPDX-License-Identifier: GPL-3.0-or-later
"""The Principled BSDF node."""

from __future__ import annotations

from functools import partial

import numpy as np

from ..bsdf import coating, dielectric, principled
from ..bsdf.shading_normal import unit_normal
from .base import Operation
from .closure import RAW_NORMAL, SUBSURFACE, UNTURNED_NORMAL, Closure, is_never, raised_normal
from .geometry import lookup_tangent

_COATING = ("sheen_weight", "sheen_roughness", "sheen_tint", "coat_weight", "coat_roughness", "coat_ior", "coat_tint")


def _lobes(constants, properties):
    found = principled.lobes_of(constants, properties.get("older", ()))
    found.pop("alpha", None)  # passages are decided before the surface is shaded
    return found


def _is_stretched(lobes):
    return any(principled.is_stretched(lobe) for lobe in lobes.values())


def _used(lobes):
    names = principled.inputs_of(lobes) | {"normal"}
    if _is_stretched(lobes):
        names |= {"tangent"}
    return names | ({"coat_normal"} if "coat" in lobes else set())


def _build(context, inputs, lobes, properties):
    s, arena = context.surface, context.arena
    opaque = np.clip(inputs["alpha"], 0, 1)
    known = {name: value for name, value in inputs.items() if name in principled.DEFAULTS}
    multiscatter = properties.get("distribution", "MULTI_GGX") == "MULTI_GGX"
    tangent = inputs.get("tangent")
    if tangent is None and _is_stretched(lobes):
        tangent = lookup_tangent(context)
    raw = inputs.get(RAW_NORMAL, s.ns)
    # Left alone, the coat's normal is the surface's, whatever lies below it, as in Cycles.
    coat_normal = inputs.get("coat_normal", inputs.get(UNTURNED_NORMAL)) if "coat" in lobes else None
    if coat_normal is not None:
        coat_normal = unit_normal(coat_normal, raw, arena)
    sheen_normal = None
    if "sheen" in lobes and (coat_normal is not None or raw is not s.ns):
        sheen_normal = coating.sheen_normal(known, raw, coat_normal, arena)
    if coat_normal is not None and "uncorrected" not in properties:
        coat_normal = raised_normal(context, coat_normal)
    older = properties.get("older", ())
    normals = {"coat_normal": coat_normal, "sheen_normal": sheen_normal}
    found = principled.expand(known, s.front, s.wo, s.ns, arena, lobes, multiscatter, tangent, older=older, **normals)
    if opaque.size > 1 or opaque[0] != 1:
        found = [(lobe, weight * opaque, params, n) for lobe, weight, params, n in found]
    return found


def _is_by_angle(lobes, inputs):
    """Sheen stands on the shading normal as it is, the rest on the raised one, a coat on the one no node turned."""
    has_own_normal = "sheen" in lobes or "coat_normal" in inputs or ("coat" in lobes and "normal" in inputs)
    return not (_is_stretched(lobes) or has_own_normal)


def _notes(constants, linked, properties):
    if not is_never(constants, "subsurface_weight"):
        yield SUBSURFACE
    if not is_never(constants, "thin_wall"):
        yield "thin walls are not supported; the surface bounds a solid"


# -- emission under sheen and coat -------------------------------------------------------------------------------------


def _cover(constants, properties):
    """The operation that lessens what is emitted, and its inputs; None where nothing covers it."""
    if is_never(constants, "sheen_weight") and is_never(constants, "coat_weight"):
        return None
    operation = "principled_cover_4" if "coat" in properties.get("older", ()) else "principled_cover"
    operation += "_uncorrected" if "uncorrected" in properties else ""
    return operation, (*_COATING, "normal", "coat_normal")


def _covered(context, inputs, properties, regains, is_corrected):
    """Share of the light from below that sheen and coat let pass towards the viewer, (3, N).

    `regains` is that of `coating.coat_layer`; `is_corrected` raises the coat's normal as `_build` does.
    """
    s, arena = context.surface, context.arena
    below = np.ones((3, 1), np.float32)
    wo, n = getattr(s, "wo", None), getattr(s, "ns", None)
    if wo is None:  # a point that no ray has met is seen along its normal
        n = wo = np.repeat(np.float32([[0], [0], [1]]), context.count, axis=1)
    else:
        n = unit_normal(inputs["normal"], n, arena) if "normal" in inputs else n
    coat_normal = None
    if hasattr(s, "wo"):
        coat_normal = unit_normal(inputs["coat_normal"], n, arena) if "coat_normal" in inputs else s.ns
    x = principled.cleaned({name: inputs[name] for name in _COATING})
    _, below = coating.sheen_layer(x, coating.sheen_normal(x, n, coat_normal, arena), wo, below, arena)
    if coat_normal is None:
        coat_normal = n
    elif is_corrected:
        coat_normal = raised_normal(context, coat_normal)
    _, below = coating.coat_layer(dielectric.Rough, x, coat_normal, wo, below, arena, regains)
    return {"value": below}


_DEFAULTS = principled.DEFAULTS

OPERATIONS = {
    name + ending: Operation(
        partial(_covered, regains=regains, is_corrected=not ending),
        {name: _DEFAULTS[name] for name in _COATING} | {"normal": None, "coat_normal": None},
        foldable=False,
    )
    for name, regains in (("principled_cover", True), ("principled_cover_4", False))
    for ending in ("", "_uncorrected")
}

CLOSURES = (
    Closure(
        "principled",
        _DEFAULTS
        | {"emission_color": (1.0, 1.0, 1.0), "emission_strength": 0.0, "thin_wall": 0.0}
        | {"normal": None, "coat_normal": None, "tangent": None},
        _lobes,
        _build,
        used=_used,
        emission=("emission_color", "emission_strength", "alpha"),
        cover=_cover,
        transparency=("1-alpha",),
        notes=_notes,
        by_angle=_is_by_angle,
        color="base_color",
    ),
)
