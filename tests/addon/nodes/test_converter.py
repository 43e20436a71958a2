# SPDX-License-Identifier: GPL-3.0-or-later
"""Ranges, ramps and curves beside Cycles."""

from __future__ import annotations

import pytest

from .harness import Case, add, difference, output, signed
from .varied import EDGES, options, plane_numbers, plane_vectors

FLOAT_RANGES = {
    "plain": (-1.0, 1.5, 0.2, 0.9),
    "backwards": (1.5, -1.0, 0.9, 0.2),
    "crossed": (-1.0, 1.5, 0.9, 0.2),
    "empty": (0.5, 0.5, 0.2, 0.9),
}


def map_range(interpolation, limits, clamp):
    def build(tree, obj):
        inputs = dict(
            zip(("Value", "From Min", "From Max", "To Min", "To Max"), (plane_numbers(tree)[0], *limits), strict=True)
        )
        if interpolation == "STEPPED":
            inputs["Steps"] = output(
                add(tree, "Math", {0: plane_numbers(tree, -3.0, 6.0)[1], 1: 1.0}, operation="SNAP")
            )
        return signed(tree, output(add(tree, "MapRange", inputs, interpolation_type=interpolation, clamp=clamp)))

    return build


def map_vector_range(interpolation, clamp):
    def build(tree, obj):
        a, _, c = plane_vectors(tree)
        inputs = {"Vector": a, "From Min": (-1.0, 1.0, 0.5), "From Max": (1.5, -1.0, 0.5), "To Min": (0.2, 0.9, 0.4)}
        inputs["To Max"] = c
        if interpolation == "STEPPED":
            inputs["Steps"] = (3.0, 0.0, 1.5)
        node = add(tree, "MapRange", inputs, data_type="FLOAT_VECTOR", interpolation_type=interpolation, clamp=clamp)
        return signed(tree, output(node))

    return build


INTERPOLATIONS = options("MapRange", "interpolation_type")
RANGE = [
    Case(
        f"Map Range: {interpolation.lower()}, {name}{', clamped' * clamp}",
        map_range(interpolation, limits, clamp),
        share=EDGES,
    )
    for interpolation in INTERPOLATIONS
    for name, limits in FLOAT_RANGES.items()
    for clamp in (False, True)
] + [
    Case(
        f"Map Range: vector {interpolation.lower()}{', clamped' * clamp}",
        map_vector_range(interpolation, clamp),
        share=EDGES,
    )
    for interpolation in INTERPOLATIONS
    for clamp in (False, True)
]


def clamp(kind):
    def build(tree, obj):
        inputs = {"Value": plane_numbers(tree)[0], "Min": plane_numbers(tree)[1], "Max": 0.4}
        return signed(tree, output(add(tree, "Clamp", inputs, clamp_type=kind)))

    return build


RANGE += [Case(f"Clamp: {kind.lower()}", clamp(kind)) for kind in options("Clamp", "clamp_type")]

STOPS = (
    (0.1, (0.9, 0.1, 0.0, 1.0)),
    (0.35, (0.1, 0.5, 0.9, 0.2)),
    (0.4, (0.0, 0.9, 0.3, 0.6)),
    (0.8, (0.6, 0.1, 0.7, 0.9)),
)


def ramp(mode, interpolation, hue="NEAR", result="Color"):
    def build(tree, obj):
        node = add(tree, "ValToRGB", {"Fac": plane_numbers(tree, -0.2, 1.2)[2]})
        colors = node.color_ramp
        colors.color_mode, colors.interpolation, colors.hue_interpolation = mode, interpolation, hue
        while len(colors.elements) < len(STOPS):
            colors.elements.new(0.5)
        for element, (position, color) in zip(colors.elements, STOPS, strict=True):
            element.position, element.color = position, color
        return output(node, result)

    return build


RAMP_INTERPOLATIONS = ("LINEAR", "EASE", "B_SPLINE", "CARDINAL", "CONSTANT")
RAMP = (
    [
        Case(f"Color Ramp: RGB {kind.lower()}", ramp("RGB", kind), share=EDGES if kind == "CONSTANT" else 0.0)
        for kind in RAMP_INTERPOLATIONS
    ]
    + [
        Case(f"Color Ramp: {mode} {hue.lower()}", ramp(mode, "LINEAR", hue))
        for mode in ("HSV", "HSL")
        for hue in ("NEAR", "FAR", "CW", "CCW")
    ]
    + [Case("Color Ramp: alpha", ramp("RGB", "LINEAR", result="Alpha"))]
)

POINTS = ((0.15, 0.6), (0.4, 0.2), (0.7, 0.9))


def curves(kind, extend="EXTRAPOLATED", points=POINTS, ends=None):
    def build(tree, obj):
        varied = plane_numbers(tree, -0.4, 1.4)[2] if kind == "FloatCurve" else plane_vectors(tree, -0.4, 1.4)[0]
        node = add(tree, kind, {0: 0.8, 1: varied})
        mapping = node.mapping
        mapping.use_clip, mapping.extend = False, extend
        for number, curve in enumerate(mapping.curves):
            for x, y in points[number % 2 :]:
                curve.points.new(x, y)
            if ends is not None:
                curve.points[0].location, curve.points[len(curve.points) - 1].location = ends
            if number == 1:
                curve.points[1].handle_type = "VECTOR"
        mapping.update()
        return signed(tree, output(node))

    return build


CURVE = [
    Case(f"{title}: {extend.lower()}{', wide' * bool(ends)}", curves(kind, extend, ends=ends))
    for title, kind in (("RGB Curves", "RGBCurve"), ("Vector Curves", "VectorCurve"), ("Float Curve", "FloatCurve"))
    for extend in ("HORIZONTAL", "EXTRAPOLATED")
    for ends in (None, ((-0.3, 0.1), (1.2, 0.7)))
]

CASES = RANGE + RAMP + CURVE


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_agrees_with_cycles(case):
    largest, share = difference(case)
    print(f"largest difference {largest:.1e}, {share:.2%} of the pixels beyond {case.tolerance:g}")
    assert share <= case.share
