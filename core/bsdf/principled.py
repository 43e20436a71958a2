# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Principled BSDF as a list of lobes.

From the top: transparency by `alpha`; sheen; a coat; the mix of metal by `metallic`, glass by `transmission_weight`,
and a dielectric surface over a diffuse base. What a layer reflects, those below do not get. GGX lobes get back the
energy that single scattering loses where Blender's distribution is "Multiscatter GGX". Subsurface scattering is diffuse
reflection here. Emission is the caller's.

Source: the Principled node of Cycles 4 and 5, compared by rendering.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from . import (
    coating,
    conductor,
    dielectric,
    diffuse,
    energy,
    facets,
    fresnel,
    glass,
    glass_film,
    metal,
    microfacet,
    oren_nayar,
    sheen,
    tangents,
    thin_film,
    transparent,
)
from .base import Lobe

DEFAULTS = {
    "base_color": (0.8, 0.8, 0.8),
    "metallic": 0.0,
    "roughness": 0.5,
    "diffuse_roughness": 0.0,
    "ior": 1.5,
    "specular_ior_level": 0.5,
    "specular_tint": (1.0, 1.0, 1.0),
    "transmission_weight": 0.0,
    "alpha": 1.0,
    "subsurface_weight": 0.0,
    "anisotropic": 0.0,
    "anisotropic_rotation": 0.0,
    "coat_weight": 0.0,
    "coat_roughness": 0.03,
    "coat_ior": 1.5,
    "coat_tint": (1.0, 1.0, 1.0),
    "sheen_weight": 0.0,
    "sheen_roughness": 0.5,
    "sheen_tint": (1.0, 1.0, 1.0),
    "thin_film_thickness": 0.0,
    "thin_film_ior": 1.33,
}

_SURFACE = ("roughness", "specular_tint")
_FILM = ("thin_film_thickness", "thin_film_ior")
_STRETCH = ("anisotropic", "anisotropic_rotation")
_UP_TO_ONE = ("metallic", "roughness", "transmission_weight", "alpha", "subsurface_weight", "anisotropic")
_USED = {
    "sheen": ("sheen_weight", "sheen_roughness", "sheen_tint"),
    "coat": ("coat_weight", "coat_roughness", "coat_ior", "coat_tint"),
    "metallic": ("metallic", "base_color", *_SURFACE),
    "transmission": ("transmission_weight", "base_color", "ior", *_SURFACE),
    "specular": ("ior", "specular_ior_level", *_SURFACE),
    "diffuse": ("base_color",),
    "subsurface": ("base_color", "subsurface_weight"),
}


def lobes_of(constants, older=()):
    """The lobes that a node needs, by layer, from those of its inputs that are constant.

    Parameters
    ----------
    constants : mapping of str to float or sequence
        Inputs with one value for all lanes; an input that is missing here varies (fill in `DEFAULTS` first).
    older : collection of str
        As of `expand`.

    Returns
    -------
    dict of str to lobe
        Keys "alpha", "sheen", "coat", "metallic", "transmission", "specular", "diffuse", "subsurface", in this order.
    """

    def never(name, value=0.0):
        return name in constants and float(np.max(constants[name])) <= value

    def always(name, value):
        return name in constants and float(np.min(constants[name])) >= value

    smooth = never("roughness", microfacet.SMOOTH_ALPHA**0.5)
    film, stretched = not never("thin_film_thickness", thin_film.THINNEST), not never("anisotropic")
    lobes = {}
    if not always("alpha", 1.0):
        lobes["alpha"] = transparent
    if never("alpha"):
        return lobes
    if not never("sheen_weight"):
        lobes["sheen"] = sheen
    if not never("coat_weight"):
        polished = never("coat_roughness", microfacet.SMOOTH_ALPHA**0.5)
        lobes["coat"] = dielectric.Mirror if polished else dielectric.Rough
    lobes |= _surface(never, always, smooth, film, stretched, older)
    return lobes


