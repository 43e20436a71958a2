# SPDX-License-Identifier: GPL-3.0-or-later
"""The tabs of materials and the world; most of them are Blender's own panels."""

from __future__ import annotations

import bpy

from .panel import ClosedPanel


class MATERIAL_PT_zraka_settings(ClosedPanel, bpy.types.Panel):
    """What Zraka reads of a material beside its nodes."""

    bl_label = "Settings"
    bl_context = "material"

    @classmethod
    def poll(cls, context):
        """Show the panel for materials that are rendered."""
        material = context.material
        return super().poll(context) and material is not None and not material.grease_pencil

    def draw_settings(self, column, context):
        """Draw the number of the pass *Material Index*."""
        column.prop(context.material, "pass_index")


class WORLD_PT_zraka_preview(ClosedPanel, bpy.types.Panel):
    """A small render of the world."""

    bl_label = "Preview"
    bl_context = "world"

    @classmethod
    def poll(cls, context):
        """Show the panel where there is a world."""
        return super().poll(context) and context.world is not None

    def draw(self, context):
        """Draw the preview."""
        self.layout.template_preview(context.world)


class WORLD_PT_zraka_ray_visibility(ClosedPanel, bpy.types.Panel):
    """Which rays see the world; Cycles' add-on keeps it."""

    bl_label = "Ray Visibility"
    bl_context = "world"

    @classmethod
    def poll(cls, context):
        """Show the panel where Cycles' add-on is on."""
        return super().poll(context) and hasattr(context.world, "cycles_visibility")

    def draw_settings(self, column, context):
        """Draw a switch a kind of ray."""
        for name in ("camera", "diffuse", "glossy", "transmission"):
            column.prop(context.world.cycles_visibility, name)


CLASSES = (MATERIAL_PT_zraka_settings, WORLD_PT_zraka_preview, WORLD_PT_zraka_ray_visibility)
