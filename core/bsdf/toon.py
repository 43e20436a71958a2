# SPDX-License-Identifier: GPL-3.0-or-later
"""Cartoon shading: light from a cone alone, the same from all of it but for a soft edge.

Parameters, (N,) or (1,): `size` and `smooth` in [0, 1], the angle of the cone's core and of its edge as shares of 90°.
`Diffuse` has its cone about the normal, `Glossy` about the mirrored view. The value is that of a density which is even
over core and edge, times 1 in the core and falling linearly with the angle over the edge.

Source: Cycles' Toon node.
"""

from __future__ import annotations

import math

import numpy as np

from .. import vecmath
from ..sampling import warp
from ..vecmath import dot
from .base import Lobe, LobeSample

_LEAST_SIZE = 1e-5


def _cone(params):
    """Angle of the core, of the edge, and 1 - cos of the whole cone, (N,) or (1,) each."""
    core = np.clip(params["size"], _LEAST_SIZE, 1.0) * (math.pi / 2)
    edge = np.clip(params["smooth"], 0.0, 1.0) * (math.pi / 2)
    sine = np.sin(np.minimum(core + edge, math.pi / 2) * 0.5)
    return core, edge, 2.0 * sine * sine


def _intensity(angle, core, edge):
    """1 in the core, linear over the edge, 0 beyond."""
    fall = (angle - core) / np.maximum(edge, 1e-20)
    return np.clip(1.0 - fall, 0.0, 1.0)


def _angle(w, axis, arena):
    """Angle between unit vectors, from their chord: exact for narrow cones."""
    chord = np.subtract(w, axis, out=arena.empty(w.shape))
    half = np.sqrt(dot(chord, chord, arena)) * 0.5
    return 2.0 * np.arcsin(np.minimum(half, 1.0))


class _Toon:
    """What both share; `axis(n, wo, arena)` is the cone's axis."""

    @classmethod
    def sample(cls, params, n, wo, uc, u0, u1, arena):
        """A uniform direction of the cone."""
        count = u0.shape[-1]
        wi, weight, pdf = arena.empty((3, count)), arena.empty(count), arena.empty(count)
        with arena.frame():
            core, edge, cap = _cone(params)
            axis = cls.axis(n, wo, arena)
            s, t = vecmath.frame(axis, arena)
            local = warp.square_to_uniform_cone(u0, u1, cap, arena)
            np.copyto(wi, vecmath.to_world(local, s, t, axis, arena))
            np.copyto(weight, _intensity(_angle(wi, axis, arena), core, edge))
            seen = dot(n, wi, arena) > 0.0
            if cls.needs_view:
                seen &= dot(n, wo, arena) > 0.0
            np.multiply(weight, seen, out=weight)
            np.copyto(pdf, warp.uniform_cone_pdf(cap))
            np.multiply(pdf, seen, out=pdf)
        return LobeSample(wi, weight, pdf)

    @classmethod
    def eval_pdf(cls, params, n, wo, wi, arena):
        """f·cosθ and the cone's density."""
        count = vecmath.lanes(wo, wi)
        f, pdf = arena.empty(count), arena.empty(count)
        with arena.frame():
            core, edge, cap = _cone(params)
            angle = _angle(wi, cls.axis(n, wo, arena), arena)
            inside = (dot(n, wi, arena) > 0.0) & (angle < np.minimum(core + edge, math.pi / 2))
            if cls.needs_view:
                inside &= dot(n, wo, arena) > 0.0
            np.copyto(pdf, warp.uniform_cone_pdf(cap))
            np.multiply(pdf, inside, out=pdf)
            np.multiply(pdf, _intensity(angle, core, edge), out=f)
        return f, pdf

    @staticmethod
    def albedo(params, n, wo, arena):
        """About 1: an estimate."""
        return 1.0


class Diffuse(_Toon):
    """A cone about the normal."""

    flags = Lobe.REFLECTION | Lobe.DIFFUSE
    needs_view = False

    @staticmethod
    def axis(n, wo, arena):
        """The normal."""
        return n


class Glossy(_Toon):
    """A cone about the mirrored view; what of it lies below the surface is lost."""

    flags = Lobe.REFLECTION | Lobe.GLOSSY
    needs_view = True

    @staticmethod
    def axis(n, wo, arena):
        """The view mirrored about the normal."""
        return vecmath.reflect(wo, n, arena)
