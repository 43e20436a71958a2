# SPDX-License-Identifier: GPL-3.0-or-later
"""Worlds over a floor that they light, beside Cycles: means of blocks within 2% of the brightest."""

from __future__ import annotations

import pytest

from .world_cases import CASES, measure


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.item)
def test_as_cycles_shows_it(blender_scene, case):
    difference, messages = measure(blender_scene, case)
    assert messages == []
    assert difference < 0.02
