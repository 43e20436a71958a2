# SPDX-License-Identifier: GPL-3.0-or-later
"""Samples fall where the pixel filter says."""

from __future__ import annotations

import math

import numpy as np
import pytest

from zraka.core.arena import Arena
from zraka.core.camera_description import Camera
from zraka.core.compile import compile_scene
from zraka.core.diagnostics import Diagnostics
from zraka.core.render import render
from zraka.core.sampling.pixel_filter import PixelFilter, filter_profile, pixel_filter
from zraka.core.scene import Instance, Material, Mesh, Scene
from zraka.core.settings import Settings

KINDS = [("gaussian", 1.5), ("gaussian", 3.0), ("blackman_harris", 1.5), ("blackman_harris", 0.01)]


def integral(kind, width, edges):
    """Share of the filter below each of `edges`, pixels from the centre, by quadrature."""
    half, profile = filter_profile(kind, width)
    x = np.linspace(-half, half, 200001)
    cdf = np.concatenate(([0], np.cumsum(profile(x[1:] - (x[1] - x[0]) / 2))))
    return np.interp(edges, x, cdf / cdf[-1])


def placed(kind, width, count=200000):
    """Places, pixels from the centre, of evenly spread numbers."""
    jitter = np.tile(((np.arange(count) + 0.5) / count).astype(np.float32), (2, 1))
    PixelFilter(kind, width).place(jitter, Arena())
    assert np.array_equal(jitter[0], jitter[1])
    return jitter[0] - 0.5


@pytest.mark.parametrize(("kind", "width"), KINDS)
def test_samples_are_spread_as_the_filter(kind, width):
    half, _ = filter_profile(kind, width)
    found = placed(kind, width)
    assert np.abs(found).max() <= half * (1 + 1e-6)
    edges = np.linspace(-half, half, 61)
    share = np.searchsorted(np.sort(found), edges) / found.size
    np.testing.assert_allclose(share, integral(kind, width, edges), atol=2e-4)


def test_another_width_is_told_apart():
    edges = np.linspace(-1, 1, 21)
    share = np.searchsorted(np.sort(placed("gaussian", 1.5)), edges) / 200000
    assert np.abs(share - integral("gaussian", 1.6, edges)).max() > 0.005


def test_widths_are_blenders():
    found = placed("gaussian", 2.0)
    assert math.isclose(found.std(), 0.5, rel_tol=1e-3)  # a standard deviation of a quarter
    assert filter_profile("gaussian", 2.0)[0] == 3.0
    assert filter_profile("blackman_harris", 1.5)[0] == 1.5
    assert filter_profile("box", 7.0)[0] == 0.5


@pytest.mark.parametrize(("kind", "width"), KINDS)
def test_the_middle_stays_in_the_middle(kind, width):
    jitter = np.full((2, 3), 0.5, np.float32)
    PixelFilter(kind, width).place(jitter, Arena())
    assert (jitter == 0.5).all()


def test_largest_number_stays_inside():
    jitter = np.array([[0.0, 1 - 2.0**-24]] * 2, np.float32)
    PixelFilter("blackman_harris", 1.5).place(jitter, Arena())
    assert jitter.min() >= -1
    assert jitter.max() <= 2


def test_box_moves_nothing_and_a_wrong_name_is_refused():
    assert pixel_filter("box", 3.0) is None
    with pytest.raises(ValueError, match="unknown pixel filter 'mitchell'"):
        pixel_filter("mitchell", 1.5)


@pytest.mark.parametrize(("kind", "width"), [("box", 1.0), ("gaussian", 1.5), ("blackman_harris", 1.5)])
@pytest.mark.parametrize("edge", [8.5, 8.2])
def test_edge_of_a_half_plane_is_the_filters_integral(kind, width, edge):
    size = 16
    vertices = np.array([(edge - 100, -50, -1), (edge, -50, -1), (edge, 50, -1), (edge - 100, 50, -1)], np.float32)
    mesh = Mesh(vertices, np.array([(0, 1, 2), (0, 2, 3)], np.int32))
    scene = Scene(
        Camera(window=(0, size, 0, size), projection="ORTHOGRAPHIC"),
        (Instance(mesh, materials=(Material.emission(),)),),
    )
    settings = Settings(width=size, height=size, samples=256, depth=1, threads=1, pixel_filter=kind, filter_width=width)
    film = render(compile_scene(scene, settings, Diagnostics()), settings)
    profile = film.image()[..., 0].mean(axis=0)
    wanted = integral(kind, width, edge - (np.arange(size) + 0.5))
    np.testing.assert_allclose(profile, wanted, atol=4e-3)
