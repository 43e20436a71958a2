# SPDX-License-Identifier: GPL-3.0-or-later
"""Error over time in Blender's window: as an image, and as a page to keep.

Renders run on a thread of Blender's, which may not touch its data. So a timer on the window's own thread looks twice a
second whether `monitor` knows more.
"""

from __future__ import annotations

import math
from pathlib import Path

import bpy
import numpy as np
from bpy.app.handlers import persistent

from ..core.diagnostics import SceneError
from .compare import show
from .monitor import monitor
from .progress import ends_text, error_text, forecast_text, reaches_text, thinned
from .properties import METHODS
from .report import raster
from .report.chart import Text, error_chart
from .report.glyphs import HEIGHT as LINE

IMAGE = "Zraka Error"
SIZE = 680, 380  # of the chart
LOOK_EVERY = 0.5  # seconds
ROWS = 8
"""Of the table of errors."""

NAMES = {identifier.lower(): label for identifier, label, _ in METHODS}
_COLUMNS = 90, 190, 300  # where the table's columns end
_SENTENCES = 330  # where what stands beside it begins

_seen = {"changes": 0, "packed": None, "shown": None, "curve": None}


# -- what is said ------------------------------------------------------------------------------------------------------


def sentences(record):
    """What is known of a render, and what is foretold."""
    said = [f"{NAMES[record.settings.method]}, {record.rays / 1e6:.2f} M rays/s"]
    said.append(f"Error {error_text(record)} after {record.stats.get('seconds', 0.0):.2f} s")
    if record.is_done:
        said.append(f"Ended by {_ENDED[record.stats['stopped']]}")
        return said + reaches_text(record)
    if foretold := forecast_text(record, record.settings):
        said.append(foretold[0].upper() + foretold[1:])
    said.append(ends_text(record.settings))
    return list(dict.fromkeys([*said, *reaches_text(record)]))


_ENDED = {"samples": "its samples", "noise": "its noise target", "time": "its time limit", "cancelled": "a cancel"}


def table(record):
    """Rows of samples, seconds and error, as texts; the head first."""
    return [("Samples", "Seconds", "Error"), *map(_row, thinned(record.history)[-ROWS:])]


def _row(step):
    error = f"{step.error:.2%}" if math.isfinite(step.error) else "unknown"
    return f"{step.samples:.0f}", f"{step.seconds:.2f}", error


# -- the image ---------------------------------------------------------------------------------------------------------


def error_sheet(record, before=None):
    """Chart, table and sentences in one picture, (H, W, 4) float32, row 0 at the top, colours as they are shown."""
    width, height = SIZE
    sheet = raster.paper(width, height + (ROWS + 2) * LINE)
    sheet[:height] = _curve(record, before)
    for number, row in enumerate(table(record)):
        for x, word in zip(_COLUMNS, row, strict=True):
            place = x, height + (number + 1) * LINE
            raster.write(sheet, Text(*place, word, "text" if number else "faint", "end"))
    for number, sentence in enumerate(sentences(record)):
        raster.write(sheet, Text(_SENTENCES, height + (number + 1) * LINE, sentence))
    return sheet


def _curve(record, before):
    """The chart alone, drawn when another step of the render is known: that takes longer than to write texts."""
    shown = record.history, record.is_done, before and before.history, record.settings
    if _seen["shown"] != shown:
        picture, chart = raster.paper(*SIZE), error_chart(record, before, *SIZE)
        if chart is None:
            raster.write(picture, Text(SIZE[0] / 2, SIZE[1] / 2, "No error is known yet", "faint", "middle"))
        else:
            raster.draw(picture, chart)
        _seen.update(shown=shown, curve=picture)
    return _seen["curve"]


