# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Wave Texture. Source: Blender, intern/cycles/kernel/svm/wave.h."""

from __future__ import annotations

import math

import numpy as np

from ..vecmath import lanes
from .base import Operation, Outputs
from .fractal import Fractal, evaluate
from .texture import grey, scaled, vector_of

_AXES = {"X": (0,), "Y": (1,), "Z": (2,), "DIAGONAL": (0, 1, 2)}
_AROUND = {"X": (1, 2), "Y": (0, 2), "Z": (0, 1), "SPHERICAL": (0, 1, 2)}


def _wave(context, inputs, properties):
    arena = context.arena
    p = scaled(vector_of(context, inputs), inputs["scale"], arena)
    # Blender's nudge off whole numbers, where profiles jump.
    np.add(p, 1e-6, out=p)
    np.multiply(p, 0.999999, out=p)
    numbers = [inputs[name] for name in ("distortion", "phase_offset", "detail", "detail_scale", "detail_roughness")]
    n = lanes(p, *numbers)

    def fac():
        out = arena.empty(n)
        with arena.frame(), np.errstate(over="ignore", invalid="ignore"):
            phase = _phase(p, n, properties, arena)
            np.add(phase, inputs["phase_offset"], out=phase)
            if inputs["distortion"].any():
                np.add(phase, _distortion(p, inputs, arena), out=phase)
            _profile(phase, properties.get("wave_profile", "SIN"), out)
        return out

    outputs = Outputs({"fac": fac, "color": lambda: grey(outputs["fac"])})
    return outputs


def _phase(p, n, properties, arena):
    """Phase (n,), rad: 20 for each unit of length, along a direction or away from an axis or the origin."""
    phase = arena.zeros(n)
    if properties.get("wave_type", "BANDS") == "BANDS":
        axes = _AXES[properties.get("bands_direction", "X")]
        for axis in axes:
            np.add(phase, p[axis], out=phase)
        return np.multiply(phase, 20 if len(axes) == 1 else 10, out=phase)
    with arena.frame():
        t = arena.empty(p.shape[-1])
        for axis in _AROUND[properties.get("rings_direction", "X")]:
            np.add(phase, np.multiply(p[axis], p[axis], out=t), out=phase)
    np.sqrt(phase, out=phase)
    return np.multiply(phase, 20, out=phase)


def _distortion(p, inputs, arena):
    fractal = Fractal("FBM", inputs["detail"], inputs["detail_roughness"], np.float32([2]))
    noise = evaluate(fractal, scaled(p, inputs["detail_scale"], arena), arena)
    np.multiply(noise, 2, out=noise)
    np.subtract(noise, 1, out=noise)
    out = arena.empty(lanes(noise, inputs["distortion"]))
    return np.multiply(noise, inputs["distortion"], out=out)


def _profile(phase, profile, out):
    """Height from 0 to 1 at `phase`, which is overwritten."""
    if profile == "SIN":
        np.subtract(phase, math.pi / 2, out=phase)
        np.sin(phase, out=out)
        np.multiply(out, 0.5, out=out)
        np.add(out, 0.5, out=out)
        return
    np.divide(phase, 2 * math.pi, out=phase)
    triangular = profile == "TRI"
    np.add(phase, 0.5 if triangular else 0, out=out)
    np.floor(out, out=out)
    np.subtract(phase, out, out=out)
    if triangular:
        np.abs(out, out=out)
        np.multiply(out, 2, out=out)


OPERATIONS = {
    "wave": Operation(
        _wave,
        {
            "vector": None,
            "scale": 5.0,
            "distortion": 0.0,
            "detail": 2.0,
            "detail_scale": 1.0,
            "detail_roughness": 0.5,
            "phase_offset": 0.0,
        },
        foldable=False,
    ),
}
