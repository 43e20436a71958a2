# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Mix node, one operation for each type of data, and the older Mix Color.

Source: Blender manual, "Mix Node"; Cycles, `kernel/svm/mix.h`.
"""

from __future__ import annotations

import numpy as np

from ..vecmath import lanes
from .arithmetic import lerp, saturate
from .base import Operation
from .blend import BLEND


def _factor(inputs, properties):
    t = inputs["factor"]
    return saturate(t, np.zeros_like(t)) if properties.get("clamp_factor", True) else t


def _mix_number(context, inputs, properties):
    a, b = inputs["a"], inputs["b"]
    with np.errstate(all="ignore"):
        t = _factor(inputs, properties)
        return {"result": lerp(a, b, t, context.arena.empty(lanes(a, b, t)))}


def _mix_vector(context, inputs, properties):
    a, b = inputs["a"], inputs["b"]
    with np.errstate(all="ignore"):
        t = _factor(inputs, properties)
        return {"result": lerp(a, b, t, context.arena.empty((3, lanes(a, b, t))))}


def _mix_color(context, inputs, properties):
    """Two colours blended in the way of ``blend_type``."""
    a, b = inputs["a"], inputs["b"]
    with np.errstate(all="ignore"):
        t = _factor(inputs, properties)
        kind = properties.get("blend_type", "MIX")
        if kind == "MIX":  # by far the most frequent
            out = lerp(a, b, t, context.arena.empty((3, lanes(a, b, t))))
        else:
            out = BLEND[kind](t, a, b)
        if properties.get("clamp_result"):
            saturate(out, out)
    return {"result": out}


def _prepare(properties, diagnostics, place):
    kind = properties.get("blend_type", "MIX")
    if kind not in BLEND:
        diagnostics.warn(f"blend mode {kind} is not supported; the colours are mixed", place)
        kind = "MIX"
    clamps = {name: properties[name] for name in ("clamp_factor", "clamp_result") if name in properties}
    return {"blend_type": kind} | clamps


_GREY, _ZERO = (0.5, 0.5, 0.5), (0.0, 0.0, 0.0)

OPERATIONS = {
    "mix_float": Operation(_mix_number, {"factor": 0.5, "a": 0.0, "b": 0.0}),
    # The factor of a vector is one number or three; a number fills a vector.
    "mix_vector": Operation(_mix_vector, {"factor": _GREY, "a": _ZERO, "b": _ZERO}),
    "mix_rgba": Operation(_mix_color, {"factor": 0.5, "a": _GREY, "b": _GREY}, prepare=_prepare),
}