def _surface(never, always, smooth, film, stretched, older):
    """The lobes below sheen and coat."""
    lobes = {}
    if not never("metallic"):
        plain, curve = (conductor, metal.f82_film) if film and "film" not in older else (conductor, None)
        lobes["metallic"] = _reflection(plain, curve, smooth, stretched)
    if always("metallic", 1.0):
        return lobes
    if not never("transmission_weight"):
        kind = glass_film if film else glass
        lobes["transmission"] = kind.Smooth if smooth else kind.Rough
    if always("transmission_weight", 1.0):
        return lobes
    unseen = never("specular_ior_level") or (never("ior", 1.0) and always("ior", 1.0))
    if film or not unseen:
        lobes["specular"] = _reflection(dielectric, metal.dielectric_film if film else None, smooth, stretched)
    lobes["diffuse"] = diffuse if never("diffuse_roughness", 1e-5) else oren_nayar
    if lobes["diffuse"] is oren_nayar and not never("subsurface_weight"):
        lobes["subsurface"] = diffuse
    return lobes


def inputs_of(lobes):
    """Names of the inputs that `expand` reads for `lobes`, as `lobes_of` gives them."""
    names = {"alpha"}
    for layer, lobe in lobes.items():
        names.update(_USED.get(layer, ()))
        names.update(_FILM if _has_film(lobe) else ())
        names.update(_STRETCH if is_stretched(lobe) else ())
        names.update(("diffuse_roughness",) if lobe is oren_nayar else ())
    return names


def expand(
    inputs,
    front,
    wo,
    n,
    arena,
    lobes=None,
    multiscatter=True,
    tangent=None,
    coat_normal=None,
    older=(),
    sheen_normal=None,
):
    """The lobes of the lanes with weights and parameters, for `mixture.Mixture`.

    Parameters
    ----------
    inputs : mapping of str to (1,), (N,), (3, 1) or (3, N) float32
        By the names of `DEFAULTS`; what is missing takes the default. Constants should stay (1,): they cost less.
    front : (N,) bool
        Whether the viewer is on the front; from the back, glass is seen from within.
    wo, n : (3, N)
        Viewing direction and shading normal.
    lobes : dict, optional
        What `lobes_of` told when the material was compiled; None asks it about the inputs of size one.
    multiscatter : bool
        Blender's distribution "Multiscatter GGX": lobes get back the energy that single scattering loses.
    tangent : (3, N), optional
        Direction of anisotropy; without one any will do.
    coat_normal : (3, N), optional
        Unit normal of the coat, where it is not `n`.
    sheen_normal : (3, N), optional
        Unit normal of the sheen, where it is not `n`.
    older : collection of str
        What is done as by an older Blender: ``"coat"`` (before 4.5) regains no energy, ``"film"`` (before 5.0) is seen
        by a fit of the eye's response, and metal has none.

    Returns
    -------
    list of (lobe, weight (3, N) or (3, 1), params, normal (3, N) or None for `n`)
    """
    x = cleaned(inputs)
    if lobes is None:
        lobes = lobes_of({name: value for name, value in x.items() if value.shape[-1] == 1}, older)
    below, out = np.ones((3, 1), np.float32), []
    if "alpha" in lobes:
        out.append((transparent, below * (1.0 - x["alpha"]), {}, None))
        below = below * x["alpha"]
    if "sheen" in lobes or "coat" in lobes:
        upper, below = _coating(lobes, x, n, coat_normal, sheen_normal, wo, below, arena, "coat" not in older)
        out += upper
    if "film" in older:
        x["film_fitted"] = np.ones(1, np.float32)
    mu = coating.facing(n, wo, arena)
    facing = _Facing(mu, np.square(x["roughness"]), _stretch(x, n, tangent, arena, lobes), multiscatter, arena)
    if "metallic" in lobes:
        out.append((*_metal(lobes["metallic"], x, facing, below), None))
        below = below * (1.0 - x["metallic"])
    if "transmission" in lobes:
        out.append((*_transmission(lobes["transmission"], x, facing, front, below), None))
        below = below * (1.0 - x["transmission_weight"])
    if "specular" in lobes:
        specular, reflected = _specular(lobes["specular"], x, facing, below)
        out.append((*specular, None))
        below = below * np.maximum(1.0 - reflected.max(axis=0), 0.0)
    return out + _base(lobes, x, below)


