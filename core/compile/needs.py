# SPDX-License-Identifier: GPL-3.0-or-later
"""What the materials of a scene read of meshes and objects, so that nothing else is tabulated."""

from __future__ import annotations

from dataclasses import dataclass, field

from ..nodes import OPERATIONS
from ..nodes.closure_hair import takes_random
from ..scene import Link

DEFAULT_COLOR = None  # stands for each mesh's active colour attribute, where an attribute's name is expected

# What a texture takes where nothing is linked, if not generated coordinates.
_COORDINATES = {"image": "uv", "ies": "normal"}
_OF_OBJECTS = ("object_info", "vector_transform", "displacement", "vector_displacement", "hair", "principled_hair")


@dataclass
class Needs:
    """Names of what is read; "" is each mesh's active UV map.

    uvs, tangents: of UV maps; attributes, colors: of attributes of meshes, by the two nodes that read them;
    object_attributes: (type, name) of those of objects; generated, pointiness, island: whether these are read; objects:
    whether anything of objects is; strand, point: what Curves Info and Point Info tell.
    """

    uvs: set = field(default_factory=set)
    tangents: set = field(default_factory=set)
    attributes: set = field(default_factory=set)
    colors: set = field(default_factory=set)
    object_attributes: set = field(default_factory=set)
    generated: bool = False
    pointiness: bool = False
    island: bool = False
    objects: bool = False
    strand: bool = False
    point: bool = False

    @property
    def corner_columns(self):
        """Columns of all tables of values at triangles' corners (`core.compile.corners`), about."""
        names = 4 * (len(self.attributes) + len(self.colors)) + 7 * len(self.tangents)
        return names + 3 * self.generated + self.pointiness + self.island + 4 * self.strand + self.point

    def __or__(self, other):
        """What one of both names."""
        return Needs(*(a | b for a, b in zip(vars(self).values(), vars(other).values(), strict=True)))

    def __le__(self, other):
        """Whether `other` names all that this does."""
        return all(a <= b for a, b in zip(vars(self).values(), vars(other).values(), strict=True))


def needs_of(materials):
    """The `Needs` of `core.scene.Material`s."""
    needs = Needs()
    for material in materials:
        read = _read_outputs(material)
        for number, node in enumerate(material.nodes):
            _add(needs, node, read.get(number, frozenset()))
    return needs


def _read_outputs(material):
    """Names of the outputs that are read, by number of the node."""
    links = [v for node in material.nodes for v in node.inputs.values() if isinstance(v, Link)]
    links += material.side_links
    read = {}
    for link in links:
        read.setdefault(link.node, set()).add(link.output)
    return read


def _add(needs, node, outputs):
    properties = node.properties
    if node.op == "tex_coord":
        _add_coordinates(needs, properties, outputs)
    elif node.op == "uv_map":
        needs.uvs.add(properties.get("uv_map", ""))
        needs.objects |= bool(properties.get("from_instancer"))
    elif node.op == "geometry":
        needs.generated |= "tangent" in outputs
        needs.objects |= bool(outputs & {"tangent", "parametric"})
        needs.pointiness |= "pointiness" in outputs
        needs.island |= "random_per_island" in outputs
    elif node.op == "attribute":
        if properties.get("attribute_type", "GEOMETRY") == "GEOMETRY":
            needs.attributes.add(properties.get("attribute_name", ""))
        else:
            needs.objects = True
            needs.object_attributes.add((properties["attribute_type"], properties.get("attribute_name", "")))
    elif node.op == "vertex_color":
        needs.colors.add(properties.get("layer_name") or DEFAULT_COLOR)
    elif node.op in ("normal_map", "tangent", "vector_displacement"):
        _add_tangents(needs, node)
    elif _takes_coordinates(node):
        default = _default_coordinates(node)
        needs.generated |= default == "generated"
        if default == "uv":
            needs.uvs.add("")
    if _takes_tangent(node):
        needs.generated = needs.objects = True
    needs.strand |= node.op == "hair_info" or takes_random(node)
    needs.point |= node.op == "point_info" and "random" in outputs
    needs.objects |= node.op in _OF_OBJECTS or (node.op == "image" and properties.get("projection") == "BOX")
    needs.objects |= node.op == "ies" and "vector" not in node.inputs


def _add_coordinates(needs, properties, outputs):
    instanced = bool(properties.get("from_instancer"))
    if "uv" in outputs and not instanced:
        needs.uvs.add("")
    needs.generated |= "generated" in outputs and not instanced
    needs.objects |= "normal" in outputs or (instanced and bool(outputs & {"generated", "uv"}))
    needs.objects |= "object" in outputs and "matrix" not in properties


def _add_tangents(needs, node):
    properties = node.properties
    if node.op == "tangent" and properties.get("direction_type", "RADIAL") == "RADIAL":
        needs.generated = needs.objects = True
    elif properties.get("space", "TANGENT") == "TANGENT":
        needs.tangents.add(properties.get("uv_map", ""))
        needs.objects = True
    elif "OBJECT" in properties["space"]:
        needs.objects = True


def takes_generated(node):
    """Whether a texture takes generated coordinates, because nothing is linked."""
    return _takes_coordinates(node) and _default_coordinates(node) == "generated"


def _default_coordinates(node):
    return node.properties.get("coordinates", _COORDINATES.get(node.op, "generated"))


def _takes_coordinates(node):
    """Whether a texture's coordinates are left to be chosen: its vector has no default and is not linked."""
    operation = OPERATIONS.get(node.op)
    return operation is not None and operation.inputs.get("vector", 0) is None and "vector" not in node.inputs


def _takes_tangent(node):
    """Whether an anisotropic closure's tangent is left to be chosen."""
    given = [node.inputs.get(name, 0.0) for name in ("anisotropy", "anisotropic")]
    return node.op in ("glossy", "metallic", "principled") and "tangent" not in node.inputs and any(given)
