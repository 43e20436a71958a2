# SPDX-License-Identifier: GPL-3.0-or-later
"""Converter, colour and vector nodes: on odd numbers, on constants, and in long chains."""

from __future__ import annotations

import numpy as np
import pytest

from zraka.core.arena import Arena
from zraka.core.compile import graph
from zraka.core.compile.code import Code
from zraka.core.compile.graph import Builder
from zraka.core.diagnostics import Diagnostics
from zraka.core.nodes import (
    blackbody,
    clamp,
    color,
    combine,
    convert,
    curves,
    hsv,
    map_range,
    math,
    mix,
    normal,
    ramp,
    vector_math,
    vector_rotate,
    wavelength,
)
from zraka.core.nodes.base import Context, Operation, as_vector
from zraka.core.nodes.blend import BLEND
from zraka.core.nodes.color_space import hsl_to_rgb, hsv_to_rgb, rgb_to_hsl, rgb_to_hsv
from zraka.core.nodes.table import Table
from zraka.core.scene import Link, Material, Node

FAMILIES = (blackbody, clamp, color, combine, curves, hsv, map_range, math, mix, normal, ramp)
FAMILIES += (vector_math, vector_rotate, wavelength)
OPERATIONS = {name: operation for family in FAMILIES for name, operation in family.OPERATIONS.items()}
LANES = 64

# Modes of the operations that have any; the others run as they are.
MODES = {
    "mix_rgba": [{"blend_type": kind, "clamp_result": True} for kind in BLEND],
    "map_range_float": [{"interpolation_type": k} for k in ("LINEAR", "STEPPED", "SMOOTHSTEP", "SMOOTHERSTEP")],
    "map_range_float_vector": [{"interpolation_type": k} for k in ("LINEAR", "STEPPED", "SMOOTHSTEP", "SMOOTHERSTEP")],
    "clamp_range": [{"clamp_type": kind} for kind in ("MINMAX", "RANGE")],
    "combine_color": [{"mode": mode} for mode in ("RGB", "HSV", "HSL")],
    "separate_color": [{"mode": mode} for mode in ("RGB", "HSV", "HSL")],
    "color_ramp": [{"samples": np.linspace(0, 1, 4 * 9).reshape(4, 9), "interpolate": kind} for kind in (True, False)],
    "float_curve": [{"samples": np.linspace(1, 0, 9).reshape(1, 9) ** 2, "low": -0.5, "high": 1.5}],
    "rgb_curves": [
        {"samples": np.linspace(0, 1, 27).reshape(3, 9) ** 2, "extrapolate": kind} for kind in (True, False)
    ],
    "vector_curves": [{"samples": np.linspace(0, 1, 27).reshape(3, 9) ** 2}],
}
CASES = [(name, mode) for name in OPERATIONS for mode in MODES.get(name, [{}])]


def name_of(value):
    return "-".join(v for v in value.values() if isinstance(v, str)) if isinstance(value, dict) else value


def run(name, inputs, properties, count):
    operation = OPERATIONS[name]
    if operation.prepare is not None:
        properties = operation.prepare({**properties, "linked": ()}, Diagnostics(), "")
    return operation.run(Context(Arena(), count), inputs, properties)


def random_inputs(operation, rng, count):
    """Lanes of all inputs in the operation's order."""
    shapes = {name: (3, count) if isinstance(v, tuple) else (count,) for name, v in operation.inputs.items()}
    return {name: rng.uniform(-1.5, 1.5, shape).astype(np.float32) for name, shape in shapes.items()}


cases = pytest.mark.parametrize("name, mode", CASES, ids=name_of)


@cases
def test_odd_numbers_stay_in_their_lane(name, mode):
    """Not a number, infinities, zeros and huge numbers neither warn nor reach another lane."""
    rng = np.random.default_rng(1)
    inputs = random_inputs(OPERATIONS[name], rng, LANES)
    plain = {k: np.array(v) for k, v in run(name, inputs, mode, LANES).items()}
    odd = np.array([np.nan, np.inf, -np.inf, 0.0, -0.0, 3e38, -3e38, 1e-42], np.float32)
    mixed = {k: v.copy() for k, v in inputs.items()}
    for v in mixed.values():
        v[..., ::2] = rng.choice(odd, v[..., ::2].shape)
    for output, value in run(name, mixed, mode, LANES).items():
        assert value.dtype == np.float32
        np.testing.assert_array_equal(value[..., 1::2], plain[output][..., 1::2])


