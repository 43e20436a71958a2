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


@pytest.mark.parametrize("pieces", [2, 3, 4])
@pytest.mark.parametrize("size", [(320, 180), (512, 512), (1920, 1080)])
def test_squares_follow_one_another_and_every_piece_holds_some_of_everywhere(size, pieces):
    width, height = size
    order = TileOrder((0, 0, width, height), width, 32)
    heights, widths = order._shapes
    whole = order[:]
    for first, last, tall, wide in zip(order._ends, order._ends[1:], heights, widths, strict=False):
        y, x = np.divmod(whole[first:last], width)
        assert (np.ptp(y), np.ptp(x)) == (tall - 1, wide - 1)
    near = np.hypot(*(whole // width - height / 2, whole % width - width / 2)) < 0.3 * height
    up, right = whole // width < height / 2, whole % width < width / 2
    for part in (near, up, right):
        shares = [part[a:b].mean() / part.mean() for a, b in ranges(whole.size, pieces)]
        assert max(shares) < 1.35 and min(shares) > 0.65


def test_squares_are_no_larger_than_pieces_that_are_asked_for():
    y, x = np.divmod(TileOrder((0, 0, 1000, 600), 1000, 4096)[: 250 * 200], 1000)
    assert np.ptp(x) < 256 and np.ptp(y) < 256
