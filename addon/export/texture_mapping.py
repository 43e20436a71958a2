# SPDX-License-Identifier: GPL-3.0-or-later
"""The mapping that each texture node has inside, from before there were Mapping nodes."""

from __future__ import annotations

import numpy as np

from ...core import scene as description

_DEFAULTS = {"ShaderNodeTexImage": "uv", "ShaderNodeTexEnvironment": "position"}
_SMALLEST = 1e-5  # scale, where it is divided by


def texture_mapping(node, vector):
    """`core.scene.Node` that maps what `node` reads as its `vector`, None where nothing is mapped.

    Parameters
    ----------
    node : bpy.types.ShaderNode
    vector : core.scene.Link, tuple or None
        None is the texture's default coordinates.
    """
    mapping = getattr(node, "texture_mapping", None)
    if mapping is None or _is_identity(mapping) or not any(s.name == "Vector" and s.enabled for s in node.inputs):
        return None
    matrix = _matrix(mapping)
    inputs = {axis: tuple(row[:3].tolist()) for axis, row in zip("xyz", matrix, strict=False)}
    inputs["offset"] = tuple(matrix[:3, 3].tolist())
    if vector is not None:
        inputs["vector"] = vector
    properties = {"coordinates": _DEFAULTS.get(node.bl_idname, "generated")}
    return description.Node("texture_mapping", inputs, properties | {"normalize": mapping.vector_type == "NORMAL"})


def _is_identity(mapping):
    """Whether nothing is mapped; limits have no effect in Cycles."""
    return (
        tuple(mapping.translation) == (0, 0, 0)
        and tuple(mapping.rotation) == (0, 0, 0)
        and tuple(mapping.scale) == (1, 1, 1)
        and (mapping.mapping_x, mapping.mapping_y, mapping.mapping_z) == ("X", "Y", "Z")
    )


def _matrix(mapping):
    """The whole mapping, (4, 4): axes chosen, then scaled, turned about X, Y, Z and moved, or the inverse."""
    axes = np.zeros((4, 4))
    axes[3, 3] = 1
    for row, name in enumerate((mapping.mapping_x, mapping.mapping_y, mapping.mapping_z)):
        if name != "NONE":
            axes[row, "XYZ".index(name)] = 1
    kind, scale = mapping.vector_type, np.array(mapping.scale)
    if kind in ("TEXTURE", "NORMAL"):
        scale = np.where(np.abs(scale) < _SMALLEST, np.copysign(_SMALLEST, scale), scale)
    placed = np.eye(4)
    placed[:3, :3] = np.array(mapping.rotation.to_matrix()) * scale
    if kind in ("TEXTURE", "POINT"):
        placed[:3, 3] = mapping.translation
    if kind == "TEXTURE":
        placed = np.linalg.inv(placed)
    elif kind == "NORMAL":
        placed = np.linalg.inv(placed).T
    return placed @ axes
