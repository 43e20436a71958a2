# SPDX-License-Identifier: GPL-3.0-or-later
"""Normal maps, bumps and displacement beside Cycles."""

from __future__ import annotations

import bpy
import pytest

from .harness import Case, add, difference, output, signed
from .shapes import ball

COLOR = {"Color": (0.7, 0.4, 0.9, 1)}


def noise(tree, scale=3.0):
    """A height that varies."""
    return output(add(tree, "TexNoise", {"Scale": scale}), 0)


def mapped(strength=1.0, shape=None, keep_uv=True, **properties):
    """Builds a Normal Map of one colour on a ball."""

    def build(tree, obj):
        ball(obj, **(shape or {}))
        if not keep_uv:
            obj.data.uv_layers.remove(obj.data.uv_layers[0])
        return signed(tree, output(add(tree, "NormalMap", COLOR | {"Strength": strength}, **properties)))

    return build


def seam(tree, obj):
    """A Normal Map without a UV map at the side where the map that Blender makes begins and ends."""
    shown = mapped(keep_uv=False, shape={"scale": (3, 3, 3)})(tree, obj)
    obj.rotation_euler, obj.location = (-1.4, 0.2, 0.1), (0, 0, -3)
    return shown


def bumped(height=noise, inputs=None, shape=None, **properties):
    """Builds a Bump on a ball."""

    def build(tree, obj):
        ball(obj, **(shape or {}))
        given = {"Height": height(tree), "Distance": 0.3} | (inputs or {})
        return signed(tree, output(add(tree, "Bump", given, **properties)))

    return build


def component(kind, socket):
    """A height that is the first component of a node's vector."""
    return lambda tree: output(add(tree, "SeparateXYZ", {0: output(add(tree, kind), socket)}), 0)


def stripes(tree):
    """A height that follows the UV map."""
    scaled = add(tree, "Mapping", {0: output(add(tree, "UVMap")), "Scale": (20, 20, 20)})
    u = output(add(tree, "SeparateXYZ", {0: output(scaled)}), 0)
    return output(add(tree, "Math", {0: u}, operation="SINE"))


def of_a_bump(tree):
    """A height that depends on another bump."""
    normal = output(add(tree, "Bump", {"Height": noise(tree), "Distance": 0.3}))
    return output(add(tree, "SeparateXYZ", {0: normal}), 0)


def chained(tree, obj):
    ball(obj)
    first = output(add(tree, "Bump", {"Height": noise(tree), "Distance": 0.3}))
    given = {"Height": noise(tree, 8.0), "Distance": 0.1, "Normal": first}
    return signed(tree, output(add(tree, "Bump", given)))


def displaced(kind="Displacement", space="OBJECT", shape=None):
    """Builds the normal of a surface that is displaced."""

    def build(tree, obj):
        ball(obj, **(shape or {}))
        name, socket = ("Height", 0) if kind == "Displacement" else ("Vector", 1)
        moved = output(add(tree, "TexNoise", {"Scale": 3.0}), socket)
        displacement = add(tree, kind, {name: moved, "Scale": 0.3}, space=space)
        shown = signed(tree, output(add(tree, "NewGeometry"), "Normal"))
        # The first output is the active one, whatever the harness adds.
        last = add(tree, "OutputMaterial")
        tree.links.new(output(displacement), last.inputs["Displacement"])
        tree.links.new(output(add(tree, "Emission", {"Color": shown})), last.inputs["Surface"])
        return shown

    return build


SPACES = ("TANGENT", "OBJECT", "WORLD", "BLENDER_OBJECT", "BLENDER_WORLD")

CASES = [
    *(Case(f"Normal Map: {s.lower()} {k:g}", mapped(k, space=s)) for s in SPACES for k in (0.5, 1.0, 2.0)),
    Case("Normal Map: tangent, flat", mapped(shape={"smooth": False})),
    Case("Normal Map: tangent, mirrored", mapped(shape={"scale": (-1, 0.8, 0.6)})),
    Case("Normal Map: tangent, inside", mapped(shape={"inside_out": True})),
    Case("Normal Map: world, inside", mapped(shape={"inside_out": True}, space="WORLD")),
    Case("Normal Map: tangent, missing UV map", mapped(uv_map="nothing")),
    # Blender makes a map of its own then. At a pole its tangents cancel, and what Cycles takes is rounding noise.
    Case("Normal Map: tangent, no UV map", mapped(keep_uv=False), share=0.06),
    Case("Bump: noise", bumped()),
    Case("Bump: inverted, strength 0.4", bumped(inputs={"Strength": 0.4}, invert=True)),
    Case("Bump: flat", bumped(shape={"smooth": False})),
    Case("Bump: inside", bumped(shape={"inside_out": True})),
    Case("Bump: constant height", bumped(lambda tree: output(add(tree, "Value")))),
    Case("Bump: UV map", bumped(stripes, {"Distance": 0.1})),
    *(Case(f"Bump: {s.lower()}", bumped(component("TexCoord", s))) for s in ("Object", "Camera", "Window")),
    Case("Bump: position", bumped(component("NewGeometry", "Position"))),
    Case("Bump: of a bump", bumped(of_a_bump)),
    Case("Bump: after a bump", chained),
    *(Case(f"Displacement: {s.lower()}", displaced(space=s)) for s in ("OBJECT", "WORLD")),
    Case("Displacement: flat", displaced(shape={"smooth": False})),
    *(
        Case(f"Vector Displacement: {s.lower()}", displaced("VectorDisplacement", s))
        for s in ("TANGENT", "OBJECT", "WORLD")
    ),
]
if bpy.app.version >= (5, 0):
    CASES.append(Case("Bump: filter width 3", bumped(inputs={"Filter Width": 3.0})))
    # Before, Cycles measures triangles over the seam the long way round, and their tangents jump (its issue 139753).
    CASES.append(Case("Normal Map: tangent, no UV map, its seam", seam))


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_agrees_with_cycles(case):
    largest, share = difference(case)
    print(f"largest difference {largest:.1e}, {share:.2%} of the pixels beyond {case.tolerance:g}")
    assert share <= case.share