@cases
def test_constants_give_constants_equal_to_lanes(name, mode):
    rng = np.random.default_rng(2)
    inputs = random_inputs(OPERATIONS[name], rng, 1)
    lanes = {k: np.repeat(v, LANES, axis=-1) for k, v in inputs.items()}
    constant, varied = run(name, inputs, mode, 1), run(name, lanes, mode, LANES)
    assert OPERATIONS[name].foldable
    for output, value in constant.items():
        assert value.shape[-1] == 1 and value.dtype == np.float32
        expected = np.broadcast_to(value, (*value.shape[:-1], LANES))
        np.testing.assert_allclose(np.broadcast_to(varied[output], expected.shape), expected, rtol=2e-6, atol=1e-6)


@cases
def test_constants_and_lanes_mix(name, mode):
    """Every other input constant gives what the same numbers give in lanes."""
    rng = np.random.default_rng(3)
    inputs = random_inputs(OPERATIONS[name], rng, LANES)
    for number, (k, v) in enumerate(inputs.items()):
        if number % 2 == 0 and len(inputs) > 1:
            inputs[k] = v[..., :1]
    lanes = {k: np.ascontiguousarray(np.broadcast_to(v, (*v.shape[:-1], LANES))) for k, v in inputs.items()}
    mixed, plain = run(name, inputs, mode, LANES), run(name, lanes, mode, LANES)
    for output, value in plain.items():
        np.testing.assert_allclose(np.broadcast_to(mixed[output], value.shape), value, rtol=2e-6, atol=1e-6)


# -- graphs ------------------------------------------------------------------------------------------------------------


def build(nodes):
    """The builder of a graph, its messages, and the value of the last node."""
    diagnostics = Diagnostics()
    builder = Builder(Material("chain", tuple(nodes), len(nodes) - 1), diagnostics)
    for index in range(len(nodes)):
        outputs = builder.node_outputs(index)
    return builder, diagnostics, outputs


def chain(first, output, length):
    """`first`, and `length` Math nodes after it that each halve or add 1/16."""
    nodes = [first]
    for number in range(length):
        op, other = ("math_add", 0.0625) if number % 2 else ("math_multiply", 0.5)
        nodes.append(Node(op, {"a": Link(number, "value" if number else output), "b": other}))
    return nodes


def expected(x, length):
    for number in range(length):
        x = x + 0.0625 if number % 2 else x * 0.5
    return x


def test_two_thousand_constant_nodes_in_a_row_fold():
    builder, diagnostics, outputs = build(chain(Node("value", {"value": 0.3}), "value", 2000))
    assert diagnostics.messages() == [] and builder.instructions == []
    assert outputs["value"].value == pytest.approx(expected(0.3, 2000), rel=1e-5)


def test_two_thousand_nodes_in_a_row_run(monkeypatch):
    source = np.linspace(0, 1, LANES, dtype=np.float32)
    varied = Operation(lambda context, inputs, properties: {"value": source}, foldable=False)
    monkeypatch.setitem(graph.OPERATIONS, "varied", varied)
    builder, diagnostics, outputs = build(chain(Node("varied"), "value", 2000))
    code = Code(builder, {"x": outputs.get("value")})
    assert diagnostics.messages() == []
    found = code.run(Context(Arena(), LANES), code.row.reshape(-1, 1))["x"]
    np.testing.assert_allclose(found, expected(source, 2000), rtol=1e-5)


def test_a_constant_graph_folds_through_every_kind_of_node():
    nodes = [
        Node("blackbody", {"temperature": 4000.0}),
        Node("hue_saturation", {"color": Link(0, "color"), "saturation": 0.5}),
        Node("separate_color", {"color": Link(1, "color")}, {"mode": "HSV"}),
        Node("map_range_float", {"value": Link(2, "green"), "to_max": 2.0}),
        Node("color_ramp", {"fac": Link(3, "result")}, {"samples": np.linspace(0, 1, 40).reshape(4, 10)}),
        Node("mix_rgba", {"factor": 0.3, "a": Link(4, "color"), "b": Link(0, "color")}, {"blend_type": "SCREEN"}),
        Node("vector_math_normalize", {"a": Link(5, "result")}),
        Node("vector_rotate_z_axis", {"vector": Link(6, "vector"), "angle": 1.0}),
        Node("convert", {"value": Link(7, "vector")}, {"from": "vector", "to": "float"}),
        Node("math_power", {"a": Link(8, "value"), "b": 2.0}),
    ]
    builder, diagnostics, outputs = build(nodes)
    assert diagnostics.messages() == [] and builder.instructions == []
    assert np.isfinite(outputs["value"].value).all()
    assert Code(builder, {"x": outputs["value"]}).is_constant