def write_image(scene):
    """Draw the latest render of the scene of that name into the image `IMAGE`; None where there is none.

    Returns
    -------
    bpy.types.Image or None
    """
    record = monitor.latest(scene)
    if record is None:
        return None
    sheet = error_sheet(record, monitor.before(scene))[::-1]
    height, width = sheet.shape[:2]
    image = bpy.data.images.get(IMAGE)
    if image is None or tuple(image.size) != (width, height):
        image = image or bpy.data.images.new(IMAGE, width, height)
        image.scale(width, height)
    image.pixels.foreach_set(np.ascontiguousarray(sheet).reshape(-1))
    image.update()
    if record.is_done and _seen["packed"] is not record:
        image.pack()  # so that the file keeps it
        _seen["packed"] = record
    return image


# -- the window --------------------------------------------------------------------------------------------------------


def look():
    """Show what is new; called by a timer, on the window's own thread."""
    if _seen["changes"] != monitor.changes:
        _seen["changes"] = monitor.changes
        windows = bpy.context.window_manager.windows
        if bpy.data.images.get(IMAGE) is not None and windows:
            write_image(windows[0].scene.name)
        for window in windows:
            for area in window.screen.areas:
                if area.type == "PROPERTIES" or (area.type == "IMAGE_EDITOR" and _shows(area)):
                    area.tag_redraw()
    return LOOK_EVERY


def _shows(area):
    image = area.spaces.active.image
    return image is not None and image.name == IMAGE


class ZRAKA_OT_error_curve(bpy.types.Operator):
    """Draw the error over time of the latest render, and of one that goes on."""

    bl_idname = "zraka.error_curve"
    bl_label = "Show Error Curve"
    bl_description = (
        f"Draw the error of the latest render over its time into the image '{IMAGE}', which open image editors can "
        "show. It is drawn anew twice a second while a render goes on"
    )

    @classmethod
    def poll(cls, context):
        """Offer it when there is something to show."""
        return context.scene is not None and monitor.latest(context.scene.name) is not None

    def execute(self, context):
        """Draw it."""
        show(context, write_image(context.scene.name))
        return {"FINISHED"}


class ZRAKA_OT_error_report(bpy.types.Operator):
    """Keep the latest render's picture, curve, table, settings and machine in one page."""

    bl_idname = "zraka.error_report"
    bl_label = "Save Report"
    bl_description = (
        "Save a page of the latest render that holds all in one file: the picture, where and how large its error is, "
        "error over time as curve and table, settings and machine"
    )

    filepath: bpy.props.StringProperty(name="File", description="The .html file that is written", subtype="FILE_PATH")
    filter_glob: bpy.props.StringProperty(default="*.html", options={"HIDDEN"})
    check_existing: bpy.props.BoolProperty(default=True, options={"HIDDEN"})

    @classmethod
    def poll(cls, context):
        """Offer it when a render is done."""
        record = monitor.latest(context.scene.name) if context.scene is not None else None
        if record is None or not record.is_done:
            cls.poll_message_set("Render first, and let the render end")
            return False
        return True

    def invoke(self, context, event):
        """Ask where."""
        blend = Path(bpy.data.filepath)
        self.filepath = self.filepath or str(blend.with_name(f"{blend.stem or 'untitled'}_error.html"))
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        """Write the page."""
        from .report.latest import write_report

        path = Path(bpy.path.abspath(self.filepath)).with_suffix(".html")
        try:
            write_report(path, context.scene, monitor.latest(context.scene.name))
        except SceneError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"Saved {path}")
        return {"FINISHED"}


@persistent
def _on_load(*_):
    monitor.forget()


CLASSES = (ZRAKA_OT_error_curve, ZRAKA_OT_error_report)


def register():
    """Add the operators, and look out for renders where there is a window."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.app.handlers.load_post.append(_on_load)
    if not bpy.app.background:
        bpy.app.timers.register(look, first_interval=LOOK_EVERY, persistent=True)


def unregister():
    """Remove them."""
    if bpy.app.timers.is_registered(look):
        bpy.app.timers.unregister(look)
    bpy.app.handlers.load_post.remove(_on_load)
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
