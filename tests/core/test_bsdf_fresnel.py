# SPDX-License-Identifier: GPL-3.0-or-later
"""Fresnel's equations at known points, and averages against quadrature."""

import numpy as np
import pytest

from zraka.core.arena import Arena
from zraka.core.bsdf import fresnel


def dielectric(cosine, eta):
    return fresnel.dielectric(np.float32([cosine]), np.float32([eta]), Arena())[0][0]


def average(curve):
    """∫ 2 c F(c) dc by Gauss-Legendre."""
    x, w = np.polynomial.legendre.leggauss(200)
    c = (x + 1) / 2
    return (w * c * curve(c.astype(np.float32))).sum(axis=-1)


@pytest.mark.parametrize(
    ("cosine", "eta", "truth"),
    [
        (1.0, 1.5, 0.04),
        (1.0, 1 / 1.5, 0.04),
        (1.0, 2.4, (1.4 / 3.4) ** 2),
        (0.0, 1.5, 1.0),
        (0.3, 1.0, 0.0),
        (np.cos(np.radians(45)), 1.5, 0.0502399),
        (np.cos(np.radians(50)), 1 / 1.5, 1.0),
        (0.0, 1 / 1.5, 1.0),
    ],
)
def test_reflectance_of_dielectrics(cosine, eta, truth):
    assert dielectric(cosine, eta) == pytest.approx(truth, abs=2e-6)


def test_brewster():
    """At Brewster's angle the parallel part vanishes: half of the perpendicular one is left."""
    cosine = 1 / np.sqrt(1 + 1.5**2)
    assert dielectric(cosine, 1.5) == pytest.approx(0.5 * ((1 - 1.5**2) / (1 + 1.5**2)) ** 2, rel=1e-5)


def test_refracted_cosine_obeys_snell():
    c = np.linspace(0.01, 1, 50, dtype=np.float32)
    _, cos_t = fresnel.dielectric(c, np.float32([1.5]), Arena())
    assert np.allclose((1 - c**2) / 1.5**2, 1 - cos_t.astype(float) ** 2, atol=1e-6)


def test_almost_equal_indices_keep_their_digits():
    """((η - 1)/(η + 1))² is exact for η close to 1, where it is tiny."""
    eta = np.float32(1.0001)
    assert dielectric(1.0, eta) == pytest.approx(((float(eta) - 1) / (float(eta) + 1)) ** 2, rel=1e-3)


def test_schlick_and_f82_tint_at_their_marks():
    arena = Arena()
    cosine, f0, tint = np.float32([1.0, 1 / 7, 0.0]), np.float32([[0.9], [0.5], [0.1]]), np.float32([[1], [0.5], [0]])
    schlick = fresnel.schlick(cosine, f0, arena)
    assert np.allclose(schlick[:, 0], f0[:, 0]) and np.allclose(schlick[:, 2], 1)
    metal = fresnel.f82_tint(cosine, f0, fresnel.f82_drop(f0, tint), arena)
    assert np.allclose(metal[:, 0], f0[:, 0], atol=1e-6) and np.allclose(metal[:, 2], 1)
    assert np.allclose(metal[:, 1], schlick[:, 1] * tint[:, 0], atol=2e-6)


def test_white_tint_is_schlick():
    arena = Arena()
    cosine, f0 = np.linspace(0, 1, 9, dtype=np.float32), np.float32([[0.9], [0.5], [0.1]])
    drop = fresnel.f82_drop(f0, np.float32([[1], [1], [1]]))
    assert np.array_equal(fresnel.f82_tint(cosine, f0, drop, arena), fresnel.schlick(cosine, f0, arena))


@pytest.mark.parametrize("eta", [1.2, 1.5, 2.0, 0.8, 0.5])
def test_average_of_dielectrics(eta):
    curve = average(lambda c: fresnel.dielectric(c, np.float32([eta]), Arena())[0])
    assert fresnel.dielectric_average(np.float32([eta]))[0] == pytest.approx(curve, abs=0.008)


def test_average_of_metals():
    f0, tint = np.float32([[0.8], [0.5], [0.2]]), np.float32([[1.0], [0.9], [0.8]])
    drop = fresnel.f82_drop(f0, tint)
    curve = average(lambda c: fresnel.f82_tint(c, f0, drop, Arena()))
    assert np.allclose(fresnel.f82_average(f0, drop)[:, 0], curve, atol=1e-5)


def test_index_from_reflectance():
    assert np.allclose(fresnel.ior_from_f0(fresnel.f0_from_ior(np.float32([1.2, 1.5, 2.4]))), [1.2, 1.5, 2.4])


def test_tinted_f0_follows_the_exact_curve():
    """Untinted, the carried-over curve is the exact one."""
    arena, eta = Arena(), np.float32([1.5])
    exact, _ = fresnel.dielectric(np.linspace(0, 1, 20, dtype=np.float32), eta, arena)
    s = fresnel.interpolation(exact, eta, arena)
    assert np.allclose(fresnel.mix_to_white(np.float32([0.04]), s, arena), exact, atol=1e-6)
