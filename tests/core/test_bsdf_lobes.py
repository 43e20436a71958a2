# SPDX-License-Identifier: GPL-3.0-or-later
"""Every lobe against its contract: density, weight, energy, reciprocity, extremes."""

import numpy as np
import pytest

from zraka.core.arena import Arena
from zraka.core.bsdf import (
    conductor,
    dielectric,
    diffuse,
    glass,
    glossy,
    oren_nayar,
    refraction,
    translucent,
    transparent,
)
from zraka.core.bsdf.base import Lobe
from zraka.core.bsdf.energy_tables import directional_albedo
from zraka.core.nodes.closures import CLOSURES
from zraka.tests import stat

ANGLES = (30.0, 80.0, 89.9)
ALPHAS = (0.05, 0.3, 1.0)


def f32(*values):
    return np.float32(values)


def rgb(*values):
    return np.float32(values).reshape(3, 1)


def view(degrees, count=1):
    """Viewing directions (3, count) at an angle to +Z, off the axes."""
    t, p = np.radians(degrees), 0.7
    return np.repeat(np.float32([[np.sin(t) * np.cos(p)], [np.sin(t) * np.sin(p)], [np.cos(t)]]), count, axis=1)


def up(count):
    n = np.zeros((3, count), np.float32)
    n[2] = 1
    return n


def smooth_lobes(alpha):
    """Name -> (lobe, params) of lobes with a density."""
    metal = {"alpha": f32(alpha), "f0": rgb(0.9, 0.6, 0.2), "tint": rgb(0.9, 0.5, 0.3)}
    return {
        "glossy": (glossy.Rough, {"alpha": f32(alpha)}),
        "conductor": (conductor.Rough, metal),
        "dielectric": (dielectric.Rough, {"alpha": f32(alpha), "eta": f32(1.5), "f0": f32(0.04)}),
        "glass outside": (glass.Rough, {"alpha": f32(alpha), "eta": f32(1.5)}),
        "glass inside": (glass.Rough, {"alpha": f32(alpha), "eta": f32(1 / 1.5)}),
        "tinted glass": (glass.Rough, {"alpha": f32(alpha), "eta": f32(1.5), "tint": rgb(0.9, 0.5, 0.1)}),
        "refraction": (refraction.Rough, {"alpha": f32(alpha), "eta": f32(1.5)}),
        "refraction inside": (refraction.Rough, {"alpha": f32(alpha), "eta": f32(1 / 1.5)}),
        "diffuse": (diffuse, {}),
        "translucent": (translucent, {}),
        "oren_nayar": (oren_nayar, {"roughness": f32(0.7), "color": rgb(0.8, 0.5, 0.2)}),
    }


DELTA = {
    "mirror": (glossy.Mirror, {}),
    "metal": (conductor.Mirror, {"f0": rgb(0.9, 0.6, 0.2), "tint": rgb(1, 1, 1)}),
    "varnish": (dielectric.Mirror, {"eta": f32(1.5), "f0": f32(0.04)}),
    "glass": (glass.Smooth, {"eta": f32(1.5)}),
    "glass inside": (glass.Smooth, {"eta": f32(1 / 1.5)}),
    "refraction": (refraction.Smooth, {"eta": f32(1 / 1.5)}),
    "transparent": (transparent, {}),
}


def p_value(lobe, params, degrees, scale=1.0, fine=12, count=60_000):
    wo = view(degrees)

    def sample(u, arena):
        n = u.shape[1]
        s = lobe.sample(params, up(n), np.repeat(wo, n, axis=1), u[0], u[1], u[2], arena)
        return s.wi, s.pdf

    def density(wi, arena):
        n = wi.shape[1]
        return scale * lobe.eval_pdf(params, up(n), np.repeat(wo, n, axis=1), wi, arena)[1]

    return stat.check_sampler(sample, density, count, fine=fine)


