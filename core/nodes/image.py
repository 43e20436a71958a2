# SPDX-License-Identifier: GPL-3.0-or-later
"""Image textures on a surface's coordinates."""

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np

from .base import Operation
from .coordinates import lookup_uv
from .texels import MISSING, Texels, read_pixels, to_linear

_READ = WeakKeyDictionary()
_NO_IMAGE = Texels.of(MISSING)


def _prepare(properties, diagnostics, place):
    """Read the pixels into texels of linear values."""
    projection = properties.get("projection", "FLAT")
    if projection != "FLAT":
        diagnostics.warn(f"image projection {projection} is not supported; flat is used", place)
    return {
        "texels": _texels(properties.get("image"), diagnostics, place),
        "interpolation": properties.get("interpolation", "Linear"),
        "extension": properties.get("extension", "REPEAT"),
    }


def _texels(image, diagnostics, place):
    """Texels of an image, read once however many nodes use it."""
    known = _READ.get(image) if image is not None else None
    if known is None:
        pixels = to_linear(read_pixels(image, diagnostics, place), image, diagnostics, place)
        known = _NO_IMAGE if image is None else Texels.of(pixels)
        if image is not None:
            _READ[image] = known
    return known


def _image(context, inputs, properties):
    arena = context.arena
    vector = inputs["vector"] if "vector" in inputs else lookup_uv(context, "")
    vector = np.broadcast_to(vector, (3, context.count))
    rgba = arena.empty((4, context.count))
    extension = properties["extension"]
    properties["texels"].look_up(vector[0], vector[1], properties["interpolation"], extension, arena, rgba)
    if extension == "CLIP":
        with arena.frame():
            inside = (vector[0] >= 0) & (vector[0] < 1) & (vector[1] >= 0) & (vector[1] < 1)
            np.multiply(rgba, inside, out=rgba)
    return {"color": rgba[:3], "alpha": rgba[3]}


OPERATIONS = {"image": Operation(_image, {"vector": None}, foldable=False, prepare=_prepare)}
