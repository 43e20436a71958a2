# SPDX-License-Identifier: GPL-3.0-or-later
"""What shader nodes read at the corners of triangles, as tables.

Keys of the tables: ``"generated"`` (3 columns a corner), ``"pointiness"`` and ``"island"`` (1), ``("attribute", name)``
and ``("color", name)`` (colour, alpha and, where a mesh has it as a 2-D vector, the number it is read as; different in
the alpha of meshes without the attribute: 1 or 0), ``("tangent", UV map)`` (tangent, sign and normal in object
space; zero where there is no such map).
"""

from __future__ import annotations

from functools import partial

import numpy as np

from ..diagnostics import SceneError
from .connectivity import island_random, pointiness, triangle_sides
from .placing import corner_index
from .tangents import corner_frames


def corner_tables(groups, count, needs):
    """Tables (T, 3 C) float32 of what `needs` names.

    Parameters
    ----------
    groups : list
        Instances of one mesh each (`core.compile.geometry`).
    count : int
        T.
    needs : Needs
    """
    makers = {}
    if needs.generated:
        makers["generated"] = 3, _generated
    if needs.pointiness:
        makers["pointiness"] = 1, _pointiness
    if needs.island:
        makers["island"] = 1, _islands
    for kind, names in (("attribute", needs.attributes), ("color", needs.colors)):
        for name in names:
            columns = 5 if any(_width(_attribute(g.mesh, name)) == 2 for g in groups) else 4
            makers[kind, name] = columns, partial(_colors, name=name, missing=missing_color(kind))
    for name in needs.tangents:
        makers["tangent", name] = 7, partial(_frames, name=name)
    for key, columns in (("strand", 4), ("point", 1)):  # that only what is round has
        if getattr(needs, key):
            makers[key] = columns, _nothing
    return {key: _table(groups, count, columns, maker) for key, (columns, maker) in makers.items()}


def _table(groups, count, columns, maker):
    table = np.zeros((count, 3 * columns), np.float32)
    for group in groups:
        values = maker(group)  # (T, 3, C)
        if values is None:
            continue
        rows = table[group.rows].reshape(len(group.numbers), len(group.triangles), 3, columns)
        rows[...] = values[..., :columns]
        if group.flipped.any():
            rows[group.flipped] = rows[group.flipped][:, :, (0, 2, 1)]
    return table


def _nothing(group):
    return None


def _generated(group):
    vertices = np.asarray(group.mesh.vertices, np.float64)
    space = group.mesh.texture_space
    if space is None:
        low, high = vertices.min(0), vertices.max(0)
        location, size = (low + high) / 2, (high - low) / 2
        size = np.where(size == 0, 1.0, size)
    else:
        location, size = (np.asarray(x, np.float64) for x in (space.location, space.size))
        if space.undeformed is not None:
            vertices = np.asarray(space.undeformed, np.float64)
    scale = np.divide(0.5, size, out=np.zeros(3), where=size != 0)
    return (vertices * scale - (location * scale - 0.5))[group.triangles]


def _edges(group):
    mesh = group.mesh
    return triangle_sides(group.triangles) if mesh.edges is None else np.asarray(mesh.edges)


def _pointiness(group):
    mesh = group.mesh
    normals = np.asarray(mesh.normals, np.float64) if mesh.normals is not None else None
    if mesh.normals_domain != "vertex":
        normals = None
    vertices = np.asarray(mesh.vertices, np.float64)
    return pointiness(vertices, group.triangles, _edges(group), normals)[group.triangles][..., None]


def _islands(group):
    found = island_random(group.triangles, _edges(group), len(group.mesh.vertices))
    return np.broadcast_to(found[:, None, None], (len(found), 3, 1))


# -- attributes --------------------------------------------------------------------------------------------------------


def _attribute(mesh, name):
    """(values, domain) of a mesh's attribute or UV map, None where it has none of this name."""
    name = mesh.active_color if name is None else name
    found = mesh.attributes.get(name)
    if found is not None:
        return found.values, found.domain
    return (mesh.uvs[name], "corner") if name in mesh.uvs else None


