# SPDX-License-Identifier: GPL-3.0-or-later
"""Attributes of meshes as the core's arrays.

What nodes cannot read in Blender (text, matrices, pairs of integers) is left out, as if it did not exist.
"""

from __future__ import annotations

import numpy as np

from ...core import scene as description

# By data type: name in foreach_get, number of columns, what is stored.
TYPES = {
    "FLOAT": ("value", 1, np.float32),
    "INT": ("value", 1, np.int32),
    "INT8": ("value", 1, np.int32),
    "BOOLEAN": ("value", 1, np.bool_),
    "FLOAT2": ("vector", 2, np.float32),
    "FLOAT_VECTOR": ("vector", 3, np.float32),
    "FLOAT_COLOR": ("color", 4, np.float32),
    "BYTE_COLOR": ("color", 4, np.float32),
    "QUATERNION": ("value", 4, np.float32),
}
_DOMAINS = {"POINT": "vertex", "CORNER": "corner", "FACE": "triangle", "EDGE": "vertex"}


def export_attributes(obj, mesh, names):
    """Those of the attributes `names` that the mesh of `obj` has, a mapping of str to `core.scene.Attribute`.

    A name that is None asks for the active colour attribute, whatever it is called. Vertex groups are attributes too.
    """
    wanted = {active_color(mesh) if name is None else name for name in names}
    found = {}
    for name in wanted:
        attribute = mesh.attributes.get(name) if name else None
        if attribute is not None:
            exported = _read(mesh, attribute)
        else:
            group = obj.vertex_groups.get(name) if name else None
            exported = None if group is None else _weights(mesh, group.index)
        if exported is not None:
            found[name] = exported
    return found


def active_color(mesh):
    """Name of the colour attribute that is rendered, "" where there is none."""
    colors = mesh.color_attributes
    index = colors.render_color_index
    return colors[index].name if 0 <= index < len(colors) else ""


def _read(mesh, attribute):
    if attribute.data_type not in TYPES or attribute.domain not in _DOMAINS:
        return None
    member, columns, dtype = TYPES[attribute.data_type]
    values = np.zeros((len(attribute.data), columns), dtype)
    attribute.data.foreach_get(member, values.reshape(-1))
    if attribute.domain == "FACE":
        triangles = np.zeros(len(mesh.loop_triangles), np.int32)
        mesh.loop_triangle_polygons.foreach_get("value", triangles)
        values = values[triangles]
    elif attribute.domain == "EDGE":
        values = _of_vertices(values, edges_of(mesh), len(mesh.vertices))
    return description.Attribute(values.astype(np.float32), _DOMAINS[attribute.domain])


def edges_of(mesh):
    """Vertex numbers (E, 2) of the edges."""
    edges = np.zeros((len(mesh.edges), 2), np.int32)
    mesh.attributes[".edge_verts"].data.foreach_get("value", edges.reshape(-1))
    return edges


def _of_vertices(values, edges, count):
    """Mean over the edges of each vertex; a flag is set where one of them has it."""
    ends, doubled = edges.reshape(-1), np.repeat(values, 2, axis=0)
    total = np.stack([np.bincount(ends, column, count) for column in doubled.T], axis=-1)
    if values.dtype == np.bool_:
        return total > 0
    mean = total / np.maximum(np.bincount(ends, minlength=count), 1)[:, None]
    return np.copysign(np.floor(np.abs(mean) + 0.5), mean) if values.dtype == np.int32 else mean


def _weights(mesh, group):
    """Weights of the vertices in a vertex group."""
    weights = np.zeros((len(mesh.vertices), 1), np.float32)
    for vertex in mesh.vertices:
        for element in vertex.groups:
            if element.group == group:
                weights[vertex.index] = element.weight
    return description.Attribute(weights, "vertex")