class _Facing(NamedTuple):
    """What the microfacet layers share: cosine of the view, width of the facets, how they are stretched."""

    mu: np.ndarray
    alpha: np.ndarray
    stretch: dict
    multiscatter: bool
    arena: object

    def width(self, lobe):
        """Parameters of the lobe's facets, and the isotropic width that loses as much energy."""
        if Lobe.DELTA in lobe.flags:
            return {}, None
        if not is_stretched(lobe):
            return {"alpha": self.alpha}, self.alpha
        params = {"alpha": self.alpha} | self.stretch
        return params, facets.mean_alpha(params)


def _reflection(plain, film_curve, smooth, stretched):
    """The lobe of a reflecting layer; `plain` is its module, `film_curve` its Fresnel curve under a film, else None."""
    if stretched and not smooth:
        return facets.reflection(facets.GGX, film_curve or plain.reflectance)
    rough, mirror = metal.lobes(film_curve) if film_curve else (plain.Rough, plain.Mirror)
    return mirror if smooth else rough


def is_stretched(lobe):
    """Whether a lobe's facets take a tangent."""
    return hasattr(lobe, "facets")


def _has_film(lobe):
    curves = (metal.f82_film, metal.dielectric_film)
    return getattr(lobe, "reflectance", None) in curves or getattr(lobe, "split", None) is glass_film.split


def cleaned(inputs):
    """All inputs by the names of `DEFAULTS`, which are filled in, within their ranges."""
    x = {}
    for name, default in DEFAULTS.items():
        if name in inputs:
            x[name] = inputs[name]
        else:
            x[name] = np.float32(default).reshape(-1, 1) if isinstance(default, tuple) else np.float32([default])
        if name != "anisotropic_rotation":
            x[name] = np.maximum(x[name], 0.0)
    for name in _UP_TO_ONE:
        x[name] = np.minimum(x[name], 1.0)
    x["ior"] = np.maximum(x["ior"], 1e-5)
    return x


def _coating(lobes, x, n, coat_normal, sheen_normal, wo, below, arena, regains):
    """Entries of sheen and coat, and what is left below them."""
    out = []
    if "sheen" in lobes:
        entry, below = coating.sheen_layer(x, n if sheen_normal is None else sheen_normal, wo, below, arena)
        out.append((*entry, sheen_normal))
    if "coat" in lobes:
        coat_normal_ = n if coat_normal is None else coat_normal
        entry, below = coating.coat_layer(lobes["coat"], x, coat_normal_, wo, below, arena, regains)
        out.append((*entry, coat_normal))
    return out, below


def _stretch(x, n, tangent, arena, lobes):
    """Parameters of anisotropic facets: how much wider they are along the tangent, and the tangent."""
    if not any(is_stretched(lobe) for lobe in lobes.values()):
        return {}
    turns = x["anisotropic_rotation"]
    if tangent is None:
        tangent = np.zeros((3, 1), np.float32)
    elif turns.size > 1 or turns.any():
        tangent = tangents.rotated(tangent, n, turns, arena)
    return {"stretch": 1.0 / np.sqrt(1.0 - 0.9 * x["anisotropic"]), "tangent": tangent}


def _metal(lobe, x, facing, below):
    """F82-tint metal: base colour at normal incidence, specular tint at the edge."""
    f0, tint = np.minimum(x["base_color"], 1.0), np.minimum(x["specular_tint"], 1.0)
    weight = below * x["metallic"]
    params, alpha = facing.width(lobe)
    if alpha is not None and facing.multiscatter:
        average = fresnel.f82_average(f0, fresnel.f82_drop(f0, tint))
        weight = weight * energy.compensation(*energy.reflection(facing.mu, alpha, facing.arena), average)
    return lobe, weight, params | {"f0": f0, "tint": tint} | _film(lobe, x)


