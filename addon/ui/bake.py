# SPDX-License-Identifier: GPL-3.0-or-later
"""The render tab's panels of baking: Blender's own settings and operator, as Cycles shows them."""

from __future__ import annotations

import bpy

from .panel import ClosedPanel, Panel

_LIT = {"DIFFUSE", "GLOSSY", "TRANSMISSION"}
_SEEN = _LIT | {"COMBINED", "EMIT"}


def _multires(context):
    """Where the switch of baking from multiresolution stands; it moved in Blender 5."""
    render = context.scene.render
    return (render.bake, "use_multires") if hasattr(render.bake, "use_multires") else (render, "use_bake_multires")


class RENDER_PT_zraka_bake(ClosedPanel, bpy.types.Panel):
    """What is baked."""

    bl_label = "Bake"

    def draw_settings(self, column, context):
        """Draw the button, and what it bakes; baking from multiresolution is all Blender's."""
        scene, multires = context.scene, _multires(context)
        if getattr(*multires):
            column.operator("object.bake_image", icon="RENDER_STILL")
            column.prop(*multires)
            settings, kind = multires[0], "type" if multires[1] == "use_multires" else "bake_type"
            column.prop(settings, kind)
            return
        column.operator("object.bake", icon="RENDER_STILL").type = scene.zraka.bake_type
        column.prop(*multires)
        column.prop(scene.zraka, "bake_type")
        if scene.zraka.bake_type in _SEEN:
            row = column.row()
            row.active = scene.camera is not None
            row.prop(scene.render.bake, "view_from")


class _Part(Panel):
    bl_parent_id = "RENDER_PT_zraka_bake"

    @classmethod
    def poll(cls, context):
        """Show the panel where Zraka bakes."""
        return super().poll(context) and not getattr(*_multires(context))


class RENDER_PT_zraka_bake_influence(_Part, bpy.types.Panel):
    """Which part of it."""

    bl_label = "Influence"

    @classmethod
    def poll(cls, context):
        """Show the panel for what has parts."""
        return super().poll(context) and context.scene.zraka.bake_type in _LIT | {"COMBINED", "NORMAL"}

    def draw_settings(self, column, context):
        """Draw light and lobes, or the space of normals."""
        kind, settings = context.scene.zraka.bake_type, context.scene.render.bake
        if kind == "NORMAL":
            column.prop(settings, "normal_space", text="Space")
            for name, text in (("normal_r", "Swizzle R"), ("normal_g", "G"), ("normal_b", "B")):
                column.prop(settings, name, text=text)
            return
        light = column.column(heading="Lighting" if kind == "COMBINED" else "Contributions", align=True)
        light.prop(settings, "use_pass_direct")
        light.prop(settings, "use_pass_indirect")
        if kind != "COMBINED":
            light.prop(settings, "use_pass_color")
            return
        lobes = column.column(heading="Contributions", align=True)
        for name in ("diffuse", "glossy", "transmission", "emit"):
            lobes.prop(settings, f"use_pass_{name}")


class RENDER_PT_zraka_bake_selected_to_active(_Part, bpy.types.Panel):
    """From other objects."""

    bl_label = "Selected to Active"
    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012

    def draw_header(self, context):
        """Draw the switch."""
        self.layout.prop(context.scene.render.bake, "use_selected_to_active", text="")

    def draw_settings(self, column, context):
        """Draw the cage and how far it reaches."""
        settings = context.scene.render.bake
        column.active = settings.use_selected_to_active
        column.prop(settings, "use_cage", text="Cage")
        if settings.use_cage:
            column.prop(settings, "cage_object")
        column.prop(settings, "cage_extrusion", text="Extrusion")
        column.prop(settings, "max_ray_distance")


class RENDER_PT_zraka_bake_output(_Part, bpy.types.Panel):
    """Where it goes."""

    bl_label = "Output"

    def draw_settings(self, column, context):
        """Draw the target, and the margin of images."""
        settings = context.scene.render.bake
        column.prop(settings, "target")
        if settings.target == "IMAGE_TEXTURES":
            column.prop(settings, "use_clear", text="Clear Image")
            column.prop(settings, "margin_type", text="Margin")
            column.prop(settings, "margin", text="Size")


CLASSES = (
    RENDER_PT_zraka_bake,
    RENDER_PT_zraka_bake_influence,
    RENDER_PT_zraka_bake_selected_to_active,
    RENDER_PT_zraka_bake_output,
)
