# SPDX-License-Identifier: GPL-3.0-or-later
"""Images to texels, each once: nodes and materials share them, and files are kept from one render to the next.

Source of what is multiplied by alpha, and when: Cycles (`scene/image.cpp`, `scene/image_oiio.cpp`).
"""

from __future__ import annotations

import os
from collections import OrderedDict
from threading import Lock
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from .image_files import read_file
from .image_spaces import as_halves, is_data, is_linear, is_srgb, rounded, to_scene_linear
from .texels import Texels
from .tiles import Tiles

MAGENTA = (1.0, 0.0, 1.0, 1.0)  # what Blender shows where an image is missing

_KEPT_BYTES = 2 << 30  # of files that were read before
_BLOCK = 1 << 22  # texels that are worked on at a time

_TYPES = (np.uint8, np.uint16, np.float16, np.float32)
_MISSING = Texels.of(np.array([[MAGENTA]], np.float32))

_by_image = WeakKeyDictionary()
_by_file = OrderedDict()
_lock = Lock()


class _Loaded(NamedTuple):
    """Texels of an image and what is to be told of it."""

    texels: Texels | Tiles
    messages: tuple[str, ...]


def load(image, diagnostics, place):
    """`Texels` or `Tiles` of a `core.scene.Image`; magenta where there is none."""
    if image is None:
        diagnostics.warn("an image texture has no image; choose one in the node", place)
        return _MISSING
    with _lock:
        loaded = _loaded(image)
    for message in loaded.messages:
        diagnostics.warn(message, place)
    return loaded.texels


def _loaded(image):
    """`_Loaded` of an image, made when it is first asked for."""
    loaded = _by_image.get(image)
    if loaded is None:
        if image.tiles:
            tiles = {number: _loaded(tile) for number, tile in image.tiles.items()}
            texels = Tiles({number: tile.texels for number, tile in tiles.items()}, MAGENTA)
            loaded = _Loaded(texels, tuple(message for tile in tiles.values() for message in tile.messages))
        else:
            loaded = _read(image) if image.pixels is not None else _from_file(image)
        _by_image[image] = loaded
    return loaded


def _from_file(image):
    """Texels of a file, which is not read again while it is as it was."""
    try:
        status = os.stat(image.filepath)
    except OSError:
        return _read(image)
    settings = image.colorspace, image.alpha_mode, image.color_configuration, image.linear_first, image.nearest
    key = image.filepath, status.st_mtime_ns, status.st_size, *settings
    loaded = _by_file.pop(key, None) or _read(image)
    _by_file[key] = loaded
    used = sum(kept.texels.nbytes for kept in _by_file.values())
    while used > _KEPT_BYTES and len(_by_file) > 1:
        used -= _by_file.popitem(last=False)[1].texels.nbytes
    return loaded


def _read(image):
    """Texels made anew."""
    pixels, straight, owned = image.pixels, True, False
    if pixels is None:
        picture = read_file(image.filepath) if image.filepath else None
        if picture is None:
            return _Loaded(_MISSING, (f"image '{image.name}' cannot be read; magenta is shown, as in Blender",))
        (pixels, straight), owned = picture, True
    if image.alpha_mode != "AUTO":
        straight = image.alpha_mode == "STRAIGHT"
    if 0 in pixels.shape:
        size = " × ".join(str(n) for n in pixels.shape[1::-1])
        return _Loaded(_MISSING, (f"image '{image.name}' has {size} pixels; magenta is shown, as in Blender",))
    messages = []
    colored = pixels.ndim < 3 or pixels.shape[2] != 2  # Cycles does not multiply greys by their alpha
    with np.errstate(all="ignore"):  # what is not finite is set to zero
        pixels, owned = _channels(pixels, owned)
        multiplies = straight and colored and _multiplies(image) and pixels.shape[2] == 4
        if pixels.dtype.kind == "u" and not _as_stored(image):
            nearest = image.nearest or image.pixels is None
            at_once = multiplies and not nearest  # before they are rounded, as in Cycles
            pixels, owned = as_halves(pixels, nearest, at_once), True
            multiplies = multiplies and not at_once
        if image.alpha_mode == "NONE" and pixels.shape[2] == 4:
            pixels, owned = pixels if owned else pixels.copy(), True
            pixels[..., 3] = _one(pixels.dtype)
        if multiplies:
            pixels, owned = _multiplied(pixels, owned, image.nearest), True
        pixels = _finite(pixels, owned, image, messages)
        pixels = _linear(pixels, image, colored and _multiplies(image), messages)
    return _Loaded(Texels.of(pixels, _is_encoded(image), colored and _multiplies(image)), tuple(messages))


