# SPDX-License-Identifier: GPL-3.0-or-later
"""Math and Vector Math beside Cycles."""

from __future__ import annotations

import pytest

from .harness import Case, add, difference, output, signed
from .varied import EDGES, away_from_zero, options, plane_numbers, plane_vectors

STEPS = {"LESS_THAN", "GREATER_THAN", "ROUND", "FLOOR", "CEIL", "TRUNC", "FRACT", "MODULO", "FLOORED_MODULO", "WRAP"}
STEPS |= {"SNAP", "COMPARE", "SIGN", "FRACTION", "FACEFORWARD", "REFRACT", "POWER"}


def math(operation, low=-2.0, high=2.0, clamp=False, scale=0.25):
    def build(tree, obj):
        inputs = dict(enumerate(plane_numbers(tree, low, high)))
        node = tree.nodes.new("ShaderNodeMath")
        node.operation, node.use_clamp = operation, clamp
        for number, socket in enumerate(s for s in node.inputs if s.enabled):
            tree.links.new(inputs[number], socket)
        return signed(tree, output(node), scale)

    return build


def math_by_constant(operation, value, low=-2.0, high=2.0):
    def build(tree, obj):
        return signed(
            tree, output(add(tree, "Math", {0: plane_numbers(tree, low, high)[0], 1: value}, operation=operation))
        )

    return build


RANGES = {
    "POWER": (0.0, 2.0),
    "EXPONENT": (-3.0, 1.5),
    "SINH": (-2.0, 2.0),
    "COSH": (-2.0, 2.0),
    "TANGENT": (-1.2, 1.2),
}
SCALES = {"DEGREES": 0.002, "INVERSE_SQRT": 0.02, "DIVIDE": 0.001, "LOGARITHM": 0.01}

MATH = [
    Case(
        f"Math: {operation.lower().replace('_', ' ')}",
        math(operation, *RANGES.get(operation, (-2.0, 2.0)), scale=SCALES.get(operation, 0.25)),
        share=EDGES if operation in STEPS else 0.0,
    )
    for operation in options("Math", "operation")
] + [
    Case("Math: clamp", math("MULTIPLY_ADD", clamp=True, scale=1.0)),
    Case("Math: divide by 0", math_by_constant("DIVIDE", 0.0)),
    Case("Math: modulo by 0", math_by_constant("MODULO", 0.0)),
    Case("Math: ping pong over 0", math_by_constant("PINGPONG", 0.0)),
    Case("Math: wrap in 0", math_by_constant("WRAP", 0.5)),
    Case("Math: smooth minimum of sharp edge", math_by_constant("SMOOTH_MIN", 0.3)),
    Case("Math: power of negative numbers", math_by_constant("POWER", 3.0)),
    Case("Math: power of negative numbers, root", math_by_constant("POWER", 0.5)),
    Case("Math: logarithm to base 1", math_by_constant("LOGARITHM", 1.0)),
    Case("Math: constants", lambda tree, obj: output(add(tree, "Math", {0: 0.3, 1: 0.2}, operation="SUBTRACT"))),
]


def vector_math(operation, low=-2.0, high=2.0, scale=0.1):
    def build(tree, obj):
        vectors = dict(enumerate(plane_vectors(tree, low, high)))
        if operation in ("DIVIDE", "SNAP", "MODULO"):
            vectors[1] = away_from_zero(tree, vectors[1])
        node = tree.nodes.new("ShaderNodeVectorMath")
        node.operation = operation
        for number, socket in enumerate(s for s in node.inputs if s.enabled):
            if socket.type == "VECTOR":
                tree.links.new(vectors[number], socket)
            else:
                socket.default_value = 0.7
        return signed(tree, output(node), scale)

    return build


def vector_math_by_constant(operation, value):
    def build(tree, obj):
        return signed(tree, output(add(tree, "VectorMath", {0: plane_vectors(tree)[0], 1: value}, operation=operation)))

    return build


VECTOR_RANGES = {"POWER": (0.5, 1.5), "TANGENT": (-1.0, 1.0)}
VECTOR_MATH = [
    Case(
        f"Vector Math: {operation.lower().replace('_', ' ')}",
        vector_math(operation, *VECTOR_RANGES.get(operation, (-2.0, 2.0)), scale=0.1),
        share=EDGES if operation in STEPS else 0.0,
    )
    for operation in options("VectorMath", "operation")
] + [
    Case(f"Vector Math: {operation.lower()} by 0", vector_math_by_constant(operation, (0.0, 0.5, 0.0)))
    for operation in ("DIVIDE", "MODULO", "SNAP")
]

CASES = MATH + VECTOR_MATH


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_agrees_with_cycles(case):
    largest, share = difference(case)
    print(f"largest difference {largest:.1e}, {share:.2%} of the pixels beyond {case.tolerance:g}")
    assert share <= case.share
