# SPDX-License-Identifier: GPL-3.0-or-later
"""Who sees what, beside Cycles: means of blocks of pixels within 2% of the brightest."""

from __future__ import annotations

import pytest

from . import catcher_cases, visibility_cases
from .visibility_cases import measure

CASES = visibility_cases.CASES + catcher_cases.CASES


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.item)
def test_as_cycles_shows_it(case):
    difference, shown, messages = measure(case)
    assert messages == []
    assert difference < case.tolerance
    assert shown > 1.5 * case.tolerance  # what is changed is seen
