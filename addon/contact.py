# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures side by side, each over its caption."""

from __future__ import annotations

import math

import numpy as np

_GAP = 4  # pixels between pictures
_STRIP = 24  # pixels of a caption


def contact_sheet(pictures, captions):
    """Arrange pictures of one size in rows, as square as their number allows.

    Parameters
    ----------
    pictures : sequence of (H, W, 4) float32
        Linear, row 0 at the bottom.
    captions : sequence of str
        One of each; left blank where Blender brings no OpenImageIO to draw them.

    Returns
    -------
    (H', W', 4) float32
        Linear, row 0 at the bottom, black and opaque between the pictures; (1, 1, 4) of no pictures.
    """
    if not pictures:
        return np.zeros((1, 1, 4), np.float32)
    height, width, _ = pictures[0].shape
    columns = math.ceil(math.sqrt(len(pictures)))
    rows = math.ceil(len(pictures) / columns)
    cell_height, cell_width = height + _STRIP + _GAP, width + _GAP
    sheet = np.zeros((rows * cell_height - _GAP, columns * cell_width - _GAP, 4), np.float32)
    sheet[..., 3] = 1
    text_size = max(6, min(16, 2 * width // max(1, *map(len, captions))))
    for number, (picture, caption) in enumerate(zip(pictures, captions, strict=True)):
        row, column = divmod(number, columns)
        x, y = column * cell_width, (rows - 1 - row) * cell_height
        sheet[y : y + _STRIP, x : x + width] = _drawn(caption, width, text_size)
        sheet[y + _STRIP : y + _STRIP + height, x : x + width] = picture
    return sheet


def _drawn(text, width, size):
    """A strip of white text on black, (_STRIP, width, 4)."""
    strip = np.zeros((_STRIP, width, 4), np.float32)
    strip[..., 3] = 1
    try:
        import OpenImageIO as oiio
    except ImportError:
        return strip
    canvas = oiio.ImageBuf(oiio.ImageSpec(width, _STRIP, 4, oiio.FLOAT))
    if oiio.ImageBufAlgo.render_text(canvas, 4, _STRIP - 8, text, size, "", (1.0, 1.0, 1.0, 1.0)):
        strip = np.maximum(strip, canvas.get_pixels(oiio.FLOAT).reshape(_STRIP, width, 4)[::-1])
    return strip
