# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Gradient Texture. Source: Blender, intern/cycles/kernel/svm/gradient.h."""

from __future__ import annotations

import math

import numpy as np

from .base import Operation, Outputs
from .texture import grey, vector_of


def _gradient(context, inputs, properties):
    arena, vector = context.arena, vector_of(context, inputs)
    kind = properties.get("gradient_type", "LINEAR")

    def fac():
        out = arena.empty(vector.shape[-1])
        with arena.frame(), np.errstate(over="ignore", invalid="ignore"):
            _KINDS[kind](*vector, out, arena)
        np.fmax(out, 0, out=out)
        return np.minimum(out, 1, out=out)

    outputs = Outputs({"fac": fac, "color": lambda: grey(outputs["fac"])})
    return outputs


def _linear(x, y, z, out, arena):
    np.copyto(out, x)


def _quadratic(x, y, z, out, arena):
    np.fmax(x, 0, out=out)
    np.multiply(out, out, out=out)


def _easing(x, y, z, out, arena):
    """3 r² - 2 r³."""
    r = np.fmin(np.fmax(x, 0, out=arena.empty(x.size)), 1)
    np.multiply(r, -2, out=out)
    np.add(out, 3, out=out)
    np.multiply(out, r, out=out)
    np.multiply(out, r, out=out)


def _diagonal(x, y, z, out, arena):
    np.add(x, y, out=out)
    np.multiply(out, 0.5, out=out)


def _radial(x, y, z, out, arena):
    np.arctan2(y, x, out=out)
    np.divide(out, 2 * math.pi, out=out)
    np.add(out, 0.5, out=out)


def _spherical(x, y, z, out, arena):
    """What is left of the radius 1, exactly nothing for vectors of unit length."""
    t = arena.empty(x.size)
    np.multiply(x, x, out=out)
    np.add(out, np.multiply(y, y, out=t), out=out)
    np.add(out, np.multiply(z, z, out=t), out=out)
    np.sqrt(out, out=out)
    np.subtract(0.999999, out, out=out)
    np.fmax(out, 0, out=out)


def _quadratic_sphere(x, y, z, out, arena):
    _spherical(x, y, z, out, arena)
    np.multiply(out, out, out=out)


_KINDS = {
    "LINEAR": _linear,
    "QUADRATIC": _quadratic,
    "EASING": _easing,
    "DIAGONAL": _diagonal,
    "RADIAL": _radial,
    "SPHERICAL": _spherical,
    "QUADRATIC_SPHERE": _quadratic_sphere,
}

OPERATIONS = {"gradient": Operation(_gradient, {"vector": None}, foldable=False)}
