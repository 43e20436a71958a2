# SPDX-License-Identifier: GPL-3.0-or-later
"""The render tab, in Cycles' order; only what the chosen method uses is shown."""

from __future__ import annotations

import bpy

from ..presets import ZRAKA_PT_sampling_presets
from ..properties import OVERRIDES
from .panel import ClosedPanel, Panel, traces_paths


class RENDER_PT_zraka_method(Panel, bpy.types.Panel):
    """Which method renders."""

    bl_label = "Method"

    def draw_settings(self, column, context):
        """Draw the method, and what compares all four."""
        settings = context.scene.zraka
        column.prop(settings, "method")
        column.operator("zraka.compare_methods", icon="IMGDISPLAY")
        if settings.took_over:
            column.label(text="Settings taken over from Cycles", icon="INFO")


class RENDER_PT_zraka_overrides(ClosedPanel, bpy.types.Panel):
    """One value of the classic methods for all materials."""

    bl_label = "Material Overrides"
    bl_parent_id = "RENDER_PT_zraka_method"

    @classmethod
    def poll(cls, context):
        """Show the panel for the classic methods; path tracing takes the materials as they are."""
        return super().poll(context) and not traces_paths(context)

    def draw_settings(self, column, context):
        """Draw a switch and a value a row."""
        settings = context.scene.zraka
        for name in OVERRIDES:
            row = column.row(heading=settings.bl_rna.properties[name].name)
            row.prop(settings, f"use_{name}", text="")
            value = row.row()
            value.active = getattr(settings, f"use_{name}")
            value.prop(settings, name, text="")


class RENDER_PT_zraka_sampling(Panel, bpy.types.Panel):
    """How many samples, and when it is enough."""

    bl_label = "Sampling"

    def draw_header_preset(self, context):
        """Draw the menu of presets."""
        ZRAKA_PT_sampling_presets.draw_panel_header(self.layout)


class RENDER_PT_zraka_sampling_viewport(Panel, bpy.types.Panel):
    """Of Rendered shading."""

    bl_label = "Viewport"
    bl_parent_id = "RENDER_PT_zraka_sampling"

    def draw_settings(self, column, context):
        """Draw how far Rendered shading is refined."""
        settings = context.scene.zraka
        column.prop(settings, "viewport_noise_target", text="Noise Target")
        limited = settings.viewport_noise_target > 0
        column.prop(settings, "viewport_samples", text="Max Samples" if limited else "Samples")


class RENDER_PT_zraka_sampling_render(Panel, bpy.types.Panel):
    """Of final renders."""

    bl_label = "Render"
    bl_parent_id = "RENDER_PT_zraka_sampling"

    def draw_settings(self, column, context):
        """Draw samples and what ends a render earlier."""
        settings = context.scene.zraka
        column.prop(settings, "noise_target")
        column.prop(settings, "samples", text="Max Samples" if settings.noise_target > 0 else "Samples")
        column.prop(settings, "time_limit")
        column.prop(settings, "adaptive")


class RENDER_PT_zraka_sampling_advanced(ClosedPanel, bpy.types.Panel):
    """What few need."""

    bl_label = "Advanced"
    bl_parent_id = "RENDER_PT_zraka_sampling"

    def draw_settings(self, column, context):
        """Draw the seed, and the way from Cycles."""
        column.prop(context.scene.zraka, "seed")
        column.operator("zraka.take_over_cycles", icon="IMPORT")


class RENDER_PT_zraka_light_paths(ClosedPanel, bpy.types.Panel):
    """What a path may do."""

    bl_label = "Light Paths"


class RENDER_PT_zraka_max_bounces(Panel, bpy.types.Panel):
    """How far a path may go."""

    bl_label = "Max Bounces"
    bl_parent_id = "RENDER_PT_zraka_light_paths"

    def draw_settings(self, column, context):
        """Draw depths; Phong and ray casting stop at the first hit, and ray tracing at what is diffuse."""
        settings = context.scene.zraka
        if settings.method in {"RAYTRACE", "PATHTRACE"}:
            column.prop(settings, "depth")
            if settings.method == "PATHTRACE":
                column.prop(settings, "diffuse_bounces", text="Diffuse")
            column.prop(settings, "glossy_bounces", text="Glossy")
            column.prop(settings, "transmission_bounces", text="Transmission")
        column.prop(settings, "transparent_depth", text="Transparent")


