# SPDX-License-Identifier: GPL-3.0-or-later
"""Links across socket types, through groups, beside Cycles."""

from __future__ import annotations

import bpy
import pytest

from .harness import Case, add, difference, output, signed
from .varied import EDGES, plane_numbers, plane_vectors


def through_group(kind, source):
    """A value that passes a group's socket of another type."""

    def build(tree, obj):
        group = bpy.data.node_groups.new("Group", "ShaderNodeTree")
        group.interface.new_socket("In", in_out="INPUT", socket_type=f"NodeSocket{kind}")
        group.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketVector")
        start, end = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
        group.links.new(start.outputs[0], end.inputs[0])
        node = tree.nodes.new("ShaderNodeGroup")
        node.node_tree = group
        tree.links.new(source(tree), node.inputs[0])
        return signed(tree, node.outputs[0])

    return build


def color_source(tree):
    return output(add(tree, "Gamma", {"Color": plane_vectors(tree)[0]}))


def into_number(source):
    """A value that enters a socket of a number."""
    return lambda tree, obj: signed(tree, output(add(tree, "Math", {0: source(tree), 1: 0.1}, operation="ADD")))


SOURCES = {
    "number": lambda tree: plane_numbers(tree)[2],
    "vector": lambda tree: plane_vectors(tree)[0],
    "colour": color_source,
}
CONSTANTS = {
    "constant number": lambda tree: output(add(tree, "Math", {0: 1.5, 1: 0.4}, operation="ADD")),
    "constant vector": lambda tree: output(add(tree, "CombineXYZ", {0: 0.9, 1: 1.5, 2: -2.6})),
    "constant colour": lambda tree: output(add(tree, "CombineColor", {0: 0.9, 1: 1.5, 2: 0.6})),
}
CASES = [
    Case(f"Link: {name} through {kind.lower()}", through_group(kind, source), share=EDGES if kind == "Int" else 0.0)
    for name, source in (SOURCES | CONSTANTS).items()
    for kind in ("Float", "Vector", "Color", "Int", "Bool")
] + [Case(f"Link: {name} into a number", into_number(source)) for name, source in SOURCES.items()]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_agrees_with_cycles(case):
    largest, share = difference(case)
    print(f"largest difference {largest:.1e}, {share:.2%} of the pixels beyond {case.tolerance:g}")
    assert share <= case.share
