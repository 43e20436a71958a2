# SPDX-License-Identifier: GPL-3.0-or-later
"""Letters as small pictures, for text in pictures.

Blender's OpenImageIO is built without FreeType and draws no text, and Blender has no other library that draws without a
window. So the letters of OpenImageIO's own font (Droid Sans, Apache License 2.0) are kept in ``glyphs.npz``, drawn once
by ``python -m zraka.addon.report.glyphs`` where the OpenImageIO of PyPI is installed.
"""

from __future__ import annotations

import unicodedata
from functools import cache
from pathlib import Path

import numpy as np

HEIGHT = 20
"""Of a line, in pixels."""

_FILE = Path(__file__).with_name("glyphs.npz")
_SIZE, _BASE, _PAD = 15, 15, 2
_CHARACTERS = "".join(map(chr, range(32, 127))) + "×·–²°±"
_UNKNOWN = "?"


@cache
def _glyphs():
    with np.load(_FILE) as file:
        rows = zip(file["pictures"], file["advances"].tolist(), strict=True)
        return dict(zip(_CHARACTERS, rows, strict=True))


def _glyph(letter):
    """Picture and advance of a letter, or of the letter that it has a mark on."""
    glyphs = _glyphs()
    return glyphs.get(letter) or glyphs.get(unicodedata.normalize("NFKD", letter)[0]) or glyphs[_UNKNOWN]


def width(text):
    """Of a text, in pixels."""
    return sum(_glyph(letter)[1] for letter in text)


def fitted(text, most):
    """The text, cut with dots at its end where it is wider than `most` pixels."""
    if width(text) <= most:
        return text
    while text and width(text + "...") > most:
        text = text[:-1]
    return text + "..."


def draw(text):
    """How much of each pixel the text covers, (`HEIGHT`, width) float32 in [0, 1], row 0 at the top."""
    out = np.zeros((HEIGHT, width(text) + 4 * HEIGHT), np.float32)
    x = 0
    for letter in text:
        picture, advance = _glyph(letter)
        part = out[:, x : x + picture.shape[1]]
        np.maximum(part, picture.astype(np.float32) / 255, out=part)
        x += advance
    return out[:, _PAD : _PAD + width(text)]


def main():
    """Draw the letters anew."""
    import OpenImageIO as oiio
    from OpenImageIO import ImageBufAlgo as algo

    def extent(text):
        return algo.text_size(text, _SIZE).width

    pictures, advances = [], []
    for letter in _CHARACTERS:
        image = oiio.ImageBuf(oiio.ImageSpec(HEIGHT + 2 * _PAD, HEIGHT, 1, oiio.FLOAT))
        if not algo.render_text(image, _PAD, _BASE, letter, _SIZE, textcolor=(1.0,)):
            raise RuntimeError(image.geterror())
        pictures.append(np.round(255 * np.clip(image.get_pixels()[..., 0], 0, 1)).astype(np.uint8))
        advances.append(extent(f"x{letter}x") - extent("xx"))
    np.savez_compressed(_FILE, pictures=np.array(pictures), advances=np.array(advances, np.uint8))


if __name__ == "__main__":
    main()
