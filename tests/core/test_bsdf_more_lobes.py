# SPDX-License-Identifier: GPL-3.0-or-later
"""Cloth, toon, stretched and Beckmann facets, Ashikhmin-Shirley: density, weight, energy, reciprocity, extremes."""

import numpy as np
import pytest
from scipy.special import erf

from zraka.core.arena import Arena
from zraka.core.bsdf import (
    ashikhmin_shirley,
    conductor,
    facet_glass,
    facets,
    glass,
    glass_film,
    metal,
    refraction,
    sheen,
    toon,
    velvet,
)
from zraka.core.bsdf.base import Lobe
from zraka.tests import stat

ANGLES = (30.0, 80.0, 89.9)
GGX, BECKMANN = facets.reflection(facets.GGX), facets.reflection(facets.Beckmann)
BECKMANN_GLASS = facet_glass.rough(facets.Beckmann)


def f32(*values):
    return np.float32(values)


def rgb(*values):
    return np.float32(values).reshape(3, 1)


def view(degrees, count):
    """Viewing directions (3, count) at an angle to +Z, off the axes."""
    t, p = np.radians(degrees), 0.7
    return np.repeat(np.float32([[np.sin(t) * np.cos(p)], [np.sin(t) * np.sin(p)], [np.cos(t)]]), count, axis=1)


def up(count):
    n = np.zeros((3, count), np.float32)
    n[2] = 1
    return n


def fixed(**params):
    """Parameters that do not depend on the view."""
    return lambda wo, arena: params


def fibres(roughness):
    def params(wo, arena):
        a, b, _ = sheen.transform(np.maximum(wo[2], 0), f32(roughness), arena)
        return {"a": a, "b": b}

    return params


def stretched(alpha, **more):
    return fixed(alpha=f32(alpha), stretch=f32(2.5), tangent=rgb(1.0, 0.2, 0.1), **more)


METAL = {"f0": rgb(0.9, 0.6, 0.2), "tint": rgb(0.9, 0.5, 0.3)}
FILM = {"film": f32(1.4), "thickness": f32(350.0)}
LOBES = {
    "sheen 0.3": (sheen, fibres(0.3)),
    "sheen 1": (sheen, fibres(1.0)),
    "velvet 0.2": (velvet, fixed(sigma=f32(0.2))),
    "velvet 1": (velvet, fixed(sigma=f32(1.0))),
    "diffuse toon": (toon.Diffuse, fixed(size=f32(0.3), smooth=f32(0.5))),
    "glossy toon": (toon.Glossy, fixed(size=f32(0.9), smooth=f32(0.5))),
    "stretched GGX": (GGX, stretched(0.3)),
    "Beckmann 0.1": (BECKMANN, fixed(alpha=f32(0.1))),
    "Beckmann 0.5": (BECKMANN, fixed(alpha=f32(0.5))),
    "stretched Beckmann": (BECKMANN, stretched(0.3)),
    "stretched metal": (facets.reflection(facets.GGX, conductor.reflectance), stretched(0.4, **METAL)),
    "filmed metal": (metal.lobes(metal.f82_film)[0], fixed(alpha=f32(0.4), **METAL, **FILM)),
    "Ashikhmin-Shirley 0.3": (ashikhmin_shirley, fixed(alpha=f32(0.3))),
    "stretched Ashikhmin-Shirley": (ashikhmin_shirley, stretched(0.4)),
    "Beckmann glass": (BECKMANN_GLASS, fixed(alpha=f32(0.3), eta=f32(1.5))),
    "Beckmann glass inside": (BECKMANN_GLASS, fixed(alpha=f32(0.3), eta=f32(1 / 1.5))),
    "Beckmann refraction": (facet_glass.rough(facets.Beckmann, refraction), fixed(alpha=f32(0.3), eta=f32(1.5))),
    "Beckmann refraction inside": (
        facet_glass.rough(facets.Beckmann, refraction),
        fixed(alpha=f32(0.3), eta=f32(1 / 1.5)),
    ),
    "filmed glass": (glass_film.Rough, fixed(alpha=f32(0.3), eta=f32(1.5), **FILM)),
    "filmed glass inside": (glass_film.Rough, fixed(alpha=f32(0.3), eta=f32(1 / 1.5), **FILM)),
}
RECIPROCAL = ("velvet", "stretched", "Beckmann 0", "filmed metal", "Ashikhmin")
CHI_SQUARE = [(name, degrees) for name in LOBES for degrees in ANGLES]


