# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Gabor Texture: waves in small windows, eight in each cell of a grid.

Sources: A. Lagae et al., "Procedural Noise using Sparse Gabor Convolution" (2009); V. Tavernier et al., "Making Gabor
Noise Fast and Normalized" (2019); T. Tricard et al., "Procedural Phasor Noise" (2019), for phase and intensity; the
window, the random numbers and the scale are Blender's (intern/cycles/kernel/svm/gabor.h).
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from ..vecmath import lanes
from .base import Operation, Outputs
from .hashing import hash_to_unit
from .texture import scaled, vector_of

_BLOCK = 16384
_IMPULSES = 8
# Six standard deviations of the noise, by dimension.
_RANGE = {2: 6 * math.sqrt(_IMPULSES * 0.5 * 0.25), 3: 6 * math.sqrt(_IMPULSES * 0.5 / (4 * math.sqrt(2)))}
# Order in which a second and third number are hashed from the same words.
_TURNED = {2: ((2, 0, 1),), 3: ((2, 0, 3, 1), (3, 2, 1, 0))}


def _gabor(context, inputs, properties):
    arena = context.arena
    dimension = int(properties.get("gabor_type", "2D")[0])
    p = scaled(vector_of(context, inputs)[:dimension], inputs["scale"], arena)
    p = np.where(np.isfinite(p), p, np.float32(0))
    waves = _Waves(
        np.fmax(inputs["frequency"], np.float32(0.001)),
        np.float32(1) - np.clip(np.nan_to_num(inputs["anisotropy"]), 0, 1),
        _angles(inputs["orientation_2d"] if dimension == 2 else inputs["orientation_3d"]),
    )
    phasor = _phasor(p, waves, arena)
    real, imaginary = phasor
    return Outputs(
        {
            "value": lambda: imaginary * np.float32(0.5 / _RANGE[dimension]) + np.float32(0.5),
            "phase": lambda: (np.arctan2(imaginary, real) + np.float32(math.pi)) * np.float32(0.5 / math.pi),
            "intensity": lambda: np.hypot(real, imaginary) * np.float32(1 / _RANGE[dimension]),
        }
    )


@dataclass
class _Waves:
    """Of the waves: frequency and isotropy (N,) or (1,), angles of the direction (D - 1, N) or (D - 1, 1)."""

    frequency: np.ndarray
    isotropy: np.ndarray
    angles: np.ndarray

    def at(self, chosen):
        """The same of some of the lanes."""
        return _Waves(*(a[..., chosen] if a.shape[-1] > 1 else a for a in vars(self).values()))

    def vectors(self, turns):
        """Frequency vectors (D, N) of waves turned by `turns` (D - 1, N), in half circles; None turns nothing."""
        angles = self.angles if turns is None else self.angles + turns * (self.isotropy * np.float32(math.pi))
        if len(angles) == 1:
            return self.frequency * np.stack([np.cos(angles[0]), np.sin(angles[0])])
        inclination, azimuth = angles
        across = np.sin(inclination)
        direction = [across * np.cos(azimuth), across * np.sin(azimuth), np.cos(inclination)]
        return self.frequency * np.stack(direction)


def _angles(orientation):
    """Angles (D - 1, N) of an orientation: an angle (N,) as it is, a vector (3, N) as inclination and azimuth."""
    if orientation.ndim == 1:
        return orientation.reshape(1, -1)
    x, y, z = np.nan_to_num(orientation)
    return np.stack([np.arctan2(np.hypot(x, y), z), np.arctan2(y, x)])


def _phasor(p, waves, arena):
    """Sum of the waves at `p` (D, N) as cosine and sine parts, (2, N)."""
    n = lanes(p, *vars(waves).values())
    p = np.broadcast_to(p, (len(p), n))
    out = arena.zeros((2, n))
    for start in range(0, n, _BLOCK):
        block = slice(start, min(start + _BLOCK, n))
        with arena.frame():
            _add_waves(p[:, block], waves.at(block), out[:, block], arena)
    return out