def _transmission(lobe, x, facing, front, below):
    """Glass whose refraction takes the root of the base colour: a ray crosses the surface twice."""
    ior, white = x["ior"], bool((x["specular_tint"] == 1.0).all())
    tint = np.sqrt(np.minimum(x["base_color"], 1.0))
    inside = np.logical_not(front)
    params, alpha = facing.width(lobe)
    params |= {"eta": np.where(front, ior, 1.0 / ior), "tint": tint} | _film(lobe, x)
    if "film" in params:
        params["film"] = np.where(front, params["film"], params["film"] / ior)
    if not white:
        params["f0"] = np.minimum(fresnel.f0_from_ior(ior) * x["specular_tint"], 1.0)
    weight = below * x["transmission_weight"]
    if alpha is not None and facing.multiscatter:
        dense_side = inside if float(ior.min()) >= 1.0 else inside ^ (ior < 1.0)
        e, average = energy.glass(facing.mu, alpha, np.maximum(ior, 1.0 / ior), dense_side, facing.arena)
        weight = weight * energy.compensation(e, average, tint)
    return lobe, weight, params


def _specular(lobe, x, facing, below):
    """The dielectric surface, and what it reflects of the light, (3, N)."""
    f0, eta = _specular_index(x)
    mu, arena, film = facing.mu, facing.arena, _film(lobe, x)
    params, alpha = facing.width(lobe)
    params |= {"eta": eta, "f0": f0} | film
    if alpha is None or film:
        reflected = lobe.reflectance(params, mu, arena)
    else:
        reflected = f0 + (1.0 - f0) * energy.schlick(mu, alpha, eta, arena)
    weight = below
    if alpha is not None and facing.multiscatter:
        e, average = energy.reflection(mu, alpha, arena)
        real = fresnel.f0_from_ior(eta)
        share = np.clip((fresnel.dielectric_average(eta) - real) / (1.0 - real), 0.0, 1.0)
        factor = energy.compensation(e, average, f0 + (1.0 - f0) * share)
        weight = below * factor
        # Without compensation, Cycles takes no account of the lost energy: the base gets none of it.
        reflected = factor * e * reflected
    return (lobe, weight, params), np.broadcast_to(reflected, (3, reflected.shape[-1]))


def _specular_index(x):
    """Reflectance at normal incidence, (1,), (N,) or tinted (3, ·), and the relative index that goes with it."""
    level, ior = x["specular_ior_level"], x["ior"]
    f0, eta = fresnel.f0_from_ior(ior), ior
    if not (level == 0.5).all():
        f0 = f0 * 2.0 * level
        eta = fresnel.ior_from_f0(f0)
        eta = np.where(ior < 1.0, 1.0 / eta, eta)
    f0 = np.minimum(f0 * x["specular_tint"], 1.0)
    return (f0[0] if bool((x["specular_tint"] == 1.0).all()) else f0), eta


def _film(lobe, x):
    """Parameters of a thin film, none where the lobe has none."""
    if not _has_film(lobe):
        return {}
    fitted = {"film_fitted": x["film_fitted"]} if "film_fitted" in x else {}
    return {"film": x["thin_film_ior"], "thickness": x["thin_film_thickness"]} | fitted


def _base(lobes, x, below):
    """Diffuse reflection; what is scattered below the surface is not rough."""
    if "diffuse" not in lobes:
        return []
    if lobes["diffuse"] is not oren_nayar:
        return [(diffuse, below * x["base_color"], {}, None)]
    color = np.minimum(x["base_color"], 1.0)
    params = {"roughness": np.minimum(x["diffuse_roughness"], 1.0), "color": color}
    if "subsurface" not in lobes:
        return [(oren_nayar, below * x["base_color"], params, None)]
    share = x["subsurface_weight"]
    rough = (oren_nayar, below * x["base_color"] * (1.0 - share), params, None)
    return [rough, (diffuse, below * color * share, {}, None)]
