# SPDX-License-Identifier: GPL-3.0-or-later
"""What differs between Blender 4.2 and 5.2, as far as the export sees it."""

from __future__ import annotations

import bpy


def shader_tree(owner):
    """The node tree that a material, world or light is rendered with, or None.

    Materials and worlds always use their nodes since 5.0, lights since 5.1; reading `use_nodes` then warns.
    """
    always = bpy.app.version >= ((5, 1) if isinstance(owner, bpy.types.Light) else (5, 0))
    return owner.node_tree if always or owner.use_nodes else None


def casts_shadow(light):
    """Whether a light casts shadows; Cycles had a setting of its own until it took Blender's."""
    cycles = getattr(light, "cycles", None)
    return bool(getattr(cycles, "cast_shadow", light.use_shadow))


def temperature_color(light):
    """Linear Rec.709 colour of the light's temperature (3 floats), white where it is off or before 4.5."""
    return tuple(light.temperature_color) if getattr(light, "use_temperature", False) else (1.0, 1.0, 1.0)


def exposure(light):
    """Stops that are added to the light's power; since 4.5."""
    return getattr(light, "exposure", 0.0)


def normalizes(light):
    """Whether the power is independent of the light's size; always so before 4.5."""
    return getattr(light, "normalize", True)
