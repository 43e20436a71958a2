# SPDX-License-Identifier: GPL-3.0-or-later
"""Glossy, Metallic, Glass and Refraction: shader nodes of microfacets."""

from __future__ import annotations

import numpy as np

from ..bsdf import (
    ashikhmin_shirley,
    conductor,
    energy,
    facet_glass,
    facets,
    fresnel,
    glass,
    glass_film,
    glossy,
    metal,
    refraction,
    thin_film,
)
from ..bsdf.base import Lobe
from .closure import Closure, alpha_of, facing, is_black, is_never, is_smooth, relative_index, stretched

_LEAST_ANISOTROPY = 1e-4  # Cycles' own


def _layer(constants):
    """The name of a layer of facets, which tells programs apart."""
    isotropic = "anisotropy" in constants and float(np.abs(constants["anisotropy"]).max()) <= _LEAST_ANISOTROPY
    return "isotropic" if isotropic else "anisotropic"


def _is_isotropic(lobes, inputs):
    return "anisotropic" not in lobes


def _distribution(properties):
    return facets.Beckmann if properties.get("distribution") == "BECKMANN" else facets.GGX


# -- Glossy ------------------------------------------------------------------------------------------------------------


def _glossy_lobes(constants, properties):
    if is_black(constants):
        return {}
    if is_smooth(constants):
        return {"mirror": glossy.Mirror}
    layer, distribution = _layer(constants), properties.get("distribution")
    if distribution == "ASHIKHMIN_SHIRLEY":
        return {layer: ashikhmin_shirley}
    if distribution != "BECKMANN" and layer == "isotropic":
        return {layer: glossy.Rough}
    return {layer: facets.reflection(_distribution(properties))}


def _glossy(context, inputs, lobes, properties):
    """Positive anisotropy narrows the lobe along the tangent. Source of the widths: Cycles."""
    (layer, lobe), color = *lobes.items(), inputs["color"]
    if layer == "mirror":
        return [(lobe, color, {}, None)]
    params = {"alpha": alpha_of(inputs)}
    if layer == "anisotropic":
        anisotropy = np.clip(inputs["anisotropy"], -0.99, 0.99)
        narrow = 1 - np.abs(anisotropy)
        params |= stretched(context, inputs, np.where(anisotropy < 0, 1 / narrow, narrow), inputs["rotation"])
    if properties.get("distribution") == "MULTI_GGX":
        e, average = energy.reflection(facing(context), facets.mean_alpha(params), context.arena)
        color = color * energy.compensation(e, average, np.clip(color, 0, 1))
    return [(lobe, color, params, None)]


# -- Metallic ----------------------------------------------------------------------------------------------------------


def _metallic_curve(constants, properties):
    """The Fresnel curve that the node needs."""
    film = _has_film(constants)
    if properties.get("fresnel_type") == "PHYSICAL_CONDUCTOR":
        return metal.physical_film if film else metal.physical
    return metal.f82_film if film else conductor.reflectance


def _metallic_lobes(constants, properties):
    curve = _metallic_curve(constants, properties)
    rough, mirror = (conductor.Rough, conductor.Mirror) if curve is conductor.reflectance else metal.lobes(curve)
    if is_smooth(constants):
        return {"mirror": mirror}
    layer = _layer(constants)
    if properties.get("distribution") != "BECKMANN" and layer == "isotropic":
        return {layer: rough}
    return {layer: facets.reflection(_distribution(properties), curve)}


def _metallic(context, inputs, lobes, properties):
    ((layer, lobe),) = lobes.items()
    params, weight = {"alpha": alpha_of(inputs)}, np.ones((3, 1), np.float32)
    if layer == "anisotropic":
        stretch = 1 / np.sqrt(1 - 0.9 * np.clip(inputs["anisotropy"], 0, 1))
        params |= stretched(context, inputs, stretch, inputs["rotation"])
    curve, average = _metallic_params(inputs, properties)
    if lobe.reflectance is not conductor.reflectance:
        curve |= {"film": inputs["thin_film_ior"], "thickness": inputs["thin_film_thickness"]}
    if layer != "mirror" and properties.get("distribution", "MULTI_GGX") == "MULTI_GGX":
        e, mean_e = energy.reflection(facing(context), facets.mean_alpha(params), context.arena)
        weight = energy.compensation(e, mean_e, average)
    return [(lobe, weight, params | curve, None)]


