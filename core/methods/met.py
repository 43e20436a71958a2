# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces that rays have met, with what their materials make of them, for all that describes a hit."""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..bsdf import energy, facets
from ..bsdf.base import Lobe
from ..nodes.base import CAMERA_RAY
from ..vecmath import dot, normalize
from .transparency import straight_weight
from .wavefront import gather, surface_context

_PLAIN_SHARE = 0.25  # a surface with less of itself to show is looked through. Source: Cycles
_SHARE_OF_ALL = 0.5  # with that it shows itself alone, where this is blended. Source: Cycles
_SPECULAR_ALPHA = 0.075  # narrower lobes show what they reflect rather than themselves. Source: Cycles
_PLAIN_ALPHA = 0.15  # lobes of that width show only themselves, where this is blended. Source: Cycles


class Met:
    """Lanes that have met a surface.

    Parameters
    ----------
    scene : CompiledScene
    hits : Hits
        Of all lanes.
    o, d : (3, N) float32
        Their rays.
    arena : Arena
    ray : Ray
        What kind of rays they are.

    Attributes
    ----------
    lane : (n,) int
        The lanes that met something.
    surface : Surface
        Of these, dense; so is all that the methods return.
    """

    def __init__(self, scene, hits, o, d, arena, ray=CAMERA_RAY):
        self._scene, self._arena, self._ray = scene, arena, ray
        self.lane = np.flatnonzero(hits.prim >= 0)
        o, d = arena.take(o, self.lane), arena.take(d, self.lane)
        self.surface = scene.interact(gather(hits, self.lane, arena), o, d, arena)
        self.material = arena.take(scene.geometry.material, self.surface.prim)

    @cached_property
    def parts(self):
        """[(places in `lane`, their surface, mixture, its entries)] of each program that scatters."""
        scene, arena = self._scene, self._arena
        found = []
        for number, lanes in scene.materials.groups(self.material, arena):
            program = scene.materials.programs[number]
            if not program.closures or not self.lane.size:
                continue
            lanes = np.arange(self.lane.size) if lanes is None else lanes
            surface = gather(self.surface, lanes, arena)
            constants = scene.materials.constants(number, "scatter", arena.take(self.material, lanes), arena)
            entries = program.lobes_over(surface_context(surface, scene.geometry, arena, self._ray), constants)
            found.append((lanes, surface, program.mixture, entries))
        return found

    def alpha(self):
        """What is not let through unbent, (3, n)."""
        return 1 - straight_weight(self._scene, self.surface, self._arena, self._ray)

    def opacity(self):
        """The same, mean of the channels, (n,)."""
        return 1 - straight_weight(self._scene, self.surface, self._arena, self._ray).mean(axis=0)

    def emitted(self):
        """Radiance (3, n)."""
        return self._scene.emitted(self.surface, self._arena, self._ray)

    def normal(self, flag=None):
        """Mean of the lobes' normals by their weights, (3, n); the shading normal where nothing scatters.

        With `flag`, a `Lobe`, of those alone that have it.
        """
        out = self.surface.ns.copy()
        for lanes, surface, _, entries in self.parts:
            if flag is not None:
                entries = [entry for entry in entries if flag in entry[0].flags]
            if all(n is None for _, _, _, n in entries):
                continue
            total = np.zeros((3, lanes.size), np.float32)
            for _, weight, _, n in entries:
                total += (surface.ns if n is None else n) * np.abs(weight.mean(axis=0))
            out[:, lanes] = _unit_or(total, surface.ns, self._arena)
        return out

    def colors(self):
        """What is reflected diffusely, as gloss, and transmitted, three arrays (3, n)."""
        out = np.zeros((3, 3, self.lane.size), np.float32)
        for lanes, surface, _, entries in self.parts:
            for entry in entries:
                for total, color in zip(out, split_color(entry, surface, self._arena), strict=True):
                    if color is not None:
                        total[:, lanes] += color
        return out


