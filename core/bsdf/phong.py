# SPDX-License-Identifier: GPL-3.0-or-later
"""How a Blender material becomes Phong parameters.

The classic methods know a diffuse and a specular colour, an exponent, a share that a mirror ray carries (k_s) and one
that a refracted ray carries (k_t). They are read from the lobes of the material:

=====================  =============================================================================================
parameter              from
=====================  =============================================================================================
diffuse                the sum of the diffuse lobes' colours (transmitted diffuse light counts as reflected)
specular               the sum of the glossy reflections' colours, Fresnel's share at the viewing angle included
exponent               2 / alpha² - 2 of those, weighted by colour (Walter et al., EGSR 2007), at most 4096
k_s, the mirror ray    the same colours times (1 - alpha)²: a rough surface shows highlights but no mirror image
k_t, the refracted ray the sum of the transmissions' colours; index from the lobe; straight passages have index 1
normal                 that of the brightest lobe
=====================  =============================================================================================
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..vecmath import dot
from .base import Lobe

MAX_EXPONENT = 4096.0
_SMOOTH = np.zeros(1, np.float32)


class PhongParameters(NamedTuple):
    """Of each lane: diffuse, specular (3, N); exponent (N,); k_s, k_t (3, N); eta (N,), relative, on the viewer's side.

    k_s, k_t and eta are None where no ray goes on; normal (3, N) is None where no lobe has one of its own.
    """

    diffuse: np.ndarray
    specular: np.ndarray
    exponent: np.ndarray
    k_s: np.ndarray | None
    k_t: np.ndarray | None
    eta: np.ndarray | None
    normal: np.ndarray | None = None


def phong_parameters(lobes, ns, wo, straight, arena, goes_on=True):
    """Reduce the lobes of a material to `PhongParameters`.

    Parameters
    ----------
    lobes : list of (lobe, weight, params, n)
    ns, wo : (3, N) float32
    straight : (3, N), (3, 1), (1,) or None
        What passes unbent.
    arena : Arena
    goes_on : bool
        Whether mirror and refracted rays are asked for.
    """
    n = wo.shape[1]
    diffuse, specular, exponent = arena.zeros((3, n)), arena.zeros((3, n)), arena.zeros(n)
    k_s = k_t = eta = None
    if goes_on:
        k_s, k_t, eta = arena.zeros((3, n)), arena.zeros((3, n)), arena.full(n, 1.0)
    with arena.frame():
        strength, color = arena.zeros(n), arena.empty((3, n))
        for lobe, weight, params, normal in lobes:
            with arena.frame():
                normal = ns if normal is None else normal
                if Lobe.TRANSMISSION in lobe.flags and Lobe.DIFFUSE not in lobe.flags:
                    reflected, transmitted = _divided(lobe, params, normal, wo, arena)
                    if goes_on:
                        eta[:] = params.get("eta", 1.0)
                        np.add(k_t, weight * transmitted, out=k_t)
                else:
                    reflected = lobe.albedo(params, normal, wo, arena)
                np.multiply(weight, reflected, out=color)
                if Lobe.DIFFUSE in lobe.flags:
                    np.add(diffuse, color, out=diffuse)
                    continue
                np.add(specular, color, out=specular)
                alpha = params.get("alpha", _SMOOTH)
                if goes_on:
                    np.add(k_s, color * np.square(1 - alpha), out=k_s)
                share = color.sum(axis=0, out=arena.empty(n))
                np.add(strength, share, out=strength)
                np.multiply(share, _exponent(alpha), out=share)
                np.add(exponent, share, out=exponent)
        np.divide(exponent, strength, out=exponent, where=strength > 0)
    if straight is not None and goes_on:
        np.add(k_t, straight, out=k_t)
    return PhongParameters(diffuse, specular, exponent, k_s, k_t, eta, _normal(lobes, ns, wo, arena))


def _exponent(alpha):
    """Phong's exponent of GGX's `alpha`, (N,) or (1,)."""
    return np.minimum(2 / np.maximum(np.square(alpha), 1e-8) - 2, MAX_EXPONENT)


def _normal(lobes, ns, wo, arena):
    """The normal of the lobe that is brightest in each lane, None where all have the surface's."""
    if all(normal is None for *_, normal in lobes):
        return None
    out, most = arena.zeros(wo.shape), arena.full(wo.shape[1], -1.0)
    np.copyto(out, ns)
    with arena.frame():
        for lobe, weight, params, normal in lobes:
            normal = ns if normal is None else normal
            color = np.multiply(weight, lobe.albedo(params, normal, wo, arena), out=arena.empty(wo.shape))
            bright = color.sum(axis=0)
            np.copyto(out, normal, where=bright > most)
            np.maximum(most, bright, out=most)
    return out


def _divided(lobe, params, normal, wo, arena):
    """Reflected and transmitted share of a lobe that transmits."""
    if not hasattr(lobe, "split"):
        return 0.0, lobe.albedo(params, normal, wo, arena)
    cosine = np.maximum(dot(normal, wo, arena), 0.0)
    reflected, transmitted, _, _ = lobe.split(params, cosine, arena)
    return reflected, transmitted
