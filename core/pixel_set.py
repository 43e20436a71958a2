# SPDX-License-Identifier: GPL-3.0-or-later
"""Some of a picture's pixels, which stand for all."""

from __future__ import annotations

import numpy as np

BLOCK = 8  # pixels to a side
BLOCKS = 256  # of a large picture


class PixelSet:
    """Some of a film's pixels, by their numbers in the order of tracing.

    Parameters
    ----------
    pixels : (K,) int, optional
        Ascending; None is all.
    """

    def __init__(self, pixels=None):
        self._pixels = pixels

    def count(self, total):
        """How many of `total` pixels they are."""
        return total if self._pixels is None else self._pixels.size

    def rows(self, pixels):
        """Where `pixels`, which are among them, stand."""
        return pixels if self._pixels is None else np.searchsorted(self._pixels, pixels)

    def among(self, where):
        """Those of the pixels `where` (slice or (P,) int): (where they stand, which of `where` they are)."""
        if self._pixels is None:
            return where, slice(None)
        if isinstance(where, slice):
            rows = slice(*np.searchsorted(self._pixels, (where.start, where.stop)))
            return rows, self._pixels[rows] - where.start
        rows = np.minimum(np.searchsorted(self._pixels, where), self._pixels.size - 1)
        known = np.flatnonzero(self._pixels[rows] == where)
        return rows[known], known


def spread(pixels):
    """Blocks (h, w, K) of a picture's `pixels` (H, W) at the points of a plane lattice; a small picture as it is.

    Source of the lattice: Roberts (2018), "The Unreasonable Effectiveness of Quasirandom Sequences".
    """
    if pixels.size <= BLOCK**2 * BLOCKS:
        return pixels
    plastic = 1.324717957244746
    tall, wide = (min(BLOCK, side) for side in pixels.shape)
    number = np.arange(BLOCKS)
    top = ((0.5 + number / plastic**2) % 1 * (pixels.shape[0] - tall + 1)).astype(np.intp)
    left = ((0.5 + number / plastic) % 1 * (pixels.shape[1] - wide + 1)).astype(np.intp)
    return pixels[top + np.arange(tall)[:, None, None], left + np.arange(wide)[:, None]]
