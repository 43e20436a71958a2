# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Map Range node, for numbers and for vectors.

Source: Blender manual, "Map Range Node"; Cycles, `kernel/svm/map_range.h`.
"""

from __future__ import annotations

import numpy as np

from ..vecmath import lanes
from .arithmetic import divide, lerp
from .base import Operation


def _smooth(t):
    return t * t * (3 - 2 * t)


def _smoother(t):
    return t * t * t * (t * (t * 6 - 15) + 10)


_SMOOTH = {"SMOOTHSTEP": _smooth, "SMOOTHERSTEP": _smoother}


def _share(inputs, kind, out):
    """How far the value is from ``from_min`` to ``from_max``, 0 where these are equal, into `out`."""
    low = inputs["from_min"]
    divide(inputs["value"] - low, inputs["from_max"] - low, out)
    if kind == "STEPPED":
        steps = inputs["steps"]
        np.floor(out * (steps + 1), out=out)
        np.divide(out, steps, out=out)
        np.copyto(out, 0, where=~(steps > 0))
    elif kind in _SMOOTH:
        np.fmax(out, 0, out=out)
        np.minimum(out, 1, out=out)
        np.copyto(out, _SMOOTH[kind](out))
    return out


def _mapped(inputs, properties, out):
    """The value moved from one range to another, into `out`: an empty one maps numbers to 0, vectors to ``to_min``."""
    kind = properties.get("interpolation_type", "LINEAR")
    low, high = inputs["to_min"], inputs["to_max"]
    with np.errstate(all="ignore"):
        _share(inputs, kind, out)
        lerp(low, high, out.copy(), out)
        if out.ndim == 1:
            np.copyto(out, 0, where=inputs["from_min"] == inputs["from_max"])
        if properties.get("clamp", True):
            np.clip(out, np.minimum(low, high), np.maximum(low, high), out=out)
    return out


def _map_number(context, inputs, properties):
    return {"result": _mapped(inputs, properties, context.arena.empty(lanes(*inputs.values())))}


def _map_vector(context, inputs, properties):
    return {"vector": _mapped(inputs, properties, context.arena.empty((3, lanes(*inputs.values()))))}


def _vectors(**values):
    return {name: (value,) * 3 for name, value in values.items()}


_RANGE = {"from_min": 0.0, "from_max": 1.0, "to_min": 0.0, "to_max": 1.0, "steps": 4.0}

OPERATIONS = {
    "map_range_float": Operation(_map_number, {"value": 1.0} | _RANGE),
    "map_range_float_vector": Operation(_map_vector, _vectors(value=0.0, **_RANGE)),
}
