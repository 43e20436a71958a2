# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Noise Texture.

Source: Blender, intern/cycles/kernel/svm/noisetex.h: seeds are offsets of the points, between 100 and 200 along each
axis.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from ..arena import Arena
from ..vecmath import lanes
from .base import Operation, Outputs
from .fractal import Fractal, evaluate
from .hashing import hash_to_unit
from .perlin import BLOCK, signed_noise
from .texture import scaled, vector_of


def _noise(context, inputs, properties):
    arena = context.arena
    fractal = Fractal(
        properties.get("noise_type", "FBM"),
        *(inputs[name] for name in ("detail", "roughness", "lacunarity", "offset", "gain")),
        properties.get("normalize", True),
    )
    p = _points(context, inputs, int(properties.get("noise_dimensions", "3D")[0]))
    if inputs["distortion"].any():
        p = _distorted(p, inputs["distortion"], arena)
    dimension = p.shape[0]

    def color():
        rows = [outputs["fac"]]
        for seed in (dimension, dimension + 1):
            with np.errstate(over="ignore", invalid="ignore"):
                moved = np.add(p, _seed_offset(seed, dimension), out=arena.empty(p.shape))
            rows.append(evaluate(fractal, moved, arena))
        return np.stack(rows, out=arena.empty((3, rows[0].size)))

    outputs = Outputs({"fac": lambda: evaluate(fractal, p, arena), "color": color})
    return outputs


def _points(context, inputs, dimension):
    """Where the noise is evaluated, (D, N): w of one dimension, else the vector and in the fourth w."""
    arena, w, scale = context.arena, inputs["w"], inputs["scale"]
    if dimension == 1:
        return scaled(w.reshape(1, -1), scale, arena)
    vector = vector_of(context, inputs)[: min(dimension, 3)]
    if dimension < 4:
        return scaled(vector, scale, arena)
    out = arena.empty((4, lanes(vector, w, scale)))
    with np.errstate(over="ignore", invalid="ignore"):
        np.multiply(vector, scale, out=out[:3])
        np.multiply(w, scale, out=out[3])
    return out


def _distorted(p, distortion, arena):
    """Points moved by noise, with a seed for each axis."""
    dimension = p.shape[0]
    n = lanes(p, distortion)
    out = arena.empty((dimension, n))
    p = np.broadcast_to(p, out.shape)
    for start in range(0, n, BLOCK):
        block = slice(start, start + BLOCK)
        strength = distortion[block] if distortion.size > 1 else distortion
        for axis, row in enumerate(out[:, block]):
            with arena.frame(), np.errstate(over="ignore", invalid="ignore"):
                moved = arena.empty((dimension, row.size))
                np.add(p[:, block], _seed_offset(axis, dimension), out=moved)
                shift = signed_noise(moved, arena)
                np.multiply(shift, strength, out=shift)
                np.add(p[axis, block], shift, out=row)
    return out


@cache
def _seed_offset(seed, dimension):
    """Offset (D, 1) that stands for a seed."""
    if dimension == 1:
        words = (np.float32([seed]),)
    else:
        words = (np.full(dimension, seed, np.float32), np.arange(dimension, dtype=np.float32))
    return np.float32(100) + np.float32(100) * hash_to_unit(words, Arena(4096)).reshape(-1, 1)


OPERATIONS = {
    "noise": Operation(
        _noise,
        {
            "vector": None,
            "w": 0.0,
            "scale": 5.0,
            "detail": 2.0,
            "roughness": 0.5,
            "lacunarity": 2.0,
            "offset": 0.0,
            "gain": 1.0,
            "distortion": 0.0,
        },
        foldable=False,
    ),
}
