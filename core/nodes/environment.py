# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Environment Texture: a picture of all directions.

As in Cycles, the picture repeats in both ways, and colours that are stored by the sRGB transfer function are
interpolated as stored.
"""

from __future__ import annotations

import math
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from ..sampling.color import srgb_to_linear
from .base import Operation
from .texels import MISSING, Texels, is_srgb, read_pixels, to_linear

COLUMNS, ROWS = 1024, 512  # of what light sampling sees of a picture

_READ = WeakKeyDictionary()


class Panorama(NamedTuple):
    """Texels of a picture, its colours times its alpha.

    stored: whether `texels` are by the sRGB transfer function; averaged: at most `COLUMNS` × `ROWS` linear ones.
    """

    texels: Texels
    stored: bool
    averaged: Texels


_NO_IMAGE = Panorama(Texels.of(MISSING[..., :3]), False, Texels.of(MISSING[..., :3]))


def equirectangular(direction, arena):
    """Coordinates u, v (N,) in [0, 1] of directions (3, N) of any length.

    u is 1/2 along +X and falls towards +Y, v rises from -Z to +Z: u = 1/2 - φ/2π, v = 1 - θ/π.
    """
    x, y, z = direction
    u, v = arena.empty(x.shape), arena.empty(x.shape)
    np.arctan2(y, x, out=u)
    np.multiply(u, -0.5 / math.pi, out=u)
    np.add(u, 0.5, out=u)
    # The angle to the pole by its tangent: its cosine is blind near the poles.
    np.hypot(x, y, out=v)
    np.arctan2(v, z, out=v)
    np.multiply(v, -1.0 / math.pi, out=v)
    np.add(v, 1.0, out=v)
    return u, v


def mirror_ball(direction, arena):
    """Coordinates u, v (N,) of directions (3, N) of any length, in the picture of a mirrored ball seen along +Y.

    The ball's normal is halfway between the direction and the way back to the viewer, -Y.
    """
    x, y, z = direction
    u, v = arena.empty(x.shape), arena.empty(x.shape)
    with arena.frame():
        length, half = arena.empty(x.shape), arena.empty(x.shape)
        np.hypot(x, z, out=length)
        np.hypot(length, y, out=length)
        np.subtract(y, length, out=half)
        np.hypot(half, x, out=half)
        np.hypot(half, z, out=half)
        np.maximum(half, 1e-30, out=half)
        np.divide(0.5, half, out=half)
        for out, component in ((u, x), (v, z)):
            np.multiply(component, half, out=out)
            np.add(out, 0.5, out=out)
    return u, v


_PROJECTIONS = {"EQUIRECTANGULAR": equirectangular, "MIRROR_BALL": mirror_ball}


def _prepare(properties, diagnostics, place):
    """Read the picture."""
    interpolation = properties.get("interpolation", "Linear")
    if interpolation == "Cubic":
        diagnostics.warn("cubic interpolation of environment textures is not supported; linear is used", place)
    return {
        "panorama": _panorama(properties.get("image"), diagnostics, place),
        "projection": properties.get("projection", "EQUIRECTANGULAR"),
        "interpolation": interpolation,
    }


def _panorama(image, diagnostics, place):
    """`Panorama` of an image, read once however many nodes use it."""
    known = _READ.get(image) if image is not None else None
    if known is None:
        pixels = read_pixels(image, diagnostics, place)
        np.multiply(pixels[..., :3], pixels[..., 3:], out=pixels[..., :3])
        if image is None:
            return _NO_IMAGE
        texels = Texels.of(pixels[..., :3])
        pixels = to_linear(pixels, image, diagnostics, place)
        linear = Texels.of(pixels[..., :3]) if is_srgb(image) else texels
        known = _READ[image] = Panorama(texels, is_srgb(image), linear.averaged(COLUMNS, ROWS))
    return known


def _environment(context, inputs, properties):
    arena = context.arena
    color = arena.empty((3, context.count))
    with arena.frame():
        vector = np.broadcast_to(inputs.get("vector", np.zeros((3, 1), np.float32)), (3, context.count))
        u, v = _PROJECTIONS[properties["projection"]](vector, arena)
        panorama = properties["panorama"]
        texels = panorama.averaged if context.averaged else panorama.texels
        texels.look_up(u, v, properties["interpolation"], "REPEAT", arena, color)
        if panorama.stored and not context.averaged:
            color[:] = srgb_to_linear(color)
    return {"color": color}


OPERATIONS = {
    "environment": Operation(
        _environment,
        {"vector": None},
        foldable=False,
        prepare=_prepare,
        unsupported={"vector": "an environment texture on a surface needs coordinates; one colour of it is shown"},
    )
}
