# SPDX-License-Identifier: GPL-3.0-or-later
"""The order in which pixels are traced, asked for piece by piece."""

import numpy as np
import pytest

from zraka.core.tile_order import TileOrder, ranges


@pytest.mark.parametrize("region", [(0, 0, 70, 53), (5, 9, 70, 53), (0, 7, 70, 8), (3, 0, 4, 1)])
@pytest.mark.parametrize("side", [1, 8, 32, 4096])
def test_every_pixel_comes_once_and_pieces_are_those_of_the_whole(region, side):
    x0, y0, x1, y1 = region
    width, height = x1 - x0, y1 - y0
    order = TileOrder(region, 70, side)
    whole = order[:]
    assert whole.dtype == np.int32
    np.testing.assert_array_equal(np.sort(whole), np.arange(width * height))
    for a, b in ranges(order.size, 7):
        np.testing.assert_array_equal(order[a:b], whole[a:b])
    some = np.random.default_rng(1).permutation(order.size)[:50]
    np.testing.assert_array_equal(order[some], whole[some])
    y, x = np.divmod(whole, width)
    np.testing.assert_array_equal(order.pixels(slice(0, order.size)), (y + y0) * 70 + x + x0)


def test_squares_follow_one_another_from_the_middle():
    order = TileOrder((0, 0, 96, 96), 96, 32)
    y, x = np.divmod(order[:].reshape(9, 32, 32), 96)
    assert (np.ptp(x, axis=(1, 2)) == 31).all() and (np.ptp(y, axis=(1, 2)) == 31).all()
    far = np.abs(x[:, 0, 0] - 32) + np.abs(y[:, 0, 0] - 32)
    assert far[0] == 0 and (np.diff(far) >= 0).all()


def test_squares_are_no_larger_than_pieces_that_are_asked_for():
    y, x = np.divmod(TileOrder((0, 0, 1000, 600), 1000, 4096)[: 250 * 200], 1000)
    assert np.ptp(x) < 256 and np.ptp(y) < 256
