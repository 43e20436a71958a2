# SPDX-License-Identifier: GPL-3.0-or-later
"""Error over time as a small picture inside a panel; both axes are logarithmic, where noise falls along a line."""

from __future__ import annotations

import bpy
import bpy.utils.previews
import numpy as np

WIDTH, HEIGHT = 192, 96
_BACK, _GRID, _LINE = (0.1, 0.1, 0.1, 1.0), (0.22, 0.22, 0.22, 1.0), (0.95, 0.6, 0.2, 1.0)
_LOOK_EVERY = 0.5  # seconds

_drawn = {"previews": None, "points": None, "waiting": False}


def error_curve(points):
    """Number of an icon that shows the curve; 0 where fewer than two points have a finite error.

    Parameters
    ----------
    points : sequence of (samples, seconds, error)
    """
    if curve_pixels(points) is None:
        return 0
    if _drawn["previews"] is None:
        _drawn["previews"] = bpy.utils.previews.new()
    previews = _drawn["previews"]
    preview = previews["error"] if "error" in previews else previews.new("error")
    if _drawn["points"] != points:
        _drawn["points"] = points
        preview.image_size = preview.icon_size = WIDTH, HEIGHT
        pixels = curve_pixels(points).reshape(-1)
        preview.image_pixels_float.foreach_set(pixels)
        preview.icon_pixels_float.foreach_set(pixels)
    return preview.icon_id


def curve_pixels(points):
    """The picture, (HEIGHT, WIDTH, 4) float32, row 0 at the bottom; lines stand at the powers of ten of the error."""
    data = np.array([(seconds, error) for _, seconds, error in points], np.float64).reshape(-1, 2)
    data = np.log10(data[np.isfinite(data).all(axis=1) & (data > 0).all(axis=1)])
    if len(data) < 2 or data[0, 0] == data[-1, 0]:
        return None
    low, high = np.floor(data[:, 1].min()), np.ceil(data[:, 1].max() + 1e-9)
    picture = np.zeros((HEIGHT, WIDTH, 4), np.float32)
    picture[:] = _BACK
    for power in range(int(low), int(high) + 1):
        picture[_row_of(power, low, high)] = _GRID
    columns = np.arange(WIDTH)
    times = data[0, 0] + (data[-1, 0] - data[0, 0]) * columns / (WIDTH - 1)
    rows = _row_of(np.interp(times, data[:, 0], data[:, 1]), low, high)
    for thick in (0, 1):
        picture[np.minimum(rows + thick, HEIGHT - 1), columns] = _LINE
    return picture


def _row_of(exponent, low, high):
    return np.asarray((exponent - low) / (high - low) * (HEIGHT - 2)).astype(np.int64)


def redraw_later():
    """Let the tabs of properties be drawn again soon: a render tells them nothing."""
    if not _drawn["waiting"]:
        _drawn["waiting"] = True
        bpy.app.timers.register(_redraw, first_interval=_LOOK_EVERY)


def _redraw():
    _drawn["waiting"] = False
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "PROPERTIES":
                area.tag_redraw()


def forget():
    """Free the picture, and end the timer."""
    if _drawn["previews"] is not None:
        bpy.utils.previews.remove(_drawn["previews"])
    if bpy.app.timers.is_registered(_redraw):
        bpy.app.timers.unregister(_redraw)
    _drawn.update(previews=None, points=None, waiting=False)
