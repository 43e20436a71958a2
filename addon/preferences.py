# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on's page in Blender's preferences: which libraries this Blender runs Zraka with."""

from __future__ import annotations

import importlib.util

import bpy
import numpy as np


class ZrakaPreferences(bpy.types.AddonPreferences):
    """What a report of an error should quote."""

    bl_idname = __package__.rpartition(".")[0]

    def draw(self, context):
        """Draw the versions."""
        column = self.layout.column(align=True)
        column.label(text=f"numpy {np.__version__}")
        for library, use in (("embreex", "the rays"), ("OpenImageIO", "image files")):
            found = importlib.util.find_spec(library) is not None
            column.label(
                text=f"{library}: {'found' if found else f'missing, needed for {use}'}",
                icon="CHECKMARK" if found else "ERROR",
            )


def register():
    """Add the page."""
    bpy.utils.register_class(ZrakaPreferences)


def unregister():
    """Remove it."""
    bpy.utils.unregister_class(ZrakaPreferences)