def _as_stored(image):
    """Whether texels are kept as they are stored: they are linear, or made so after the lookup."""
    return _is_encoded(image) or is_linear(image.colorspace)


def _is_encoded(image):
    """Whether texels stand by the sRGB transfer function when they are looked up."""
    return is_srgb(image.colorspace) and not image.linear_first


def _multiplies(image):
    """Whether the image's colours are to be times alpha."""
    return image.alpha_mode not in ("CHANNEL_PACKED", "NONE") and not is_data(image.colorspace)


def _channels(pixels, owned):
    """`pixels` with one or four channels of a type that texels have, and whether they are not the caller's."""
    pixels = pixels.reshape(*pixels.shape[:2], -1)
    if pixels.dtype.type not in _TYPES:
        pixels, owned = pixels.astype(np.float32), True
    channels = pixels.shape[2]
    if channels in (1, 4):
        return pixels, owned
    out = np.zeros((*pixels.shape[:2], 4), pixels.dtype)
    for channel in range(3):  # one by one is four times as fast as at once
        out[..., channel] = pixels[..., 0 if channels == 2 else channel]
    out[..., 3] = pixels[..., 1] if channels == 2 else _one(pixels.dtype)
    return out, True


def _multiplied(pixels, owned, nearest):
    """Colours times alpha in the type that they are stored in: halves by `rounded`, whole numbers rounded down."""
    one = _one(pixels.dtype)
    if (pixels[..., 3] == one).all():
        return pixels
    out = pixels if owned else pixels.copy()
    for block in _blocks(out):
        if out.dtype.kind == "u":
            block[..., :3] = block[..., :3].astype(np.uint32) * block[..., 3:] // one
        else:
            product = block[..., :3].astype(np.float32) * block[..., 3:]
            block[..., :3] = rounded(product, nearest) if out.dtype == np.float16 else product
    return out


def _finite(pixels, owned, image, messages):
    """`pixels` with texels of zeros where a channel is not finite."""
    if pixels.dtype.kind != "f":
        return pixels
    count = 0
    for number, block in enumerate(_blocks(pixels)):
        wrong = ~np.isfinite(block).all(axis=-1)
        if wrong.any():
            if not owned:
                pixels, owned = pixels.copy(), True
                block = _blocks(pixels)[number]
            block[wrong] = 0
            count += int(np.count_nonzero(wrong))
    if count:
        messages.append(f"image '{image.name}' has {count:,} texels that are not finite; they are set to zero")
    return pixels


def _linear(pixels, image, multiplied, messages):
    """`pixels` made linear, unless that is done after the lookup."""
    if _as_stored(image):
        return pixels
    space = image.colorspace or "sRGB"
    linear = to_scene_linear(pixels, space, image.color_configuration, multiplied, image.nearest)
    if linear is None:
        space = f"colour space '{image.colorspace}' of image '{image.name}'"
        messages.append(f"{space} is not known here; it is read as linear")
        return pixels
    return linear


def _blocks(pixels):
    """Runs of rows, views: large pictures are not worked on all at once."""
    rows = max(_BLOCK // pixels.shape[1], 1)
    return [pixels[row : row + rows] for row in range(0, len(pixels), rows)]


def _one(dtype):
    """What stands for 1."""
    return np.iinfo(dtype).max if dtype.kind == "u" else 1
