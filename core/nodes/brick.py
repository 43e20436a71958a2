# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Brick Texture. Source: Blender, intern/cycles/kernel/svm/brick.h."""

from __future__ import annotations

import numpy as np

from ..vecmath import lanes
from .base import Operation
from .texture import scaled, vector_of

# Rows and bricks are numbered by integers; farther ones share the last number.
_MOST = float(2**30)


def _brick(context, inputs, properties):
    """Fac is 1 in mortar; a brick's colour lies between the two by a tint of its own."""
    arena = context.arena
    p = scaled(vector_of(context, inputs), inputs["scale"], arena)
    n = lanes(p, *(v for name, v in inputs.items() if name != "vector"))
    color, fac = arena.empty((3, n)), arena.empty(n)
    with arena.frame(), np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        row, number, distance = _lay(p, inputs, properties)
        tint = np.clip(_number_noise(row, number) + inputs["bias"], 0, 1)
        fac[:] = _mortar(distance, inputs["mortar_size"], inputs["mortar_smooth"])
        np.subtract(inputs["color2"], inputs["color1"], out=color)
        np.multiply(color, tint, out=color)
        np.add(color, inputs["color1"], out=color)
        difference = np.subtract(inputs["mortar"], color, out=arena.empty((3, n)))
        np.multiply(difference, fac, out=difference)
        np.add(color, difference, out=color)
    return {"color": color, "fac": fac}


def _lay(p, inputs, properties):
    """Number of the row, number of the brick in it, both integral floats, and distance to the brick's edge."""
    x, y, _ = p
    width, height = inputs["brick_width"], inputs["row_height"]
    row = _floor(y / height)
    every_offset, every_squash = properties.get("offset_frequency", 2), properties.get("squash_frequency", 2)
    if every_offset and every_squash:
        is_squashed, is_shifted = np.fmod(row, every_squash) == 0, np.fmod(row, every_offset) == 0
        width = width * np.where(is_squashed, np.float32(properties.get("squash", 1.0)), np.float32(1))
        x = x + width * np.where(is_shifted, np.float32(properties.get("offset", 0.5)), np.float32(0))
    number = _floor(x / width)
    x, y = x - width * number, y - height * row
    return row, number, np.minimum(np.minimum(x, y), np.minimum(width - x, height - y))


def _floor(value):
    return np.clip(np.floor(np.nan_to_num(value, copy=False)), -_MOST, _MOST)


def _number_noise(row, number):
    """A number from 0 to 1 of each brick, from an integer hash."""
    row, number = row.astype(np.int32).view(np.uint32), number.astype(np.int32).view(np.uint32)
    n = (((row << 16) + (number & 0xFFFF)) + 1013) & 0x7FFFFFFF
    n ^= n >> 13
    n = (n * (n * n * 60493 + 19990303) + 1376312589) & 0x7FFFFFFF
    return n.astype(np.float32) * np.float32(2.0**-31)


def _mortar(distance, size, smooth):
    """Share of mortar, 1 at the brick's edge; it falls smoothly to 0 over the share `smooth` of `size`."""
    depth = np.divide(
        distance, size, out=np.ones(np.broadcast_shapes(distance.shape, size.shape), np.float32), where=size != 0
    )
    slope = np.where(smooth != 0, smooth, np.float32(1e-20))
    t = np.clip((1 - depth) / slope, 0, 1)
    return np.where(distance < size, t * t * (3 - 2 * t), np.float32(0))


OPERATIONS = {
    "brick": Operation(
        _brick,
        {
            "vector": None,
            "color1": (0.8,) * 3,
            "color2": (0.2,) * 3,
            "mortar": (0.0,) * 3,
            "scale": 5.0,
            "mortar_size": 0.02,
            "mortar_smooth": 0.1,
            "bias": 0.0,
            "brick_width": 0.5,
            "row_height": 0.25,
        },
        foldable=False,
    ),
}