def _metallic_params(inputs, properties):
    """Parameters of the Fresnel curve, and its average over the hemisphere."""
    if properties.get("fresnel_type") == "PHYSICAL_CONDUCTOR":
        n, k = np.maximum(inputs["ior"], 0), np.maximum(inputs["extinction"], 0)
        return {"n": n, "k": k}, metal.physical_average(n, k)
    f0, tint = np.clip(inputs["base_color"], 0, 1), np.clip(inputs["edge_tint"], 0, 1)
    return {"f0": f0, "tint": tint}, fresnel.f82_average(f0, fresnel.f82_drop(f0, tint))


# -- Glass and Refraction ----------------------------------------------------------------------------------------------


def _has_film(constants):
    return not is_never(constants, "thin_film_thickness", thin_film.THINNEST)


def _glass_lobes(constants, properties):
    kind = glass_film if _has_film(constants) else glass
    return {"glass": _boundary(kind, constants, properties)}


def _boundary(kind, constants, properties):
    """The lobe of a module that has `Rough` GGX facets and a `Smooth` boundary."""
    if is_smooth(constants):
        return kind.Smooth
    return facet_glass.rough(facets.Beckmann, kind) if properties.get("distribution") == "BECKMANN" else kind.Rough


def _glass(context, inputs, lobes, properties):
    lobe, color = lobes["glass"], inputs["color"]
    ior, eta = relative_index(context, inputs["ior"])
    params = {"eta": eta}
    if lobe.split is glass_film.split:
        film = inputs["thin_film_ior"]
        params |= {
            "film": np.where(context.surface.front, film, film / ior),
            "thickness": inputs["thin_film_thickness"],
        }
    if Lobe.DELTA in lobe.flags:
        return [(lobe, color, params, None)]
    params["alpha"] = alpha = alpha_of(inputs)
    if properties.get("distribution") == "MULTI_GGX":
        dense_side = context.surface.front == (ior < 1)
        e, average = energy.glass(facing(context), alpha, np.maximum(ior, 1 / ior), dense_side, context.arena)
        color = color * energy.compensation(e, average, np.clip(color, 0, 1))
    return [(lobe, color, params, None)]


def _refraction_lobes(constants, properties):
    return {} if is_black(constants) else {"refraction": _boundary(refraction, constants, properties)}


def _refraction(context, inputs, lobes, properties):
    params = {"eta": relative_index(context, inputs["ior"])[1]}
    if Lobe.DELTA not in lobes["refraction"].flags:
        params["alpha"] = alpha_of(inputs)
    return [(lobes["refraction"], inputs["color"], params, None)]


_ANISOTROPY = {"anisotropy": 0.0, "rotation": 0.0, "tangent": None, "normal": None}
_FILM = {"thin_film_thickness": 0.0, "thin_film_ior": 1.33}

CLOSURES = (
    Closure(
        "glossy",
        {"color": (0.8, 0.8, 0.8), "roughness": 0.5} | _ANISOTROPY,
        _glossy_lobes,
        _glossy,
        by_angle=_is_isotropic,
    ),
    Closure(
        "metallic",
        {
            "base_color": (0.617, 0.577, 0.540),
            "edge_tint": (0.695, 0.726, 0.770),
            "ior": (2.757, 2.513, 2.231),
            "extinction": (3.867, 3.404, 3.009),
            "roughness": 0.5,
        }
        | _ANISOTROPY
        | _FILM,
        _metallic_lobes,
        _metallic,
        by_angle=_is_isotropic,
    ),
    Closure(
        "glass",
        {"color": (1.0, 1.0, 1.0), "roughness": 0.0, "ior": 1.5, "normal": None} | _FILM,
        _glass_lobes,
        _glass,
        by_angle=_is_isotropic,
    ),
    Closure(
        "refraction",
        {"color": (1.0, 1.0, 1.0), "roughness": 0.0, "ior": 1.45, "normal": None},
        _refraction_lobes,
        _refraction,
    ),
)
