# SPDX-License-Identifier: GPL-3.0-or-later
"""What nodes are fed with: numbers and vectors that vary over the picture."""

from __future__ import annotations

import bpy

from .harness import add, coordinates, output

# Modes whose result jumps: where the numbers of both engines fall on different sides, a pixel may differ.
EDGES = 0.002


def plane_numbers(tree, low=-2.0, high=2.0):
    """Three numbers that vary differently over the picture, from `low` to `high`."""
    reach = high - low
    vector = coordinates(tree, (reach, reach, 1.0), (low, low, 0.0))
    turned = coordinates(tree, (-0.7 * reach, 0.6 * reach, 1.0), (high * 0.8, low * 0.6, 0.0), (0.0, 0.0, 0.4))
    # Lines on which two of them are equal, or whole, would fall on pixels' centres without the odd shift.
    vector = output(add(tree, "VectorMath", {0: vector, 1: (0.00317, -0.00513, 0.0)}, operation="ADD"))
    first, second = add(tree, "SeparateXYZ", {0: vector}), add(tree, "SeparateXYZ", {0: turned})
    return output(first, 0), output(first, 1), output(second, 0)


def plane_vectors(tree, low=-2.0, high=2.0):
    """Three vectors that vary differently over the picture."""
    reach = high - low
    return (
        coordinates(tree, (reach, reach, 1.0), (low, low, 0.3), (0.4, 0.2, 0.0)),
        coordinates(tree, (-reach, 0.7 * reach, 1.0), (high, low * 0.8, -0.4), (0.2, -0.5, 0.9)),
        coordinates(tree, (0.5 * reach, -reach, 1.0), (low, high, 0.2), (-0.7, 0.3, 0.1)),
    )


def away_from_zero(tree, vector):
    """A divisor by which rounding errors do not grow."""
    positive = output(add(tree, "VectorMath", {0: vector}, operation="ABSOLUTE"))
    return output(add(tree, "VectorMath", {0: positive, 1: (0.3, 0.3, 0.3)}, operation="ADD"))


def options(kind, name):
    """All values of an enumeration of a node."""
    return [item.identifier for item in getattr(bpy.types, f"ShaderNode{kind}").bl_rna.properties[name].enum_items]
