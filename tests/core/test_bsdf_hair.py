# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair lobes: density, weight, energy, absorption, extremes."""

import numpy as np
import pytest

from zraka.core.arena import Arena
from zraka.core.bsdf import hair, principled_hair
from zraka.tests import stat


def f32(*values):
    return np.float32(values)


def along_x(count):
    tangent = np.zeros((3, count), np.float32)
    tangent[0] = 1
    return tangent


def wide(lobe, offset=0.0):
    return lobe, {"offset": f32(offset), "roughness_u": f32(0.3), "roughness_v": f32(0.45)}


def fibre(roughness, radial, h, sigma=(0.2, 0.6, 1.5), coat=0.0, tilt=0.05):
    params = {"h": h, "roughness": roughness, "radial": radial, "coat": coat, "tilt": tilt, "ior": 1.55}
    params = {name: f32(value) for name, value in params.items()}
    return principled_hair, params | {"sigma": np.float32(sigma).reshape(3, 1)}


LOBES = {
    "reflection": wide(hair.Reflection),
    "tilted reflection": wide(hair.Reflection, 0.2),
    "transmission": wide(hair.Transmission, -0.1),
    "rough fibre": fibre(0.9, 0.9, 0.3),
    "fibre": fibre(0.4, 0.5, -0.6, coat=0.3),
    "clear fibre": fibre(0.5, 0.3, 0.8, sigma=(0, 0, 0)),
}
ANGLES = (20.0, 65.0)
LUMINANCE = np.float32([[0.2126], [0.7152], [0.0722]])


def view(degrees, count):
    """Directions across the strand's end, at an angle to +Z, the normal."""
    t = np.radians(degrees)
    return np.repeat(np.float32([[np.sin(t)], [0], [np.cos(t)]]), count, axis=1)


def sampled(name, degrees, count, **changed):
    lobe, params = LOBES[name]
    params = params | {"tangent": along_x(count)} | {key: f32(value) for key, value in changed.items()}
    u = np.random.default_rng(0).random((3, count), np.float32)
    return lobe.sample(params, view(0, count), view(degrees, count), *u, Arena()), params


def p_value(name, degrees, scale=1.0, count=60_000):
    lobe, params = LOBES[name]

    def sample(u, arena):
        count = u.shape[1]
        own = params | {"tangent": along_x(count)}
        s = lobe.sample(own, view(0, count), view(degrees, count), *u, arena)
        return s.wi, s.pdf

    def density(wi, arena):
        count = wi.shape[1]
        own = params | {"tangent": along_x(count)}
        return scale * lobe.eval_pdf(own, view(0, count), view(degrees, count), wi, arena)[1]

    return stat.check_sampler(sample, density, count, fine=16)


@pytest.mark.parametrize("name", LOBES)
@pytest.mark.parametrize("degrees", ANGLES)
def test_samples_follow_the_density(name, degrees):
    assert p_value(name, degrees) > stat.sidak(stat.LEVEL, len(LOBES) * len(ANGLES))


@pytest.mark.parametrize("name", ["reflection", "fibre"])
def test_the_test_finds_a_wrong_density(name):
    assert p_value(name, 20.0, scale=1.05, count=400_000) < 1e-5


@pytest.mark.parametrize("name", LOBES)
def test_weight_is_f_over_pdf(name):
    s, params = sampled(name, 40.0, 8192)
    f, pdf = LOBES[name][0].eval_pdf(params, view(0, 8192), view(40.0, 8192), s.wi, Arena())
    kept = (s.pdf > 1e-3) & (pdf > 1e-3)
    assert kept.mean() > 0.9
    np.testing.assert_allclose(pdf[kept], s.pdf[kept], rtol=6e-2)
    weight = np.broadcast_to(s.weight, f.shape)
    np.testing.assert_allclose((f / np.where(kept, pdf, 1))[..., kept], weight[..., kept], rtol=6e-2)


@pytest.mark.parametrize("degrees", ANGLES)
@pytest.mark.parametrize("h", [0.0, 0.7, 0.99])
def test_a_clear_fibre_loses_nothing(degrees, h):
    """The white furnace: without absorption all light goes on."""
    s, _ = sampled("clear fibre", degrees, 200_000, h=h)
    assert s.weight.mean() == pytest.approx(1.0, abs=2e-3)


def test_absorption_follows_colour_and_melanin():
    """Darker colours and more melanin absorb more; black does so without end, but finitely."""
    sigma = principled_hair.sigma_of_color(np.float32([[0.8], [0.5], [0.2]]), f32(0.3))
    assert (np.diff(sigma[:, 0]) > 0).all()
    dark, light = (principled_hair.sigma_of_melanin(f32(x), f32(0.5)) for x in (0.9, 0.3))
    assert (dark > light).all()
    black = principled_hair.sigma_of_color(np.zeros((3, 1), np.float32), f32(0.3))
    assert np.isfinite(black).all()


@pytest.mark.parametrize("name", LOBES)
@pytest.mark.parametrize("width", [0.0, 1e-3, 0.05, 1.0])
@pytest.mark.parametrize("degrees", [0.0, 89.99, 90.0])
def test_extremes_are_finite(name, width, degrees):
    names = ("roughness", "radial") if name.endswith("fibre") else ("roughness_u", "roughness_v")
    s, params = sampled(name, degrees, 4096, **dict.fromkeys(names, width))
    f, pdf = LOBES[name][0].eval_pdf(params, view(0, 4096), view(degrees, 4096), s.wi, Arena())
    for values in (s.wi, s.weight, s.pdf, f, pdf, LOBES[name][0].albedo(params, None, view(degrees, 4096), Arena())):
        assert np.isfinite(values).all()
    assert np.allclose(np.square(s.wi).sum(axis=0), 1, atol=1e-4)
    energy = s.weight if np.ndim(s.weight) == 1 else (LUMINANCE * s.weight).sum(axis=0)
    assert (s.pdf >= 0).all()
    assert energy.max() < 1.01