CHI_SQUARE = [
    (name, alpha, degrees)
    for name in ("glossy", "glass outside", "glass inside", "refraction")
    for alpha in ALPHAS
    for degrees in ANGLES
    if alpha > 0.1 or degrees < 89  # else too narrow for cells, see below
] + [("tinted glass", 0.3, 30.0), ("diffuse", 1.0, 30.0), ("translucent", 1.0, 30.0)]
CHI_SQUARE += [("refraction inside", 0.3, degrees) for degrees in (30.0, 60.0, 80.0)]


@pytest.mark.parametrize(("name", "alpha", "degrees"), CHI_SQUARE)
def test_samples_follow_the_density(name, alpha, degrees):
    fine = 32 if alpha < 0.1 or degrees > 89 else 12
    lobe, params = smooth_lobes(alpha)[name]
    assert p_value(lobe, params, degrees, fine=fine) > stat.sidak(stat.LEVEL, len(CHI_SQUARE))


@pytest.mark.parametrize("name", ["glossy", "glass outside", "diffuse"])
def test_the_test_finds_a_wrong_density(name):
    lobe, params = smooth_lobes(0.3)[name]
    assert p_value(lobe, params, 30.0, scale=1.05, count=400_000) < 1e-5


@pytest.mark.parametrize(("alpha", "degrees"), [(0.01, 30.0), (0.01, 80.0), (0.05, 89.9)])
@pytest.mark.parametrize("name", ["glossy", "glass outside", "glass inside"])
def test_a_narrow_density_integrates_to_the_kept_samples(name, alpha, degrees):
    """The density of a lobe too narrow for cells, integrated by the sampler of a wider one."""
    arena = Arena()
    lobe, params = smooth_lobes(alpha)[name]
    wide = smooth_lobes(1.5 * alpha)[name][1]
    u = np.random.default_rng(5).random((3, 400_000), np.float32)
    wo = np.repeat(view(degrees), u.shape[1], axis=1)
    s = lobe.sample(wide, up(u.shape[1]), wo, *u, arena)
    pdf = lobe.eval_pdf(params, up(u.shape[1]), wo, s.wi, arena)[1]
    kept = s.pdf > 0
    ratio = np.where(kept, pdf / np.where(kept, s.pdf, 1), 0)
    whole = np.mean(lobe.sample(params, up(u.shape[1]), wo, *u, arena).pdf > 0)
    assert ratio.mean() == pytest.approx(whole, abs=0.02)


@pytest.mark.parametrize("alpha", [1e-4, 0.01, 0.05, 0.3, 1.0])
@pytest.mark.parametrize("degrees", [0.0, *ANGLES])
def test_weight_is_f_over_pdf(alpha, degrees):
    arena = Arena()
    u = np.random.default_rng(6).random((3, 4096), np.float32)
    wo = view(degrees, 4096)
    for name, (lobe, params) in smooth_lobes(alpha).items():
        s = lobe.sample(params, up(4096), wo, *u, arena)
        f, pdf = lobe.eval_pdf(params, up(4096), wo, s.wi, arena)
        kept = (s.pdf > 0) & (pdf > 0)
        f, weight = (np.broadcast_to(a, (3, 4096))[:, kept] for a in (f, s.weight))
        assert np.allclose(f / pdf[kept], weight, rtol=2e-3, atol=1e-6), name
        # A half vector is known to about 1e-7/cos in float32, so the density to about 1e-7/(alpha cos).
        known_to = 2e-6 / (alpha * max(np.cos(np.radians(degrees)), 0.01))
        assert np.allclose(pdf[kept], s.pdf[kept], rtol=max(5e-3, known_to)), name


@pytest.mark.parametrize("alpha", [1e-4, 0.05, 0.3, 1.0])
@pytest.mark.parametrize("degrees", [0.0, *ANGLES])
def test_no_lobe_makes_energy(alpha, degrees):
    arena = Arena()
    for name, (lobe, params) in (smooth_lobes(alpha) | DELTA).items():
        rough = name == "oren_nayar"  # white only in the mean, and noisy at grazing angles
        points, limit = (1 << 17, 1.005) if rough else (1 << 13, 1 + 1e-5)
        e = directional_albedo(lobe, params, float(np.cos(np.radians(degrees))), arena, points)
        assert (e <= limit).all(), name


