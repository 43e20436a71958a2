# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that turn vectors, and Light Falloff, beside Cycles."""

from __future__ import annotations

import bpy
import pytest

from .harness import Case, add, difference, output, signed
from .ies_files import FILES, ies_text
from .varied import options, plane_numbers, plane_vectors


def vector_rotate(kind, invert):
    def build(tree, obj):
        a, b, c = plane_vectors(tree)
        inputs = {"Vector": a, "Center": (0.3, -0.2, 0.1)}
        inputs |= {"Rotation": c} if kind == "EULER_XYZ" else {"Angle": plane_numbers(tree)[1]}
        if kind == "AXIS_ANGLE":
            inputs["Axis"] = b
        return signed(tree, output(add(tree, "VectorRotate", inputs, rotation_type=kind, invert=invert)), 0.1)

    return build


def no_axis(tree, obj):
    inputs = {"Vector": plane_vectors(tree)[0], "Axis": (0.0, 0.0, 0.0), "Angle": 1.0}
    return signed(tree, output(add(tree, "VectorRotate", inputs)), 0.1)


def mapping(kind):
    def build(tree, obj):
        inputs = {"Vector": plane_vectors(tree)[0], "Rotation": (0.3, -0.5, 1.1), "Scale": (2.0, 0.5, -1.5)}
        inputs |= {"Location": (0.3, -0.2, 0.1)} if kind in ("POINT", "TEXTURE") else {}
        return signed(tree, output(add(tree, "Mapping", inputs, vector_type=kind)), 0.1)

    return build


def constant(kind, value):
    def build(tree, obj):
        node = tree.nodes.new(kind)
        node.outputs[0].default_value = value
        return node.outputs[0]

    return build


def normal(result):
    def build(tree, obj):
        node = add(tree, "Normal", {0: plane_vectors(tree)[0]})
        node.outputs["Normal"].default_value = (0.6, 0.0, 0.8)
        return signed(tree, output(node, result))

    return build


def vector_transform(kind, start, end):
    """On an object and by a camera that are turned and moved; the plane still fills the picture."""

    def build(tree, obj):
        obj.location, obj.rotation_euler, obj.scale = (0.2, -0.1, 0.0), (0.0, 0.0, 0.5), (2.0, 3.0, 0.7)
        camera = bpy.context.scene.camera
        camera.location, camera.rotation_euler = (0.1, 0.2, 2.5), (0.1, 0.0, 0.3)
        inputs = {0: plane_vectors(tree, 0.1, 1.0)[0]}
        node = add(tree, "VectorTransform", inputs, vector_type=kind, convert_from=start, convert_to=end)
        return signed(tree, output(node))

    return build


def light_falloff(result, smooth):
    def build(tree, obj):
        strength = plane_numbers(tree, 0.0, 2.0)[0]
        node = add(tree, "LightFalloff", {"Strength": strength, "Smooth": smooth})
        return signed(tree, output(node, result), 0.1)

    return build


def ies(name):
    """The file over directions that cross the plane, half of them from above."""

    def build(tree, obj):
        inputs = {"Vector": plane_vectors(tree, -1.0, 1.0)[0], "Strength": 0.1}
        return output(add(tree, "TexIES", inputs, mode="INTERNAL", ies=ies_text(name)))

    return build


VECTOR = [
    Case(f"Vector Rotate: {kind.lower().replace('_', ' ')}{', inverted' * invert}", vector_rotate(kind, invert))
    for kind in options("VectorRotate", "rotation_type")
    for invert in (False, True)
] + [
    Case("Vector Rotate: axis of no length", no_axis),
    Case("Normal: normal", normal("Normal")),
    Case("Normal: dot", normal("Dot")),
]
VECTOR += [
    Case(f"Vector Transform: {kind.lower()}, {start.lower()} to {end.lower()}", vector_transform(kind, start, end))
    for kind in options("VectorTransform", "vector_type")
    for start in options("VectorTransform", "convert_from")
    for end in options("VectorTransform", "convert_to")
]
VECTOR += [
    Case(f"Light Falloff: {result.lower()}{', smooth' * bool(smooth)}", light_falloff(result, smooth))
    for result in ("Quadratic", "Linear", "Constant")
    for smooth in (0.0, 3.0)
]

VECTOR += [Case(f"IES Texture: {name}", ies(name), share=0.002) for name in FILES]

VECTOR += [Case(f"Mapping: {k.lower()}", mapping(k)) for k in ("POINT", "TEXTURE", "VECTOR", "NORMAL")]
VECTOR += [Case("RGB: a colour", constant("ShaderNodeRGB", (0.2, 0.7, 1.5, 1.0)))]
VECTOR += [Case("Value: a number", constant("ShaderNodeValue", 0.3))]
CASES = VECTOR


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_agrees_with_cycles(case):
    largest, share = difference(case)
    print(f"largest difference {largest:.1e}, {share:.2%} of the pixels beyond {case.tolerance:g}")
    assert share <= case.share
