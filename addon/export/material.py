# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials."""

from __future__ import annotations

from ...core import scene as description
from .graph import GraphReader
from .versions import shader_tree


class Materials:
    """Materials of one export, each exported once.

    Parameters
    ----------
    images : callable
        bpy image to core image.
    diagnostics : Diagnostics
    """

    def __init__(self, images, diagnostics):
        self._images = images
        self._diagnostics = diagnostics
        self._known = {}

    def __call__(self, material):
        """`core.scene.Material` of a bpy material; None stays None."""
        if material is None:
            return None
        key = material.as_pointer()
        if key not in self._known:
            self._known[key] = export_material(material, self._images, self._diagnostics)
        return self._known[key]


def export_material(material, images, diagnostics):
    """One material.

    Parameters
    ----------
    material : bpy.types.Material
    images : callable
        bpy image to core image.
    diagnostics : Diagnostics

    Returns
    -------
    core.scene.Material
        The node graph below the active output; a material without nodes reflects its viewport colour diffusely.
    """
    tree = shader_tree(material)
    if tree is None:
        return description.Material.diffuse(material.diffuse_color[:3], material.name)
    output = tree.get_output_node("CYCLES")
    if output is None:
        return description.Material(material.name)
    place = f"material '{material.name}'"
    if output.inputs["Volume"].is_linked:
        diagnostics.warn("volume is not rendered yet", place)
    reader = GraphReader(tree, place, images, diagnostics)
    surface = reader.closure(output.inputs["Surface"])
    displacement = reader.link(output.inputs["Displacement"])
    if displacement is not None and material.displacement_method != "BUMP":
        diagnostics.warn("true displacement is not rendered yet; it is shown as a bump", place)
    return description.Material(material.name, tuple(reader.nodes), surface, displacement, material.pass_index)
