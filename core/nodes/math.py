# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Math node: one operation for each of its functions, ``math_add`` and so on.

Source: Blender manual, "Math Node"; Cycles, `kernel/svm/math_util.h`.
"""

from __future__ import annotations

from functools import partial
from math import pi

import numpy as np

from ..vecmath import lanes
from . import arithmetic
from .base import Operation

_EPSILON = float(np.finfo(np.float32).eps)


def _logarithm(a, base, out):
    """Logarithm of `a`; 0 where `a` or `base` has none."""
    np.log(a, out=out)
    of_base = np.log(base)
    np.divide(out, of_base, out=out)
    np.copyto(out, 0, where=(a <= 0) | (base <= 0) | (of_base == 0))


def _square_root(a, out):
    np.maximum(a, 0, out=out)
    np.sqrt(out, out=out)


def _inverse_square_root(a, out):
    np.sqrt(a, out=out)
    np.divide(1, out, out=out)
    np.copyto(out, 0, where=~(a > 0))


def _compare(a, b, apart, out):
    """1 where `a` and `b` are `apart` at most."""
    np.subtract(a, b, out=out)
    np.abs(out, out=out)
    np.copyto(out, (out <= np.maximum(apart, _EPSILON)) | (a == b))


def _smooth_minimum(a, b, distance, out):
    """The lower of two, rounded where they are nearer than `distance`: Inigo Quilez' cubic polynomial."""
    near = np.maximum(distance - np.abs(a - b), 0)
    np.divide(near, distance, out=out)
    np.multiply(out * out * out, distance, out=out)
    np.multiply(out, 1 / 6, out=out)
    np.copyto(out, 0, where=distance == 0)
    np.subtract(np.minimum(a, b), out, out=out)


def _smooth_maximum(a, b, distance, out):
    _smooth_minimum(-a, -b, distance, out)
    np.negative(out, out=out)


def _ping_pong(a, reach, out):
    """To `reach` and back to 0."""
    np.subtract(a, reach, out=out)
    np.divide(out, reach * 2, out=out)
    np.subtract(out, np.floor(out), out=out)
    np.multiply(out, reach * 2, out=out)
    np.subtract(out, reach, out=out)
    np.abs(out, out=out)
    np.copyto(out, 0, where=reach == 0)


def _arc(function, a, out):
    np.clip(a, -1, 1, out=out)
    function(out, out=out)


def _scaled(factor, a, out):
    np.multiply(a, factor, out=out)


_UNARY = {
    "sqrt": _square_root,
    "inverse_sqrt": _inverse_square_root,
    "absolute": np.abs,
    "exponent": np.exp,
    "sign": np.sign,
    "round": arithmetic.round_half_up,
    "floor": np.floor,
    "ceil": np.ceil,
    "trunc": np.trunc,
    "fract": arithmetic.fraction,
    "sine": np.sin,
    "cosine": np.cos,
    "tangent": np.tan,
    "arcsine": partial(_arc, np.arcsin),
    "arccosine": partial(_arc, np.arccos),
    "arctangent": np.arctan,
    "sinh": np.sinh,
    "cosh": np.cosh,
    "tanh": np.tanh,
    "radians": partial(_scaled, pi / 180),
    "degrees": partial(_scaled, 180 / pi),
}
_BINARY = {
    "add": np.add,
    "subtract": np.subtract,
    "multiply": np.multiply,
    "divide": arithmetic.divide,
    "power": arithmetic.power,
    "logarithm": _logarithm,
    "minimum": np.minimum,
    "maximum": np.maximum,
    "less_than": np.less,
    "greater_than": np.greater,
    "modulo": arithmetic.modulo,
    "floored_modulo": arithmetic.floored_modulo,
    "snap": arithmetic.snap,
    "pingpong": _ping_pong,
    "arctan2": np.arctan2,
}
_TERNARY = {
    "multiply_add": arithmetic.multiply_add,
    "compare": _compare,
    "smooth_min": _smooth_minimum,
    "smooth_max": _smooth_maximum,
    "wrap": arithmetic.wrap,
}


def _run(function, context, inputs, properties):
    """`function` of the inputs in their order."""
    values = inputs.values()
    out = context.arena.empty(lanes(*values))
    with np.errstate(all="ignore"):
        function(*values, out=out)
        if properties.get("use_clamp"):
            arithmetic.saturate(out, out)
    return {"value": out}


OPERATIONS = {
    f"math_{name}": Operation(partial(_run, function), dict.fromkeys(names, 0.5))
    for functions, names in ((_UNARY, "a"), (_BINARY, "ab"), (_TERNARY, "abc"))
    for name, function in functions.items()
}
