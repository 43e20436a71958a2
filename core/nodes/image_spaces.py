# SPDX-License-Identifier: GPL-3.0-or-later
"""Colour spaces of images, by Blender's names.

What is stored by the sRGB transfer function stays so and is made linear after the lookup; other spaces are converted
once, by the OpenColorIO configuration that defines them. Source: Cycles (`scene/colorspace.cpp`, `scene/image.cpp`).
"""

from __future__ import annotations

import numpy as np

_SRGB = ("sRGB", "sRGB IEC61966-2.1", "")
_DATA = ("Non-Color", "Non-Colour Data", "Generic Data", "Raw")
_LINEAR = ("Linear Rec.709", "Linear BT.709", "Linear", "scene_linear")

_BLOCK = 1 << 22  # texels that are converted at a time
_LARGEST, _SMALLEST = 65504.0, 2.0**-14  # normal numbers of a half


def is_data(name):
    """Whether pixels in space `name` are no colours."""
    return name in _DATA


def is_srgb(name):
    """Whether space `name` is Rec.709 by the sRGB transfer function."""
    return name in _SRGB


def is_linear(name):
    """Whether values in space `name` are taken as they are."""
    return name in _DATA or name in _LINEAR


def as_halves(pixels, nearest, multiplied=False):
    """Whole numbers as float16: Cycles converts between spaces in halves, whose rounding shows in steep ones.

    `nearest` is how a file's are rounded; those that Blender holds are rounded down. With `multiplied` colours are
    first multiplied by alpha.
    """
    out = np.zeros(pixels.shape, np.float16)
    for row in range(0, len(pixels), _rows(pixels)):
        block = slice(row, row + _rows(pixels))
        values = pixels[block].astype(np.float32) / np.float32(np.iinfo(pixels.dtype).max)
        if multiplied:
            values[..., :3] *= values[..., 3:]
        out[block] = rounded(values, nearest)
    return out


def truncated(values):
    """Values (float32) as halves, rounded towards 0; what a half has no normal number for is 0."""
    values = np.clip(values, -_LARGEST, _LARGEST).astype(np.float32)
    values[np.abs(values) < _SMALLEST] = 0
    return (values.view(np.uint32) & np.uint32(0xFFFFE000)).view(np.float32).astype(np.float16)


def rounded(values, nearest):
    """Values (float32) as halves, rounded to the nearest or towards 0."""
    return np.clip(values, -_LARGEST, _LARGEST).astype(np.float16) if nearest else truncated(values)


def to_scene_linear(pixels, name, configuration, multiplied, nearest=False):
    """`pixels` (H, W, 1 or 4) of space `name`, float16 or float32, as linear Rec.709 of that type; None when unknown.

    Parameters
    ----------
    configuration : str
        Path of the OpenColorIO configuration that has the space.
    multiplied : bool
        Whether colours are times alpha: they are converted without it.
    nearest : bool
        How halves are rounded (`rounded`).
    """
    try:
        import OpenImageIO as oiio
    except ImportError:
        return None
    if not configuration or not _knows(oiio, configuration, name):
        return None
    channels = pixels.shape[2]
    out = np.zeros_like(pixels)
    for row in range(0, len(pixels), _rows(pixels)):
        rows = slice(row, row + _rows(pixels))
        block = pixels[rows].astype(np.float32)
        alpha = _divisor(block) if multiplied and channels == 4 else None
        if alpha is not None:
            block[..., :3] /= alpha
        source = block if channels == 4 else np.repeat(block, 3, axis=2)
        buffer = oiio.ImageBufAlgo.colorconvert(
            oiio.ImageBuf(source), name, "scene_linear", False, "", "", configuration
        )
        if buffer.has_error:
            buffer.geterror()
            return None
        linear = buffer.get_pixels(oiio.FLOAT).reshape(source.shape)
        if alpha is not None:
            linear[..., :3] *= alpha
        if channels == 1:
            linear = linear.mean(axis=2, keepdims=True)
        linear = np.nan_to_num(linear, nan=0.0)
        out[rows] = rounded(linear, nearest) if out.dtype == np.float16 else linear
    return out


def _knows(oiio, configuration, name):
    config = oiio.ColorConfig(configuration)
    names = config.getColorSpaceNames()
    return name in names or any(name in config.getAliases(known) for known in names)


def _rows(pixels):
    """How many rows are worked on at a time."""
    return max(_BLOCK // pixels.shape[1], 1)


def _divisor(block):
    """Alpha (H, W, 1), 1 where there is none to divide by."""
    alpha = block[..., 3:].copy()
    alpha[alpha <= 0] = 1
    return alpha
