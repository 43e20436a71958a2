# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Vector Math node: one operation for each of its functions, ``vector_math_add`` and so on.

Those that give a number have the output ``"value"``, the others ``"vector"``.

Source: Blender manual, "Vector Math Node"; Cycles, `kernel/svm/math_util.h`.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from ..vecmath import cross, dot, lanes, normalize
from . import arithmetic
from .base import Operation

_ZERO = (0.0, 0.0, 0.0)


def _round(a, out):
    """The nearest whole number, of two the one away from 0."""
    np.abs(a, out=out)
    arithmetic.round_half_up(out, out)
    np.copysign(out, a, out=out)


_COMPONENTWISE = {
    "add": (np.add, "ab"),
    "subtract": (np.subtract, "ab"),
    "multiply": (np.multiply, "ab"),
    "divide": (arithmetic.divide, "ab"),
    "multiply_add": (arithmetic.multiply_add, "abc"),
    "absolute": (np.abs, "a"),
    "power": (arithmetic.power, "ab"),
    "sign": (np.sign, "a"),
    "minimum": (np.minimum, "ab"),
    "maximum": (np.maximum, "ab"),
    "round": (_round, "a"),
    "floor": (np.floor, "a"),
    "ceil": (np.ceil, "a"),
    "fraction": (arithmetic.fraction, "a"),
    "modulo": (arithmetic.modulo, "ab"),
    "wrap": (arithmetic.wrap, "abc"),
    "snap": (arithmetic.snap, "ab"),
    "sine": (np.sin, "a"),
    "cosine": (np.cos, "a"),
    "tangent": (np.tan, "a"),
}


def _by_component(function, context, inputs, properties):
    values = inputs.values()
    out = context.arena.empty((3, lanes(*values)))
    with np.errstate(all="ignore"):
        function(*values, out=out)
    return {"vector": out}


def _cross_product(context, inputs, properties):
    with np.errstate(all="ignore"):
        return {"vector": cross(inputs["a"], inputs["b"], context.arena)}


def _project(context, inputs, properties):
    """`a` along `b`; 0 where `b` is 0."""
    a, b, arena = inputs["a"], inputs["b"], context.arena
    share = arena.empty(lanes(a, b))
    with np.errstate(all="ignore"):
        arithmetic.divide(dot(a, b, arena), dot(b, b, arena), share)
        return {"vector": np.multiply(b, share, out=arena.empty((3, share.size)))}


def _reflect(context, inputs, properties):
    """`a` mirrored at the plane of normal `b`."""
    a, arena = inputs["a"], context.arena
    with np.errstate(all="ignore"):
        n = normalize(inputs["b"], arena)
        out = np.multiply(n, dot(a, n, arena) * -2, out=arena.empty((3, lanes(a, n))))
        return {"vector": np.add(out, a, out=out)}


def _refract(context, inputs, properties):
    """`a` bent at the plane of normal `b` by the ratio of indices `scale`; 0 where it is wholly reflected."""
    a, eta, arena = inputs["a"], inputs["scale"], context.arena
    with np.errstate(all="ignore"):
        n = normalize(inputs["b"], arena)
        cosine = dot(a, n, arena)
        k = 1 - eta * eta * (1 - cosine * cosine)
        out = np.multiply(n, eta * cosine + np.sqrt(k), out=arena.empty((3, k.size)))
        np.subtract(a * eta, out, out=out)
        np.copyto(out, 0, where=k < 0)
    return {"vector": out}


def _face_forward(context, inputs, properties):
    """`a`, turned round where `b` and `c` point to the same side."""
    a, arena = inputs["a"], context.arena
    with np.errstate(all="ignore"):
        behind = dot(inputs["c"], inputs["b"], arena) < 0
        return {"vector": np.multiply(a, np.where(behind, 1, -1).astype(np.float32))}


def _scale(context, inputs, properties):
    a, factor = inputs["a"], inputs["scale"]
    with np.errstate(all="ignore"):
        return {"vector": np.multiply(a, factor, out=context.arena.empty((3, lanes(a, factor))))}


def _normalize(context, inputs, properties):
    with np.errstate(all="ignore"):
        return {"vector": normalize(inputs["a"], context.arena)}


def _dot_product(context, inputs, properties):
    with np.errstate(all="ignore"):
        return {"value": dot(inputs["a"], inputs["b"], context.arena)}


def _length_of(v, arena):
    square = dot(v, v, arena)
    return {"value": np.sqrt(square, out=square)}


def _distance(context, inputs, properties):
    with np.errstate(all="ignore"):
        return _length_of(inputs["a"] - inputs["b"], context.arena)


def _length(context, inputs, properties):
    with np.errstate(all="ignore"):
        return _length_of(inputs["a"], context.arena)


_OTHERS = {
    "cross_product": (_cross_product, "ab"),
    "project": (_project, "ab"),
    "reflect": (_reflect, "ab"),
    "faceforward": (_face_forward, "abc"),
    "dot_product": (_dot_product, "ab"),
    "distance": (_distance, "ab"),
    "length": (_length, "a"),
    "normalize": (_normalize, "a"),
}

OPERATIONS = {
    f"vector_math_{name}": Operation(run, dict.fromkeys(names, _ZERO))
    for name, (run, names) in (
        {n: (partial(_by_component, f), names) for n, (f, names) in _COMPONENTWISE.items()} | _OTHERS
    ).items()
} | {
    "vector_math_refract": Operation(_refract, {"a": _ZERO, "b": _ZERO, "scale": 1.0}),
    "vector_math_scale": Operation(_scale, {"a": _ZERO, "scale": 1.0}),
}
