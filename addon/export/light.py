# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights, in Blender's units."""

from __future__ import annotations

import numpy as np

from ...core import scene as description
from ...core.visibility import LAMP
from .graph import GraphReader
from .versions import casts_shadow, exposure, normalizes, shader_tree, temperature_color


def export_light(light, transform, name, images, diagnostics, visibility=LAMP):
    """One light.

    Parameters
    ----------
    light : bpy.types.Light
    transform : (4, 4) float64
        Object to world. Its scale stretches area lights; the radius of other lights ignores it, as in Cycles.
    name : str
    images : callable
        bpy image to core image.
    diagnostics : Diagnostics
    visibility : Visibility

    Returns
    -------
    core.scene.Light or None
        None for a light portal, which only guides the sampling of the world.
    """
    place = f"light '{name}'"
    cycles = getattr(light, "cycles", None)
    if light.type == "AREA" and getattr(cycles, "is_portal", False):
        return None
    _diagnose(light, transform, place, diagnostics)
    strength = _strength(light, place, images, diagnostics)
    common = {"normalize": normalizes(light), "casts_shadow": casts_shadow(light), "name": name}
    common["visibility"] = visibility
    position = tuple(float(v) for v in transform[:3, 3])
    direction = _unit(-transform[:3, 2])
    if light.type == "SUN":
        return description.SunLight(direction, strength, angle=light.angle, **common)
    if light.type == "AREA":
        size = (light.size, light.size_y if light.shape in ("RECTANGLE", "ELLIPSE") else light.size)
        shape = "ELLIPSE" if light.shape in ("DISK", "ELLIPSE") else "RECTANGLE"
        return description.AreaLight(transform, strength, size, shape, light.spread, **common)
    common |= {"radius": light.shadow_soft_size, "soft_falloff": light.use_soft_falloff}
    if light.type == "SPOT":
        return description.SpotLight(
            position, direction, strength, angle=light.spot_size, blend=light.spot_blend, **common
        )
    return description.PointLight(position, strength, **common)


def _strength(light, place, images, diagnostics):
    """Power (W) or irradiance (W/m2) of each channel: energy, exposure, colours and Emission node."""
    scale = light.energy * 2.0 ** exposure(light)
    colors = light.color, temperature_color(light), _emission(light, place, images, diagnostics)
    return tuple(float(scale * a * b * c) for a, b, c in zip(*colors, strict=True))


def _emission(light, place, images, diagnostics):
    """What the light's nodes multiply its colour with; white where they are more than one constant Emission."""
    tree = shader_tree(light)
    output = tree and tree.get_output_node("CYCLES")
    if output is None:
        return (1.0, 1.0, 1.0)
    reader = GraphReader(tree, place, images, diagnostics)
    surface = reader.closure(output.inputs["Surface"])
    if surface is None:
        return (0.0, 0.0, 0.0)
    color = constant_radiance(reader.nodes[surface], "emission")
    if color is None:
        diagnostics.warn("light nodes other than one constant Emission are not supported and ignored", place)
        return (1.0, 1.0, 1.0)
    return color


def constant_radiance(node, op):
    """Colour times strength of a core node `op`, None where it is another node or anything is linked."""
    color, strength = node.inputs.get("color", (1.0, 1.0, 1.0)), node.inputs.get("strength", 1.0)
    if node.op != op or isinstance(color, description.Link) or isinstance(strength, description.Link):
        return None
    return tuple(float(v * strength) for v in color)


def _diagnose(light, transform, place, diagnostics):
    if light.type != "SPOT":
        return
    scales = np.linalg.norm(transform[:3, :3], axis=0)
    if scales.max() > 1.001 * scales.min():
        diagnostics.warn("spot lights stretched by their scale are not supported; the cone stays round", place)


def _unit(vector):
    return tuple(float(v) for v in vector / max(np.linalg.norm(vector), 1e-30))
