# SPDX-License-Identifier: GPL-3.0-or-later
"""Pixel filters: a sample counts for its pixel alone and falls where the filter says, also beyond the pixel's edge.

All samples weigh the same, so the film is a plain mean. Source: Ernst, Stamminger and Greiner, "Filter Importance
Sampling", IEEE Symposium on Interactive Ray Tracing, 2006. Shapes and widths are those of Cycles, scene/film.cpp.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

FILTERS = ("box", "gaussian", "blackman_harris")
_CELLS = 16383  # odd, so that 0.5 is the middle of a cell and gives the pixel's centre


def filter_profile(kind, width):
    """The filter along one axis.

    Parameters
    ----------
    kind : str
        One of `FILTERS`. "box" is always one pixel wide.
    width : float
        Blender's, in pixels: the Gaussian's standard deviation is a quarter of it and it ends at 1.5 widths from the
        centre; Blackman-Harris ends at one width.

    Returns
    -------
    half : float
        Where the filter ends, in pixels from the centre.
    profile : callable
        Its value, not normalised, at such distances.
    """
    if kind == "box":
        return 0.5, np.ones_like
    if kind == "gaussian":
        return 1.5 * width, lambda x: np.exp(-8 * (x / width) ** 2)
    if kind == "blackman_harris":
        return width, lambda x: _blackman_harris(np.pi * x / width)
    raise ValueError(f"unknown pixel filter {kind!r}; choose one of {', '.join(FILTERS)}")


def _blackman_harris(angle):
    return 0.35875 + 0.48829 * np.cos(angle) + 0.14128 * np.cos(2 * angle) + 0.01168 * np.cos(3 * angle)


class PixelFilter:
    """A filter made ready: even numbers become places in and around the pixel.

    Parameters
    ----------
    kind : {"gaussian", "blackman_harris"}
    width : float
        As in `filter_profile`.
    """

    def __init__(self, kind, width):
        half, profile = filter_profile(kind, width)
        x = np.linspace(-half, half, 4 * _CELLS)
        value = profile(x)
        cdf = np.concatenate(([0], np.cumsum(0.5 * (value[1:] + value[:-1]))))
        middles = np.interp((np.arange(_CELLS) + 0.5) / _CELLS, cdf / cdf[-1], x)
        # Symmetric to the last bit.
        self._places = (0.5 + 0.5 * (middles - middles[::-1])).astype(np.float32)

    def place(self, jitter, arena):
        """Move even numbers `jitter` (2, N) in place to where the filter wants samples; the pixel is [0, 1)²."""
        with arena.frame():
            cell = arena.empty(jitter.shape[1], np.int32)
            for row in jitter:
                np.multiply(row, _CELLS, out=row)
                np.copyto(cell, row, casting="unsafe")
                np.take(self._places, cell, out=row, mode="clip")


@lru_cache(maxsize=4)
def pixel_filter(kind, width):
    """A `PixelFilter`; None for the box, which leaves the samples where they are."""
    filter_profile(kind, width)
    return None if kind == "box" else PixelFilter(kind, width)