@pytest.mark.parametrize("name", [*smooth_lobes(0.5), *DELTA])
@pytest.mark.parametrize("degrees", [0.0, 60.0, 89.99, 95.0])
def test_extreme_numbers_stay_finite(name, degrees):
    edge = np.float32([0.0, 2.0**-24, 0.5, 1.0 - 2.0**-24])
    u = np.ascontiguousarray(np.stack([a.ravel() for a in np.meshgrid(edge, edge, edge)]))
    wo, n = view(degrees, u.shape[1]), up(u.shape[1])
    for alpha in (0.0, 1e-4, 0.2, 1.0):
        arena = Arena()
        lobe, params = (smooth_lobes(alpha) | DELTA)[name]
        s = lobe.sample(params, n, wo, *u, arena)
        assert np.isfinite(s.wi).all() and np.isfinite(s.weight).all()
        assert np.abs(np.sqrt((s.wi.astype(float) ** 2).sum(axis=0)) - 1).max() < 1e-5
        assert s.wi.dtype == s.pdf.dtype == np.float32
        assert (s.pdf >= 0).all()
        lost = s.pdf == 0
        assert (np.broadcast_to(s.weight, s.wi.shape)[:, lost] == 0).all()
        if Lobe.DELTA in lobe.flags:
            assert (np.isinf(s.pdf) | lost).all()
        else:
            f, pdf = lobe.eval_pdf(params, n, wo, s.wi, arena)
            assert np.isfinite(f).all() and np.isfinite(pdf).all() and (f >= 0).all() and (pdf >= 0).all()


def test_samples_stay_on_the_side_of_the_lobe():
    arena = Arena()
    u = np.random.default_rng(7).random((3, 8192), np.float32)
    for name, (lobe, params) in (smooth_lobes(1.0) | DELTA).items():
        s = lobe.sample(params, up(8192), view(75.0, 8192), *u, arena)
        kept = s.wi[2][s.pdf > 0]
        if Lobe.TRANSMISSION not in lobe.flags:
            assert (kept > 0).all(), name
        elif Lobe.REFLECTION not in lobe.flags:
            assert (kept < 0).all(), name


@pytest.mark.parametrize("alpha", [0.05, 0.3, 1.0])
def test_reflection_is_reciprocal(alpha):
    arena = Arena()
    rng = np.random.default_rng(8)
    a, b = rng.normal(size=(2, 3, 2000)).astype(np.float32)
    a, b = (v / np.linalg.norm(v, axis=0) for v in (a, b))
    a[2], b[2] = np.abs(a[2]), np.abs(b[2])
    n = up(2000)
    for name, (lobe, params) in smooth_lobes(alpha).items():
        if Lobe.REFLECTION in lobe.flags:
            there = lobe.eval_pdf(params, n, a, b, arena)[0] / b[2]
            back = lobe.eval_pdf(params, n, b, a, arena)[0] / a[2]
            assert np.allclose(there, back, rtol=2e-3, atol=1e-6), name


def test_refraction_is_reciprocal_but_for_the_index():
    """f/(η² cos) is symmetric: radiance is not scaled where it crosses the boundary."""
    arena = Arena()
    rng = np.random.default_rng(9)
    a, b = rng.normal(size=(2, 3, 4000)).astype(np.float32)
    a, b = (v / np.linalg.norm(v, axis=0) for v in (a, b))
    a[2], b[2] = np.abs(a[2]), -np.abs(b[2])
    out, inside = ({"alpha": f32(0.4), "eta": f32(eta)} for eta in (1.5, 1 / 1.5))
    there = glass.Rough.eval_pdf(out, up(4000), a, b, arena)[0] / (-b[2] * 1.5**2)
    back = glass.Rough.eval_pdf(inside, -up(4000), b, a, arena)[0] / a[2]
    assert (there > 1e-3).sum() > 500
    assert np.allclose(there, back, rtol=3e-3, atol=1e-5)


