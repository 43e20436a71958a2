# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader nodes that scatter, emit or let light pass: which lobes each becomes."""

from __future__ import annotations

import numpy as np

from ..bsdf import diffuse, oren_nayar, sheen, toon, translucent, velvet
from . import closure_hair, closure_principled, closure_specular
from .closure import SUBSURFACE, Closure, facing, is_black, is_never

_LEAST_ROUGHNESS = 1e-5  # below it Cycles' rough diffuse is Lambert's


def _diffuse_lobes(constants, properties):
    if is_black(constants):
        return {}
    return {"diffuse": diffuse if is_never(constants, "roughness", _LEAST_ROUGHNESS) else oren_nayar}


def _diffuse(context, inputs, lobes, properties):
    params = {}
    if lobes["diffuse"] is oren_nayar:
        # What is not scattered again between the facets takes on no colour there.
        color = np.zeros((3, 1), np.float32) if "facets" in properties.get("older", ()) else inputs["color"]
        params = {"roughness": np.clip(inputs["roughness"], 0, 1), "color": np.clip(color, 0, 1)}
    return [(lobes["diffuse"], inputs["color"], params, None)]


def _translucent_lobes(constants, properties):
    return {} if is_black(constants) else {"translucent": translucent}


def _translucent(context, inputs, lobes, properties):
    return [(translucent, inputs["color"], {}, None)]


def _sheen_lobes(constants, properties):
    if is_black(constants):
        return {}
    return {"sheen": velvet if properties.get("distribution") == "ASHIKHMIN" else sheen}


def _sheen(context, inputs, lobes, properties):
    roughness = np.clip(inputs["roughness"], 0, 1)
    if lobes["sheen"] is velvet:
        return [(velvet, inputs["color"], {"sigma": roughness}, None)]
    a, b, reflected = sheen.transform(facing(context), roughness, context.arena)
    return [(sheen, inputs["color"] * reflected, {"a": a, "b": b}, None)]


def _toon_lobes(constants, properties):
    if is_black(constants):
        return {}
    return {"toon": toon.Glossy if properties.get("component") == "GLOSSY" else toon.Diffuse}


def _toon(context, inputs, lobes, properties):
    params = {"size": inputs["size"], "smooth": inputs["smooth"], "alpha": np.clip(inputs["size"], 0, 1)}
    return [(lobes["toon"], inputs["color"], params, None)]


def _subsurface_lobes(constants, properties):
    return {} if is_black(constants) else {"diffuse": diffuse}


def _note(sentence):
    def notes(constants, linked, properties):
        yield sentence

    return notes


_NORMAL = {"normal": None}
_GREY = {"color": (0.8, 0.8, 0.8)}
_VOLUME = _note("a volume shader in the place of a surface's shows nothing")

CLOSURES = {
    c.name: c
    for c in (
        Closure("diffuse", _GREY | {"roughness": 0.0} | _NORMAL, _diffuse_lobes, _diffuse),
        Closure("translucent", _GREY | _NORMAL, _translucent_lobes, _translucent),
        Closure("sheen", _GREY | {"roughness": 0.5} | _NORMAL, _sheen_lobes, _sheen),
        Closure("toon", _GREY | {"size": 0.5, "smooth": 0.0} | _NORMAL, _toon_lobes, _toon),
        Closure("subsurface", _GREY | _NORMAL, _subsurface_lobes, _diffuse, notes=_note(SUBSURFACE)),
        Closure("transparent", {"color": (1.0, 1.0, 1.0)}, transparency=("color",)),
        Closure(
            "ray_portal",
            {"color": (1.0, 1.0, 1.0)},
            transparency=("color",),
            notes=_note("ray portals are not supported; rays pass straight through"),
        ),
        Closure("holdout", {}, is_holdout=True),
        Closure("volume", {}, notes=_VOLUME),
        Closure("background", {"color": (0.8, 0.8, 0.8), "strength": 1.0}, emission=("color", "strength")),
        Closure("emission", {"color": (1.0, 1.0, 1.0), "strength": 1.0}, emission=("color", "strength")),
        *closure_hair.CLOSURES,
        *closure_specular.CLOSURES,
        *closure_principled.CLOSURES,
    )
}
