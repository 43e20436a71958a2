# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Magic Texture: sines of sines. Source: Blender, intern/cycles/kernel/svm/magic.h."""

from __future__ import annotations

import math

import numpy as np

from ..vecmath import lanes
from .base import Operation, Outputs
from .texture import vector_of

# What each level of depth computes: the coordinate replaced, the signs of x, y and z, the function, its sign.
_LEVELS = (
    ("y", (1, -1, 1), np.cos, -1),
    ("x", (1, -1, -1), np.cos, 1),
    ("z", (-1, -1, -1), np.sin, 1),
    ("x", (-1, 1, -1), np.cos, -1),
    ("y", (-1, 1, 1), np.sin, -1),
    ("y", (-1, 1, 1), np.cos, -1),
    ("x", (1, 1, 1), np.cos, 1),
    ("z", (1, 1, -1), np.sin, 1),
    ("x", (-1, -1, 1), np.cos, -1),
    ("y", (1, -1, 1), np.sin, -1),
)
_FIRST = (((1, 1, 1), np.sin, 1), ((-1, 1, -1), np.cos, 1), ((-1, -1, 1), np.cos, -1))


def _magic(context, inputs, properties):
    arena, distortion = context.arena, inputs["distortion"]
    depth = int(properties.get("turbulence_depth", 2))
    vector, scale = vector_of(context, inputs), inputs["scale"]
    n = lanes(vector, scale, distortion)

    def color():
        out = arena.empty((3, n))
        x, y, z = out
        with arena.frame(), np.errstate(over="ignore", invalid="ignore"):
            _start(vector, scale, out, arena)
            if depth > 0:
                np.multiply(out, distortion, out=out)
            t = arena.empty(n)
            for axis, signs, function, sign in _LEVELS[:depth]:
                _signed_sum(signs, (x, y, z), t)
                row = out["xyz".index(axis)]
                function(t, out=row)
                np.multiply(row, sign * distortion, out=row)
            twice = np.where(distortion != 0, 2 * distortion, np.float32(1))
            np.divide(out, twice, out=out)
            np.subtract(0.5, out, out=out)
        return out

    def fac():
        out = arena.empty(n)
        np.add(outputs["color"][0], outputs["color"][1], out=out)
        np.add(out, outputs["color"][2], out=out)
        return np.multiply(out, 1 / 3, out=out)

    outputs = Outputs({"color": color, "fac": fac})
    return outputs


def _start(vector, scale, out, arena):
    """The three sines that the levels start from. Coordinates are reduced first, so that large ones keep precision."""
    with arena.frame():
        p = arena.empty(vector.shape)
        np.fmod(vector, np.float32(2 * math.pi), out=p)
        for row, (signs, function, sign) in zip(out, _FIRST, strict=True):
            _signed_sum(signs, p, row)
            np.multiply(row, 5 * scale, out=row)
            function(row, out=row)
            np.multiply(row, sign, out=row)


def _signed_sum(signs, rows, out):
    """Sum of three rows, each with its sign."""
    (first, second, third), (x, y, z) = signs, rows
    np.multiply(x, first, out=out)
    (np.add if second > 0 else np.subtract)(out, y, out=out)
    (np.add if third > 0 else np.subtract)(out, z, out=out)


OPERATIONS = {"magic": Operation(_magic, {"vector": None, "scale": 5.0, "distortion": 1.0}, foldable=False)}
