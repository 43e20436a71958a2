# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader nodes of lamps: what they shed within 0.5% of Cycles."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from zraka.addon.bench.engines import operate, watched

from .lamp_cases import CASES, Case, build, measure, render, told
from .light_cases import BALL

BOUND = 0.005
OFTEN = [case.item for case in CASES[::5]]
EACH = [
    pytest.param(case, marks=[] if case.item in OFTEN else pytest.mark.slow)
    for case in CASES
    if bpy.app.version >= case.since
]


@pytest.mark.parametrize("case", EACH, ids=lambda case: case.item)
def test_cycles(blender_scene, case):
    with watched() as seen:
        assert measure(blender_scene, case) < BOUND
    assert seen.messages == []


@pytest.mark.parametrize("scale", [0.306, 0.3])
def test_another_program_is_told_apart(blender_scene, scale):
    build(blender_scene, Case("", "POINT", told("LightPath", "Ray Length", 0.3), BALL))
    theirs = render(blender_scene, None, "CYCLES")
    bpy.data.lights["Light"].node_tree.nodes["Vector Math"].inputs[1].default_value = (scale,) * 3
    ours = render(blender_scene, None, "ZRAKA")
    assert (np.abs(ours / theirs - 1).max() < BOUND) == (scale == 0.3)


@pytest.mark.parametrize("method", ["PHONG", "RAYCAST", "RAYTRACE"])
def test_classic_methods_follow_nodes(blender_scene, method):
    case = next(c for c in CASES if c.item == "spot, image by UV")
    build(blender_scene, case)
    traced = render(blender_scene, case, "ZRAKA")
    blender_scene.zraka.method = method
    np.testing.assert_allclose(operate(blender_scene, "ZRAKA")[0].mean((0, 1)), traced, rtol=1e-3)
