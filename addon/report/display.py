# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures as they are shown: through the scene's view transform, and as files small enough to be embedded."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from ...core.diagnostics import SceneError
from .. import headless


def shown(scene, picture):
    """A linear picture (H, W, 3), row 0 at the top, through the view transform of `scene`: (H, W, 3) uint8."""
    import bpy
    import OpenImageIO as oiio

    opaque = np.ones((*picture.shape[:2], 4), np.float32)
    opaque[..., :3] = picture[::-1]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "shown.png"
        headless.write_picture(bpy, scene, opaque, path)
        return oiio.ImageBuf(str(path)).get_pixels(oiio.UINT8)[..., :3]


def as_uint8(picture):
    """The first three channels of a picture in [0, 1], (H, W, 3) uint8."""
    return np.round(255 * np.clip(picture[..., :3], 0, 1)).astype(np.uint8)


def shrunk(picture, width):
    """The picture (H, W, 3) uint8, at most `width` pixels wide."""
    import OpenImageIO as oiio

    height, own = picture.shape[:2]
    if own <= width:
        return picture
    roi = oiio.ROI(0, width, 0, max(1, round(width * height / own)), 0, 1, 0, 3)
    return oiio.ImageBufAlgo.resize(_buffer(picture), roi=roi).get_pixels(oiio.UINT8)


def enlarged(picture, factor):
    """The picture with each pixel a square of `factor` × `factor`."""
    return picture.repeat(factor, axis=0).repeat(factor, axis=1)


def write(picture, path, quality=90):
    """Write a picture (H, W, 3) uint8 as PNG or JPEG, by the ending of `path`."""
    buffer = _buffer(picture)
    buffer.specmod().attribute("Compression", f"jpeg:{quality}")
    if not buffer.write(str(path)):
        raise SceneError(f"{path} cannot be written: {buffer.geterror()}")
    if not headless.is_whole(path):
        raise SceneError(f"{path} cannot be written whole; is the disk full?")


def encoded(picture, kind="jpg", quality=88):
    """The picture (H, W, 3) uint8 as the bytes of a file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"picture.{kind}"
        write(picture, path, quality)
        return path.read_bytes()


def read_linear(path):
    """A picture's colours, (H, W, 3) float32, row 0 at the top.

    Raises
    ------
    SceneError
    """
    import OpenImageIO as oiio

    image = oiio.ImageBuf(str(path))
    if image.has_error or image.spec().width == 0:
        raise SceneError(f"{path} is no picture: {' '.join(image.geterror().split()) or 'it is empty'}")
    if image.nchannels < 3:
        raise SceneError(f"{path} has {image.nchannels} channels; a reference has red, green and blue")
    return _colours(image, oiio)


def _colours(image, oiio):
    """The first red, green and blue; Blender's multilayer files name their channels ``ViewLayer.Combined.R``."""
    names = list(image.spec().channelnames)
    found = [next((i for i, name in enumerate(names) if name.split(".")[-1] == letter), None) for letter in "RGB"]
    pixels = image.get_pixels(oiio.FLOAT)
    return np.ascontiguousarray(pixels[..., [0, 1, 2] if None in found else found])


def _buffer(picture):
    import OpenImageIO as oiio

    height, width = picture.shape[:2]
    buffer = oiio.ImageBuf(oiio.ImageSpec(width, height, 3, oiio.UINT8))
    buffer.set_pixels(oiio.ROI.All, np.ascontiguousarray(picture))
    return buffer
