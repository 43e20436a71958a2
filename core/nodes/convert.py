# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's implicit conversions, and the arithmetic that the compiler itself puts in."""

from __future__ import annotations

import numpy as np

from .base import Operation

# Rec.709 luminance to the digits that Cycles has.
_LUMINANCE = (0.2126729, 0.7151522, 0.0721750)


def luminance_in(working_space):
    """Weights of luminance of colours in a space, given the matrix (9 numbers) to it from Linear Rec.709, or None."""
    if working_space is None:
        return _LUMINANCE
    return tuple(np.linalg.solve(np.reshape(working_space, (3, 3)).T.astype(np.float64), _LUMINANCE).tolist())


def to_dimension(value, dimension, arena, color=True, luminance=_LUMINANCE):
    """`value` as a number (1 row) or a vector (3 rows).

    A vector becomes a number by `luminance` when it is a colour, else by its mean; a number fills a vector.
    """
    if dimension == 3:
        return value if value.ndim == 2 else np.broadcast_to(value, (3, value.shape[-1]))
    if value.ndim == 1:
        return value
    weights = luminance if color else (1 / 3, 1 / 3, 1 / 3)
    out = arena.empty(value.shape[-1])
    with arena.frame():
        t = arena.empty(value.shape[-1])
        np.multiply(value[0], weights[0], out=out)
        for row, weight in zip(value[1:], weights[1:], strict=True):
            np.multiply(row, weight, out=t)
            np.add(out, t, out=out)
    return out


def _convert(context, inputs, properties):
    """What arrives when a link joins sockets of different types.

    Whole numbers are cut towards 0. True are positive numbers, colours of positive luminance and vectors but 0.
    """
    color = properties.get("from", "color") == "color"
    to = properties.get("to", "float")
    if to == "bool" and not color and inputs["value"].ndim == 2:
        return {"value": inputs["value"].any(axis=0).astype(np.float32)}
    luminance, dimension = luminance_in(properties.get("working_space")), 3 if to in ("color", "vector") else 1
    with np.errstate(all="ignore"):
        value = to_dimension(inputs["value"], dimension, context.arena, color, luminance)
        if to == "int":
            value = np.trunc(value, out=context.arena.empty(value.shape))
        elif to == "bool":
            value = np.greater(value, 0, out=context.arena.empty(value.shape))
    return {"value": value}


def _constant(context, inputs, properties):
    return {"color": inputs["value"], "value": inputs["value"]}


def _multiply(context, inputs, properties):
    return {"value": inputs["a"] * inputs["b"]}


def _add(context, inputs, properties):
    return {"value": inputs["a"] + inputs["b"]}


def _clamp(context, inputs, properties):
    return {"value": np.clip(inputs["a"], 0, 1)}


def _complement(context, inputs, properties):
    return {"value": np.float32(1) - inputs["a"]}


OPERATIONS = {
    "convert": Operation(_convert, {"value": None}),
    "rgb": Operation(_constant, {"value": (0.5, 0.5, 0.5)}),
    "value": Operation(_constant, {"value": 0.0}),
    "multiply": Operation(_multiply, {"a": None, "b": None}),
    "add": Operation(_add, {"a": None, "b": None}),
    "clamp": Operation(_clamp, {"a": None}),
    "complement": Operation(_complement, {"a": None}),
}
