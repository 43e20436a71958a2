# SPDX-License-Identifier: GPL-3.0-or-later
"""Images: the file where it still says what Blender shows, else Blender's own pixels."""

from __future__ import annotations

import importlib.util
import os
from functools import cache

import bpy
import numpy as np

from ...core import scene as description


class Images:
    """Images of one export, each exported once."""

    def __init__(self, diagnostics):
        self._diagnostics = diagnostics
        self._known = {}

    def __call__(self, image):
        """`core.scene.Image` of a bpy image."""
        key = image.as_pointer()
        if key not in self._known:
            self._known[key] = export_image(image, self._diagnostics)
        return self._known[key]


def export_image(image, diagnostics):
    """One image.

    Parameters
    ----------
    image : bpy.types.Image
    diagnostics : Diagnostics

    Returns
    -------
    core.scene.Image
        With a path where the file is what Blender shows; with pixels where the image is packed, generated or painted,
        its alpha is switched off or files cannot be read; with neither where the image is missing.
    """
    _diagnose(image, diagnostics)
    name = image.name
    path = bpy.path.abspath(image.filepath, library=image.library) if image.filepath else ""
    as_on_disk = image.source == "FILE" and not image.is_dirty and image.packed_file is None
    if _core_reads_files() and as_on_disk and image.alpha_mode != "NONE" and os.path.isfile(path):
        return description.Image(name, filepath=os.path.abspath(path), colorspace=image.colorspace_settings.name)
    pixels = _pixels(image)
    if pixels is None:
        return description.Image(name)
    return description.Image(name, pixels, colorspace=_colorspace_of_pixels(image))


@cache
def _core_reads_files():
    """Whether there is an OpenImageIO to read them with; not every Blender brings it as a Python module."""
    return importlib.util.find_spec("OpenImageIO") is not None


def _diagnose(image, diagnostics):
    remedy = {
        "TILED": "UDIM images are not supported; their first tile is used everywhere",
        "SEQUENCE": "image sequences are not supported; one frame is used",
        "MOVIE": "movies are not supported as textures; one frame is used",
        "VIEWER": "render results are not supported as textures",
    }.get(image.source)
    if remedy:
        diagnostics.warn(remedy, f"image '{image.name}'")


def _pixels(image):
    """What Blender holds, (H, W, 4) with straight alpha; bytes as uint8, else float32. None without data."""
    width, height = image.size  # makes Blender read a packed file
    channels = image.channels
    if 0 in (width, height, channels):
        return None
    stored = np.zeros(width * height * channels, np.float32)
    image.pixels.foreach_get(stored)
    stored = stored.reshape(height, width, channels)
    if channels == 4:
        pixels = stored
    else:
        pixels = np.ones((height, width, 4), np.float32)
        pixels[..., :3] = stored[..., :3] if channels == 3 else stored[..., :1]
    if not image.is_float:
        return np.rint(pixels * np.float32(255)).astype(np.uint8)
    if image.alpha_mode in ("STRAIGHT", "PREMUL"):
        # Float buffers hold colours times alpha; where alpha is 0 there is only light, which stays.
        alpha = pixels[..., 3:]
        np.divide(pixels[..., :3], alpha, out=pixels[..., :3], where=alpha > 0)
    return pixels


def _colorspace_of_pixels(image):
    """Bytes are as stored; Blender made float buffers linear when it read them."""
    settings = image.colorspace_settings
    if image.is_float and not settings.is_data:
        return "Linear Rec.709"
    return settings.name