@pytest.mark.parametrize(
    ("roughness", "cosine", "truth"), [(0.25, 1, 0.995703), (0.5, 1, 0.915813), (1, 1, 0.306853), (1, 0.5, 0.450694)]
)
def test_directional_albedo_of_ggx(roughness, cosine, truth):
    e = directional_albedo(glossy.Rough, {"alpha": f32(roughness**2)}, cosine, Arena())
    assert e == pytest.approx(truth, rel=0.005)


@pytest.mark.parametrize("eta", [1.0, 1.0001, 1.5, 2.4, 1 / 1.5])
def test_clear_glass_loses_nothing(eta):
    for cosine in (1.0, 0.5, 0.1):
        e = directional_albedo(glass.Smooth, {"eta": f32(eta)}, cosine, Arena())
        assert e == pytest.approx(1, abs=1e-5)
        e = directional_albedo(glass.Rough, {"eta": f32(eta), "alpha": f32(0)}, cosine, Arena())
        assert e == pytest.approx(1, abs=4e-3)


def test_total_reflection():
    """From within glass beyond the critical angle all is reflected, and pure refraction fails."""
    arena = Arena()
    u = np.random.default_rng(10).random((3, 512), np.float32)
    params, wo, n = {"eta": f32(1 / 1.5)}, view(45.0, 512), up(512)
    assert (glass.Smooth.sample(params, n, wo, *u, arena).wi[2] > 0).all()
    assert not refraction.Smooth.sample(params, n, wo, *u, arena).pdf.any()


def test_refraction_obeys_snell():
    arena = Arena()
    s = refraction.Smooth.sample({"eta": f32(1.5)}, up(1), view(40.0), f32(0.5), f32(0.5), f32(0.5), arena)
    assert np.hypot(s.wi[0], s.wi[1]) * 1.5 == pytest.approx(np.sin(np.radians(40.0)), rel=1e-5)


def test_equal_indices_pass_straight():
    arena = Arena()
    u = np.random.default_rng(11).random((3, 512), np.float32)
    wo = view(40.0, 512)
    s = glass.Rough.sample({"eta": f32(1.0), "alpha": f32(0.3)}, up(512), wo, *u, arena)
    assert np.allclose(s.wi, -wo, atol=1e-5) and np.isinf(s.pdf).all() and (s.weight == 1).all()


def test_rough_diffuse_keeps_white_white():
    for cosine in (1.0, 0.6, 0.2):
        params = {"roughness": f32(0.6), "color": rgb(1, 1, 1)}
        assert directional_albedo(oren_nayar, params, cosine, Arena()) == pytest.approx(1, abs=0.01)


@pytest.mark.parametrize(
    ("roughness", "cosine", "truth"),
    [(0.3, 1.0, (0.7766, 0.4699, 0.1847)), (0.3, 0.5, (0.7859, 0.4818, 0.1908)), (1.0, 0.5, (0.7585, 0.4480, 0.1740))],
)
def test_rough_diffuse_as_cycles(roughness, cosine, truth):
    """Radiance that Cycles (Blender 5.0) sees of a plane of colour (0.8, 0.5, 0.2) in a white world."""
    color = rgb(0.8, 0.5, 0.2)
    e = directional_albedo(oren_nayar, {"roughness": f32(roughness), "color": color}, cosine, Arena())
    assert e * color[:, 0] == pytest.approx(truth, rel=0.005)


@pytest.mark.parametrize(
    ("roughness", "cosine", "truth"),
    [(0.3, 1.0, (0.7364, 0.4603, 0.1841)), (1.0, 1.0, (0.6212, 0.3883, 0.1553)), (1.0, 0.5, (0.6923, 0.4327, 0.1731))],
)
def test_rough_diffuse_as_an_older_cycles(roughness, cosine, truth):
    """The same in Blender 4.2, where light is not scattered again between the facets."""
    inputs = {"color": rgb(0.8, 0.5, 0.2), "roughness": f32(roughness)}
    build, older = CLOSURES["diffuse"].build, {"older": ("facets",)}
    ((lobe, color, params, _),) = build(None, inputs, {"diffuse": oren_nayar}, older)
    assert directional_albedo(lobe, params, cosine, Arena()) * color[:, 0] == pytest.approx(truth, rel=0.005)
