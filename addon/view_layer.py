# SPDX-License-Identifier: GPL-3.0-or-later
"""The view layers' settings, ``view_layer.zraka``, and their panels: which passes are rendered."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, PointerProperty

from .ui.panel import Panel


def _update(settings, context):
    """Let Blender ask again which passes there are."""
    context.view_layer.update_render_passes()


class ZrakaViewLayerSettings(bpy.types.PropertyGroup):
    """Passes that Blender itself has no switch for."""

    use_pass_denoising: BoolProperty(
        name="Denoising Data",
        description="Albedo, normal and depth as a denoiser likes them: what mirrors and glass show rather than they "
        "themselves. Takes a few camera rays of each pixel more",
        default=False,
        update=_update,
    )
    use_pass_sample_count: BoolProperty(
        name="Sample Count",
        description="Samples that each pixel took, as a share of those asked for; costs nothing",
        default=False,
        update=_update,
    )
    use_pass_error: BoolProperty(
        name="Error",
        description="Estimated standard error of each pixel's brightness: where the noise is; costs nothing",
        default=False,
        update=_update,
    )


class _PassesPanel(Panel):
    bl_context = "view_layer"
    switches = ()

    def draw(self, context):
        """Draw switches of the view layer."""
        self.layout.use_property_split = True
        self.layout.use_property_decorate = False
        column = self.layout.column()
        for name, text in self.switches:
            column.prop(context.view_layer, f"use_pass_{name}", text=text)
        self.draw_more(column, context.view_layer)

    def draw_more(self, column, view_layer):
        """Draw what is not a switch of Blender's."""


class VIEWLAYER_PT_zraka_passes(_PassesPanel, bpy.types.Panel):
    """Pictures beside the picture, in groups."""

    bl_label = "Passes"

    def draw(self, context):
        """Draw nothing: the groups are panels of their own."""


class VIEWLAYER_PT_zraka_passes_data(_PassesPanel, bpy.types.Panel):
    """What is where."""

    bl_label = "Data"
    bl_parent_id = "VIEWLAYER_PT_zraka_passes"
    switches = (
        ("z", "Z"),
        ("mist", "Mist"),
        ("position", "Position"),
        ("normal", "Normal"),
        ("vector", "Vector"),
        ("uv", "UV"),
        ("object_index", "Object Index"),
        ("material_index", "Material Index"),
    )

    def draw_more(self, column, view_layer):
        """Draw Zraka's own, and what is looked through."""
        for name in ("use_pass_denoising", "use_pass_sample_count", "use_pass_error"):
            column.prop(view_layer.zraka, name)
        column.prop(view_layer, "pass_alpha_threshold")
        column.operator("zraka.denoise")


class VIEWLAYER_PT_zraka_passes_light(_PassesPanel, bpy.types.Panel):
    """Light by the way it came, the colours that sent it on, and light seen directly."""

    bl_label = "Light"
    bl_parent_id = "VIEWLAYER_PT_zraka_passes"
    switches = (
        ("diffuse_direct", "Diffuse Direct"),
        ("diffuse_indirect", "Diffuse Indirect"),
        ("diffuse_color", "Diffuse Color"),
        ("glossy_direct", "Glossy Direct"),
        ("glossy_indirect", "Glossy Indirect"),
        ("glossy_color", "Glossy Color"),
        ("transmission_direct", "Transmission Direct"),
        ("transmission_indirect", "Transmission Indirect"),
        ("transmission_color", "Transmission Color"),
        ("emit", "Emission"),
        ("environment", "Environment"),
        ("ambient_occlusion", "Ambient Occlusion"),
    )

    def draw_more(self, column, view_layer):
        """Draw how far occlusion reaches."""
        world = view_layer.id_data.world
        if world is not None and view_layer.use_pass_ambient_occlusion:
            column.prop(world.light_settings, "distance", text="Occlusion Distance")


class VIEWLAYER_PT_zraka_passes_cryptomatte(_PassesPanel, bpy.types.Panel):
    """Mattes by name."""

    bl_label = "Cryptomatte"
    bl_parent_id = "VIEWLAYER_PT_zraka_passes"
    switches = (
        ("cryptomatte_object", "Object"),
        ("cryptomatte_material", "Material"),
        ("cryptomatte_asset", "Asset"),
    )

    def draw_more(self, column, view_layer):
        """Draw how many things of a pixel are told apart."""
        column.prop(view_layer, "pass_cryptomatte_depth", text="Levels")


class VIEWLAYER_PT_zraka_passes_aov(_PassesPanel, bpy.types.Panel):
    """Values that materials tell by AOV Output nodes."""

    bl_label = "Shader AOV"
    bl_parent_id = "VIEWLAYER_PT_zraka_passes"

    def draw_more(self, column, view_layer):
        """Draw Blender's list of them."""
        row = column.row()
        row.template_list("VIEWLAYER_UL_aov", "", view_layer, "aovs", view_layer, "active_aov_index", rows=2)
        buttons = row.column(align=True)
        buttons.operator("scene.view_layer_add_aov", icon="ADD", text="")
        buttons.operator("scene.view_layer_remove_aov", icon="REMOVE", text="")


CLASSES = (
    ZrakaViewLayerSettings,
    VIEWLAYER_PT_zraka_passes,
    VIEWLAYER_PT_zraka_passes_data,
    VIEWLAYER_PT_zraka_passes_light,
    VIEWLAYER_PT_zraka_passes_cryptomatte,
    VIEWLAYER_PT_zraka_passes_aov,
)


def register():
    """Add ``view_layer.zraka`` and its panels."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.ViewLayer.zraka = PointerProperty(name="Zraka", type=ZrakaViewLayerSettings)


def unregister():
    """Remove them."""
    del bpy.types.ViewLayer.zraka
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
