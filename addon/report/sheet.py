# SPDX-License-Identifier: GPL-3.0-or-later
"""A contact sheet: pictures beside each other, each with lines of text above it."""

from __future__ import annotations

import math

import numpy as np

from . import glyphs

GAP = 8
PAPER, INK, FAINT = 1.0, 0.1, 0.35


def contact_sheet(pictures, captions, columns=None, title=""):
    """Put pictures on a sheet.

    Parameters
    ----------
    pictures : sequence of (H, W, 3 or 4)
        Floats or uint8; row 0 at the top. All of one size. What is transparent shows the
        paper.
    captions : sequence of str
        Of each picture; a line break begins another line. The first line is darker than the others.
    columns : int, optional
        Pictures in a row; for None the sheet becomes about twice as wide as high.
    title : str
        Above all.

    Returns
    -------
    (H, W, 4) float32
        Colours as they are shown, opaque, row 0 at the top; Blender's images want it upside down: ``sheet[::-1]``.
    """
    cells = [_cell(picture, caption) for picture, caption in zip(pictures, captions, strict=True)]
    if not cells:
        raise ValueError("a sheet takes one picture at least")
    height, width = (max(cell.shape[axis] for cell in cells) for axis in (0, 1))
    columns = min(len(cells), columns or max(1, round(math.sqrt(2 * len(cells) * height / width))))
    rows = -(-len(cells) // columns)
    top = GAP + (glyphs.HEIGHT + GAP if title else 0)
    sheet = np.ones((top + rows * (height + GAP), GAP + columns * (width + GAP), 4), np.float32)
    sheet[..., :3] = PAPER
    if title:
        write(sheet, title, GAP, GAP)
    for number, cell in enumerate(cells):
        row, column = divmod(number, columns)
        y, x = top + row * (height + GAP), GAP + column * (width + GAP)
        sheet[y : y + cell.shape[0], x : x + cell.shape[1], :3] = cell
    return sheet


def write(sheet, text, x, y, ink=INK):
    """Write a line into a picture, its upper left corner at (x, y); what does not fit is cut with dots."""
    text = glyphs.fitted(text, sheet.shape[1] - x)
    cover = glyphs.draw(text)[: max(0, sheet.shape[0] - y), : sheet.shape[1] - x, None]
    place = sheet[y : y + cover.shape[0], x : x + cover.shape[1], :3]
    place += (ink - place) * cover


def _cell(picture, caption):
    """A picture under its caption, (H, W, 3)."""
    picture = np.asarray(picture)
    shown = picture.astype(np.float32) / 255 if picture.dtype == np.uint8 else picture.astype(np.float32)
    if shown.shape[-1] == 4:
        shown = shown[..., :3] * shown[..., 3:] + PAPER * (1 - shown[..., 3:])
    lines = caption.split("\n") if caption else []
    label = np.full((glyphs.HEIGHT * len(lines), shown.shape[1], 3), PAPER, np.float32)
    for number, text in enumerate(lines):
        write(label, text, 0, number * glyphs.HEIGHT, FAINT if number else INK)
    return np.concatenate((label, shown))
