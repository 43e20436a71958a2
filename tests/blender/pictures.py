# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures that Blender wrote, and how they compare."""

from __future__ import annotations

import numpy as np
import pytest

oiio = pytest.importorskip("OpenImageIO")


def read(path):
    """A picture, (H, W, C), row 0 at the top."""
    picture = oiio.ImageBuf(str(path))
    assert picture.has_error is False, picture.geterror()
    return picture.get_pixels(oiio.FLOAT)


def assert_same(picture, expected):
    """The same noise, pixel by pixel; a path or two may turn another way by a last bit."""
    assert picture.shape == expected.shape
    different = np.abs(picture - expected).max(axis=2) > 1e-4 * (1 + np.abs(expected).max(axis=2))
    assert different.mean() < 0.01
    np.testing.assert_allclose(picture.mean(axis=(0, 1)), expected.mean(axis=(0, 1)), rtol=0.01)


def blurred(picture):
    """The means of blocks of 4 × 4 pixels, (H / 4, W / 4, C)."""
    height, width, channels = picture.shape
    return picture.reshape(height // 4, 4, width // 4, 4, channels).mean(axis=(1, 3))
