# SPDX-License-Identifier: GPL-3.0-or-later
"""What a light is to the classic methods (Phong, ray casting, Whitted ray tracing): one direction from each point.

Every light becomes a *pseudo-light* without extent that gives the same irradiance from afar and stays finite nearby,
on a surface that faces it and at squared distance d²:

| light | irradiance E |
| --- | --- |
| point, spot | I/d², from its centre; with soft falloff and radius r, I/(d² + r²); a spot times its cone |
| sun | its irradiance, from its centre |
| area | L·A·cosθ/(d² + A/π), from its centre, in front only, dimmed by its spread |
| emissive mesh object | flat: L·A·abs(cosθ)/(d² + A/π); closed: L·A/(4d²), from the power-weighted centroid |
| constant world | no pseudo-light: `ambient_radiance` |

Where a lamp's nodes differ by place or direction, E is multiplied with what they say from its centre; of an area lamp,
from nine of its points, the mean.

The expressions with A/π are exact above the centre of a disk. How flat an emitter is, abs(Σ n·A)/ΣA, is 1 for a plane
and 0 for a closed body and blends the two. In a closed body light comes from all sides: nearer to its middle than its
triangles' planes, where E has reached π·L, it comes from straight above each surface, and nothing shades it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..limits import at_least
from ..vecmath import dot
from .base import NEAREST_SQUARED, towards

_WITHIN = 0.999  # of the distance to the nearest plane: what shines is not within itself
_EMITTER_MARGIN = 1e-3  # share of the distance at which a shadow ray to a flat emitter ends early


class Illumination(NamedTuple):
    """wi (3, N) unit; distance (N,), inf for suns; irradiance (3, N) on a facing surface, without visibility."""

    wi: np.ndarray
    distance: np.ndarray
    irradiance: np.ndarray


class ClassicLights:
    """Pseudo-lights of a scene.

    Parameters
    ----------
    lights : sequence of LocalLight or ParallelLight
        One whose `casts_shadow` is set to False shines through everything. Their `emitter` is what they come from, as
        of `core.compile.lights.Lights`. Their `shade`, if set, tells of points (3, N), directions to the light,
        distances and an arena what their nodes say, (3, N).
    ambient_radiance : (3,) float32
        Radiance of the constant world.
    """

    def __init__(self, lights, ambient_radiance):
        self._lights = tuple(lights)
        self.count = len(self._lights)
        self.ambient_radiance = np.asarray(ambient_radiance, np.float32)

    def emitter(self, k):
        """What light number `k` comes from."""
        return self._lights[k].emitter

    def illuminate(self, k, p, arena, n=None):
        """Light number `k` at points `p` (3, N), of normals `n` (3, N) where bodies that shine are to light inwards."""
        light = self._lights[k]
        found = light.illuminate(p, arena)
        if light.hollow > 0 and n is not None:
            np.copyto(found.wi, n, where=found.distance < light.hollow)
        if light.shade is not None:
            with arena.frame():
                said = light.shade(p, found.wi, found.distance, arena)
                np.multiply(found.irradiance, said, out=found.irradiance)
        return found

    def shadow_distance(self, k, distance, arena):
        """How far light `k`'s shadow rays go, (N,), for its `distance`: an emitter does not shadow itself.

        That of lights without shadow is 0.
        """
        light = self._lights[k]
        if not light.casts_shadow:
            return arena.zeros(distance.shape)
        if light.margin == light.relative_margin == 0:
            return distance
        out = arena.empty(distance.shape)
        np.multiply(distance, 1.0 - light.relative_margin, out=out)
        np.subtract(out, light.margin, out=out)
        return at_least(out, 0.0, out)


class LocalLight:
    """A pseudo-light at a place: E = strength · profile/(max(d², nearest) + softening).

    Parameters
    ----------
    position, strength : (3,)
    softening, nearest : float
        Squared lengths.
    profile : callable, optional
        ``profile(wi, arena) -> (N,)``, dependence on the direction.
    margin, relative_margin : float
        By how much shadow rays end before `position`, in length and as a share of the distance.
    hollow : float
        Distance from `position` below which points are within what shines.
    """

    casts_shadow = True
    emitter = 0
    shade = None
    hollow = 0.0

    def __init__(self, position, strength, softening=0.0, nearest=0.0, profile=None, margin=0.0, relative_margin=0.0):
        self.position = np.asarray(position, np.float32).reshape(3, 1)
        self.strength = np.asarray(strength, np.float32).reshape(3, 1)
        self.margin, self.relative_margin = float(margin), float(relative_margin)
        self._softening, self._nearest = float(softening), max(float(nearest), NEAREST_SQUARED)
        self._profile = profile

    def illuminate(self, p, arena):
        """Illumination of points `p` (3, N)."""
        irradiance = arena.empty(p.shape)
        wi, distance = towards(p, self.position, arena)
        with arena.frame():
            squared = np.multiply(distance, distance, out=arena.empty(distance.shape))
            np.maximum(squared, self._nearest, out=squared)
            np.add(squared, self._softening, out=squared)
            np.divide(self.strength, squared, out=irradiance)
            if self._profile:
                np.multiply(irradiance, self._profile(wi, arena), out=irradiance)
        return Illumination(wi, distance, irradiance)


class ParallelLight:
    """A pseudo-light in direction `axis` (3,), unit, of `irradiance` (3,)."""

    margin = relative_margin = hollow = 0.0

    casts_shadow = True
    emitter = 0
    shade = None

    def __init__(self, axis, irradiance):
        self.axis = np.asarray(axis, np.float32).reshape(3, 1)
        self.irradiance = np.asarray(irradiance, np.float32).reshape(3, 1)

    def illuminate(self, p, arena):
        """Illumination of points `p` (3, N)."""
        wi, irradiance = arena.empty(p.shape), arena.empty(p.shape)
        wi[...] = self.axis
        irradiance[...] = self.irradiance
        return Illumination(wi, arena.full(p.shape[-1], math.inf), irradiance)


def area_pseudo_light(center, normal, area, radiance, attenuation):
    """One-sided emitter of `area` at `center`, shining where `normal` points.

    `attenuation`, as of `AreaLights` of this light alone, is that of its spread.
    """
    normal = np.asarray(normal, np.float32).reshape(3, 1)

    def front_cosine(wi, arena):
        cosine = dot(wi, normal, arena)
        np.negative(cosine, out=cosine)
        at_least(cosine, 0.0, cosine)
        return np.multiply(cosine, attenuation(0, wi, arena), out=cosine)

    return LocalLight(center, np.asarray(radiance) * area, softening=area / math.pi, profile=front_cosine)


def mesh_pseudo_light(corners, radiance):
    """Emissive triangles as one light.

    Parameters
    ----------
    corners : (9, n)
        v0, v1, v2 of triangles that have an area.
    radiance : (3, n)
        Of each triangle, both sides.
    """
    v0, v1, v2 = vertices = np.asarray(corners, np.float64).reshape(3, 3, -1)
    scaled_normal = 0.5 * np.cross(v1 - v0, v2 - v0, axis=0)
    areas = np.linalg.norm(scaled_normal, axis=0)
    area = float(areas.sum())
    power = areas * np.abs(radiance).mean(axis=0)
    center = (vertices.mean(axis=0) * power).sum(axis=1) / power.sum()
    bound = float(np.linalg.norm(vertices - center[:, None], axis=1).max())
    normal = scaled_normal.sum(axis=1)
    length = float(np.linalg.norm(normal))
    flatness = min(length / area, 1.0)
    normal = (normal / max(length, 1e-300)).astype(np.float32).reshape(3, 1)

    def two_sided(wi, arena):
        cosine = dot(wi, normal, arena)
        np.abs(cosine, out=cosine)
        np.multiply(cosine, flatness, out=cosine)
        return np.add(cosine, 0.25 * (1.0 - flatness), out=cosine)

    made = LocalLight(
        center,
        (radiance * areas).sum(axis=1),
        softening=flatness * area / math.pi,
        nearest=(1.0 - flatness) * area / (4.0 * math.pi),
        profile=two_sided,
        margin=(1.0 - flatness * flatness) * bound,
        relative_margin=_EMITTER_MARGIN,
    )
    to_planes = np.abs(((v0 - center[:, None]) * scaled_normal).sum(axis=0)) / areas
    made.hollow = _WITHIN * float(to_planes.min())
    return made
