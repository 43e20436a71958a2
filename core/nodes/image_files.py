# SPDX-License-Identifier: GPL-3.0-or-later
"""Image files, read by OpenImageIO into pixels of the type that they are stored in."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

# Formats whose alpha OpenImageIO does not tell to be apart from the colour, though it is.
_STRAIGHT_FORMATS = ("dds", "psd")
_TARGA_PREMULTIPLIED = 4


class Picture(NamedTuple):
    """What a file holds.

    pixels: (H, W, C) uint8, uint16, float16 or float32, row 0 at the bottom; at most four channels.
    straight: whether its colours are not multiplied by its alpha.
    """

    pixels: np.ndarray
    straight: bool


def read_file(path):
    """`Picture` of an image file, None when it cannot be read."""
    opened = _open(path)
    if opened is None:
        return None
    oiio, source = opened
    spec = source.spec()
    pixels = source.read_image(0, 0, 0, min(spec.nchannels, 4), _storage(oiio, spec))
    straight = _is_straight(source.format_name(), spec)
    source.close()
    if pixels is None:
        oiio.geterror()
        return None
    return Picture(_flipped(pixels.reshape(spec.height, spec.width, -1)), straight)


def can_read(path):
    """Whether there is an OpenImageIO, and it knows the file."""
    opened = _open(path)
    if opened is None:
        return False
    opened[1].close()
    return True


def _open(path):
    """(OpenImageIO, open file) or None."""
    try:
        import OpenImageIO as oiio
    except ImportError:  # not every Blender brings it as a Python module
        return None
    # Alpha stays apart from the colour where a file stores it so.
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    source = oiio.ImageInput.open(path, config)
    if source is None:
        oiio.geterror()  # or it is printed when the program ends
        return None
    return oiio, source


def _storage(oiio, spec):
    """The type to read pixels as: the file's, where it is one of the four that texels have."""
    formats = [spec.format, *spec.channelformats]
    if spec.format == oiio.TypeDesc("half"):
        return oiio.HALF
    if any(f.basetype in (oiio.HALF, oiio.FLOAT, oiio.DOUBLE) for f in formats):
        return oiio.FLOAT
    return oiio.UINT16 if spec.format.basetype == oiio.UINT16 else oiio.UINT8


def _is_straight(format_name, spec):
    if spec.alpha_channel < 0:
        return False
    if spec.get_int_attribute("oiio:UnassociatedAlpha") or format_name in _STRAIGHT_FORMATS:
        return True
    return format_name == "targa" and spec.get_int_attribute("targa:alpha_type", -1) != _TARGA_PREMULTIPLIED


def _flipped(pixels):
    """`pixels` upside down, in place: they may be large."""
    half = len(pixels) // 2
    top = pixels[:half].copy()
    pixels[:half] = pixels[: len(pixels) - half - 1 : -1]
    pixels[len(pixels) - half :] = top[::-1]
    return pixels
