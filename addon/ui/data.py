# SPDX-License-Identifier: GPL-3.0-or-later
"""The tabs of lights and cameras; most of them are Blender's own panels."""

from __future__ import annotations

import bpy

from ..export.versions import shader_tree
from .panel import Panel

# Properties of a camera that a kind of panorama reads.
_PANORAMAS = {
    "FISHEYE_EQUIDISTANT": ("fisheye_fov",),
    "FISHEYE_EQUISOLID": ("fisheye_lens", "fisheye_fov"),
    "EQUIRECTANGULAR": ("latitude_min", "latitude_max", "longitude_min", "longitude_max"),
    "FISHEYE_LENS_POLYNOMIAL": ("fisheye_fov", *(f"fisheye_polynomial_k{i}" for i in range(5))),
    "CENTRAL_CYLINDRICAL": (
        "central_cylindrical_range_v_min",
        "central_cylindrical_range_v_max",
        "central_cylindrical_range_u_min",
        "central_cylindrical_range_u_max",
        "central_cylindrical_radius",
    ),
}


class _LightPanel(Panel):
    bl_context = "data"

    @classmethod
    def poll(cls, context):
        """Show the panel for lights."""
        return super().poll(context) and context.light is not None


class DATA_PT_zraka_light_settings(_LightPanel, bpy.types.Panel):
    """What Blender's panel of lights lacks."""

    bl_label = "Settings"
    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012

    def draw_settings(self, column, context):
        """Draw the switch of shadows; older Blenders' Cycles keeps it with itself."""
        light = context.light
        owner = light.cycles if hasattr(getattr(light, "cycles", None), "cast_shadow") else light
        column.prop(owner, "use_shadow" if owner is light else "cast_shadow", text="Cast Shadow")
        if light.type == "AREA":
            column.prop(light, "spread")


class DATA_PT_zraka_light_nodes(_LightPanel, bpy.types.Panel):
    """The light's shader."""

    bl_label = "Nodes"

    def draw_settings(self, column, context):
        """Draw the nodes that reach the output."""
        light, tree = context.light, shader_tree(context.light)
        if tree is None:
            column.prop(light, "use_nodes", icon="NODETREE")
            return
        node = next((node for node in tree.nodes if node.type == "OUTPUT_LIGHT"), None)
        if node is None:
            column.label(text="No output node")
        else:
            column.template_node_view(tree, node, node.inputs["Surface"])


class DATA_PT_zraka_panorama(Panel, bpy.types.Panel):
    """Of a panoramic camera, whose settings Blender shows to Cycles alone."""

    bl_label = "Panorama"
    bl_context = "data"
    bl_parent_id = "DATA_PT_lens"

    @classmethod
    def poll(cls, context):
        """Show the panel for panoramic cameras."""
        return super().poll(context) and context.camera is not None and context.camera.type == "PANO"

    def draw_settings(self, column, context):
        """Draw the kind, and what it reads."""
        camera = context.camera
        column.prop(camera, "panorama_type")
        for name in _PANORAMAS.get(camera.panorama_type, ()):
            column.prop(camera, name)


CLASSES = (
    DATA_PT_zraka_light_settings,
    DATA_PT_zraka_light_nodes,
    DATA_PT_zraka_panorama,
)
