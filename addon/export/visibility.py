# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of objects that are not honoured."""

from __future__ import annotations

_SHOWN = ("MESH", "CURVE", "FONT", "SURFACE", "META", "POINTCLOUD", "LIGHT", "EMPTY")
_RAY_FLAGS = (
    "visible_camera",  # off for lights by default
    "visible_diffuse",
    "visible_glossy",
    "visible_transmission",
    "visible_volume_scatter",
    "visible_shadow",
)


def diagnose_object(obj, layer, diagnostics):
    """Warn of what object `obj` asks for and Zraka does not do.

    Parameters
    ----------
    obj : bpy.types.Object
    layer : bpy.types.ViewLayer
    diagnostics : Diagnostics
    """
    if obj.type not in _SHOWN:
        return
    place = f"object '{obj.name}'"
    is_light = obj.type == "LIGHT"
    if is_light and obj.visible_camera:
        diagnostics.warn("lights that the camera sees are not supported; it does not see the light", place)
    for name in _RAY_FLAGS[is_light:]:
        if not getattr(obj, name):
            rays = name.removeprefix("visible_").replace("_", " ")
            diagnostics.warn(f"ray visibility is not supported; the object is there for {rays} rays too", place)
    if obj.is_holdout or obj.holdout_get(view_layer=layer):
        diagnostics.warn("holdout objects are not supported; they are rendered", place)
    if obj.indirect_only_get(view_layer=layer):
        diagnostics.warn("indirect-only collections are not supported; the camera sees their objects", place)
    if obj.is_shadow_catcher and not is_light:
        diagnostics.warn("shadow catchers are not supported; they are rendered as ordinary objects", place)
    linking = getattr(obj, "light_linking", None)
    if linking and (linking.receiver_collection or linking.blocker_collection):
        diagnostics.warn("light linking is not supported; the light reaches all objects", place)
    for system in obj.particle_systems:
        if system.settings.type == "HAIR" and system.settings.render_type == "PATH":
            diagnostics.warn("particle hair is not rendered yet", place)
