# SPDX-License-Identifier: GPL-3.0-or-later
"""The object tab; Blender's own panel *Visibility* is taken over, with what it shows for Cycles alone added."""

from __future__ import annotations

import bpy

from .panel import ClosedPanel, Panel

_SHAPES = {"MESH", "CURVE", "SURFACE", "META", "FONT", "CURVES", "POINTCLOUD", "VOLUME"}


def _has_rays(obj):
    """Whether rays may meet the object, or what it instances."""
    return obj is not None and (
        obj.type in _SHAPES | {"LIGHT"} or (obj.type == "EMPTY" and obj.instance_type != "NONE")
    )


class OBJECT_PT_zraka_plane(Panel, bpy.types.Panel):
    """An empty may be an infinite plane."""

    bl_label = "Zraka Plane"
    bl_context = "object"

    @classmethod
    def poll(cls, context):
        """Show the panel for empties."""
        return super().poll(context) and context.object is not None and context.object.type == "EMPTY"

    def draw_header(self, context):
        """Draw the switch."""
        self.layout.prop(context.object.zraka, "plane", text="")

    def draw_settings(self, column, context):
        """Draw the material."""
        column.active = context.object.zraka.plane
        column.prop(context.object.zraka, "plane_material")


class OBJECT_PT_zraka_ray_visibility(ClosedPanel, bpy.types.Panel):
    """Which rays meet the object: Blender's own switches, as Cycles has them."""

    bl_label = "Ray Visibility"
    bl_context = "object"
    bl_parent_id = "OBJECT_PT_visibility"

    @classmethod
    def poll(cls, context):
        """Show the panel for what rays may meet."""
        return super().poll(context) and _has_rays(context.object)

    def draw_settings(self, column, context):
        """Draw a switch a kind of ray."""
        obj = context.object
        for name in ("Camera", "Diffuse", "Glossy", "Transmission"):
            column.prop(obj, f"visible_{name.lower()}", text=name)
        if obj.type != "LIGHT":
            column.prop(obj, "visible_shadow", text="Shadow")
            column.prop(obj, "is_shadow_catcher")


CLASSES = (OBJECT_PT_zraka_plane, OBJECT_PT_zraka_ray_visibility)