def _width(attribute):
    return 0 if attribute is None else np.shape(attribute[0])[-1]


def _colors(group, name, missing):
    """Colour, alpha and number of an attribute, (T, 3, 5)."""
    attribute = _attribute(group.mesh, name)
    if attribute is None:
        return np.broadcast_to(np.float32(missing), (len(group.triangles), 3, 5))
    values, domain = attribute
    values = np.asarray(values, np.float32)
    indices = {
        "vertex": group.triangles,
        "corner": corner_index(group),
        "triangle": np.arange(len(group.triangles))[:, None],
        "mesh": np.zeros((1, 1), np.intp),
    }
    index = indices[domain]
    if values.ndim != 2 or (index.size and int(index.max()) >= len(values)):
        raise SceneError(f"attribute '{name}' of mesh '{group.mesh.name}' has shape {values.shape}; make it (n, C)")
    return np.broadcast_to(as_colors(values)[index], (len(group.triangles), 3, 5))


def as_colors(values):
    """Colour, alpha and number (n, 5) of an attribute's values (n, C)."""
    found, width = np.zeros((len(values), 5), np.float32), values.shape[1]
    found[:, :3] = values[:, :1] if width == 1 else 0
    found[:, : min(width, 4)] = values[:, :4]
    if width < 4:
        found[:, 3] = 1
    found[:, 4] = found[:, 0] if width == 2 else found[:, :3].mean(1)
    return found


def missing_color(kind):
    """What an attribute is read as where there is none, by the node that reads it."""
    return 0.0, 0.0, 0.0, float(kind == "attribute"), 0.0


# -- tangents ----------------------------------------------------------------------------------------------------------


def _frames(group, name):
    """Tangent, sign and normal of a UV map, (T, 3, 7); None where there is none."""
    mesh = group.mesh
    position = np.asarray(mesh.vertices, np.float64)[group.triangles]
    key = name or mesh.active_uv or next(iter(mesh.uvs), "")
    met = None
    if key in mesh.uvs:
        uv = np.asarray(mesh.uvs[key], np.float64)[corner_index(group)]
    elif not name and not mesh.uvs:
        met = _sphere(position)
        uv = _across_the_seam(met)
    else:
        return None
    normal = _normals(group, position)
    tangent, sign = corner_frames(position, normal, uv, met)
    return np.concatenate([tangent, sign[..., None], normal], axis=-1)


def _normals(group, position):
    """Shading normals (T, 3, 3) in object space."""
    mesh = group.mesh
    face = np.cross(position[:, 1] - position[:, 0], position[:, 2] - position[:, 0])
    length = np.sqrt((face * face).sum(-1, keepdims=True))
    face = np.divide(face, length, out=np.zeros_like(face), where=length > 0)
    face = np.broadcast_to(face[:, None], position.shape)
    if mesh.normals is None:
        return face
    index = group.triangles if mesh.normals_domain == "vertex" else corner_index(group)
    normal = np.asarray(mesh.normals, np.float64)[index]
    return np.where((normal * normal).sum(-1, keepdims=True) > 0, normal, face)


def _sphere(p):
    """UV coordinates of points (T, 3, 3) mapped to a sphere around zero."""
    length = np.sqrt((p * p).sum(-1))
    u = np.where((p[..., 0] == 0) & (p[..., 1] == 0), 0.0, 0.5 - np.arctan2(p[..., 0], p[..., 1]) / (2 * np.pi))
    cosine = np.divide(p[..., 2], length, out=np.zeros_like(length), where=length > 0)
    return np.stack([u, 1 - np.arccos(np.clip(cosine, -1, 1)) / np.pi], axis=-1)


def _across_the_seam(uv):
    """UV coordinates (T, 3, 2) of a sphere that go on beyond 1 in triangles over its seam, which else were mirrored."""
    u = uv[..., 0]
    return np.stack([u + (u.max(-1, keepdims=True) - u > 0.5), uv[..., 1]], axis=-1)
