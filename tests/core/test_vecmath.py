# SPDX-License-Identifier: GPL-3.0-or-later
"""Vectors over lanes against numpy's own."""

from __future__ import annotations

import numpy as np

from zraka.core import vecmath


def test_with_sign_is_copysign():
    """Of both zeros and of what is infinite too, by an array and by a number."""
    sign = np.float32([0.0, -0.0, 3.0, -1e-30, np.inf, -np.inf])
    magnitude = np.float32([1.0, 2.0, 0.0, np.inf, 1e-30, 5.0])
    for of in (magnitude, 1.0):
        expected = np.copysign(np.float32(of), sign)
        found = vecmath.with_sign(of, sign.copy())
        np.testing.assert_array_equal(found.view(np.uint32), np.broadcast_to(expected, sign.shape).view(np.uint32))
