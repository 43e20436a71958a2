# SPDX-License-Identifier: GPL-3.0-or-later
"""How the latest render went, or goes, in the render tab."""

from __future__ import annotations

import bpy

from ..error_curve import sentences, table
from ..monitor import monitor
from .curve import error_icon
from .panel import ClosedPanel


class RENDER_PT_zraka_latest(ClosedPanel, bpy.types.Panel):
    """Error over time, what is foretold, and where it is kept."""

    bl_label = "Latest Render"

    def draw_settings(self, column, context):
        """Draw the curve and its figures; `error_curve.look` has them drawn anew."""
        record = monitor.latest(context.scene.name)
        if record is None:
            column.label(text="Nothing was rendered yet")
        else:
            icon = error_icon(record, monitor.before(context.scene.name))
            if icon:
                column.template_icon(icon, scale=_SCALE)
            for sentence in sentences(record):
                column.label(text=sentence)
            cells = column.grid_flow(row_major=True, columns=3, align=True)
            for row in table(record):
                for word in row:
                    cells.label(text=word)
            buttons = column.row()
            buttons.operator("zraka.error_curve", icon="IMGDISPLAY")
            buttons.operator("zraka.error_report", icon="FILE_TICK")
        column.prop(context.scene.zraka, "use_error_table")


_SCALE = 9.0  # of the curve; a scale of 1 is as high as a button

CLASSES = (RENDER_PT_zraka_latest,)