class RENDER_PT_zraka_clamping(Panel, bpy.types.Panel):
    """Light given up for fewer bright dots."""

    bl_label = "Clamping"
    bl_parent_id = "RENDER_PT_zraka_light_paths"

    @classmethod
    def poll(cls, context):
        """Show the panel where there are random paths."""
        return super().poll(context) and traces_paths(context)

    def draw_settings(self, column, context):
        """Draw both limits."""
        settings = context.scene.zraka
        column.prop(settings, "clamp_direct", text="Direct Light")
        column.prop(settings, "clamp_indirect", text="Indirect Light")


class RENDER_PT_zraka_motion_blur(ClosedPanel, bpy.types.Panel):
    """Blender's own settings of the shutter."""

    bl_label = "Motion Blur"

    def draw_header(self, context):
        """Draw the switch."""
        self.layout.prop(context.scene.render, "use_motion_blur", text="")

    def draw_settings(self, column, context):
        """Draw when the shutter opens, and for how long."""
        render = context.scene.render
        column.active = render.use_motion_blur
        if hasattr(render, "motion_blur_position"):
            column.prop(render, "motion_blur_position", text="Position")
        column.prop(render, "motion_blur_shutter")
        column.template_curve_mapping(render, "motion_blur_shutter_curve")


class RENDER_PT_zraka_film(ClosedPanel, bpy.types.Panel):
    """How light becomes a picture."""

    bl_label = "Film"

    def draw_settings(self, column, context):
        """Draw the exposure, and Blender's own switch of the world."""
        column.prop(context.scene.zraka, "exposure")
        column.prop(context.scene.render, "film_transparent", text="Transparent")


class RENDER_PT_zraka_film_transparency(Panel, bpy.types.Panel):
    """How a transparent film is seen through glass."""

    bl_label = "Transparent"
    bl_parent_id = "RENDER_PT_zraka_film"

    @classmethod
    def poll(cls, context):
        """Show the panel where there are random paths."""
        return super().poll(context) and traces_paths(context)

    def draw_settings(self, column, context):
        """Draw the switch and its limit."""
        settings = context.scene.zraka
        column.active = context.scene.render.film_transparent
        column.prop(settings, "film_transparent_glass")
        limit = column.column()
        limit.active = settings.film_transparent_glass
        limit.prop(settings, "film_transparent_roughness")


class RENDER_PT_zraka_pixel_filter(Panel, bpy.types.Panel):
    """How pixels take in what is around them."""

    bl_label = "Pixel Filter"
    bl_parent_id = "RENDER_PT_zraka_film"

    def draw_settings(self, column, context):
        """Draw kind and width; the box has no other than a pixel's."""
        settings = context.scene.zraka
        column.prop(settings, "pixel_filter", text="Type")
        if settings.pixel_filter != "BOX":
            column.prop(settings, "filter_width")


class RENDER_PT_zraka_performance(ClosedPanel, bpy.types.Panel):
    """How much of the machine Zraka takes."""

    bl_label = "Performance"

    def draw_settings(self, column, context):
        """Draw Blender's own settings of threads, the order of pixels and the viewport's pixels."""
        render = context.scene.render
        column.prop(render, "threads_mode")
        threads = column.column()
        threads.enabled = render.threads_mode == "FIXED"
        threads.prop(render, "threads")
        column.prop(context.scene.zraka, "tile")
        column.prop(render, "preview_pixel_size", text="Viewport Pixel Size")
        column.prop(render, "use_persistent_data")


CLASSES = (
    RENDER_PT_zraka_method,
    RENDER_PT_zraka_overrides,
    RENDER_PT_zraka_sampling,
    RENDER_PT_zraka_sampling_viewport,
    RENDER_PT_zraka_sampling_render,
    RENDER_PT_zraka_sampling_advanced,
    RENDER_PT_zraka_light_paths,
    RENDER_PT_zraka_max_bounces,
    RENDER_PT_zraka_clamping,
    RENDER_PT_zraka_motion_blur,
    RENDER_PT_zraka_film,
    RENDER_PT_zraka_film_transparency,
    RENDER_PT_zraka_pixel_filter,
    RENDER_PT_zraka_performance,
)
