# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's RGB Curves, Vector Curves and Float Curve.

A curve is given by equally spaced samples between two numbers, ``low`` and ``high``, as in Cycles.

Source: Blender manual, "RGB Curves Node"; Cycles, `kernel/svm/ramp.h`.
"""

from __future__ import annotations

import numpy as np

from ..vecmath import lanes
from .arithmetic import lerp
from .base import Operation
from .table import Table


def _prepare(properties, diagnostics, place):
    return {
        "table": Table.of(properties["samples"]),
        "low": float(properties.get("low", 0.0)),
        "high": float(properties.get("high", 1.0)),
        "extrapolate": properties.get("extrapolate", True),
    }


def _on_curve(properties, number, value, out):
    """Curve `number` at `value` (N,), into `out` (1, N)."""
    low, reach = properties["low"], properties["high"] - properties["low"]
    np.subtract(value, low, out=out)
    np.divide(out, reach, out=out)
    properties["table"].look_up(out[0], out, number, extrapolate=properties["extrapolate"])


def _float_curve(context, inputs, properties):
    value, t = inputs["value"], inputs["factor"]
    out = context.arena.empty(lanes(value, t))
    with np.errstate(all="ignore"):
        _on_curve(properties, 0, value, out[np.newaxis])
        return {"value": lerp(value, out, t, out)}


def _curves(context, inputs, properties):
    """A curve for each channel."""
    value, t = inputs["value"], inputs["fac"]
    out = context.arena.empty((3, lanes(value, t)))
    with np.errstate(all="ignore"):
        for number, channel in enumerate(value):
            _on_curve(properties, number, channel, out[number : number + 1])
        return {"value": lerp(value, out, t, out)}


# ``samples`` (1 or 3, S); ``low``, ``high``; ``extrapolate`` beyond them by the slope of the outermost samples.
OPERATIONS = {
    "float_curve": Operation(_float_curve, {"factor": 1.0, "value": 1.0}, prepare=_prepare),
    "rgb_curves": Operation(_curves, {"fac": 1.0, "value": (1.0, 1.0, 1.0)}, prepare=_prepare),
    "vector_curves": Operation(_curves, {"fac": 1.0, "value": (0.0, 0.0, 0.0)}, prepare=_prepare),
}
