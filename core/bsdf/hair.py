# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Hair BSDF: light that a strand reflects at its surface, or lets pass through it once.

Parameters: `tangent` (3, N), unit, along the strand; `offset`, `roughness_u`, `roughness_v`, (N,) or (1,). θ is the
angle of a direction out of the plane across the strand, φ that between both directions as seen along it. Half the sum
of both θ follows a Cauchy distribution of width `roughness_u` about `offset`; φ a cosine lobe of width `roughness_v`
about 0 (`Reflection`), or a Cauchy distribution about π (`Transmission`). f·cosθ is the density itself.

Source: Cycles' Hair BSDF, after Marschner et al., "Light Scattering from Human Hair Fibers", SIGGRAPH 2003.
"""

from __future__ import annotations

import math

import numpy as np

from ..vecmath import cross, dot, lanes, normalize
from .base import Lobe, LobeSample

_HALF_PI = math.pi / 2
_STEEPEST = 0.001  # directions closer than that to the strand's own have no density
_LEAST, _MOST = 0.001, 1.0  # widths


class _Hair:
    """What both share: the longitudinal part."""

    @classmethod
    def sample(cls, params, n, wo, uc, u0, u1, arena):
        """A direction of the lobe, of weight 1."""
        count = u0.shape[-1]
        wi, pdf, weight = arena.empty((3, count)), arena.empty(count), arena.empty(count)
        with arena.frame():
            along, width = params["tangent"], _width(params, "roughness_u")
            theta_o = _elevation(along, wo, arena)
            high, low = _limits(theta_o, params["offset"], width)
            half = width * np.tan(u0 * (high - low) + low) + params["offset"]
            theta_i = 2.0 * half - theta_o
            phi = cls.azimuth(u1, _width(params, "roughness_v"))
            y = _across(along, wo, arena)
            x = cross(y, along, arena)
            cosine = np.cos(theta_i)
            np.multiply(y, np.cos(phi) * cosine, out=wi)
            np.subtract(wi, x * (np.sin(phi) * cosine), out=wi)
            np.add(wi, along * np.sin(theta_i), out=wi)
            normalize(wi, arena, out=wi)
            np.copyto(pdf, _longitudinal(theta_o, theta_i, params["offset"], width))
            np.multiply(pdf, cls.density(np.abs(phi), _width(params, "roughness_v")), out=pdf)
            np.greater(pdf, 0.0, out=weight, casting="unsafe")
        return LobeSample(wi, weight, pdf)

    @classmethod
    def eval_pdf(cls, params, n, wo, wi, arena):
        """f·cosθ = pdf on the lobe's side of the surface, one array for both."""
        pdf = arena.empty(lanes(wo, wi))
        with arena.frame():
            along, width = params["tangent"], _width(params, "roughness_u")
            theta_o, theta_i = _elevation(along, wo, arena), _elevation(along, wi, arena)
            cosine = np.clip(dot(_across(along, wo, arena), _across(along, wi, arena), arena), -1.0, 1.0)
            np.copyto(pdf, _longitudinal(theta_o, theta_i, params["offset"], width))
            np.multiply(pdf, cls.density(np.arccos(cosine), _width(params, "roughness_v")), out=pdf)
            np.multiply(pdf, cls.is_seen(dot(n, wi, arena), cosine), out=pdf)
        return pdf, pdf

    @staticmethod
    def albedo(params, n, wo, arena):
        """1: all is passed on."""
        return 1.0

    @staticmethod
    def split(params, cosine, arena):
        """What the classic methods take it for: reflection."""
        return 1.0, 0.0, None, None


class Reflection(_Hair):
    """At the strand's surface. As in Cycles, samples of a wide lobe also go where its value is taken as 0."""

    flags = Lobe.REFLECTION | Lobe.GLOSSY

    @staticmethod
    def azimuth(u, width):
        """φ of the uniform number `u`."""
        return 2.0 * np.arcsin(np.clip(1.0 - 2.0 * u, -1.0, 1.0)) * width

    @staticmethod
    def density(phi, width):
        """Of φ in [0, π]."""
        return np.maximum(np.cos(np.minimum(phi / width, math.pi) * 0.5), 0.0) * 0.25 / width

    @staticmethod
    def is_seen(side, cosine):
        """In front of the surface, and where φ is below a right angle."""
        return (side >= 0.0) & (cosine >= 0.0)


class Transmission(_Hair):
    """Through the strand."""

    flags = Lobe.TRANSMISSION | Lobe.GLOSSY

    @staticmethod
    def azimuth(u, width):
        """φ of the uniform number `u`."""
        reach = 2.0 * np.arctan(_HALF_PI / width)
        return width * np.tan(reach * (u - 0.5)) + math.pi

    @staticmethod
    def density(phi, width):
        """Of φ in [0, 2π]."""
        reach, away = 2.0 * np.arctan(_HALF_PI / width), math.pi - phi
        return width / (reach * (away * away + width * width))

    @staticmethod
    def is_seen(side, cosine):
        """Behind the surface."""
        return side < 0.0


def _width(params, name):
    return np.clip(params[name], _LEAST, _MOST)


def _elevation(along, w, arena):
    """θ of unit vectors."""
    return np.arcsin(np.clip(dot(along, w, arena), -1.0, 1.0))


def _across(along, w, arena):
    """The unit vectors across the strand nearest to `w`."""
    y = np.subtract(w, along * dot(along, w, arena), out=arena.empty(w.shape))
    return normalize(y, arena, out=y)


def _limits(theta_o, offset, width):
    """Angles of the Cauchy distribution at which θ reaches π/2 and -π/2."""
    high, low = (np.arctan(((end + theta_o) * 0.5 - offset) / width) for end in (_HALF_PI, -_HALF_PI))
    return high, low


def _longitudinal(theta_o, theta_i, offset, width):
    """Density of θ_i by solid angle."""
    high, low = _limits(theta_o, offset, width)
    away = (theta_o + theta_i) * 0.5 - offset
    cosine = np.cos(theta_i)
    density = width / (2.0 * (away * away + width * width) * (high - low) * np.maximum(cosine, 1e-6))
    return density * (_HALF_PI - np.abs(theta_i) >= _STEEPEST)
