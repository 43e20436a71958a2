# SPDX-License-Identifier: GPL-3.0-or-later
"""Pixels of images as tables of texels, and how they are looked up."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..sampling.color import srgb_to_linear

MISSING = np.array([[[1.0, 0.0, 1.0, 1.0]]], np.float32)  # Blender's magenta

_SRGB = ("sRGB", "sRGB IEC61966-2.1", "")
_LINEAR = ("Non-Color", "Raw", "Linear", "Linear Rec.709")


@dataclass(frozen=True, eq=False)
class Texels:
    """A picture as `values` (C, height · width) float32, row 0 at the bottom."""

    values: np.ndarray
    width: int
    height: int

    @classmethod
    def of(cls, pixels):
        """Texels of `pixels` (H, W, C)."""
        height, width, channels = pixels.shape
        return cls(np.ascontiguousarray(pixels.reshape(-1, channels).T, np.float32), width, height)

    def averaged(self, width, height):
        """The same picture in at most `width` × `height` texels, each the mean of those that it stands for."""
        picture = self.values.reshape(-1, self.height, self.width)
        if self.width > width:
            picture = _means(picture, 2, width)
        if self.height > height:
            picture = _means(picture, 1, height)
        return Texels(picture.reshape(picture.shape[0], -1), picture.shape[2], picture.shape[1])

    def look_up(self, x, y, interpolation, extension, arena, out):
        """Write values at coordinates `x`, `y` (N,), in [0, 1] within the picture, to `out` (C, N)."""
        with arena.frame():
            if interpolation == "Closest":
                self._closest(x, y, extension, arena, out)
            else:
                self._bilinear(x, y, extension, arena, out)

    def _closest(self, x, y, extension, arena, out):
        column = _texel(np.floor(x * np.float32(self.width)), self.width, extension)
        index = _texel(np.floor(y * np.float32(self.height)), self.height, extension)
        np.multiply(index, np.int32(self.width), out=index)
        np.add(index, column, out=index)
        for channel, row in zip(self.values, out, strict=True):
            np.take(channel, index, out=row, mode="clip")

    def _bilinear(self, x, y, extension, arena, out):
        n = out.shape[-1]
        fx, x0, x1 = _neighbours(x, self.width, extension, arena)
        fy, y0, y1 = _neighbours(y, self.height, extension, arena)
        index, texel, weight = arena.empty(n, np.int32), arena.empty(n), arena.empty(n)
        out.fill(0)
        for row, wy in ((y0, 1 - fy), (y1, fy)):
            for column, wx in ((x0, 1 - fx), (x1, fx)):
                np.multiply(row, np.int32(self.width), out=index)
                np.add(index, column, out=index)
                np.multiply(wx, wy, out=weight)
                for channel, total in zip(self.values, out, strict=True):
                    np.take(channel, index, out=texel, mode="clip")
                    np.multiply(texel, weight, out=texel)
                    np.add(total, texel, out=total)


def read_pixels(image, diagnostics, place):
    """Pixels (H, W, 4) float32 of a `core.scene.Image` as stored, alpha straight; magenta where there are none."""
    if image is None:
        diagnostics.warn("an image texture has no image; choose one in the node", place)
        return MISSING.copy()
    pixels = image.pixels
    if pixels is None:
        pixels = read_file(image.filepath) if image.filepath else None
    if pixels is None or 0 in pixels.shape:
        diagnostics.warn(f"image '{image.name}' cannot be read; magenta is shown, as in Blender", place)
        return MISSING.copy()
    if pixels.dtype == np.uint8:
        pixels = pixels.astype(np.float32) / np.float32(255)
    else:
        pixels = np.array(pixels, np.float32)
    if not np.isfinite(pixels).all():
        diagnostics.warn(f"image '{image.name}' has non-finite texels; they are set to zero", place)
        pixels = np.nan_to_num(pixels, nan=0.0, posinf=0.0, neginf=0.0)
    return pixels


def read_file(path):
    """Pixels (H, W, 4) float32 of an image file, row 0 at the bottom, alpha straight; None when it cannot be read."""
    import OpenImageIO as oiio

    # Alpha stays apart from the colour where a file stores it so: what is made linear is not yet multiplied by it.
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    source = oiio.ImageInput.open(path, config)
    if source is None:
        oiio.geterror()  # or it is printed when the program ends
        return None
    pixels = source.read_image(oiio.FLOAT)
    multiplied = not source.spec().get_int_attribute("oiio:UnassociatedAlpha")
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
    if multiplied and channels in (2, 4):
        alpha = out[..., 3:]  # where it is 0 there is only light, which stays
        np.divide(out[..., :3], alpha, out=out[..., :3], where=alpha > 0)
    return out[::-1]


def is_srgb(image):
    """Whether the colours of a `core.scene.Image` are stored by the sRGB transfer function."""
    return image is not None and image.colorspace in _SRGB


def to_linear(pixels, image, diagnostics, place):
    """Make stored `pixels` (H, W, 4) of `image` scene-linear, in place."""
    if is_srgb(image):
        pixels[..., :3] = srgb_to_linear(pixels[..., :3])
    elif image is not None and image.colorspace not in _LINEAR:
        message = f"colour space '{image.colorspace}' of image '{image.name}' is not supported; it is read as linear"
        diagnostics.warn(message, place)
    return pixels


def _means(picture, axis, size):
    """Means of `size` runs of nearly equal length along `axis`."""
    start = np.arange(size) * picture.shape[axis] // size
    length = np.diff(np.append(start, picture.shape[axis])).astype(np.float32)
    return np.add.reduceat(picture, start, axis) / length.reshape(-1, *(1,) * (picture.ndim - 1 - axis))


def _neighbours(coordinate, size, extension, arena):
    """Fraction and the two texel numbers around `coordinate`; texel centres are at half integers."""
    t, base = arena.empty(coordinate.size), arena.empty(coordinate.size)
    np.multiply(coordinate, float(size), out=t)
    np.subtract(t, 0.5, out=t)
    np.floor(t, out=base)
    np.subtract(t, base, out=t)
    after = np.add(base, 1, out=arena.empty(base.size))
    return t, _texel(base, size, extension), _texel(after, size, extension)


def _texel(number, size, extension):
    """Texel number (N,) int32 of an unbounded one (float32), which is spoilt. What is no number is texel 0."""
    if extension in ("REPEAT", "MIRROR"):
        period = float(size if extension == "REPEAT" else 2 * size)
        turns = np.floor(number / np.float32(period))
        np.multiply(turns, period, out=turns)
        np.subtract(number, turns, out=number)
    if extension == "MIRROR":
        np.minimum(number, np.float32(2 * size - 1) - number, out=number)
    np.fmax(number, 0, out=number)
    np.fmin(number, size - 1, out=number)
    return number.astype(np.int32)
