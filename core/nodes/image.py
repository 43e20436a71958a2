# SPDX-License-Identifier: GPL-3.0-or-later
"""Image textures on a surface's coordinates."""

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np

from ..sampling.color import srgb_to_linear
from .base import Operation
from .coordinates import lookup_uv

_READ = WeakKeyDictionary()
_MISSING = np.array([[[1.0, 0.0, 1.0, 1.0]]], np.float32)  # Blender's magenta


def _prepare(properties, diagnostics, place):
    """Read the pixels into a table (C, H·W) of linear values."""
    projection = properties.get("projection", "FLAT")
    if projection != "FLAT":
        diagnostics.warn(f"image projection {projection} is not supported; flat is used", place)
    texels, width, height = _texels(properties.get("image"), diagnostics, place)
    return {
        "texels": texels,
        "width": width,
        "height": height,
        "interpolation": properties.get("interpolation", "Linear"),
        "extension": properties.get("extension", "REPEAT"),
    }


def _texels(image, diagnostics, place):
    """Texels (4, H·W), width and height of an image, read once however many nodes use it."""
    known = _READ.get(image) if image is not None else None
    if known is None:
        pixels = _read(image, diagnostics, place)
        height, width = pixels.shape[:2]
        known = np.ascontiguousarray(pixels.reshape(-1, 4).T), width, height
        if image is not None:
            _READ[image] = known
    return known


def _read(image, diagnostics, place):
    if image is None:
        diagnostics.warn("an image texture has no image; choose one in the node", place)
        return _MISSING
    pixels = image.pixels
    if pixels is None:
        pixels = read_file(image.filepath) if image.filepath else None
    if pixels is None or 0 in pixels.shape:
        diagnostics.warn(f"image '{image.name}' cannot be read; magenta is shown, as in Blender", place)
        return _MISSING
    if pixels.dtype == np.uint8:
        pixels = pixels.astype(np.float32) / np.float32(255)
    else:
        pixels = np.array(pixels, np.float32)
    if not np.isfinite(pixels).all():
        diagnostics.warn(f"image '{image.name}' has non-finite texels; they are set to zero", place)
        pixels = np.nan_to_num(pixels, nan=0.0, posinf=0.0, neginf=0.0)
    return to_linear(pixels, image.colorspace, image.name, diagnostics, place)


def read_file(path):
    """Pixels (H, W, 4) float32 of an image file, row 0 at the bottom; None when it cannot be read."""
    import OpenImageIO as oiio

    # Alpha stays as stored, apart from the colour: what is converted to linear is not yet multiplied by it.
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    source = oiio.ImageInput.open(path, config)
    if source is None:
        oiio.geterror()  # else OpenImageIO prints it when the program ends
        return None
    pixels = source.read_image(oiio.FLOAT)
    source.close()
    if pixels is None:
        return None
    out = np.ones((*pixels.shape[:2], 4), np.float32)
    channels = pixels.shape[2]
    if channels < 3:
        out[..., :3] = pixels[..., :1]
        if channels == 2:
            out[..., 3] = pixels[..., 1]
    else:
        out[..., : min(channels, 4)] = pixels[..., :4]
    return out[::-1]


def to_linear(pixels, colorspace, name, diagnostics, place):
    """Scene-linear values of stored ones, by Blender's name of their colour space."""
    if colorspace in ("sRGB", "sRGB IEC61966-2.1", ""):
        pixels[..., :3] = srgb_to_linear(pixels[..., :3])
    elif colorspace not in ("Non-Color", "Raw", "Linear", "Linear Rec.709"):
        diagnostics.warn(f"colour space '{colorspace}' of image '{name}' is not supported; it is read as linear", place)
    return pixels


def _image(context, inputs, properties):
    arena = context.arena
    vector = inputs["vector"] if "vector" in inputs else lookup_uv(context, "")
    vector = np.broadcast_to(vector, (3, context.count))
    rgba = arena.empty((4, context.count))
    with arena.frame():
        if properties["interpolation"] == "Closest":
            _closest(vector, properties, arena, rgba)
        else:
            _bilinear(vector, properties, arena, rgba)
        if properties["extension"] == "CLIP":
            inside = (vector[0] >= 0) & (vector[0] < 1) & (vector[1] >= 0) & (vector[1] < 1)
            np.multiply(rgba, inside, out=rgba)
    return {"color": rgba[:3], "alpha": rgba[3]}


def _closest(vector, p, arena, out):
    x = _texel(np.floor(vector[0] * np.float32(p["width"])), p["width"], p["extension"])
    y = _texel(np.floor(vector[1] * np.float32(p["height"])), p["height"], p["extension"])
    index = y * np.int32(p["width"]) + x
    for channel in range(4):
        np.take(p["texels"][channel], index, out=out[channel], mode="clip")


def _bilinear(vector, p, arena, out):
    n = vector.shape[-1]
    fx, x0, x1 = _neighbours(vector[0], p["width"], p["extension"], arena)
    fy, y0, y1 = _neighbours(vector[1], p["height"], p["extension"], arena)
    index, texel, weight = arena.empty(n, np.int32), arena.empty(n), arena.empty(n)
    out.fill(0)
    for y, wy in ((y0, 1 - fy), (y1, fy)):
        for x, wx in ((x0, 1 - fx), (x1, fx)):
            np.multiply(y, np.int32(p["width"]), out=index)
            np.add(index, x, out=index)
            np.multiply(wx, wy, out=weight)
            for channel in range(4):
                np.take(p["texels"][channel], index, out=texel, mode="clip")
                np.multiply(texel, weight, out=texel)
                np.add(out[channel], texel, out=out[channel])


def _neighbours(coordinate, size, extension, arena):
    """Fraction and the two texel numbers around `coordinate`; texel centres are at half integers."""
    t, base = arena.empty(coordinate.size), arena.empty(coordinate.size)
    np.multiply(coordinate, float(size), out=t)
    np.subtract(t, 0.5, out=t)
    np.floor(t, out=base)
    np.subtract(t, base, out=t)
    return t, _texel(base, size, extension), _texel(base + 1, size, extension)


def _texel(number, size, extension):
    """Texel number (N,) int32 of an unbounded one (float32)."""
    if extension == "REPEAT":
        number = np.mod(number, np.float32(size))
    elif extension == "MIRROR":
        number = np.mod(number, np.float32(2 * size))
        number = np.minimum(number, np.float32(2 * size - 1) - number)
    number = np.clip(np.nan_to_num(number), 0, size - 1)
    return number.astype(np.int32)


OPERATIONS = {"image": Operation(_image, {"vector": None}, foldable=False, prepare=_prepare)}
