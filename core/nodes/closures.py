# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader nodes that scatter, emit or let light pass: which lobes each becomes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from ..bsdf import diffuse, energy, glass, glossy, microfacet, oren_nayar, principled, refraction, translucent
from ..vecmath import dot

# Principled inputs that this renderer does not honour yet, and the value at which they do nothing.
_IGNORED = {
    "coat_weight": 0.0,
    "sheen_weight": 0.0,
    "subsurface_weight": 0.0,
    "anisotropic": 0.0,
    "thin_film_thickness": 0.0,
}


def _no_lobes(constants, properties):
    return {}


@dataclass(frozen=True, eq=False)
class Closure:
    """One kind of shader node.

    Parameters
    ----------
    name : str
    inputs : mapping of str to float, tuple or None
        Defaults; None for an input that only counts when it is linked.
    lobes : callable
        ``lobes(constants, properties) -> {layer: lobe}``, decided by the inputs that are constant.
    build : callable, optional
        ``build(context, inputs, lobes, properties) -> [(lobe, weight, params, n)]`` over lanes.
    emission, transparency : tuple of str
        Inputs whose product is emitted, or passes straight through; "1-x" is the complement of x.
    ignored : mapping of str to float
        Inputs that are not honoured unless they have this value.
    """

    name: str
    inputs: Mapping
    lobes: Callable = _no_lobes
    build: Callable | None = None
    emission: tuple = ()
    transparency: tuple = ()
    ignored: Mapping = None

    def diagnose(self, constants, linked, diagnostics, place):
        """Name what the node asks for and does not get."""
        for name, neutral in (self.ignored or {}).items():
            if name in linked or (name in constants and not np.all(constants[name] == neutral)):
                diagnostics.warn(f"{self.name}: {name.replace('_', ' ')} is not supported and has no effect", place)


def _is_smooth(constants):
    return "roughness" in constants and float(np.max(constants["roughness"])) ** 2 <= microfacet.SMOOTH_ALPHA


def _alpha(inputs):
    return np.square(np.clip(inputs["roughness"], 0, 1))


def _facing(context):
    arena = context.arena
    return np.maximum(dot(context.surface.ns, context.surface.wo, arena), 0)


def _is_black(constants):
    return "color" in constants and not constants["color"].any()


# -- one pair of functions a node --------------------------------------------------------------------------------------


def _diffuse_lobes(constants, properties):
    if _is_black(constants):
        return {}
    smooth = "roughness" in constants and not constants["roughness"].any()
    return {"diffuse": diffuse if smooth else oren_nayar}


def _diffuse(context, inputs, lobes, properties):
    params = {}
    if lobes["diffuse"] is oren_nayar:
        params = {"roughness": np.clip(inputs["roughness"], 0, 1), "color": np.clip(inputs["color"], 0, 1)}
    return [(lobes["diffuse"], inputs["color"], params, None)]


def _translucent_lobes(constants, properties):
    return {} if _is_black(constants) else {"translucent": translucent}


def _translucent(context, inputs, lobes, properties):
    return [(translucent, inputs["color"], {}, None)]


def _glossy_lobes(constants, properties):
    if _is_black(constants):
        return {}
    return {"glossy": glossy.Mirror if _is_smooth(constants) else glossy.Rough}


def _glossy(context, inputs, lobes, properties):
    lobe, color = lobes["glossy"], inputs["color"]
    if lobe is glossy.Mirror:
        return [(lobe, color, {}, None)]
    alpha = _alpha(inputs)
    if properties.get("distribution") == "MULTI_GGX":
        e, average = energy.reflection(_facing(context), microfacet.clamp_alpha(alpha), context.arena)
        color = color * energy.compensation(e, average, np.clip(color, 0, 1))
    return [(lobe, color, {"alpha": alpha}, None)]


def _glass_lobes(constants, properties):
    return {"glass": glass.Smooth if _is_smooth(constants) else glass.Rough}


def _relative_index(context, inputs):
    ior = np.maximum(inputs["ior"], 1e-5)
    return ior, np.where(context.surface.front, ior, 1 / ior)


def _glass(context, inputs, lobes, properties):
    lobe, color = lobes["glass"], inputs["color"]
    ior, eta = _relative_index(context, inputs)
    if lobe is glass.Smooth:
        return [(lobe, color, {"eta": eta}, None)]
    alpha = _alpha(inputs)
    if properties.get("distribution") == "MULTI_GGX":
        dense_side = context.surface.front == (ior < 1)
        e, average = energy.glass(_facing(context), alpha, np.maximum(ior, 1 / ior), dense_side, context.arena)
        color = color * energy.compensation(e, average, np.clip(color, 0, 1))
    return [(lobe, color, {"eta": eta, "alpha": alpha}, None)]


def _refraction_lobes(constants, properties):
    if _is_black(constants):
        return {}
    return {"refraction": refraction.Smooth if _is_smooth(constants) else refraction.Rough}


def _refraction(context, inputs, lobes, properties):
    params = {"eta": _relative_index(context, inputs)[1]}
    if lobes["refraction"] is refraction.Rough:
        params["alpha"] = _alpha(inputs)
    return [(lobes["refraction"], inputs["color"], params, None)]


def _principled_lobes(constants, properties):
    found = principled.lobes_of(constants)
    found.pop("alpha", None)  # passages are decided before the surface is shaded
    return found


def _principled(context, inputs, lobes, properties):
    s = context.surface
    opaque = np.clip(inputs["alpha"], 0, 1)
    known = {name: inputs[name] for name in principled.DEFAULTS}
    multiscatter = properties.get("distribution", "MULTI_GGX") == "MULTI_GGX"
    found = principled.expand(known, s.front, s.wo, s.ns, context.arena, lobes, multiscatter)
    if opaque.size > 1 or opaque[0] != 1:
        found = [(lobe, weight * opaque, params) for lobe, weight, params in found]
    return [(*entry, None) for entry in found]


_NORMAL = {"normal": None}

CLOSURES = {
    c.name: c
    for c in (
        Closure("diffuse", {"color": (0.8, 0.8, 0.8), "roughness": 0.0} | _NORMAL, _diffuse_lobes, _diffuse),
        Closure("translucent", {"color": (0.8, 0.8, 0.8)} | _NORMAL, _translucent_lobes, _translucent),
        Closure(
            "glossy",
            {"color": (0.8, 0.8, 0.8), "roughness": 0.5, "anisotropy": 0.0} | _NORMAL,
            _glossy_lobes,
            _glossy,
            ignored={"anisotropy": 0.0},
        ),
        Closure("glass", {"color": (1.0, 1.0, 1.0), "roughness": 0.0, "ior": 1.5} | _NORMAL, _glass_lobes, _glass),
        Closure(
            "refraction",
            {"color": (1.0, 1.0, 1.0), "roughness": 0.0, "ior": 1.45} | _NORMAL,
            _refraction_lobes,
            _refraction,
        ),
        Closure("transparent", {"color": (1.0, 1.0, 1.0)}, transparency=("color",)),
        Closure("background", {"color": (0.8, 0.8, 0.8), "strength": 1.0}, emission=("color", "strength")),
        Closure("emission", {"color": (1.0, 1.0, 1.0), "strength": 1.0}, emission=("color", "strength")),
        Closure(
            "principled",
            principled.DEFAULTS | {"emission_color": (1.0, 1.0, 1.0), "emission_strength": 0.0} | _IGNORED | _NORMAL,
            _principled_lobes,
            _principled,
            emission=("emission_color", "emission_strength", "alpha"),
            transparency=("1-alpha",),
            ignored=_IGNORED,
        ),
    )
}