def test_equal_ramps_are_one_table():
    samples = np.random.default_rng(0).random((4, 9))
    first, again, other = Table.of(samples), Table.of(samples.copy()), Table.of(samples + 1)
    assert first is again and first is not other


def test_an_unknown_blend_mode_is_said():
    _, diagnostics, outputs = build([Node("mix_rgba", {"a": (1.0,) * 3, "b": (0.0,) * 3}, {"blend_type": "PINK"})])
    assert "PINK is not supported" in diagnostics.messages()[0]
    np.testing.assert_allclose(outputs["result"].value, 0.5)


# -- facts -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("there, back", [(rgb_to_hsv, hsv_to_rgb), (rgb_to_hsl, hsl_to_rgb)])
def test_colour_spaces_invert(there, back):
    rgb = np.random.default_rng(4).random((3, 1000)).astype(np.float32)
    rgb[:, :8] = np.indices((2, 2, 2)).reshape(3, 8)
    np.testing.assert_allclose(back(there(rgb)), rgb, atol=3e-6)


@pytest.mark.parametrize(
    "name, values, result",
    [
        ("math_divide", (1.0, 0.0), 0.0),
        ("math_power", (-2.0, 0.5), 0.0),
        ("math_power", (-2.0, 3.0), -8.0),
        ("math_logarithm", (8.0, 2.0), 3.0),
        ("math_logarithm", (-8.0, 2.0), 0.0),
        ("math_modulo", (-5.5, 2.0), -1.5),
        ("math_floored_modulo", (-5.5, 2.0), 0.5),
        ("math_wrap", (3.5, 1.0, -1.0), -0.5),
        ("math_wrap", (3.5, 1.0, 1.0), 1.0),
        ("math_pingpong", (2.5, 1.0), 0.5),
        ("math_snap", (3.7, 0.5), 3.5),
        ("math_smooth_min", (1.0, 1.0, 0.6), 0.9),
        ("math_compare", (1.0, 1.25, 0.25), 1.0),
        ("math_inverse_sqrt", (0.0,), 0.0),
        ("math_round", (-2.5,), -2.0),
    ],
)
def test_math_by_hand(name, values, result):
    inputs = {k: as_vector(v) for k, v in zip("abc", values, strict=False)}
    assert run(name, inputs, {}, 1)["value"][0] == pytest.approx(result, rel=1e-6, abs=1e-7)


@pytest.mark.parametrize(
    "value, kinds, result",
    [
        ((0.25, 0.5, 1.0), ("color", "float"), 0.25 * 0.2126729 + 0.5 * 0.7151522 + 0.072175),
        ((0.25, 0.5, 1.5), ("vector", "float"), 0.75),
        ((-1.0, -2.0, -2.5), ("vector", "int"), -1.0),
        ((1.0, -1.0, 0.0), ("vector", "bool"), 1.0),
        ((0.0, 0.0, 0.0), ("vector", "bool"), 0.0),
        ((-1.0, 0.1, 0.0), ("color", "bool"), 0.0),
        (-2.7, ("float", "int"), -2.0),
        (0.2, ("float", "bool"), 1.0),
        (-0.2, ("float", "bool"), 0.0),
        (2.0, ("int", "vector"), (2.0, 2.0, 2.0)),
        (1.0, ("bool", "color"), (1.0, 1.0, 1.0)),
    ],
)
def test_conversions_of_links(value, kinds, result):
    source, target = kinds
    operation = convert.OPERATIONS["convert"]
    found = operation.run(Context(Arena(), 1), {"value": as_vector(value)}, {"from": source, "to": target})["value"]
    assert found.dtype == np.float32
    np.testing.assert_allclose(found.reshape(-1), result, rtol=1e-6)
