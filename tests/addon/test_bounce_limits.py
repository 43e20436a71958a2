# SPDX-License-Identifier: GPL-3.0-or-later
"""Limits of one kind of bounce, beside Cycles: means of blocks of pixels within 2% of the brightest."""

from __future__ import annotations

import numpy as np
import pytest

from zraka.addon.bench.engines import match, operate

from .bounce_cases import CASES, matte, means, measure, room, set_limits

QUICK = (
    "diffuse bounces: 1",
    "glossy bounces, mirrors: 1",
    "transmission bounces, glass ball: 1",
    "translucent panes: 0",
)


@pytest.mark.parametrize(
    "case",
    [pytest.param(c, id=c.item, marks=[] if c.item.endswith(QUICK) else pytest.mark.slow) for c in CASES],
)
def test_as_cycles_ends_paths(case):
    difference, shown, messages = measure(case)
    assert messages == []
    assert difference < 0.02
    assert shown > 0.01  # what is missing would be seen


def test_one_bounce_more_is_seen():
    scene, found = room(), []
    matte()
    for engine, bounces in (("ZRAKA", 2), ("CYCLES", 1)):
        set_limits(scene, {"diffuse": bounces})
        match(scene)
        found.append(means(operate(scene, engine)[0]))
    assert np.abs(found[0] - found[1]).max() > 0.1 * found[1].max()
