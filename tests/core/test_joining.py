# SPDX-License-Identifier: GPL-3.0-or-later
"""Groups of materials side by side."""

from __future__ import annotations

import numpy as np
import pytest

from zraka.core.arena import Arena
from zraka.core.bsdf.base import BSDFSample
from zraka.core.methods.joining import Joined

NOTHING = (None, None)


def gave(value, count):
    """Direct light and a sample of `count` lanes that hold one number; its weight is constant."""
    lanes = np.full((3, count), value, np.float32)
    return lanes, BSDFSample(lanes, lanes[:, :1], lanes[0])


@pytest.mark.parametrize("groups", [(0, 0, 5, 0), (3, 4), (0, 5), (5, 0, 6), (0, 0)])
def test_groups_that_give_nothing_are_black(groups):
    """Before, between and after others, in memory that was written before."""
    arena = Arena()
    with arena.frame():
        arena.full((20, 256), np.nan)
    joined = Joined(4 * len(groups), arena)
    for number, value in enumerate(groups):
        joined.put(*(gave(value, 4) if value else NOTHING), 4 * number, 4 * number + 4)
    if not any(groups):
        assert joined.direct is None and joined.scattered is None
        return
    expected = np.repeat(np.float32(groups), 4)
    for rows in (joined.direct, joined.scattered.wi, joined.scattered.weight):
        np.testing.assert_array_equal(rows, [expected] * 3)
    np.testing.assert_array_equal(joined.scattered.pdf, expected)