def sampled(name, degrees, count, seed=0):
    """(LobeSample, wo, params) of random numbers."""
    lobe, params_of = LOBES[name]
    u = np.random.default_rng(seed).random((3, count), np.float32)
    wo, arena = view(degrees, count), Arena()
    params = params_of(wo, arena)
    return lobe.sample(params, up(count), wo, *u, arena), wo, params


def p_value(name, degrees, scale=1.0, fine=16, count=60_000):
    lobe, params_of = LOBES[name]

    def sample(u, arena):
        wo = view(degrees, u.shape[1])
        s = lobe.sample(params_of(wo, arena), up(u.shape[1]), wo, *u, arena)
        return s.wi, s.pdf

    def density(wi, arena):
        wo = view(degrees, wi.shape[1])
        return scale * lobe.eval_pdf(params_of(wo, arena), up(wi.shape[1]), wo, wi, arena)[1]

    return stat.check_sampler(sample, density, count, fine=fine)


@pytest.mark.parametrize(("name", "degrees"), CHI_SQUARE)
def test_samples_follow_the_density(name, degrees):
    fine = 32 if degrees > 89 or "0.1" in name else 16
    assert p_value(name, degrees, fine=fine) > stat.sidak(stat.LEVEL, len(CHI_SQUARE))


@pytest.mark.parametrize("name", LOBES)
def test_the_test_finds_a_wrong_density(name):
    assert p_value(name, 30.0, scale=1.05, count=400_000) < 1e-5


@pytest.mark.parametrize("name", LOBES)
@pytest.mark.parametrize("degrees", [0.0, *ANGLES])
def test_weight_is_f_over_pdf(name, degrees):
    count, arena = 8192, Arena()
    s, wo, params = sampled(name, degrees, count)
    f, pdf = LOBES[name][0].eval_pdf(params, up(count), wo, s.wi, arena)
    kept = (s.pdf > 0) & (pdf > 0)
    assert kept.any() or "refraction inside" in name
    f, weight = (np.broadcast_to(a, (3, count))[:, kept] for a in (f, s.weight))
    assert np.allclose(f / pdf[kept], weight, rtol=5e-3, atol=1e-4)
    wrong = np.abs(pdf[kept] - s.pdf[kept]) > 1e-2 * s.pdf[kept]
    assert wrong.sum() <= 1e-3 * kept.sum()  # samples at a cone's or the horizon's very edge


@pytest.mark.parametrize("name", LOBES)
@pytest.mark.parametrize("degrees", [0.0, *ANGLES])
def test_no_lobe_makes_energy(name, degrees):
    s, _, _ = sampled(name, degrees, 1 << 15)
    weight = np.broadcast_to(s.weight, s.wi.shape).astype(np.float64)
    error = weight.std(axis=1) / np.sqrt(weight.shape[1])
    assert (weight.mean(axis=1) <= 1 + 1e-5 + 4 * error).all()


def test_the_energy_test_can_fail():
    s, _, _ = sampled("velvet 1", 89.9, 1 << 15)
    weight = 1.1 * s.weight.astype(np.float64)
    assert weight.mean() > 1 + 4 * weight.std() / np.sqrt(weight.size)


@pytest.mark.parametrize("name", [name for name in LOBES if name.startswith(RECIPROCAL)])
def test_reflection_is_reciprocal(name):
    arena = Arena()
    rng = np.random.default_rng(8)
    a, b = rng.normal(size=(2, 3, 2000)).astype(np.float32)
    a, b = (v / np.linalg.norm(v, axis=0) for v in (a, b))
    a[2], b[2] = np.abs(a[2]), np.abs(b[2])
    n, (lobe, params_of) = up(2000), LOBES[name]
    params = params_of(a, arena)
    there = lobe.eval_pdf(params, n, a, b, arena)[0] / b[2]
    back = lobe.eval_pdf(params, n, b, a, arena)[0] / a[2]
    assert np.allclose(there, back, rtol=5e-3, atol=1e-4)


def test_sheen_is_not_reciprocal():
    """So the test of reciprocity can fail."""
    arena, n = Arena(), up(1)
    a, b = view(30.0, 1), view(70.0, 1)
    there, back = (sheen.eval_pdf(fibres(0.3)(o, arena), n, o, i, arena)[0] / i[2] for o, i in ((a, b), (b, a)))
    assert not np.allclose(there, back, rtol=0.05)


