# SPDX-License-Identifier: GPL-3.0-or-later
"""Error over time as a picture inside a panel."""

from __future__ import annotations

import bpy.utils.previews
import numpy as np

from ..report import raster
from ..report.chart import error_chart

WIDTH = HEIGHT = 256
"""Pixels; Blender keeps a square free for a preview."""

_drawn = {"previews": None, "history": None}


def error_icon(record, before=None):
    """Number of an icon that shows the curve; 0 where no error is known yet.

    Parameters
    ----------
    record, before : monitor.Record
        The latest render of a scene, and the one before.
    """
    chart = error_chart(record, before, WIDTH, HEIGHT)
    if chart is None:
        return 0
    if _drawn["previews"] is None:
        _drawn["previews"] = bpy.utils.previews.new()
    previews = _drawn["previews"]
    preview = previews["error"] if "error" in previews else previews.new("error")
    shown = record.history, record.is_done
    if _drawn["history"] != shown:
        _drawn["history"] = shown
        picture = raster.paper(WIDTH, HEIGHT)
        raster.draw(picture, chart)
        pixels = np.ascontiguousarray(picture[::-1]).reshape(-1)
        preview.image_size = preview.icon_size = WIDTH, HEIGHT
        preview.image_pixels_float.foreach_set(pixels)
        preview.icon_pixels_float.foreach_set(pixels)
    return preview.icon_id


def forget():
    """Free the picture."""
    if _drawn["previews"] is not None:
        bpy.utils.previews.remove(_drawn["previews"])
    _drawn.update(previews=None, history=None)