def _add_waves(p, waves, out, arena):
    """Add the waves of each lane's cell and of its neighbours.

    Impulses of a box of few cells are drawn once and looked up, else each lane draws those of its own cells.
    """
    dimension = len(p)
    corner = np.floor(p)
    place = p - corner
    turns = bool(waves.isotropy.any())
    size = corner.max(axis=1).astype(np.float64) - corner.min(axis=1) + 3
    is_small = size.prod() <= corner.shape[1]
    index = np.arange(corner.shape[1])
    if is_small:
        low, size = corner.min(axis=1, keepdims=True) - 1, size.astype(np.intp)
        table = _impulses(np.indices(size).reshape(dimension, -1).astype(np.float32) + low, turns, arena)
        strides = np.append(np.cumprod(size[:0:-1])[::-1], 1)
        index = strides @ (corner - low).astype(np.intp)
    for step in itertools.product((-1, 0, 1), repeat=dimension):
        shift = np.float32(step).reshape(-1, 1)
        with arena.frame():
            impulses = table if is_small else _impulses(corner + shift, turns, arena)
            cells = index + strides @ np.array(step) if is_small else index
            here = place - shift
            for impulse in impulses:
                with arena.frame():
                    _add_wave(impulse, cells, here, waves, out, arena)


def _impulses(cells, turns, arena):
    """Tables (8, C, U) of the impulses of `cells`: centre in the cell, weight ±1/2, and turns where asked for."""
    dimension, count = cells.shape
    out = arena.empty((_IMPULSES, dimension + 1 + (dimension - 1 if turns else 0), count))
    seeds = 3 * np.arange(_IMPULSES, dtype=np.float32).reshape(-1, 1)
    with arena.frame():
        for k, words in enumerate(_orders([*cells, seeds + 1], dimension)):
            out[:, k] = hash_to_unit(words, arena)
        out[:, dimension] = np.where(hash_to_unit([*cells, seeds + 2], arena) < 0.5, -0.5, 0.5)
        for k, words in enumerate(_orders([*cells, seeds], dimension - 1)[: dimension - 1 if turns else 0]):
            out[:, dimension + 1 + k] = hash_to_unit(words, arena)
    if turns and dimension == 2:
        out[:, 3] -= 0.5
    return out


def _orders(words, count):
    """`words` in the orders whose hashes are `count` numbers."""
    orders = (range(len(words)), *_TURNED[len(words) - 1])
    return [[words[i] for i in order] for order in orders[:count]]


def _add_wave(row, index, place, waves, out, arena):
    """Add one impulse of each lane's cell, whose table is `row` (C, U), where the lane is within its window."""
    dimension = len(place)
    away = arena.take(row[:dimension], index)
    np.subtract(place, away, out=away)
    squared = _dot(away, away, arena)
    near = np.flatnonzero(np.less(squared, 1, out=arena.empty(squared.size, np.bool_)))
    if not near.size:
        return
    away, squared, index = arena.take(away, near), arena.take(squared, near), arena.take(index, near)
    turns = arena.take(row[dimension + 1 :], index) if len(row) > dimension + 1 else None
    angle = _dot(away, waves.at(near).vectors(turns), arena)
    np.multiply(angle, 2 * math.pi, out=angle)
    # The envelope is a Gaussian in the window of a cosine.
    np.multiply(squared, -math.pi, out=squared)
    envelope = np.cos(squared, out=arena.empty(near.size))
    np.add(envelope, 1, out=envelope)
    np.multiply(envelope, np.exp(squared, out=squared), out=envelope)
    np.multiply(envelope, arena.take(row[dimension], index), out=envelope)
    for total, part in zip(out, (np.cos, np.sin), strict=True):
        total[near] += np.multiply(part(angle, out=squared), envelope, out=squared)


def _dot(a, b, arena):
    """Dot product of vectors (D, N), where `b` may be (D, 1)."""
    out, t = arena.empty(a.shape[1]), arena.empty(a.shape[1])
    np.multiply(a[0], b[0], out=out)
    for x, y in zip(a[1:], b[1:], strict=True):
        np.add(out, np.multiply(x, y, out=t), out=out)
    return out


OPERATIONS = {
    "gabor": Operation(
        _gabor,
        {
            "vector": None,
            "scale": 5.0,
            "frequency": 2.0,
            "anisotropy": 1.0,
            "orientation_2d": math.pi / 4,
            "orientation_3d": (math.sqrt(2), math.sqrt(2), 0.0),
        },
        foldable=False,
    ),
}
