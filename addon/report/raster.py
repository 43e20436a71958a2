# SPDX-License-Identifier: GPL-3.0-or-later
"""A chart in pixels, without a library: Blender 4.2 has none that draws, and later ones none that writes."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from . import glyphs

DARK = {
    "paper": (0.11, 0.11, 0.11),
    "text": (0.9, 0.9, 0.9),
    "faint": (0.6, 0.6, 0.6),
    "grid": (0.22, 0.22, 0.22),
    "curve": (0.98, 0.62, 0.22),
    "forecast": (0.75, 0.48, 0.2),
    "root": (0.45, 0.62, 0.85),
    "target": (0.45, 0.8, 0.45),
    "before": (0.5, 0.45, 0.4),
}
"""Colours, as they are shown, of each role; those of Blender's own window."""

_DASH = 6.0  # pixels, and as many between


def paper(width, height, colors=DARK):
    """An empty picture, (H, W, 4) float32, opaque."""
    picture = np.ones((height, width, 4), np.float32)
    picture[..., :3] = colors["paper"]
    return picture


def draw(picture, chart, colors=DARK):
    """Draw a `chart.Chart` into the upper left of a picture (H, W, 4), row 0 at the top."""
    for line in chart.lines:
        _draw_line(picture, line, colors[line.role])
    for text in chart.texts:
        write(picture, text, colors)


def write(picture, text, colors=DARK):
    """Write a `chart.Text`; what does not fit is cut."""
    words = glyphs.fitted(text.text, picture.shape[1] - text.x) if text.anchor == "start" else text.text
    cover = glyphs.draw(words)
    shift = {"start": 0.0, "middle": cover.shape[1] / 2, "end": cover.shape[1]}[text.anchor]
    x, y = max(round(text.x - shift), 0), max(round(text.y - glyphs.HEIGHT / 2), 0)
    place = picture[y : y + glyphs.HEIGHT, x : x + cover.shape[1], :3]
    place += (np.float32(colors[text.role]) - place) * cover[: place.shape[0], : place.shape[1], None]


def _draw_line(picture, line, color):
    """Blend the line in by how far pixels' middles are from it."""
    points = line.points if len(line.points) > 1 else line.points.repeat(2, axis=0)
    pieces = list(_dashes(points)) if line.dashed else list(pairwise(points))
    color, reach = np.float32(color), line.width / 2 + 0.5
    for a, b in pieces:
        x0, y0 = np.maximum(np.floor(np.minimum(a, b) - reach), 0).astype(int)
        x1, y1 = np.ceil(np.maximum(a, b) + reach + 1).astype(int)
        place = picture[y0:y1, x0:x1, :3]
        x, y = x0 + 0.5 + np.arange(place.shape[1]), (y0 + 0.5 + np.arange(place.shape[0]))[:, None]
        way = b - a
        along = np.clip(((x - a[0]) * way[0] + (y - a[1]) * way[1]) / max(float(way @ way), 1e-9), 0, 1)
        far = np.hypot(x - a[0] - along * way[0], y - a[1] - along * way[1])
        place += (color - place) * np.clip(reach - far, 0, 1)[..., None].astype(np.float32)


def _dashes(points):
    """Yield the ends of the dashes along a line."""
    ways = np.diff(points, axis=0)
    lengths = np.hypot(*ways.T)
    at = np.concatenate([[0.0], np.cumsum(lengths)])
    for start in np.arange(0.0, at[-1], 2 * _DASH):
        ends = np.array([start, min(start + _DASH, at[-1])])
        yield from [tuple(np.stack([np.interp(ends, at, points[:, k]) for k in (0, 1)], axis=1))]
