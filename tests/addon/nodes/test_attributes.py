# SPDX-License-Identifier: GPL-3.0-or-later
"""Attributes of meshes, objects and view layers beside Cycles."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from .harness import Case, add, difference, output, signed
from .shapes import ball, instances

MEMBERS = {
    "FLOAT": ("value", 1),
    "INT": ("value", 1),
    "INT8": ("value", 1),
    "BOOLEAN": ("value", 1),
    "FLOAT2": ("vector", 2),
    "FLOAT_VECTOR": ("vector", 3),
    "FLOAT_COLOR": ("color", 4),
    "BYTE_COLOR": ("color", 4),
    "QUATERNION": ("value", 4),
}


def random_attribute(mesh, kind, domain, name="A", seed=1):
    """Give `mesh` an attribute of random values."""
    is_color = kind in ("FLOAT_COLOR", "BYTE_COLOR")
    attribute = (mesh.color_attributes if is_color else mesh.attributes).new(name, kind, domain)
    member, columns = MEMBERS[kind]
    values = np.random.default_rng(seed).random((len(attribute.data), columns))
    if kind in ("INT", "INT8"):
        values = np.round(5 * values).astype(int)
    elif kind == "BOOLEAN":
        values = values > 0.5
    attribute.data.foreach_set(member, values.ravel())


def of_mesh(kind, domain, socket="Color", node="Attribute"):
    def build(tree, obj):
        ball(obj)
        random_attribute(obj.data, kind, domain)
        name = {"attribute_name": "A"} if node == "Attribute" else {"layer_name": "A"}
        return output(add(tree, node, **name), socket)

    return build


def active_color(tree, obj):
    ball(obj)
    random_attribute(obj.data, "BYTE_COLOR", "CORNER", "First")
    random_attribute(obj.data, "FLOAT_COLOR", "POINT", "Second", seed=2)
    obj.data.color_attributes.render_color_index = 1
    return output(add(tree, "VertexColor"), "Color")


def vertex_group(tree, obj):
    group = obj.vertex_groups.new(name="Group")
    group.add([0, 1], 0.7, "REPLACE")
    group.add([2], 0.2, "REPLACE")
    return output(add(tree, "Attribute", attribute_name="Group"), "Fac")


def named(name, socket, node="Attribute"):
    key = "attribute_name" if node == "Attribute" else "layer_name"
    return lambda tree, obj: output(add(tree, node, **{key: name}), socket)


def of_object(kind, name, socket):
    def build(tree, obj):
        obj["number"], obj["count"], obj["flag"] = 0.7, 3, True
        obj["pair"], obj["vector"], obj["color"] = (0.5, 0.6), (0.1, 0.2, 0.3), (0.1, 0.2, 0.3, 0.4)
        obj.data["of mesh"] = 0.3
        scene = bpy.context.scene
        scene["of scene"], bpy.context.view_layer["of layer"] = 0.6, 0.4
        return signed(tree, output(add(tree, "Attribute", attribute_type=kind, attribute_name=name), socket))

    return build


def of_instancer(name):
    def build(tree, obj):
        instances(obj, "FACES")
        return signed(tree, output(add(tree, "Attribute", attribute_type="INSTANCER", attribute_name=name), "Color"))

    return build


DOMAINS = ("POINT", "CORNER", "FACE", "EDGE")
PLAIN = ("FLOAT", "INT", "INT8", "BOOLEAN", "FLOAT2", "FLOAT_VECTOR")
PROPERTIES = ("number", "count", "flag", "pair", "vector", "color", "of mesh", "location", "pass_index", "missing")

CASES = [
    *(Case(f"Attribute: {k.lower()} of {d.lower()}s", of_mesh(k, d)) for k in PLAIN for d in DOMAINS),
    *(Case(f"Attribute: quaternion of {d.lower()}s", of_mesh("QUATERNION", d)) for d in DOMAINS[:3]),
    *(
        Case(f"Attribute: {k.lower()} of {d.lower()}s", of_mesh(k, d))
        for k in ("FLOAT_COLOR", "BYTE_COLOR")
        for d in DOMAINS[:2]
    ),
    *(
        Case(f"Attribute: {s.lower()} of {k.lower()}", of_mesh(k, "POINT", s))
        for s in ("Vector", "Fac", "Alpha")
        for k in ("FLOAT", "FLOAT2", "FLOAT_VECTOR", "FLOAT_COLOR")
    ),
    *(Case(f"Attribute: missing, {s.lower()}", named("nothing", s)) for s in ("Color", "Fac", "Alpha")),
    *(Case(f"Attribute: UV map, {s.lower()}", named("UVMap", s)) for s in ("Color", "Fac", "Alpha")),
    Case("Attribute: vertex group", vertex_group),
    *(
        Case(f"Attribute: {kind.lower()}, {name}, {socket.lower()}", of_object(kind, name, socket))
        for kind in ("OBJECT", "INSTANCER")
        for name in PROPERTIES
        for socket in ("Color", "Alpha")
    ),
    *(
        Case(f"Attribute: view layer, {name}", of_object("VIEW_LAYER", name, "Color"))
        for name in ("of scene", "of layer", "frame_current", "render.fps", "missing")
    ),
    *(Case(f"Attribute: instancer of instances, {name}", of_instancer(name)) for name in ("of grid", "color")),
    *(
        Case(f"Color Attribute: {k.lower()}, {s.lower()}", of_mesh(k, d, s, "VertexColor"))
        for k, d in (("BYTE_COLOR", "CORNER"), ("FLOAT_COLOR", "POINT"))
        for s in ("Color", "Alpha")
    ),
    Case("Color Attribute: active", active_color),
    *(
        Case(f"Color Attribute: {'missing' if name else 'none'}, {s.lower()}", named(name, s, "VertexColor"))
        for name in ("nothing", "")
        for s in ("Color", "Alpha")
    ),
]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_agrees_with_cycles(case):
    largest, share = difference(case)
    print(f"largest difference {largest:.1e}, {share:.2%} of the pixels beyond {case.tolerance:g}")
    assert share <= case.share
