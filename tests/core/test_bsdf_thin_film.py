# SPDX-License-Identifier: GPL-3.0-or-later
"""Thin films and metals against Fresnel's and Airy's formulas in complex numbers, wave by wave."""

import numpy as np
import pytest

from zraka.core.arena import Arena
from zraka.core.bsdf import conductor, fresnel, metal, thin_film
from zraka.core.nodes import wavelength


def f32(*values):
    return np.float32(values)


def rgb(*values):
    return np.float32(values).reshape(3, 1)


def amplitudes(n1, n2, cos1):
    """Reflected amplitudes (s, p) from index `n1` to `n2`, and the cosine beyond; complex."""
    cos2 = np.sqrt(1 - (n1 / n2) ** 2 * (1 - cos1**2) + 0j)
    s = (n1 * cos1 - n2 * cos2) / (n1 * cos1 + n2 * cos2)
    p = (n2 * cos1 - n1 * cos2) / (n2 * cos1 + n1 * cos2)
    return s, p, cos2


def airy(cosine, film, substrate, thickness, wave):
    """Reflectance of unpolarised light of wavelengths `wave` (nm) by a film."""
    above = amplitudes(1.0, film, cosine)
    below = amplitudes(film, substrate, above[2])
    turn = np.exp(2j * np.pi * 2 * film * thickness * above[2] / wave)
    return sum(np.abs((a + b * turn) / (1 + a * b * turn)) ** 2 for a, b in zip(above[:2], below[:2], strict=True)) / 2


def colors(of_wave):
    """What the eye makes of reflectances: means over the red, green and blue matching functions, (3,)."""
    waves = np.arange(380.0, 780.0, 0.5)
    nodes = wavelength._FIRST + wavelength._STEP * np.arange(len(wavelength._MATCH))
    match = wavelength._XYZ_TO_RGB @ np.stack([np.interp(waves, nodes, m) for m in wavelength._MATCH.T])
    return (match * of_wave(waves)).sum(axis=1) / match.sum(axis=1)


@pytest.mark.parametrize("eta", [1.5, 2.2])
@pytest.mark.parametrize("thickness", [100.0, 300.0, 700.0])
@pytest.mark.parametrize("cosine", [1.0, 0.5, 0.2])
@pytest.mark.parametrize("fitted", [False, True])
def test_film_on_a_dielectric(eta, thickness, cosine, fitted):
    truth = colors(lambda wave: airy(cosine, 1.33, eta, thickness, wave))
    ours = thin_film.over_dielectric(f32(cosine), f32(eta), f32(1.33), f32(thickness), Arena(), fitted)[:, 0]
    # The series ends after three terms, and its table interpolates linearly; the fit of the eye's response is rough.
    assert ours == pytest.approx(truth, abs=0.03 if fitted else 0.01)


@pytest.mark.parametrize("thickness", [100.0, 300.0])
@pytest.mark.parametrize("cosine", [1.0, 0.5])
def test_film_on_a_metal(thickness, cosine):
    n, k = 2.0, 3.0
    truth = colors(lambda wave: airy(cosine, 1.5, n + 1j * k, thickness, wave))
    index = rgb(n, n, n), rgb(k, k, k)
    ours = thin_film.over_metal(f32(cosine), *index, f32(1.5), f32(thickness), Arena())[:, 0]
    assert ours == pytest.approx(truth, abs=0.015)


def test_the_comparison_can_fail():
    truth = colors(lambda wave: airy(0.5, 1.33, 1.5, 320.0, wave))
    ours = thin_film.over_dielectric(f32(0.5), f32(1.5), f32(1.33), f32(300.0), Arena())[:, 0]
    assert ours != pytest.approx(truth, abs=0.005)


def test_without_a_film_there_is_the_bare_surface():
    cosine = np.linspace(0.01, 1.0, 50, dtype=np.float32)
    exact, _ = fresnel.dielectric(cosine, f32(1.5), Arena())
    for fitted in (False, True):
        ours = thin_film.over_dielectric(cosine, f32(1.5), f32(1.33), f32(0.0), Arena(), fitted)
        assert np.allclose(ours, exact, atol=1e-4)
    params = {"f0": rgb(0.9, 0.5, 0.2), "tint": rgb(0.9, 0.5, 0.3), "film": f32(1.33), "thickness": f32(0.0)}
    assert np.allclose(
        metal.f82_film(params, cosine, Arena()), conductor.reflectance(params, cosine, Arena()), atol=2e-3
    )


def test_metal_of_complex_index():
    cosine = np.linspace(0.01, 1.0, 50, dtype=np.float32)
    n, k = rgb(2.757, 0.2, 1.5), rgb(3.867, 3.9, 0.0)
    ours = metal.physical({"n": n, "k": k}, cosine, Arena())
    for channel in range(3):
        s, p, _ = amplitudes(1.0, complex(n[channel, 0], k[channel, 0]), cosine.astype(float))
        assert np.allclose(ours[channel], (np.abs(s) ** 2 + np.abs(p) ** 2) / 2, atol=1e-5)


def test_average_of_a_metal():
    n, k = rgb(2.757, 2.513, 2.231), rgb(3.867, 3.404, 3.009)
    mu = (np.arange(1000, dtype=np.float32) + 0.5) / 1000
    truth = (2 * mu * metal.physical({"n": n, "k": k}, mu, Arena())).mean(axis=1)
    assert metal.physical_average(n, k)[:, 0] == pytest.approx(truth, abs=0.01)


def test_all_stays_between_nothing_and_all():
    rng = np.random.default_rng(4)
    cosine = rng.random(4000, np.float32)
    cosine[:10] = 0.0
    eta, film = (np.float32(0.3) + 3 * rng.random(4000, np.float32) for _ in range(2))
    thickness = 3000 * rng.random(4000, np.float32) ** 3
    n, k = 4 * rng.random((2, 3, 4000), np.float32)
    for ours in (
        thin_film.over_dielectric(cosine, eta, film, thickness, Arena()),
        thin_film.over_dielectric(cosine, eta, film, thickness, Arena(), fitted=True),
        thin_film.over_metal(cosine, n, k, film, thickness, Arena()),
        thin_film.over_metal(cosine, n, k, film, thickness, Arena(), f82=np.clip(n, 0, 1)),
        thin_film.conductor(cosine, n, k),
    ):
        assert ours.dtype == np.float32 and np.isfinite(ours).all() and (ours >= 0).all() and (ours <= 1).all()


def test_total_reflection():
    below = thin_film.over_dielectric(f32(0.3), f32(1 / 1.5), f32(1.33 / 1.5), f32(300.0), Arena())
    assert (below == 1).all()
