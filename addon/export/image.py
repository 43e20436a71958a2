# SPDX-License-Identifier: GPL-3.0-or-later
"""Images: the file where it still says what Blender shows, else Blender's own pixels."""

from __future__ import annotations

import hashlib
import os
import re
from collections import OrderedDict

import bpy
import numpy as np

from ...core import scene as description
from ...core.nodes.image_files import can_read
from . import versions

_PACKED_BYTES = 1 << 30  # of packed images that are kept from one export to the next
_packed = OrderedDict()


class Images:
    """Images of one export, each exported once.

    Parameters
    ----------
    diagnostics : Diagnostics
    frame : int
        Of the scene, for image sequences.
    known : dict, optional
        Images of the export before, by key.

    Attributes
    ----------
    used : dict
        Images by key.
    sequences : int
        How often one of a sequence was asked for.
    """

    def __init__(self, diagnostics, frame=1, known=None):
        self._diagnostics = diagnostics
        self._frame = frame
        self._known = known or {}
        self.used = {}
        self.sequences = 0

    def __call__(self, image, user=None):
        """`core.scene.Image` of a bpy image as its `user` (bpy.types.ImageUser) sees it."""
        number = None
        if user is not None and image.source == "SEQUENCE":
            number = frame_number(user, self._frame)
            self.sequences += 1
        key = image.as_pointer(), number
        if key not in self.used:
            self.used[key] = self._known.get(key) or export_image(image, self._diagnostics, number)
        return self.used[key]


def export_image(image, diagnostics, frame=None):
    """One image.

    Parameters
    ----------
    image : bpy.types.Image
    diagnostics : Diagnostics
    frame : int, optional
        Number of the picture of an image sequence; None is the file that the image names.

    Returns
    -------
    core.scene.Image
        With a path where the file is what Blender shows; with pixels where the image is packed, generated or painted,
        or no library reads it; with neither where the image is missing.
    """
    _diagnose(image, diagnostics)
    if image.source == "TILED":
        tiles = {tile.number: _tile(image, tile, diagnostics) for tile in image.tiles}
        return description.Image(image.name, tiles=tiles)
    path = _path(image)
    if image.source == "SEQUENCE" and frame is not None:
        path = numbered(path, frame)
    as_on_disk = image.source in ("FILE", "SEQUENCE") and not image.is_dirty and image.packed_file is None
    if as_on_disk and os.path.isfile(path) and can_read(path):
        return _of_file(image, path)
    if image.source == "SEQUENCE":
        return _of_file(image, path)  # Blender's pixels are of one frame, perhaps another
    if image.packed_file is not None and not image.is_dirty:
        return _of_packed(image)
    return _of_pixels(image)


def frame_number(user, frame):
    """Number of the picture that an image `user` shows at `frame` of the scene.

    Whether it refreshes by itself makes no difference: a render is always refreshed. Source: Blender
    (`BKE_image_user_frame_get`).
    """
    length = user.frame_duration
    if length == 0:
        return 0
    number = frame - user.frame_start + 1
    if user.use_cyclic:
        number = number % length or length
    return min(max(number, 0), length) + user.frame_offset


def numbered(path, frame):
    """`path` of a sequence with the last number in its name replaced by `frame`, filled with zeros to its width."""
    folder, name = os.path.split(path)
    stem, ending = os.path.splitext(name)
    head, digits, tail = re.fullmatch(r"(.*?)(\d*)(\D*)", stem).groups()
    return os.path.join(folder, f"{head}{frame:0{len(digits)}d}{tail}{ending}")


def color_configuration():
    """Path of the OpenColorIO configuration that Blender uses."""
    folder = bpy.utils.system_resource("DATAFILES", path="colormanagement")
    return os.environ.get("OCIO") or os.path.join(folder, "config.ocio")


def _diagnose(image, diagnostics):
    remedy = {
        "MOVIE": "movies are not supported as textures; one frame is used",
        "VIEWER": "render results are not supported as textures",
    }.get(image.source)
    if remedy:
        diagnostics.warn(remedy, f"image '{image.name}'")


def _path(image):
    """Absolute path, "" where there is none."""
    return os.path.abspath(bpy.path.abspath(image.filepath, library=image.library)) if image.filepath else ""


