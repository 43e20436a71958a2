# SPDX-License-Identifier: GPL-3.0-or-later
"""Limits over lanes against numpy's own."""

from __future__ import annotations

import numpy as np
import pytest

from zraka.core import limits


@pytest.mark.parametrize("count", [0, 1, 5, limits._FEW - 1, limits._FEW, 3 * limits._FEW + 1])
@pytest.mark.parametrize("rows", [None, 3])
def test_limits_are_numpys(count, rows):
    """Also of what is not finite, and where the arrays of limits must grow."""
    shape = count if rows is None else (rows, count)
    x = np.random.default_rng(1).normal(size=shape).astype(np.float32)
    x[..., ::3], x[..., 1::7], x[..., 2::7] = np.nan, np.inf, -np.inf
    for least, most in ((0.0, 1.0), (-0.5, 1e-7)):
        out = np.empty_like(x)
        np.testing.assert_array_equal(limits.at_least(x, least, out), np.maximum(x, np.float32(least)))
        np.testing.assert_array_equal(limits.at_most(x, most, out), np.minimum(x, np.float32(most)))
        found = limits.within(x, least, most, out)
        assert found is out
        np.testing.assert_array_equal(found, np.clip(x, np.float32(least), np.float32(most)))


def test_limits_are_not_written():
    """A caller who kept a limit's array could change all later pictures."""
    with pytest.raises(ValueError, match="read-only"):
        limits._limit(0.25, 2 * limits._FEW)[0] = 1
