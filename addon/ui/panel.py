# SPDX-License-Identifier: GPL-3.0-or-later
"""What all of Zraka's panels share."""

from __future__ import annotations

from ..properties import ENGINE


class Panel:
    """A panel of the render tab; the others name another `bl_context`."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    COMPAT_ENGINES = {ENGINE}  # noqa: RUF012 - Blender's own name and type

    @classmethod
    def poll(cls, context):
        """Show the panel where Zraka renders."""
        return context.engine in cls.COMPAT_ENGINES

    def draw(self, context):
        """Draw properties in Blender's two columns."""
        self.layout.use_property_split = True
        self.layout.use_property_decorate = False
        self.draw_settings(self.layout.column(), context)

    def draw_settings(self, column, context):
        """Draw what the panel is for; nothing where the panel only holds others."""


class ClosedPanel(Panel):
    """One that is closed at first."""

    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012


def traces_paths(context):
    """Whether the chosen method follows more than mirrors and glass."""
    return context.scene.zraka.method == "PATHTRACE"
