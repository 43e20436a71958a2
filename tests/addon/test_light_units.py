# SPDX-License-Identifier: GPL-3.0-or-later
"""Irradiance by every kind of light: the closed form's and Cycles' within 0.5%."""

from __future__ import annotations

import math
from dataclasses import replace

import bpy
import numpy as np
import pytest

from zraka.addon.bench.engines import match, operate, watched

from .light_cases import CASES, build, measure

BOUND = 0.005
AVAILABLE = [case for case in CASES if bpy.app.version >= case.since]
EACH = [pytest.param(case, marks=[] if k % 5 == 0 else pytest.mark.slow) for k, case in enumerate(AVAILABLE)]


def irradiance(scene, case):
    """What Zraka finds, of each channel."""
    build(scene, case)
    match(scene)
    scene.zraka.samples = 128
    with watched() as seen:
        picture, _ = operate(scene, "ZRAKA")
    assert seen.messages == []
    return math.pi * picture.mean((0, 1), dtype=np.float64)


@pytest.mark.parametrize("case", EACH, ids=lambda case: case.item)
def test_closed_form(blender_scene, case):
    np.testing.assert_allclose(irradiance(blender_scene, case), case.expected(case) * np.ones(3), rtol=BOUND)


@pytest.mark.slow
@pytest.mark.parametrize("case", AVAILABLE, ids=lambda case: case.item)
def test_cycles(blender_scene, case):
    assert max(measure(blender_scene, case)) < BOUND


@pytest.mark.parametrize("setting", [{"energy": 10.1}, {"spot_blend": 0.53}, {"spot_size": math.radians(91)}])
def test_another_light_is_told_apart(blender_scene, setting):
    case = next(c for c in CASES if c.item == "spot, in its blend")
    found = irradiance(blender_scene, replace(case, settings=case.settings | setting))
    assert np.abs(found / case.expected(case) - 1).min() > BOUND
