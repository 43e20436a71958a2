# SPDX-License-Identifier: GPL-3.0-or-later
"""The world: a constant colour, or a graph over directions."""

from __future__ import annotations

from ...core import scene as description
from .graph import GraphReader
from .light import constant_radiance
from .versions import shader_tree
from .visibility import world_visibility

_SHADERS = ("background", "emission", "mix_shader", "add_shader")


def export_world(world, images, diagnostics):
    """The world as `core.scene.World`.

    No world, or one whose output is unlinked, is black; one without nodes has its viewport colour. Where a node is not
    supported, the values shown in the first Background node stand in for the whole graph.

    Parameters
    ----------
    world : bpy.types.World or None
    images : callable
        bpy image to core image.
    diagnostics : Diagnostics
    """
    if world is None:
        return description.World()
    common = {"name": world.name, "visibility": world_visibility(world)}
    tree = shader_tree(world)
    if tree is None:
        return description.World(tuple(world.color), **common)
    output = tree.get_output_node("CYCLES")
    if output is None:
        return description.World(name=world.name)
    place = f"world '{world.name}'"
    volume = output.inputs.get("Volume")  # a light's output has none
    if volume is not None and volume.is_linked:
        diagnostics.warn("volume is not rendered yet", place)
    reader = GraphReader(tree, place, images, diagnostics)
    surface = reader.closure(output.inputs["Surface"])
    radiance, unsupported = (0.0, 0.0, 0.0), None
    if surface is not None:
        radiance = constant_radiance(reader.nodes[surface], "background")
        unsupported = radiance is None and _unsupported(reader.nodes, surface)
    if unsupported:
        diagnostics.warn(f"world node '{unsupported}' is not supported; a plain colour is used", place)
        radiance = _shown_background(tree)
    aovs = reader.aovs()  # only now: what they alone read need not be supported
    if aovs or radiance is None:
        _diagnose_attributes(reader.nodes, place, diagnostics)
        common |= {"nodes": tuple(reader.nodes), "aovs": aovs}
    return description.World(surface=surface, **common) if radiance is None else description.World(radiance, **common)


def _diagnose_attributes(nodes, place, diagnostics):
    """Warn of attributes that surfaces know and a world does not."""
    for node in nodes:
        if node.op == "attribute" and node.properties.get("attribute_type") == "VIEW_LAYER":
            name = node.properties.get("attribute_name", "")
            diagnostics.warn(f"attribute '{name}' of the view layer is not known in a world; 0 is used", place)


def _unsupported(nodes, surface):
    """Name of a node that a world cannot be rendered with, None where there is none."""
    for number, node in enumerate(nodes):
        is_shader = number == surface or any(
            isinstance(link, description.Link) and link.output == "bsdf" and link.node == number
            for user in nodes
            for link in user.inputs.values()
        )
        if node.op == "unsupported" or (is_shader and node.op not in _SHADERS):
            return node.properties.get("label", node.op)
    return None


def _shown_background(tree):
    """Colour times strength as shown in the first Background node, links ignored; black without one."""
    node = next((n for n in tree.nodes if n.bl_idname == "ShaderNodeBackground"), None)
    if node is None:
        return (0.0, 0.0, 0.0)
    strength = node.inputs["Strength"].default_value
    return tuple(float(v * strength) for v in node.inputs["Color"].default_value[:3])
