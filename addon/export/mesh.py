# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes.

`foreach_get` copies a whole array at once only where its type is exactly the stored one: float32 attributes, uint32
corners of loop triangles, int32 for the rest. Other types and the older accessors (`vertices.co`,
`loop_triangles.vertices`) are read element by element, a hundred times slower.
"""

from __future__ import annotations

import numpy as np

from ...core import scene as description
from ...core.arena import uninitialised
from .attributes import active_color, edges_of, export_attributes

_PART = 1 << 14


def export_mesh(obj, name, needs):
    """The mesh of an evaluated object in its own space, or None where it has no faces.

    Parameters
    ----------
    obj : bpy.types.Object
        Evaluated, with a mesh as data.
    name : str
    needs : core.compile.needs.Needs
        What materials read of it, beside what all meshes have.

    Returns
    -------
    core.scene.Mesh or None
    """
    mesh = obj.to_mesh()
    try:
        return _read(obj, mesh, name, needs)
    finally:
        obj.to_mesh_clear()


def _read(obj, mesh, name, needs):
    mesh.calc_loop_triangles()
    count = len(mesh.loop_triangles)
    if count == 0:
        return None
    corners = _get(mesh.loop_triangles, "loops", (count, 3), np.uint32)
    corner_vertices = _get(mesh.attributes[".corner_vert"].data, "value", len(mesh.loops), np.int32)
    normals, domain = _normals(mesh)
    return description.Mesh(
        vertices=_get(mesh.attributes["position"].data, "vector", (len(mesh.vertices), 3), np.float32),
        triangles=_looked_up(corner_vertices, corners),
        corners=corners,
        normals=normals,
        normals_domain=domain,
        uvs={layer.name: _get(layer.uv, "vector", (len(mesh.loops), 2), np.float32) for layer in mesh.uv_layers},
        active_uv=next((layer.name for layer in mesh.uv_layers if layer.active_render), ""),
        material_index=_material_index(mesh, count),
        name=name,
        texture_space=_texture_space(mesh) if needs.generated or needs.tangents else None,
        attributes=export_attributes(obj, mesh, needs.attributes | needs.colors),
        active_color=active_color(mesh),
        edges=edges_of(mesh) if needs.pointiness or needs.island else None,
    )


def _texture_space(mesh):
    """The box of generated coordinates; in a render Blender keeps the vertices as they were before deformation."""
    undeformed = _get(mesh.vertices, "undeformed_co", (len(mesh.vertices), 3), np.float32)
    now = _get(mesh.attributes["position"].data, "vector", undeformed.shape, np.float32)
    return description.TextureSpace(
        tuple(mesh.texspace_location), tuple(mesh.texspace_size), None if (undeformed == now).all() else undeformed
    )


def _normals(mesh):
    """Shading normals and what they belong to; None where all faces are flat."""
    if mesh.normals_domain == "POINT":
        return _get(mesh.vertex_normals, "vector", (len(mesh.vertices), 3), np.float32), "vertex"
    if mesh.normals_domain == "CORNER":
        return _get(mesh.corner_normals, "vector", (len(mesh.loops), 3), np.float32), "corner"
    return None, "vertex"


def _material_index(mesh, count):
    """Slot of each triangle, None where all are in the first."""
    attribute = mesh.attributes.get("material_index")
    if attribute is None or attribute.domain != "FACE" or attribute.data_type != "INT":
        return None
    of_face = _get(attribute.data, "value", len(mesh.polygons), np.int32)
    if not of_face.any():
        return None
    return np.take(of_face, _get(mesh.loop_triangle_polygons, "value", count, np.int32))


def _looked_up(values, index):
    """``values[index]`` for valid rows of `index`, in parts that stay in the cache."""
    out = uninitialised(index.shape, values.dtype)
    for start in range(0, len(index), _PART):
        part = slice(start, start + _PART)
        np.take(values, index[part], out=out[part], mode="clip")
    return out


def _get(collection, attribute, shape, dtype):
    """All of `attribute` in `collection` as an array."""
    out = uninitialised(shape, dtype)
    collection.foreach_get(attribute, out.reshape(-1))
    return out
