# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Principled BSDF as a list of lobes.

From the top: transparency by `alpha`; the mix of metal by `metallic`, glass by `transmission_weight`, and a dielectric
surface over a diffuse base. What the surface reflects, the base does not get. GGX lobes get back the energy that single
scattering loses where Blender's distribution is "Multiscatter GGX". Emission, coat, sheen and subsurface are the
caller's.

Source: the Principled node of Cycles 4 and 5, compared by rendering.
"""

from __future__ import annotations

import numpy as np

from ..vecmath import dot
from . import conductor, dielectric, diffuse, energy, fresnel, glass, microfacet, oren_nayar, transparent

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
}


def lobes_of(constants):
    """The lobes that a node needs, by layer, from those of its inputs that are constant.

    Parameters
    ----------
    constants : mapping of str to float or sequence
        Inputs with one value for all lanes; an input that is missing here varies (fill in `DEFAULTS` first).

    Returns
    -------
    dict of str to lobe
        Keys "alpha", "metallic", "transmission", "specular", "diffuse", in the order of the layers.
    """

    def never(name, value):
        return name in constants and float(np.max(constants[name])) <= value

    def always(name, value):
        return name in constants and float(np.min(constants[name])) >= value

    smooth = "roughness" in constants and float(np.max(constants["roughness"])) ** 2 <= microfacet.SMOOTH_ALPHA
    lobes = {}
    if not always("alpha", 1.0):
        lobes["alpha"] = transparent
    if never("alpha", 0.0):
        return lobes
    if not never("metallic", 0.0):
        lobes["metallic"] = conductor.Mirror if smooth else conductor.Rough
    if always("metallic", 1.0):
        return lobes
    if not never("transmission_weight", 0.0):
        lobes["transmission"] = glass.Smooth if smooth else glass.Rough
    if always("transmission_weight", 1.0):
        return lobes
    if not never("specular_ior_level", 0.0) and not (never("ior", 1.0) and always("ior", 1.0)):
        lobes["specular"] = dielectric.Mirror if smooth else dielectric.Rough
    lobes["diffuse"] = diffuse if never("diffuse_roughness", 1e-5) else oren_nayar
    return lobes


def expand(inputs, front, wo, n, arena, lobes=None, multiscatter=True):
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

    Returns
    -------
    list of (lobe, weight (3, N) or (3, 1), params)
    """
    x = _clean(inputs)
    if lobes is None:
        lobes = lobes_of({name: value for name, value in x.items() if value.shape[-1] == 1})
    mu = np.maximum(dot(n, wo, arena), 0.0, out=arena.empty(wo.shape[-1]))
    alpha = np.square(x["roughness"])
    below = np.ones((3, 1), np.float32)
    out = []
    if "alpha" in lobes:
        out.append((transparent, below * (1.0 - x["alpha"]), {}))
        below = below * x["alpha"]
    if "metallic" in lobes:
        out.append(_metal(lobes["metallic"], x, alpha, mu, below, multiscatter, arena))
        below = below * (1.0 - x["metallic"])
    if "transmission" in lobes:
        out.append(_transmission(lobes["transmission"], x, alpha, mu, front, below, multiscatter, arena))
        below = below * (1.0 - x["transmission_weight"])
    if "specular" in lobes:
        specular, reflected = _specular(lobes["specular"], x, alpha, mu, below, multiscatter, arena)
        out.append(specular)
        below = below * np.maximum(1.0 - reflected.max(axis=0), 0.0)
    if "diffuse" in lobes:
        params = {}
        if lobes["diffuse"] is oren_nayar:
            params = {"roughness": np.minimum(x["diffuse_roughness"], 1.0), "color": np.minimum(x["base_color"], 1.0)}
        out.append((lobes["diffuse"], below * x["base_color"], params))
    return out


def _clean(inputs):
    """All inputs, defaults filled in, within their ranges."""
    x = {}
    for name, default in DEFAULTS.items():
        if name in inputs:
            x[name] = inputs[name]
        else:
            x[name] = np.float32(default).reshape(-1, 1) if isinstance(default, tuple) else np.float32([default])
        x[name] = np.maximum(x[name], 0.0)
    for name in ("metallic", "roughness", "transmission_weight", "alpha"):
        x[name] = np.minimum(x[name], 1.0)
    x["ior"] = np.maximum(x["ior"], 1e-5)
    return x


def _metal(lobe, x, alpha, mu, below, multiscatter, arena):
    """F82-tint metal: base colour at normal incidence, specular tint at the edge."""
    f0, tint = np.minimum(x["base_color"], 1.0), np.minimum(x["specular_tint"], 1.0)
    weight = below * x["metallic"]
    params = {"f0": f0, "tint": tint}
    if lobe is conductor.Rough:
        params["alpha"] = alpha
        if multiscatter:
            average = fresnel.f82_average(f0, fresnel.f82_drop(f0, tint))
            weight = weight * energy.compensation(*energy.reflection(mu, alpha, arena), average)
    return lobe, weight, params


def _transmission(lobe, x, alpha, mu, front, below, multiscatter, arena):
    """Glass whose refraction takes the root of the base colour: a ray crosses the surface twice."""
    ior, white = x["ior"], bool((x["specular_tint"] == 1.0).all())
    tint = np.sqrt(np.minimum(x["base_color"], 1.0))
    inside = np.logical_not(front)
    params = {"eta": np.where(front, ior, 1.0 / ior), "tint": tint}
    if not white:
        params["f0"] = np.minimum(fresnel.f0_from_ior(ior) * x["specular_tint"], 1.0)
    weight = below * x["transmission_weight"]
    if lobe is glass.Rough:
        params["alpha"] = alpha
        if multiscatter:
            dense_side = inside if float(ior.min()) >= 1.0 else inside ^ (ior < 1.0)
            e, average = energy.glass(mu, alpha, np.maximum(ior, 1.0 / ior), dense_side, arena)
            weight = weight * energy.compensation(e, average, tint)
    return lobe, weight, params


def _specular(lobe, x, alpha, mu, below, multiscatter, arena):
    """The dielectric surface, and what it reflects of the light, (3, N)."""
    level, ior = x["specular_ior_level"], x["ior"]
    f0, eta = fresnel.f0_from_ior(ior), ior
    if not (level == 0.5).all():
        f0 = f0 * 2.0 * level
        eta = fresnel.ior_from_f0(f0)
        eta = np.where(ior < 1.0, 1.0 / eta, eta)
    f0 = np.minimum(f0 * x["specular_tint"], 1.0)
    if bool((x["specular_tint"] == 1.0).all()):
        f0 = f0[0]
    params = {"eta": eta, "f0": f0}
    weight = below
    if lobe is dielectric.Rough:
        params["alpha"] = alpha
        reflected = f0 + (1.0 - f0) * energy.schlick(mu, alpha, eta, arena)
        if multiscatter:
            e, average = energy.reflection(mu, alpha, arena)
            real = fresnel.f0_from_ior(eta)
            share = np.clip((fresnel.dielectric_average(eta) - real) / (1.0 - real), 0.0, 1.0)
            factor = energy.compensation(e, average, f0 + (1.0 - f0) * share)
            weight = below * factor
            # Without compensation, Cycles takes no account of the lost energy: the base gets none of it.
            reflected = factor * e * reflected
    else:
        exact, _ = fresnel.dielectric(mu, eta, arena)
        reflected = fresnel.mix_to_white(f0, fresnel.interpolation(exact, eta, arena), arena)
    return (lobe, weight, params), np.broadcast_to(reflected, (3, reflected.shape[-1]))