def split_color(entry, surface, arena):
    """The colour of one lobe as (diffuse, glossy, transmitted), None where it has no such part.

    A diffuse lobe's is its weight, as in Cycles, of others the share of light too that they send on.
    """
    lobe, weight, params, n = entry
    flags = lobe.flags
    if Lobe.DIFFUSE in flags:
        return weight, None, None
    n = surface.ns if n is None else n
    if Lobe.TRANSMISSION not in flags:
        return None, weight * _reflected(lobe, params, n, surface.wo, arena), None
    if Lobe.REFLECTION not in flags:
        return None, None, weight * lobe.albedo(params, n, surface.wo, arena)
    cosine = np.clip(dot(n, surface.wo, arena), 0.0, 1.0)
    reflected, transmitted, _, _ = lobe.split(params, cosine, arena)
    if "alpha" in params and "eta" in params:  # a fibre has no facets
        eta = params["eta"]
        kept, _ = energy.glass(cosine, facets.mean_alpha(params), np.maximum(eta, 1 / eta), eta < 1, arena)
        weight = weight * kept
    return None, weight * reflected, weight * transmitted


def _reflected(lobe, params, n, wo, arena):
    """Share of light that a lobe of facets reflects: what single scattering keeps, times the facets' reflectance."""
    if "alpha" not in params or "size" in params or "roughness_u" in params:  # mirrors; toon and hair have no facets
        return lobe.albedo(params, n, wo, arena)
    cosine, alpha = np.clip(dot(n, wo, arena), 0.0, 1.0), facets.mean_alpha(params)
    kept, _ = energy.reflection(cosine, alpha, arena)
    if "f0" in params and "eta" in params and "film" not in params:
        f0 = params["f0"]
        return kept * (f0 + (1 - f0) * energy.schlick(cosine, alpha, params["eta"], arena))
    return kept * lobe.albedo(params, n, wo, arena)


class Features(NamedTuple):
    """What tells a denoiser of surfaces.

    albedo, specular (3, n): colour of the lobes that show themselves, and of those that show what they reflect or
    refract. normal (3, n), roughness (n,): means of the lobes' by what they send on. share (n,): of the first kind in
    all, 1 where everything is black.
    """

    albedo: np.ndarray
    specular: np.ndarray
    normal: np.ndarray
    roughness: np.ndarray
    share: np.ndarray


def features(part, arena, blends=False):
    """`Features` of one of `Met.parts`; with `blends` the two kinds of lobes go over into each other."""
    lanes, surface, mixture, entries = part
    albedo, specular, normal = np.zeros((3, 3, lanes.size), np.float32)
    total, roughness, share = np.zeros((3, lanes.size), np.float32)
    shares = mixture.shares(entries, surface, arena)
    shares = np.ones((1, lanes.size), np.float32) if shares is None else shares
    for entry, chosen in zip(entries, shares, strict=True):
        color = sum(c for c in split_color(entry, surface, arena) if c is not None)
        alpha = _alpha(entry)
        if blends:
            plain, chosen = smoothstep(alpha / _PLAIN_ALPHA), np.abs(color.mean(axis=0))
        else:
            plain = (alpha > _SPECULAR_ALPHA).astype(np.float32)
        albedo += color * plain
        specular += color * (1 - plain)
        normal += (surface.ns if entry[3] is None else entry[3]) * chosen
        total += chosen
        roughness += chosen * np.sqrt(alpha)
        share += chosen * plain
    black = total == 0
    total[black] = share[black] = 1
    return Features(albedo, specular, _unit_or(normal, surface.ns, arena), roughness / total, share / total)


def shown(share, blends):
    """How much surfaces show themselves, (n,), by the `share` of their lobes that do. Source: Cycles."""
    if not blends:
        return (share > _PLAIN_SHARE).astype(np.float32)
    return smoothstep(share / _SHARE_OF_ALL)


def smoothstep(x):
    """3x² - 2x³ of `x` kept in [0, 1]."""
    x = np.clip(x, 0, 1)
    return x * x * (3 - 2 * x)


def _alpha(entry):
    """Width of a lobe, (1,) or (n,): 0 of a mirror, 1 of what is no facets'."""
    lobe, _, params, _ = entry
    if Lobe.DELTA in lobe.flags:
        return np.zeros(1, np.float32)
    if Lobe.DIFFUSE in lobe.flags or "alpha" not in params or "size" in params:
        return np.ones(1, np.float32)
    return params["alpha"]


def _unit_or(v, other, arena):
    """`v` (3, n) at length 1, `other` where it has none."""
    none = ~v.any(axis=0)
    v = np.where(none, other, v)
    return normalize(v, arena, out=v)
