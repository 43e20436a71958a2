# SPDX-License-Identifier: GPL-3.0-or-later
"""Tabulated closures are what the closures compute."""

import numpy as np
import pytest

from zraka.core.arena import Arena
from zraka.core.compile.angular import tabulate
from zraka.core.nodes.base import Context
from zraka.core.nodes.closures import CLOSURES

COUNT = 4000


def context(seed=0):
    """Lanes that see a surface from both sides, at all angles."""
    rng = np.random.default_rng(seed)
    mu = rng.random(COUNT).astype(np.float32)
    n = np.tile(np.float32([[0], [0], [1]]), COUNT)
    wo = np.stack([np.sqrt(1 - mu * mu), np.zeros_like(mu), mu])
    surface = _Surface(n, n, wo, rng.random(COUNT) < 0.5)
    return Context(Arena(), COUNT, surface)


class _Surface:
    def __init__(self, ng, ns, wo, front):
        self.ng, self.ns, self.wo, self.front = ng, ns, wo, front


CASES = {
    "plain": ("principled", {"base_color": ..., "roughness": ...}),
    "coated metal": ("principled", {"metallic": ..., "coat_weight": ..., "roughness": ...}),
    "glass": ("principled", {"transmission_weight": ..., "roughness": ..., "ior": 1.4}),
    "cloth": ("principled", {"sheen_weight": ..., "sheen_roughness": ...}),
    "glossy": ("glossy", {"color": ..., "roughness": ...}),
}


def inputs_of(closure, rng, count, given):
    """Inputs (·, count) of a closure: `given`, random where that is ..., else the defaults."""
    found = {}
    for name, default in closure.inputs.items():
        if default is None:
            continue
        value = given.get(name, default)
        shape = (3, count) if isinstance(default, tuple) else (count,)
        if value is ...:
            found[name] = rng.uniform(0.1, 0.9, shape).astype(np.float32)
        else:
            column = np.float32(value).reshape((-1, 1) if len(shape) == 2 else 1)
            found[name] = np.array(np.broadcast_to(column, shape))
    return found


def both(name, given, color=None):
    """Entries from the tables and from the closure itself, over the same lanes."""
    closure, rng, count = CLOSURES[name], np.random.default_rng(3), 3
    inputs = inputs_of(closure, rng, count, given)
    own = {k: v for k, v in inputs.items() if k != color}
    varying = {n for n in given if given[n] is ...} | ({color} if color else set())
    lobes = closure.lobes({k: v[..., :1] for k, v in inputs.items() if k not in varying}, {})
    tables = tabulate(closure, lobes, {}, own, *([color] if color else []))
    lanes, rows = context(), rng.integers(0, count, COUNT).astype(np.int32)
    over = {k: np.ascontiguousarray(v[..., rows]) for k, v in own.items()}
    if color:
        over[color] = rng.random((3, COUNT)).astype(np.float32)
    return tables and tables.build(lanes, over, rows), closure.build(lanes, over, lobes, {})


@pytest.mark.parametrize("case", CASES)
def test_tables_are_what_the_closure_computes(case):
    tabulated, computed = both(*CASES[case])
    assert len(tabulated) == len(computed) > 0
    for (lobe, weight, params, _), (own_lobe, own_weight, own_params, _) in zip(tabulated, computed, strict=True):
        assert lobe is own_lobe
        np.testing.assert_allclose(
            np.broadcast_to(weight, (3, COUNT)), np.broadcast_to(own_weight, (3, COUNT)), atol=3e-3
        )
        for name, value in own_params.items():
            np.testing.assert_allclose(*np.broadcast_arrays(params[name], value), atol=1e-3)


def test_a_varying_colour_multiplies_what_takes_it():
    tabulated, computed = both("principled", {"roughness": ...}, color="base_color")
    for (_, weight, _, _), (_, own, _, _) in zip(tabulated, computed, strict=True):
        np.testing.assert_allclose(np.broadcast_to(weight, (3, COUNT)), np.broadcast_to(own, (3, COUNT)), atol=3e-3)


def test_a_colour_that_does_more_than_multiply_is_not_tabulated():
    assert both("principled", {"metallic": ..., "roughness": ...}, color="base_color")[0] is None


def test_what_all_materials_share_stays_one_number():
    """Three materials that differ in roughness have one index, which costs nothing over lanes."""
    tabulated, _ = both("principled", {"roughness": ...})
    specular = next(params for _, _, params, _ in tabulated if "eta" in params)
    assert specular["eta"].shape == (1,)
    assert specular["alpha"].shape == (COUNT,)
