# SPDX-License-Identifier: GPL-3.0-or-later
"""The Attribute and Color Attribute nodes.

Source: Blender manual, "Attribute Node", "Color Attribute Node". A number fills the colour, a vector has alpha 1, and
what does not exist is 0 (but for the alpha of an attribute of meshes).
"""

from __future__ import annotations

import numpy as np

from ..interaction import corner_values_at
from . import spaces
from .base import Operation


def _attribute(context, inputs, properties):
    kind, name = properties.get("attribute_type", "GEOMETRY"), properties.get("attribute_name", "")
    if context.surface is None:
        return _outputs(np.array([[0], [0], [0], [1]], np.float32))
    if kind == "GEOMETRY":
        return _of_mesh(context, "attribute", name)
    column = context.geometry.objects.attributes.get((kind, name))
    if column is None:
        return _outputs(np.zeros((4, 1), np.float32))
    return _outputs(spaces.of_object(context, column))


def _vertex_color(context, inputs, properties):
    if context.surface is None:
        return _outputs(np.zeros((4, 1), np.float32))
    return _of_mesh(context, "color", properties.get("layer_name") or None)


def _of_mesh(context, kind, name):
    s, table = context.surface, context.geometry.corner_values[kind, name]
    return _outputs(corner_values_at(table, s.prim, s.u, s.v, context.arena))


def _outputs(values):
    """Of colour and alpha, and the number where it is not the colour's mean."""
    color = values[:3]
    fac = values[4] if len(values) > 4 else (values[0] + values[1] + values[2]) * np.float32(1 / 3)
    return {"color": color, "vector": color, "fac": fac, "alpha": values[3]}


OPERATIONS = {
    "attribute": Operation(_attribute, foldable=False),
    "vertex_color": Operation(_vertex_color, foldable=False),
}
