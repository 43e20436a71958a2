# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's shader nodes by the core's names: all that the export knows about single nodes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class NodeType:
    """How one kind of node is written down.

    Parameters
    ----------
    op : str or None
        Name of the operation; None is a constant, held by the node's output.
    inputs : mapping of str to str
        Input names that differ from the socket's own (identifier in snake case).
    properties : mapping of str to str
        Node properties that are copied: Blender's name to the core's.
    expected : mapping of str to object
        Node properties without counterpart in the core, and the only value that is rendered right.
    """

    op: str | None
    inputs: Mapping[str, str] = field(default_factory=dict)
    properties: Mapping[str, str] = field(default_factory=dict)
    expected: Mapping[str, object] = field(default_factory=dict)


def _same(*names):
    return {name: name for name in names}


_SHADERS = {"shader": "a", "shader_001": "b"}
_DISTRIBUTION = _same("distribution")
_GLOSSY = NodeType("glossy", properties=_DISTRIBUTION)

NODES = {
    # Closures
    "ShaderNodeBsdfPrincipled": NodeType("principled", properties=_same("distribution", "subsurface_method")),
    "ShaderNodeBsdfDiffuse": NodeType("diffuse"),
    "ShaderNodeBsdfGlossy": _GLOSSY,
    "ShaderNodeBsdfAnisotropic": _GLOSSY,
    "ShaderNodeBsdfGlass": NodeType("glass", properties=_DISTRIBUTION),
    "ShaderNodeBsdfRefraction": NodeType("refraction", properties=_DISTRIBUTION),
    "ShaderNodeBsdfTranslucent": NodeType("translucent"),
    "ShaderNodeBsdfTransparent": NodeType("transparent"),
    "ShaderNodeEmission": NodeType("emission"),
    "ShaderNodeBackground": NodeType("background"),
    "ShaderNodeHoldout": NodeType("holdout"),
    "ShaderNodeMixShader": NodeType("mix_shader", inputs=_SHADERS),
    "ShaderNodeAddShader": NodeType("add_shader", inputs=_SHADERS),
    # Textures and coordinates
    "ShaderNodeTexImage": NodeType("image", properties=_same("image", "interpolation", "projection", "extension")),
    "ShaderNodeTexEnvironment": NodeType("environment", properties=_same("image", "interpolation", "projection")),
    "ShaderNodeTexChecker": NodeType("checker"),
    "ShaderNodeMapping": NodeType("mapping", properties=_same("vector_type")),
    "ShaderNodeTexCoord": NodeType("tex_coord", expected={"object": None, "from_instancer": False}),
    "ShaderNodeUVMap": NodeType("uv_map", properties=_same("uv_map"), expected={"from_instancer": False}),
    # Constants
    "ShaderNodeRGB": NodeType(None),
    "ShaderNodeValue": NodeType(None),
}
