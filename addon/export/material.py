# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials."""

from __future__ import annotations

from functools import cache

from ...core import scene as description
from .cache import Kept
from .graph import GraphReader
from .updates import address
from .versions import bump_correction, default_is_principled, displacement_step, older_normals, shader_tree


class Materials:
    """Materials of one export, each exported once.

    Parameters
    ----------
    images : Images
    diagnostics : Diagnostics
    known : dict, optional
        `Kept` ones of the export before, by key.

    Attributes
    ----------
    used : dict
        `Kept` by key.
    """

    def __init__(self, images, diagnostics, known=None):
        self._images = images
        self._diagnostics = diagnostics
        self._known = known or {}
        self._keys = {id(kept.value): key for key, kept in self._known.items()}
        self.used = {}
        self.default = default_material()

    def __call__(self, material):
        """`core.scene.Material` of a bpy material, or of no material."""
        if material is None:
            return self.default
        key = material.as_pointer(), address(material)
        if key not in self.used:
            kept = self._known.get(key)
            self.used[key] = kept or keep_shader(material, export_material, self._images, self._diagnostics)
        return self.used[key].value

    def stays(self, value):
        """Whether a `core.scene.Material` of the export before is still what it was made of; it is then used."""
        if value is self.default:
            return True
        key = self._keys.get(id(value))
        if key is None:
            return False
        self.used.setdefault(key, self._known[key])
        return True


def keep_shader(thing, export, images, diagnostics):
    """`Kept` of what `export` makes of a material or a world."""
    before = images.sequences
    value = export(thing, images, diagnostics)
    passing = images.sequences > before or any("matrix" in node.properties for node in value.nodes)
    return Kept(value, frozenset([address(thing)]), passing=passing)


@cache
def default_material():
    """What Blender shows where there is no material, named as it names it; one object for all exports."""
    if default_is_principled():
        return description.Material.principled("default_surface")
    return description.Material.diffuse(name="default_surface")


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
    volume, moved = output.inputs.get("Volume"), output.inputs.get("Displacement")  # neither, of a world's output
    has_volume = volume is not None and volume.is_linked
    if has_volume:
        diagnostics.warn("volume is not rendered yet", place)
    reader = GraphReader(tree, place, images, diagnostics)
    surface = reader.closure(output.inputs["Surface"])
    if surface is None and has_volume:  # nothing stops a ray but what the volume would do
        surface = reader.append(description.Node("transparent"))
    displacement = None if moved is None else reader.link(moved)
    if displacement is not None and material.displacement_method != "BUMP":
        diagnostics.warn("true displacement is not rendered yet; it is shown as a bump", place)
    aovs = reader.aovs()
    nodes, step = tuple(reader.nodes), displacement_step()
    index, is_corrected = material.pass_index, bump_correction(material)
    older = older_normals()
    return description.Material(material.name, nodes, surface, displacement, index, step, aovs, is_corrected, older)
