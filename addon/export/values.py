# SPDX-License-Identifier: GPL-3.0-or-later
"""Colour ramps, curves and other settings of nodes that are no plain values, as numbers.

Ramps and curves are sampled as Cycles samples them, so that both show the same steps.

Source: Cycles, `blender/util.h`.
"""

from __future__ import annotations

import numpy as np

_SAMPLES = 257


def color_ramp(node):
    """Properties of a Color Ramp."""
    ramp = node.color_ramp
    samples = np.array([ramp.evaluate(i / (_SAMPLES - 1)) for i in range(_SAMPLES)], np.float32)
    return {"samples": samples.T, "interpolate": ramp.interpolation != "CONSTANT"}


def rgb_curves(node):
    """Properties of RGB Curves: red, green and blue, each of the combined curve."""
    red, green, blue, combined = node.mapping.curves
    return _curves(node.mapping, (red, green, blue), combined)


def vector_curves(node):
    """Properties of Vector Curves."""
    return _curves(node.mapping, tuple(node.mapping.curves)[:3])


def float_curve(node):
    """Properties of a Float Curve."""
    return _curves(node.mapping, (node.mapping.curves[0],))


def direction(node):
    """Properties of a Normal node, which holds its direction in its output."""
    return {"direction": tuple(node.outputs["Normal"].default_value)}


def sun_direction(node):
    """Property of a Sky Texture: where its older models have the sun."""
    return {"sun_direction": tuple(node.sun_direction)}


def _curves(mapping, curves, inner=None):
    """Samples of `curves` from their lowest to their highest point; of `inner` first where there is one."""
    mapping.update()
    points = [p.location[0] for curve in (*curves, *([inner] if inner else [])) for p in curve.points]
    low, high = min(points), max(points)
    # At least from 0 to 1, as in Cycles.
    low, high = min(low, 0.0), max(high, 1.0)
    at = [low + i / (_SAMPLES - 1) * (high - low) for i in range(_SAMPLES)]
    if inner is not None:
        at = [mapping.evaluate(inner, x) for x in at]
    samples = np.array([[mapping.evaluate(curve, x) for x in at] for curve in curves], np.float32)
    return {"samples": samples, "low": low, "high": high, "extrapolate": mapping.extend == "EXTRAPOLATED"}
