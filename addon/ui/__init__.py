# SPDX-License-Identifier: GPL-3.0-or-later
"""Zraka's panels, one tab a file, and the panels of Blender that Zraka takes over."""

from __future__ import annotations

import bpy

from . import bake, curve, data, latest, objects, render, shading
from .panel import ENGINE

# Panels written for EEVEE whose settings Zraka honours; the names change from one Blender to the next. Cycles' own
# cannot be borrowed one by one: they share one set of engines.
BORROWED = (
    "DATA_PT_EEVEE_light",
    "DATA_PT_camera_dof",
    "DATA_PT_camera_dof_aperture",
    "EEVEE_MATERIAL_PT_context_material",
    "EEVEE_MATERIAL_PT_displacement",
    "EEVEE_MATERIAL_PT_surface",
    "EEVEE_WORLD_PT_mist",
    "EEVEE_WORLD_PT_surface",
    "MATERIAL_PT_preview",
    "NODE_DATA_PT_EEVEE_light",
)

CLASSES = (
    *render.CLASSES,
    *bake.CLASSES,
    *latest.CLASSES,
    *objects.CLASSES,
    *data.CLASSES,
    *shading.CLASSES,
)


def shared_panels():
    """Find the panels of Blender that serve Zraka as well."""
    # The first two are about other engines' passes; the others are parts of EEVEE's panel of lights.
    left_out = {"VIEWLAYER_PT_filter", "VIEWLAYER_PT_layer_passes", "DATA_PT_light", "NODE_DATA_PT_light"}
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
    curve.forget()
