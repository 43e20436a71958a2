# SPDX-License-Identifier: GPL-3.0-or-later
"""The world: so far one constant colour."""

from __future__ import annotations

from ...core import scene as description
from .graph import GraphReader
from .light import constant_radiance
from .versions import shader_tree


def export_world(world, images, diagnostics):
    """The world as `core.scene.World`.

    No world, or one whose output is unlinked, is black; one without nodes has its viewport colour. Nodes other than a
    constant Background are diagnosed, and the values shown in the first Background node stand in for them.

    Parameters
    ----------
    world : bpy.types.World or None
    images : callable
        bpy image to core image.
    diagnostics : Diagnostics
    """
    if world is None:
        return description.World()
    tree = shader_tree(world)
    if tree is None:
        return description.World(tuple(world.color))
    output = tree.get_output_node("CYCLES")
    if output is None:
        return description.World()
    place = f"world '{world.name}'"
    if output.inputs["Volume"].is_linked:
        diagnostics.warn("volume is not rendered yet", place)
    reader = GraphReader(tree, place, images, diagnostics)
    surface = reader.closure(output.inputs["Surface"])
    if surface is None:
        return description.World()
    radiance = constant_radiance(reader.nodes[surface], "background")
    if radiance is None:
        radiance = _shown_background(tree)
        diagnostics.warn("a world other than one constant colour is not supported yet; a plain colour is used", place)
    return description.World(radiance)


def _shown_background(tree):
    """Colour times strength as shown in the first Background node, links ignored; black without one."""
    node = next((n for n in tree.nodes if n.bl_idname == "ShaderNodeBackground"), None)
    if node is None:
        return (0.0, 0.0, 0.0)
    strength = node.inputs["Strength"].default_value
    return tuple(float(v * strength) for v in node.inputs["Color"].default_value[:3])
