# SPDX-License-Identifier: GPL-3.0-or-later
"""The comparison itself: it must be able to fail."""

from __future__ import annotations

import numpy as np
import pytest

from .harness import SIZE, Case, add, compare, coordinates, output, pictures, signed


def ramp(scale):
    return lambda tree, obj: coordinates(tree, (scale, 1.0, 1.0), (-0.5, 0.0, 0.25))


def test_pixels_are_seen_through_their_centres_and_negative_ones_as_they_are():
    centres = (np.arange(SIZE) + 0.5) / SIZE
    for picture in pictures(Case("Mapping: ramp", ramp(2.0))):
        assert picture[..., 0] == pytest.approx(np.broadcast_to(2 * centres - 0.5, (SIZE, SIZE)), abs=1e-5)
        assert picture[..., 1] == pytest.approx(np.broadcast_to(centres[::-1, None], (SIZE, SIZE)), abs=1e-5)


def test_a_small_difference_is_seen():
    ours, _ = pictures(Case("Mapping: ramp", ramp(2.0)))
    _, theirs = pictures(Case("Mapping: steeper ramp", ramp(2.004)))
    largest, share = compare(ours, theirs, 1e-3)
    assert largest == pytest.approx(0.004, rel=0.05)
    assert 0.5 < share < 1


def test_not_a_number_differs_from_any_number():
    ours, theirs = np.zeros((2, 2, 3), np.float32), np.zeros((2, 2, 3), np.float32)
    ours[0, 0, 1] = np.nan
    assert compare(ours, theirs, 1e-3) == (np.inf, 0.25)
    theirs[0, 0, 1] = np.nan
    assert compare(ours, theirs, 1e-3) == (0, 0)


def test_what_zraka_does_not_honour_fails_the_case():
    def build(tree, obj):
        return output(add(tree, "ShaderToRGB"))

    with pytest.raises(AssertionError, match="not supported"):
        pictures(Case("Shader to RGB", build))
    pictures(Case("Shader to RGB", build, known=("not supported",)))


def test_signed_values_come_back():
    ours, theirs = pictures(Case("Mapping: signed", lambda tree, obj: signed(tree, ramp(2.0)(tree, obj))))
    assert compare(ours, theirs, 1e-5)[0] < 1e-5
    assert ours.min() > 0.3
