# SPDX-License-Identifier: GPL-3.0-or-later
"""Camera rays: where they start, where they go, and through which part of the lens."""

from __future__ import annotations

import math

import numpy as np
import pytest

from zraka.core.arena import Arena
from zraka.core.camera import CameraRays
from zraka.core.camera_description import PANORAMAS, Camera, Panorama, ThinLens
from zraka.core.camera_lens import aperture_points
from zraka.core.camera_panorama import DIRECTIONS, PLACES, ROUND

N = 20000
TRANSFORM = np.array([(0, 0, -1, 2), (-1, 0, 0, 3), (0, 1, 0, 4), (0, 0, 0, 1)], float)  # looks along +X, up is +Z


def numbers(count=N, rows=4, seed=0):
    return np.random.default_rng(seed).random((rows, count), np.float32)


def trace(camera, width=8, height=6, u=None):
    """Rays of random places in random pixels: (o, d, tmax), and the places, in pixels from the lower left."""
    u = numbers() if u is None else u
    pixels = np.random.default_rng(1).integers(width * height, size=u.shape[1]).astype(np.int32)
    made = CameraRays(camera, width, height, np.zeros(3))
    rays = made.rays(pixels, u[: len(made.dimensions)], Arena())
    return rays, np.stack((pixels % width + u[0], pixels // width + u[1]))


# -- the lens ----------------------------------------------------------------------------------------------------------


def test_aperture_is_an_even_disk():
    p = aperture_points(ThinLens(2.0), numbers(rows=2), Arena())
    r = np.hypot(*p) / 2
    assert r.max() <= 1 + 1e-6
    np.testing.assert_allclose(np.histogram(r * r, 10, (0, 1))[0], N / 10, rtol=0.1)
    np.testing.assert_allclose(p.mean(axis=1), 0, atol=0.03)


@pytest.mark.parametrize("blades", [3, 4, 5, 8])
def test_aperture_is_an_even_polygon(blades):
    rotation = 0.3
    x, y = aperture_points(ThinLens(1.0, blades=blades, rotation=rotation), numbers(rows=2), Arena())
    inner = math.cos(math.pi / blades)
    sides = [rotation + 2 * math.pi * k / blades for k in range(blades)]
    reach = np.stack([x * math.cos(a) + y * math.sin(a) for a in sides])
    assert reach.max() <= inner + 1e-5
    assert reach.max(axis=1).min() > 0.98 * inner  # and every side is reached
    # The share inside the polygon of half the size is a quarter, if areas are kept.
    assert abs((reach.max(axis=0) <= 0.5 * inner).mean() - 0.25) < 0.01
    # As many points in each sector.
    counts = np.bincount(reach.argmax(axis=0), minlength=blades)
    np.testing.assert_allclose(counts, N / blades, rtol=0.05)


def test_the_middle_of_the_numbers_is_the_middle_of_the_lens():
    for blades in (0, 3, 5, 6):
        p = aperture_points(ThinLens(1.0, blades=blades, rotation=0.2), np.full((2, 1), 0.5, np.float32), Arena())
        np.testing.assert_allclose(p, 0, atol=1e-7)


def test_ratio_makes_the_aperture_narrow():
    wide = aperture_points(ThinLens(1.0), numbers(rows=2), Arena())
    narrow = aperture_points(ThinLens(1.0, ratio=2.0), numbers(rows=2), Arena())
    np.testing.assert_allclose(narrow[0] * 2, wide[0], rtol=1e-6)
    np.testing.assert_array_equal(narrow[1], wide[1])


def test_a_pinhole_draws_no_numbers_for_a_lens():
    assert CameraRays(Camera(), 4, 4, np.zeros(3)).dimensions == (0, 1)
    assert CameraRays(Camera(lens=ThinLens(0.0)), 4, 4, np.zeros(3)).dimensions == (0, 1)
    assert CameraRays(Camera(lens=ThinLens(0.1)), 4, 4, np.zeros(3)).dimensions == (0, 1, 2, 3)


@pytest.mark.parametrize("projection", ["PERSPECTIVE", "ORTHOGRAPHIC"])
def test_all_of_the_lens_sees_the_same_point_in_focus(projection):
    lens = ThinLens(0.25, 3.0, blades=5)
    sharp, _ = trace(Camera(TRANSFORM, (-1, 1, -0.7, 0.8), projection, 0.5, 20.0))
    (o, d, tmax), _ = trace(Camera(TRANSFORM, (-1, 1, -0.7, 0.8), projection, 0.5, 20.0, lens))
    at_focus = [rays[0] + rays[1] * ((5 - rays[0][0]) / rays[1][0]) for rays in (sharp, (o, d))]  # the plane x = 2 + 3
    np.testing.assert_allclose(*at_focus, atol=2e-5)
    np.testing.assert_allclose(np.linalg.norm(d, axis=0), 1, atol=1e-6)
    at_lens = [rays[0] + rays[1] * ((2 - rays[0][0]) / rays[1][0]) for rays in (sharp, (o, d))]
    apart = np.hypot(*(at_lens[0] - at_lens[1])[1:])
    assert 0.24 < apart.max() < 0.2501
    np.testing.assert_allclose(tmax, sharp[2], rtol=1e-6)


def test_the_middle_of_the_lens_is_a_pinhole():
    u = numbers()
    u[2:] = 0.5
    for projection in ("PERSPECTIVE", "ORTHOGRAPHIC"):
        sharp, _ = trace(Camera(TRANSFORM, projection=projection, clip_start=0.1), u=u)
        blurred, _ = trace(Camera(TRANSFORM, projection=projection, clip_start=0.1, lens=ThinLens(0.5, 2.0)), u=u)
        np.testing.assert_allclose(sharp[0], blurred[0], atol=1e-6)
        np.testing.assert_allclose(sharp[1], blurred[1], atol=1e-6)


def test_a_focus_on_the_lens_gives_rays():
    (o, d, _), _ = trace(Camera(TRANSFORM, lens=ThinLens(0.1, 0.0)))
    assert np.isfinite(o).all()
    np.testing.assert_allclose(np.linalg.norm(d, axis=0), 1, atol=1e-5)


# -- panoramas ---------------------------------------------------------------------------------------------------------


def panoramic(kind, **limits):
    return Camera(TRANSFORM, (0, 1, 0, 1), "PANORAMIC", 0.1, 9.0, panorama=Panorama(kind, **limits))


@pytest.mark.parametrize("kind", PANORAMAS)
def test_rays_of_a_panorama(kind):
    (o, d, tmax), _ = trace(panoramic(kind, lens=10.5, polynomial=(0, -0.1, 0, 1e-5, 0)))
    np.testing.assert_allclose(np.linalg.norm(d, axis=0), 1, atol=1e-6)
    np.testing.assert_allclose(o - d * 0.1, TRANSFORM[:3, 3:].repeat(N, 1), atol=1e-6)
    unseen = tmax == 0
    np.testing.assert_allclose(tmax[~unseen], 8.9, rtol=1e-6)
    assert unseen.any() == (kind in ROUND)


@pytest.mark.parametrize("kind", PANORAMAS)
def test_the_middle_of_a_panorama_is_ahead(kind):
    half = np.full(1, 0.5, np.float32)
    *direction, seen = DIRECTIONS[kind](Panorama(kind), half, half)
    np.testing.assert_allclose(np.concatenate(direction), (0, 0, 1), atol=1e-6)
    assert seen is None or seen.all()


@pytest.mark.parametrize("kind", PANORAMAS)
def test_directions_lead_back_to_their_places(kind):
    polynomial = (0, -0.1, 0, 1e-5, 0)
    panorama = Panorama(kind, (-2, 1.5), (-1, 0.5), (-0.5, 2), polynomial=polynomial, sensor=(30, 20))
    u = numbers(rows=2)
    *direction, seen = DIRECTIONS[kind](panorama, *u)
    places = np.stack(PLACES[kind](panorama, *(3 * np.stack(direction))))  # of any length
    good = np.abs(places - u).max(axis=0) < 1e-4
    assert good[slice(None) if seen is None else seen].mean() > (0.999 if kind == "MIRRORBALL" else 0.99999)
    assert np.isfinite(np.stack(PLACES[kind](panorama, *np.zeros((3, 1), np.float32)))).all()


def test_equirectangular_limits():
    x, y = (np.array(v, np.float32) for v in ((0, 1, 0.5), (0.5, 0.5, 1)))
    panorama = Panorama(longitude=(-0.5 * math.pi, 0.5 * math.pi), latitude=(-0.25 * math.pi, 0.25 * math.pi))
    right, up, forward, _ = DIRECTIONS["EQUIRECTANGULAR"](panorama, x, y)
    root = math.sqrt(0.5)
    np.testing.assert_allclose([right, up, forward], [(-1, 1, 0), (0, 0, root), (0, 0, root)], atol=1e-6)


def test_equisolid_keeps_areas():
    """Equal parts of the picture show equal solid angles: 1 - cosθ grows as r²."""
    r = np.linspace(2, 14, 100).astype(np.float32)
    panorama = Panorama("FISHEYE_EQUISOLID", sensor=(36, 36), lens=10.5)
    _, _, forward, seen = DIRECTIONS["FISHEYE_EQUISOLID"](panorama, 0.5 + r / 36, np.full_like(r, 0.5))
    np.testing.assert_allclose((1 - forward) / r**2, 0.5 / 10.5**2, rtol=2e-3)
    assert seen.all()


def test_mirror_ball_is_a_mirror():
    u = numbers(rows=2)
    right, up, forward, seen = DIRECTIONS["MIRRORBALL"](Panorama("MIRRORBALL"), *u)
    d = np.stack((right, up, forward))[:, seen]
    # The normal halves the way from the mirrored direction to the eye, and its sideways part is the place.
    half = d + np.array([[0], [0], [1]])
    half /= np.linalg.norm(half, axis=0)
    np.testing.assert_allclose(half[:2], 2 * u[:, seen] - 1, atol=2e-3)


@pytest.mark.parametrize("kind", PANORAMAS)
def test_a_panoramas_lens_meets_at_the_distance_of_focus(kind):
    limits = {"polynomial": (0, -0.05, 0, 1e-5, 0)}
    camera = panoramic(kind, **limits)
    sharp, _ = trace(camera)
    lens = ThinLens(0.25, 2.0, blades=6)
    blurred, _ = trace(Camera(TRANSFORM, (0, 1, 0, 1), "PANORAMIC", 0.1, 9.0, lens, camera.panorama))
    focus = TRANSFORM[:3, 3:] + 2 * sharp[1]
    way = focus - blurred[0]
    np.testing.assert_allclose(way / np.linalg.norm(way, axis=0), blurred[1], atol=1e-5)


def test_wrong_names_are_refused():
    with pytest.raises(ValueError, match="unknown panorama 'CUBE'"):
        Panorama("CUBE")
    with pytest.raises(ValueError, match="unknown projection 'PANO'"):
        Camera(projection="PANO")