@pytest.mark.parametrize("name", LOBES)
@pytest.mark.parametrize("degrees", [0.0, 60.0, 89.99, 95.0])
def test_extreme_numbers_stay_finite(name, degrees):
    edge = np.float32([0.0, 2.0**-24, 0.5, 1.0 - 2.0**-24])
    u = np.ascontiguousarray(np.stack([a.ravel() for a in np.meshgrid(edge, edge, edge)]))
    wo, n = view(degrees, u.shape[1]), up(u.shape[1])
    lobe, params_of = LOBES[name]
    for alpha in (0.0, 1e-4, 0.2, 1.0):
        arena = Arena()
        params = params_of(wo, arena)
        params = params | {key: f32(alpha) for key in ("alpha", "sigma", "size", "smooth") if key in params}
        s = lobe.sample(params, n, wo, *u, arena)
        assert np.isfinite(s.wi).all() and np.isfinite(s.weight).all()
        assert np.abs(np.sqrt((s.wi.astype(float) ** 2).sum(axis=0)) - 1).max() < 1e-5
        assert s.wi.dtype == s.pdf.dtype == np.asarray(s.weight).dtype == np.float32
        assert (s.pdf >= 0).all()
        lost = s.pdf == 0
        assert (np.broadcast_to(s.weight, s.wi.shape)[:, lost] == 0).all()
        f, pdf = lobe.eval_pdf(params, n, wo, s.wi, arena)
        assert np.isfinite(f).all() and np.isfinite(pdf).all() and (f >= 0).all() and (pdf >= 0).all()
        assert f.dtype == pdf.dtype == np.float32


def test_samples_stay_on_the_side_of_the_lobe():
    for name, (lobe, _) in LOBES.items():
        s, _, _ = sampled(name, 75.0, 8192)
        kept = s.wi[2][s.pdf > 0]
        if Lobe.TRANSMISSION not in lobe.flags:
            assert (kept > 0).all(), name
        elif Lobe.REFLECTION not in lobe.flags:
            assert (kept < 0).all(), name


def test_facets_without_stretch_are_those_of_the_plain_lobes():
    """GGX glass and reflection through the general code, against the fast one."""
    arena, count = Arena(), 4096
    rng = np.random.default_rng(3)
    wi = rng.normal(size=(3, count)).astype(np.float32)
    wi /= np.linalg.norm(wi, axis=0)
    wo, n = view(50.0, count), up(count)
    params = {"alpha": f32(0.3), "eta": f32(1.5)}
    for ours, theirs in zip(
        facet_glass.rough(facets.GGX).eval_pdf(params, n, wo, wi, arena),
        glass.Rough.eval_pdf(params, n, wo, wi, arena),
        strict=True,
    ):
        assert np.allclose(ours, theirs, rtol=2e-3, atol=1e-5)


def test_a_stretched_lobe_is_wider_along_its_tangent():
    lobe = GGX
    arena, n, wo = Arena(), up(1), view(0.0, 1)
    params = {"alpha": f32(0.2), "stretch": f32(2.0), "tangent": rgb(1, 0, 0)}
    t = np.float32(0.5)
    along, across = (
        lobe.eval_pdf(params, n, wo, np.float32(d).reshape(3, 1), arena)[0][0]
        for d in ((np.sin(t), 0, np.cos(t)), (0, np.sin(t), np.cos(t)))
    )
    assert along > 3 * across


def test_albedo_of_beckmann_facets():
    """Mean weight at normal incidence, by quadrature over half vectors: ∫ D cosθ G1(2θ) dω."""
    s, _, _ = sampled("Beckmann 0.5", 0.0, 1 << 16)
    steps = 200_000
    theta = (np.arange(steps) + 0.5) / steps * np.pi / 4  # beyond, light would leave below the horizon
    density = np.exp(-((np.tan(theta) / 0.5) ** 2)) / (np.pi * 0.25 * np.cos(theta) ** 4)
    a = 1 / (0.5 * np.tan(np.minimum(2 * theta, 1.57)))
    unshadowed = 1 / (1 + (erf(a) - 1) / 2 + np.exp(-a * a) / (2 * a * np.sqrt(np.pi)))
    truth = (density * np.cos(theta) * unshadowed * np.sin(theta)).sum() * 2 * np.pi * (np.pi / 4 / steps)
    assert s.weight.mean() == pytest.approx(truth, rel=3e-3)