def _of_file(image, path):
    return description.Image(
        image.name,
        filepath=path,
        colorspace=image.colorspace_settings.name,
        alpha_mode=versions.alpha_mode(image, "AUTO"),
        color_configuration=color_configuration(),
        linear_first=versions.has_other_working_space(),
        nearest=versions.rounds_to_nearest(),
    )


def _of_packed(image):
    """A packed image, unpacked once while its bytes stay the same."""
    digest = hashlib.blake2b(image.packed_file.data, digest_size=16).digest()
    key = digest, image.name, image.colorspace_settings.name, image.alpha_mode, versions.has_other_working_space()
    exported = _packed.pop(key, None) or _of_pixels(image)
    if exported.pixels is not None:
        _packed[key] = exported
    used = sum(kept.pixels.nbytes for kept in _packed.values())
    while used > _PACKED_BYTES and len(_packed) > 1:
        used -= _packed.popitem(last=False)[1].pixels.nbytes
    return exported


def _of_pixels(image):
    """What Blender holds; bytes are as stored, float buffers were made linear and multiplied by alpha when read."""
    pixels = _pixels(image)
    if pixels is None:
        return description.Image(image.name)
    space = image.colorspace_settings
    linear = image.is_float and not space.is_data
    return description.Image(
        image.name,
        pixels,
        colorspace="Linear Rec.709" if linear else space.name,
        alpha_mode=versions.alpha_mode(image, "PREMUL" if image.is_float else "STRAIGHT"),
        color_configuration=color_configuration(),
        linear_first=versions.has_other_working_space(),
        nearest=versions.rounds_to_nearest(),
    )


def _pixels(image):
    """(H, W, 4), or (H, W, 1) of a grey float image; bytes as uint8, else float32. None without data."""
    width, height = image.size  # makes Blender read a packed file
    channels = image.channels
    if 0 in (width, height, channels):
        return None
    stored = np.zeros(width * height * channels, np.float32)
    image.pixels.foreach_get(stored)
    if not image.is_float:
        np.multiply(stored, 255, out=stored)
        stored = np.rint(stored, out=stored).astype(np.uint8)
    stored = stored.reshape(height, width, channels)
    if channels in (1, 4):
        return stored
    pixels = np.zeros((height, width, 4), stored.dtype)
    pixels[..., 3] = 255 if stored.dtype == np.uint8 else 1
    pixels[..., :channels] = stored
    return pixels


# -- UDIM tiles --------------------------------------------------------------------------------------------------------


def _tile(image, tile, diagnostics):
    """One tile: its file, packed or not, Blender's pixels of the first, the plain colour of one that it made."""
    path = _path(image).replace("<UDIM>", f"{tile.number:04d}").replace("<UVTILE>", _uv_tile(tile.number))
    packed = next((p for p in image.packed_files if p.tile_number == tile.number), None)
    first = tile == image.tiles[0]
    if packed is None and not (first and image.is_dirty) and os.path.isfile(path):
        return _of_file(image, path)
    if first:
        return _of_pixels(image)
    if packed is not None:
        return _of_file(image, _unpacked(packed, path))
    if not getattr(tile, "is_generated_tile", False):  # since 5.0
        return description.Image(f"{image.name}, tile {tile.number}")
    diagnostics.warn(
        "UDIM tiles that were never saved are shown in their plain colour; save the image", f"image '{image.name}'"
    )
    color = np.array(tile.generated_color, np.float32).reshape(1, 1, 4)
    return description.Image(image.name, color, colorspace="Linear Rec.709", alpha_mode="PREMUL")


def _uv_tile(number):
    return f"u{(number - 1001) % 10 + 1}_v{(number - 1001) // 10 + 1}"


def _unpacked(packed, path):
    """Path of a temporary file with the content of a packed tile."""
    data = packed.packed_file.data
    name = hashlib.blake2b(data, digest_size=16).hexdigest() + os.path.splitext(packed.filepath or path)[1]
    path = os.path.join(bpy.app.tempdir, f"zraka_{name}")
    if not os.path.isfile(path):
        with open(path, "wb") as file:
            file.write(data)
    return path
