# SPDX-License-Identifier: GPL-3.0-or-later
"""Mix, in its modes, beside Cycles."""

from __future__ import annotations

import pytest

from .harness import Case, add, difference, output, signed
from .varied import away_from_zero, options, plane_numbers, plane_vectors


def mix(data_type, clamp_factor, factor_mode="UNIFORM"):
    def build(tree, obj):
        a, b, c = plane_vectors(tree) if data_type == "VECTOR" else plane_numbers(tree)
        factor = c if factor_mode == "NON_UNIFORM" else plane_numbers(tree, -0.5, 1.5)[2]
        node = add(
            tree,
            "Mix",
            {0: factor, 1: a, 2: b},
            data_type=data_type,
            clamp_factor=clamp_factor,
            factor_mode=factor_mode,
        )
        return signed(tree, output(node))

    return build


def blend(mode, low=-0.5, high=1.5, **settings):
    def build(tree, obj):
        a, b, _ = plane_vectors(tree, low, high)
        if mode == "DIVIDE":
            b = away_from_zero(tree, b)
        factor = plane_numbers(tree, -0.3, 1.3)[2]
        node = add(tree, "Mix", {0: factor, 1: a, 2: b}, data_type="RGBA", blend_type=mode, **settings)
        return signed(tree, output(node))

    return build


def blend_constants(mode, a, b):
    def build(tree, obj):
        factor = plane_numbers(tree, -0.3, 1.3)[0]
        inputs = {"Fac": factor, "Color1": (*a, 1.0), "Color2": (*b, 1.0)}
        return signed(tree, output(add(tree, "MixRGB", inputs, blend_type=mode)))

    return build


# Those that divide jump where a negative channel meets a positive one.
BLEND_RANGES = dict.fromkeys(("DODGE", "DIVIDE", "SATURATION", "COLOR"), (0.2, 1.5))
MIX = (
    [
        Case(f"Mix: {kind.lower()}, {'clamped' if clamp else 'free'} factor", mix(kind, clamp))
        for kind in ("FLOAT", "VECTOR")
        for clamp in (False, True)
    ]
    + [Case(f"Mix: vector, {clamp} factor of three", mix("VECTOR", clamp, "NON_UNIFORM")) for clamp in (False, True)]
    + [
        Case(
            f"Mix: {mode.lower().replace('_', ' ')}",
            blend(mode, *BLEND_RANGES.get(mode, (-0.5, 1.5)), clamp_factor=True),
        )
        for mode in options("Mix", "blend_type")
    ]
    + [
        Case(f"Mix: {mode.lower().replace('_', ' ')} of colours", blend(mode, 0.1, 1.0))
        for mode in options("Mix", "blend_type")
    ]
    + [
        Case("Mix: clamped result", blend("ADD", clamp_result=True)),
        Case("Mix: hue of grey", blend_constants("HUE", (0.8, 0.2, 0.1), (0.5, 0.5, 0.5))),
        Case("Mix: saturation of grey", blend_constants("SATURATION", (0.4, 0.4, 0.4), (0.5, 0.1, 0.5))),
        Case("Mix: dodge of black and white", blend_constants("DODGE", (0.0, 0.5, 1.0), (1.0, 1.0, 0.0))),
        Case("Mix: burn of black and white", blend_constants("BURN", (0.0, 0.5, 1.0), (0.0, 1.0, 0.0))),
        Case("Mix: divide by black", blend_constants("DIVIDE", (0.1, 0.5, 1.0), (0.0, 1.0, 0.0))),
    ]
    + [
        Case(f"Mix (legacy): {mode.lower().replace('_', ' ')}", blend_constants(mode, (0.8, 0.3, 0.1), (0.2, 0.6, 0.9)))
        for mode in options("MixRGB", "blend_type")
    ]
)

CASES = MIX


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_agrees_with_cycles(case):
    largest, share = difference(case)
    print(f"largest difference {largest:.1e}, {share:.2%} of the pixels beyond {case.tolerance:g}")
    assert share <= case.share
