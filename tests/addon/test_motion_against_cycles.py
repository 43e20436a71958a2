# SPDX-License-Identifier: GPL-3.0-or-later
"""What moves while the shutter is open, beside Cycles: camera, objects, their shapes, and what is to stand still."""

from __future__ import annotations

import numpy as np
import pytest

from zraka.addon.bench.engines import operate, watched
from zraka.core.report.error import agreement

from .motion_cases import CASES, lamp, measure, renders, tiles


@pytest.fixture
def scene(blender_scene):
    tiles(blender_scene)
    return blender_scene


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.item)
def test_as_cycles_shows_it(blender_scene, case):
    same, still, mean = measure(blender_scene, case)
    assert same >= 0.97
    assert abs(mean - 1) < 0.02
    assert (still < 0.97) == case.shows


def test_a_lamp_that_moves_is_told_from_one_that_stands_still(scene):
    lamp(scene)
    assert agreement(renders(scene, "ZRAKA"), renders(scene, "CYCLES")) < 0.97


def test_nothing_moves(scene):
    blurred = renders(scene, "ZRAKA")
    scene.render.use_motion_blur = False
    np.testing.assert_array_equal(blurred, renders(scene, "ZRAKA"))


def test_a_rolling_shutter_is_said(scene):
    scene.zraka.samples, scene.cycles.rolling_shutter_type = 2, "TOP"
    with watched() as seen:
        operate(scene, "ZRAKA")
    assert seen.messages == ["a rolling shutter is not supported; all rows are exposed at once"]
