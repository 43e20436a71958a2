# SPDX-License-Identifier: GPL-3.0-or-later
"""Zraka's panels, and the panels of Blender that Zraka takes over."""

from __future__ import annotations

import bpy

from .engine import ENGINE
from .properties import OVERRIDES

# Panels written for EEVEE or Cycles whose settings Zraka honours; the names change from one Blender to the next.
BORROWED = (
    "DATA_PT_EEVEE_light",
    "DATA_PT_camera_dof",
    "DATA_PT_camera_dof_aperture",
    "EEVEE_MATERIAL_PT_context_material",
    "EEVEE_MATERIAL_PT_surface",
    "EEVEE_WORLD_PT_surface",
    "MATERIAL_PT_preview",
    "NODE_DATA_PT_EEVEE_light",
)


class _Panel:
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    COMPAT_ENGINES = {ENGINE}  # noqa: RUF012 - Blender's own name and type

    @classmethod
    def poll(cls, context):
        """Show the panel where Zraka renders."""
        return context.engine in cls.COMPAT_ENGINES

    def draw(self, context):
        """Draw the properties of the scene's settings."""
        self.layout.use_property_split = True
        self.layout.use_property_decorate = False
        self.draw_settings(self.layout.column(), context.scene.zraka)


class RENDER_PT_zraka_method(_Panel, bpy.types.Panel):
    """Which method renders, and how deep."""

    bl_label = "Method"

    def draw_settings(self, column, settings):
        """Draw method and depth; Phong and ray casting stop at the first hit."""
        column.prop(settings, "method")
        if settings.method in {"RAYTRACE", "PATHTRACE"}:
            column.prop(settings, "depth")


class RENDER_PT_zraka_overrides(_Panel, bpy.types.Panel):
    """One value of the classic methods for all materials."""

    bl_label = "Material Overrides"
    bl_parent_id = "RENDER_PT_zraka_method"
    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012

    @classmethod
    def poll(cls, context):
        """Show the panel for the classic methods; path tracing takes the materials as they are."""
        return super().poll(context) and context.scene.zraka.method != "PATHTRACE"

    def draw_settings(self, column, settings):
        """Draw a switch and a value a row."""
        for name in OVERRIDES:
            row = column.row(heading=settings.bl_rna.properties[name].name)
            row.prop(settings, f"use_{name}", text="")
            value = row.row()
            value.active = getattr(settings, f"use_{name}")
            value.prop(settings, name, text="")


class RENDER_PT_zraka_sampling(_Panel, bpy.types.Panel):
    """How many samples, and when it is enough."""

    bl_label = "Sampling"

    def draw_settings(self, column, settings):
        """Draw samples, limits and seed."""
        column.prop(settings, "samples")
        column.prop(settings, "viewport_samples")
        column.prop(settings, "noise_target")
        column.prop(settings, "adaptive")
        column.prop(settings, "time_limit")
        column.prop(settings, "seed")


class RENDER_PT_zraka_light_paths(_Panel, bpy.types.Panel):
    """What a path may do."""

    bl_label = "Light Paths"
    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012

    def draw_settings(self, column, settings):
        """Draw the depth of transparency, and clamping where there is indirect light."""
        column.prop(settings, "transparent_depth")
        if settings.method == "PATHTRACE":
            column.prop(settings, "clamp_direct")
            column.prop(settings, "clamp_indirect")


class RENDER_PT_zraka_film(_Panel, bpy.types.Panel):
    """What stands behind the scene, and how pixels take it in."""

    bl_label = "Film"
    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012

    def draw(self, context):
        """Draw Blender's own switch and the pixel filter."""
        settings = context.scene.zraka
        self.layout.use_property_split = True
        self.layout.prop(context.scene.render, "film_transparent", text="Transparent")
        column = self.layout.column()
        column.prop(settings, "pixel_filter")
        if settings.pixel_filter != "BOX":
            column.prop(settings, "filter_width")


class RENDER_PT_zraka_performance(_Panel, bpy.types.Panel):
    """How much of the machine Zraka takes."""

    bl_label = "Performance"
    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012

    def draw(self, context):
        """Draw Blender's own settings of threads."""
        render = context.scene.render
        self.layout.use_property_split = True
        self.layout.use_property_decorate = False
        column = self.layout.column()
        column.prop(render, "threads_mode")
        threads = column.column()
        threads.enabled = render.threads_mode == "FIXED"
        threads.prop(render, "threads")
        column.prop(render, "preview_pixel_size", text="Viewport Pixel Size")


class OBJECT_PT_zraka_plane(_Panel, bpy.types.Panel):
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

    def draw(self, context):
        """Draw the material."""
        self.layout.use_property_split = True
        self.layout.active = context.object.zraka.plane
        self.layout.prop(context.object.zraka, "plane_material")


CLASSES = (
    RENDER_PT_zraka_method,
    RENDER_PT_zraka_overrides,
    RENDER_PT_zraka_sampling,
    RENDER_PT_zraka_light_paths,
    RENDER_PT_zraka_film,
    RENDER_PT_zraka_performance,
    OBJECT_PT_zraka_plane,
)


def shared_panels():
    """Find the panels of Blender that serve Zraka as well."""
    left_out = {"VIEWLAYER_PT_filter", "VIEWLAYER_PT_layer_passes"}
    found = [
        panel
        for panel in bpy.types.Panel.__subclasses__()
        if "BLENDER_RENDER" in getattr(panel, "COMPAT_ENGINES", ()) and panel.__name__ not in left_out
    ]
    return found + [getattr(bpy.types, name) for name in BORROWED if hasattr(bpy.types, name)]


def register():
    """Add Zraka's panels, and Zraka to Blender's."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    for panel in shared_panels():
        panel.COMPAT_ENGINES.add(ENGINE)


def unregister():
    """Undo `register`."""
    for panel in shared_panels():
        panel.COMPAT_ENGINES.discard(ENGINE)
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
