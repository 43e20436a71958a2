# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights, in Blender's units."""

from __future__ import annotations

import numpy as np

from ...core import scene as description
from ...core.visibility import LAMP
from .graph import GraphReader
from .versions import casts_shadow, exposure, lamps_in_world, normalizes, shader_tree, temperature_color


def export_light(light, transform, name, shader, diagnostics, visibility=LAMP, info=None):
    """One light.

    Parameters
    ----------
    light : bpy.types.Light
    transform : (4, 4) float64
        Object to world. Its scale stretches area lights; the radius of other lights ignores it, as in Cycles.
    name : str
    shader : core.scene.Material
        From `export_lamp_shader`.
    diagnostics : Diagnostics
    visibility : Visibility
    info : callable, optional
        ``info() -> ObjectInfo`` for nodes, where there are some.

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
    factor = _constant_factor(shader)
    strength = _strength(light, factor or (1.0, 1.0, 1.0))
    common = {"normalize": normalizes(light), "casts_shadow": casts_shadow(light), "name": name}
    common["visibility"] = visibility
    if factor is None:
        asked = description.ObjectInfo() if info is None else info()
        common["nodes"] = description.LampNodes(shader, transform, asked, lamps_in_world())
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


def export_lamp_shader(light, images, diagnostics):
    """The node tree of a light; a white Emission where it has none.

    Parameters
    ----------
    light : bpy.types.Light
    images : callable
        bpy image to core image.
    diagnostics : Diagnostics

    Returns
    -------
    core.scene.Material
        Of no surface where nothing reaches the output.
    """
    tree = shader_tree(light)
    output = tree and tree.get_output_node("CYCLES")
    if output is None:
        return description.Material.emission(name=light.name)
    reader = GraphReader(tree, f"light '{light.name}'", images, diagnostics)
    surface = reader.closure(output.inputs["Surface"])
    if any(node.bl_idname == "ShaderNodeOutputAOV" for node in tree.nodes):
        diagnostics.warn("shader AOVs of a light are not rendered", f"light '{light.name}'")
    return description.Material(light.name, tuple(reader.nodes), surface)


def _constant_factor(shader):
    """What one constant Emission multiplies the light's colour with; None where there are other nodes."""
    if shader.surface is None:
        return (0.0, 0.0, 0.0)
    return constant_radiance(shader.nodes[shader.surface], "emission")


def _strength(light, factor):
    """Power (W) or irradiance (W/m2) of each channel: energy, exposure and colours."""
    scale = light.energy * 2.0 ** exposure(light)
    colors = light.color, temperature_color(light), factor
    return tuple(float(scale * a * b * c) for a, b, c in zip(*colors, strict=True))


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
