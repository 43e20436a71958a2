# SPDX-License-Identifier: GPL-3.0-or-later
"""Colour nodes, Combine and Separate beside Cycles."""

from __future__ import annotations

import bpy
import pytest

from .harness import Case, add, difference, output, signed
from .varied import EDGES, plane_numbers, plane_vectors


def hue_saturation(low, high):
    def build(tree, obj):
        color, _, _ = plane_vectors(tree, low, high)
        hue, saturation, value = plane_numbers(tree, -0.5, 1.5)
        inputs = {"Color": color, "Hue": hue, "Saturation": saturation, "Value": value, "Fac": 0.8}
        return signed(tree, output(add(tree, "HueSaturation", inputs)))

    return build


def of_color(kind, name, inputs, **properties):
    """A node of a colour and the numbers `inputs` names, which vary."""

    def build(tree, obj):
        numbers = plane_numbers(tree, -0.5, 1.5)
        linked = dict(zip(inputs, numbers, strict=False))
        node = add(tree, kind, {name: plane_vectors(tree, -0.5, 1.5)[0]} | linked, **properties)
        return signed(tree, output(node))

    return build


def combined(kind, **properties):
    def build(tree, obj):
        return signed(tree, output(add(tree, kind, dict(enumerate(plane_numbers(tree, -0.3, 1.3))), **properties)))

    return build


def separated(kind, low=0.0, high=1.0, **properties):
    def build(tree, obj):
        apart = add(tree, kind, {0: plane_vectors(tree, low, high)[0]}, **properties)
        together = add(tree, "CombineXYZ", {number: output(apart, number) for number in range(3)})
        return signed(tree, output(together))

    return build


def temperature(kind, low, high):
    def build(tree, obj):
        number = add(
            tree, "MapRange", {"Value": plane_numbers(tree, 0.0, 1.0)[2], "To Min": low, "To Max": high}, clamp=False
        )
        return signed(tree, output(add(tree, kind, {0: output(number)})), 0.18, 0.0)

    return build


COLOR = [
    Case("Hue/Saturation: colours", hue_saturation(0.0, 1.0)),
    Case("Hue/Saturation: beyond 0 to 1", hue_saturation(-0.5, 1.5), share=EDGES),
    Case("Invert: factor", of_color("Invert", "Color", ("Fac",))),
    Case("Gamma: linked", of_color("Gamma", "Color", ("Gamma",))),
    Case("Gamma: constant", lambda tree, obj: output(add(tree, "Gamma", {0: (0.2, 0.7, 1.5, 1.0), 1: 2.2}))),
    Case("Brightness/Contrast: linked", of_color("BrightContrast", "Color", ("Bright", "Contrast"))),
    Case("RGB to BW: all", of_color("RGBToBW", "Color", ())),
    Case("Combine XYZ: all", combined("CombineXYZ")),
    Case("Separate XYZ: all", separated("SeparateXYZ")),
    Case("Blackbody: 400 K to 14,000 K", temperature("Blackbody", 400.0, 14000.0)),
    Case("Blackbody: 700 K to 2,000 K", temperature("Blackbody", 700.0, 2000.0)),
    Case("Wavelength: 360 nm to 800 nm", temperature("Wavelength", 360.0, 800.0)),
]
COLOR += [
    Case(f"Combine Color: {mode}", combined("CombineColor", mode=mode), share=EDGES) for mode in ("RGB", "HSV", "HSL")
]
COLOR += [
    Case(f"Separate Color: {mode}{beyond}", separated("SeparateColor", *limits, mode=mode), share=EDGES)
    for mode in ("RGB", "HSV", "HSL")
    for beyond, limits in (("", (0.0, 1.0)), (", beyond 0 to 1", (-0.1, 1.2)))
]
if bpy.app.version < (5, 0):
    COLOR += [Case(f"Combine {mode} (legacy): all", combined(f"Combine{mode}"), share=EDGES) for mode in ("RGB", "HSV")]
    COLOR += [Case(f"Separate {mode} (legacy): all", separated(f"Separate{mode}")) for mode in ("RGB", "HSV")]

CASES = COLOR


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_agrees_with_cycles(case):
    largest, share = difference(case)
    print(f"largest difference {largest:.1e}, {share:.2%} of the pixels beyond {case.tolerance:g}")
    assert share <= case.share
