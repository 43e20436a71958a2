# SPDX-License-Identifier: GPL-3.0-or-later
"""What the methods promise of each other, and of threads, tiles, chunks and features."""

import dataclasses
import itertools
import math
import threading

import numpy as np
import pytest

from zraka.core.compile import compile_scene
from zraka.core.compile.features import Feature
from zraka.core.diagnostics import Diagnostics
from zraka.core.methods import bake, local, pathtrace
from zraka.core.methods.joining import in_parts
from zraka.core.methods.phong_table import phong_table
from zraka.core.methods.wavefront import Chunk, Wavefront
from zraka.core.render import passes, render, step_towards
from zraka.core.scene import AreaLight, Material, PointLight, Spheres
from zraka.core.settings import METHODS, Settings

from .scenes import box, camera, cornell, film_of, looking_down, placed, quad, radiance, scene


def rich():
    """Every feature at once: textures apart."""
    lamp = np.diag([1.0, 1, 1, 1])
    lamp[:3, 3] = (0.5, -0.5, 0.9)
    view = cornell()
    veil = placed(quad(1.0, (0, -0.9, 0), "-y"), Material.principled(alpha=0.5))
    ball = Spheres(np.array([[0.5, -0.4, 0.5]]), np.array([0.2]), Material.glossy((0.9, 0.9, 0.9), 0.2))
    lights = (PointLight((0, 0, 0.5), (5, 5, 5), 0.05), AreaLight(lamp, (5, 5, 5), (0.3, 0.3)))
    return dataclasses.replace(
        view, instances=(*view.instances, veil), spheres=(ball,), lights=lights, world=type(view.world)((0.2, 0.3, 0.4))
    )


def picture(description, **settings):
    return film_of(description, size=64, **({"samples": 6, "depth": 5} | settings)).image()


@pytest.mark.parametrize("method", METHODS)
def test_same_seed_same_bytes_whatever_the_schedule(method):
    base = picture(rich(), method=method, threads=1, tile=256)
    for schedule in ({"threads": 2, "tile": 32}, {"threads": 3, "tile": 17}, {"chunk": 1000}, {"chunk": 1 << 18}):
        np.testing.assert_array_equal(base, picture(rich(), method=method, **schedule))


def test_groups_shaded_in_parts_change_no_bit(monkeypatch):
    base = picture(rich())
    shaded = []

    def cut(groups, most):
        shaded.extend(in_parts(groups, 100))
        return in_parts(groups, 100)

    monkeypatch.setattr(pathtrace, "in_parts", cut)
    np.testing.assert_array_equal(picture(rich()), base)
    sizes = [stop - start for _, start, stop in shaded]
    assert max(sizes) <= 100 < len(sizes)


def test_another_seed_gives_other_noise():
    assert (picture(rich(), seed=1) != picture(rich(), seed=2)).mean() > 0.5


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("description", [cornell, rich])
def test_forcing_all_features_changes_no_bit(method, description):
    settings = Settings(method=method, width=48, height=48, samples=4, depth=4, threads=1)
    own, forced = (
        render(compile_scene(description(), settings, Diagnostics(), f), settings).image()
        for f in (None, Feature.all())
    )
    np.testing.assert_array_equal(own, forced)


def test_a_bare_scene_survives_forced_features():
    settings = Settings(width=8, height=8, samples=1, threads=1)
    empty = scene(camera((0, 0, 1), (0, 0, 0)), placed(quad(), Material.diffuse()))
    assert not render(compile_scene(empty, settings, Diagnostics(), Feature.all()), settings).image()[..., :3].any()


def test_what_is_left_out_is_reported():
    compiled = compile_scene(cornell(), Settings(), Diagnostics())
    report = compiled.feature_report()
    assert {"environment", "lamps", "transparency", "textures"} <= set(report["left_out"])
    assert {"emissive_surfaces", "direct_light", "refraction"} <= set(report["in_use"])


def test_ray_tracing_at_depth_one_is_ray_casting():
    np.testing.assert_array_equal(picture(rich(), method="raycast"), picture(rich(), method="raytrace", depth=1))
    assert (picture(rich(), method="raycast") != picture(rich(), method="raytrace", depth=2)).any()


def test_phong_and_ray_casting_differ_in_shadows_alone():
    light = PointLight((0, 0, 2), (100,) * 3)
    blocker = placed(quad(0.5, (0.5, 0, 1)), Material.diffuse(0.8))
    floor = placed(quad(8), Material.diffuse(0.8))
    view = camera((0, 0, 0.9), (0, 0, 0), fov=1.0)
    phong, cast = (
        film_of(scene(view, floor, blocker, lights=[light]), 1, 64, method=m).image()[..., 0]
        for m in ("phong", "raycast")
    )
    shadow = cast != phong
    assert not cast[shadow].any() and 0.05 < shadow.mean() < 0.5


@pytest.mark.parametrize("reflectivity", [0.0, 0.5, 1.0])
def test_reflectivity_override_scales_the_mirror_ray(reflectivity):
    floor = placed(quad(8), Material.diffuse(0.8))
    view = looking_down(floor, world=1.0)
    value = radiance(view, 1, method="raytrace", depth=2, reflectivity=reflectivity)
    assert value == pytest.approx(0.8 + reflectivity, rel=1e-5)  # the ambient term, and the world in the mirror


def test_classic_methods_take_the_world_as_ambient_light():
    for method in ("phong", "raycast", "raytrace"):
        floor = placed(quad(8), Material.diffuse(0.8))
        assert radiance(looking_down(floor, world=0.5), 1, method=method) == pytest.approx(0.4, rel=1e-5)
        assert radiance(looking_down(floor, world=0.5), 1, method=method, ambient=0.25) == pytest.approx(0.2, rel=1e-5)


@pytest.mark.parametrize("ior", [1.0, 1.5, 2.4])
def test_whitted_glass_plate(ior):
    """To enough depth the Fresnel split adds up to the plate's transmittance."""
    plate = [placed(quad(10), Material.glass(ior=ior)), placed(quad(10, (0, 0, -0.5), "-z"), Material.glass(ior=ior))]
    light = placed(quad(10, (0, 0, -2)), Material.emission())
    r = ((ior - 1) / (ior + 1)) ** 2
    value = radiance(looking_down(*plate, light), 1, method="raytrace", depth=12)
    assert value == pytest.approx((1 - r) / (1 + r), rel=5e-3)


def test_total_reflection_keeps_the_light():
    """From inside glass, beyond the critical angle, the refracted ray's share goes to the mirror ray."""
    view = camera((0, 0, -0.5), (1.0, 0, 0))
    surface, lamp = placed(quad(20), Material.glass(ior=1.5)), placed(quad(20, (0, 0, -1)), Material.emission())
    assert radiance(scene(view, surface, lamp), 1, method="raytrace", depth=2) == pytest.approx(1.0, rel=1e-4)


def test_classic_first_sample_is_in_the_pixels_centre():
    """Half of the pixels see the square's inside: a centre is in or out, nothing between."""
    view = camera((0, 0, 2), (0, 0, 0), fov=0.5)
    value = film_of(scene(view, placed(quad(1), Material.emission())), 1, 33, method="raycast").image()[..., 0]
    assert set(np.unique(value)) == {0.0, 1.0} and value.mean() == pytest.approx((17 / 33) ** 2)


@pytest.mark.parametrize("method", [local.LocalModel, bake._AtPoints])
def test_the_first_of_several_samples_alone_is_in_the_centre(method):
    jitter = np.full((2, 6), 0.25, np.float32)
    method.place_samples(None, jitter, Chunk(np.arange(2, dtype=np.int32), (0, 1, 2)))
    np.testing.assert_array_equal(jitter, [[0.5, 0.25, 0.25] * 2] * 2)


def glossy_boxes(*more):
    """Materials that look the same from everywhere, and `more`."""
    materials = (Material.diffuse((0.8, 0.3, 0.1)), Material.glossy((0.9, 0.5, 0.4), 0.4), Material.diffuse(0.2), *more)
    things = [placed(box(0.5, (k - 1, 0, -0.2 * k)), material) for k, material in enumerate(materials)]
    lamp = PointLight((0.5, -2, 2), (500, 400, 300), 0.0)
    return scene(camera((0, -4, 0.5), (0, 0, 0), fov=0.6), *things, lights=(lamp,), world=0.3)


@pytest.mark.parametrize("method", ["phong", "raycast", "raytrace"])
@pytest.mark.parametrize("override", [{}, {"exponent": 20.0, "reflectivity": 0.3, "transparency": 0.2, "ior": 1.4}])
def test_tabulated_materials_give_the_bits_of_computed_ones(method, override, monkeypatch):
    settings = Settings(method=method, width=48, height=48, samples=2, depth=3, threads=1, **override)
    compiled = compile_scene(glossy_boxes(), settings, Diagnostics())
    assert phong_table(compiled) is not None
    tabulated = render(compiled, settings).image()
    assert tabulated[..., :3].std() > 0.02
    monkeypatch.setattr("zraka.core.methods.phong_table._FEW_PRIMITIVES", 0)
    np.testing.assert_array_equal(tabulated, render(compiled, settings).image())
    monkeypatch.setattr(local, "phong_table", lambda compiled: None)
    np.testing.assert_array_equal(tabulated, render(compiled, settings).image())


@pytest.mark.parametrize("material", [Material.glass(), Material.principled(roughness=0.3)])
def test_materials_that_change_with_the_angle_are_not_tabulated(material):
    assert phong_table(compile_scene(glossy_boxes(material), Settings(), Diagnostics())) is None


def test_materials_whose_parameters_overflow_are_tabulated_without_a_warning():
    """Colours near float32's end, whose exponents are weighed by them."""
    compiled = compile_scene(glossy_boxes(Material.glossy((3e38, 3e38, 3e38), 0.001)), Settings(), Diagnostics())
    phong_table(compiled)


@pytest.mark.parametrize("kind", ["box", "gaussian"])
def test_first_samples_need_no_random_numbers(kind, monkeypatch):
    settings = Settings(method="raycast", width=48, height=48, samples=1, threads=1, pixel_filter=kind)
    compiled = compile_scene(glossy_boxes(), settings, Diagnostics())
    picture = render(compiled, settings).image()
    monkeypatch.setattr(local.LocalModel, "camera_lanes", Wavefront.camera_lanes)
    np.testing.assert_array_equal(picture, render(compiled, settings).image())
    monkeypatch.setattr(local.LocalModel, "place_samples", Wavefront.place_samples)
    assert (picture != render(compiled, settings).image()).any()


def test_clamp_darkens_only_and_keeps_the_hue():
    floor = placed(quad(8), Material.diffuse((0.8, 0.4, 0.2)))
    view = looking_down(floor, lights=[PointLight((0, 0, 1), (1000,) * 3)])
    free, clamped = (film_of(view, 1, 8, clamp_direct=c).image()[0, 0, :3] for c in (0.0, 3.0))
    assert clamped.sum() == pytest.approx(3.0, rel=1e-4)
    np.testing.assert_allclose(clamped / clamped[0], free / free[0], rtol=1e-4)


def test_transparent_film_tells_where_the_world_was():
    view = camera((0, 0, 2), (0, 0, 0), fov=0.5)
    for method in METHODS:
        things = scene(view, placed(quad(1), Material.emission()), world=5.0)
        image = film_of(things, 16, 32, method=method, transparent_film=True).image()
        assert image[..., 3].mean() == pytest.approx(0.25, abs=0.02)
        np.testing.assert_allclose(image[..., 0], image[..., 3], atol=1e-6)


def test_roulette_changes_the_noise_but_not_the_mean(monkeypatch):
    from zraka.core.methods import pathtrace

    room = scene(camera((0, 0, 0), (0, 1, 0), fov=1.0), placed(box(2, inward=True), Material.glowing(0.7, 1.0)))
    means = {}
    for depth in (1, 1000):
        monkeypatch.setattr(pathtrace, "_ROULETTE_DEPTH", depth)
        means[depth] = np.array([radiance(room, 16, seed=s, depth=12) for s in range(8)])
    difference = means[1].mean() - means[1000].mean()
    error = np.sqrt(means[1].var(ddof=1) / 8 + means[1000].var(ddof=1) / 8)
    assert error < 0.02 and abs(difference) < 4 * error + 1e-4


def test_depth_counts_hits():
    """A lamp seen in a mirror takes a second hit's emission: depth 1 traces it, deeper changes nothing."""
    mirror, lamp = placed(quad(4), Material.glossy((1, 1, 1))), placed(quad(9, (0, 0, 3), "-z"), Material.emission())
    assert radiance(looking_down(mirror, lamp), 4, depth=1) == pytest.approx(1.0, rel=1e-5)


# -- the render loop ---------------------------------------------------------------------------------------------------


def test_passes_grow_and_add_up():
    small = 200 * 200
    assert list(passes(1, small)) == list(passes(1, 100)) == [(0, 1)]
    assert [count for _, count in passes(11, small)] == [4, 7]
    assert max(count for _, count in passes(1000, small)) == 64


def test_passes_that_would_be_long_end_early():
    def ends(pixels, samples=70, **options):
        return [first + count for first, count in passes(samples, pixels, **options)]

    assert ends(200 * 200) == [4, 16, 64, 70]
    assert ends(512 * 512) == [1, 4, 16, 32, 48, 64, 70]
    assert ends(512 * 512, long_lanes=1 << 20) == [1, 4, 8, 12, 16, 20, 24, 28, 32, 40, 48, 56, 64, 70]
    assert ends(1920 * 1080, 21) == [1, 4, 8, 12, 16, 20, 21]
    limited = passes(20, 512 * 512, lambda first: 5, long_lanes=1 << 20)
    assert [first + count for first, count in limited] == [1, 4, 8, 12, 16, 20]


def test_a_pass_may_be_longer_than_a_chunk_numbers_samples(monkeypatch):
    """Samples of a chunk are numbered by bytes, so it takes no more than 256."""
    monkeypatch.setattr("zraka.core.render._LONGEST_PASS", 1024)
    many, few = (film_of(cornell(), 1000, 4, chunk=chunk).image() for chunk in (1 << 18, 100))
    np.testing.assert_array_equal(many, few)


def test_small_pictures_begin_with_more_samples():
    assert [next(passes(1000, side * side))[1] for side in (10, 200, 400, 800)] == [16, 4, 1, 1]


def test_the_first_pass_is_long_where_nobody_sees_it(monkeypatch):
    def ends(**options):
        film = film_of(cornell(), 32, 64, **options)
        return [step.samples for step in film.history], film.image().tobytes()

    monkeypatch.setattr("zraka.core.render._FIRST_LANES", 64 * 64)
    (seen, picture), (unseen, same), (judged, _) = ends(), ends(shown=False), ends(shown=False, noise_target=1e-6)
    assert (seen, unseen, judged) == ([1, 4, 16, 32], [16, 32], [1, 4, 16, 32])
    assert same == picture


def test_every_pass_is_shown_and_cancel_keeps_it():
    settings = Settings(width=64, height=64, samples=1 << 20, threads=2)
    seen, cancel = [], threading.Event()

    def on_pass(film, progress):
        seen.append((film.samples, progress))
        if film.samples >= 64:
            cancel.set()

    film = render(compile_scene(cornell(), settings, Diagnostics()), settings, on_pass, cancel.is_set)
    assert seen[0][0] == 16 and film.stats["stopped"] == "cancelled"
    assert np.isfinite(film.image()).all() and film.image()[..., 0].mean() > 0


def test_time_limit_and_noise_target_stop_a_render():
    assert film_of(cornell(), 1 << 20, time_limit=0.2).stats["stopped"] == "time"
    film = film_of(cornell(), 1 << 20, noise_target=0.5)
    assert film.stats["stopped"] == "noise" and film.error() <= 0.5


def test_a_noise_target_is_met_and_not_overrun():
    first = film_of(cornell(), 4).error()
    for share in (0.6, 0.3):
        film = film_of(cornell(), 1 << 20, noise_target=share * first)
        assert film.stats["stopped"] == "noise"
        assert 0.75 < film.error() / (share * first) <= 1


def test_steps_towards_a_goal_stay_balanced():
    assert [step_towards(4, goal) for goal in (1, 5.9, 6, 13, 16)] == [1, 1, 2, 8, 12]
    assert step_towards(64, 100) == 96 - 64 and step_towards(64, math.inf) == (1 << 30) - 64


def test_history_tells_every_pass():
    film = film_of(cornell(), 20, 130)
    assert [step.samples for step in film.history] == [4, 16, 20]
    assert all(a.seconds < b.seconds and a.error > b.error for a, b in itertools.pairwise(film.history))
    assert film.stats["error"] == film.history[-1].error == film.error()


def test_adaptive_sampling_does_not_depend_on_threads_or_tiles():
    one = film_of(cornell(), 64, adaptive=True)
    assert len(np.unique(one.counts())) > 1
    again = film_of(cornell(), 64, adaptive=True, threads=1, tile=13, chunk=3000)
    np.testing.assert_array_equal(one.image(), again.image())


def test_border_renders_the_same_pixels():
    whole = film_of(cornell(), 4, 32).image()
    part = film_of(cornell(), 4, 32, border=(8, 4, 24, 20)).image()
    np.testing.assert_array_equal(part, whole[4:20, 8:24])


def test_a_workers_failure_reaches_the_caller(monkeypatch):
    from zraka.core.methods.pathtrace import PathTrace

    def fail(self, chunk, worker):
        raise RuntimeError("broken")

    monkeypatch.setattr(PathTrace, "trace", fail)
    with pytest.raises(RuntimeError, match="broken"):
        film_of(cornell(), 4)


@pytest.mark.parametrize("bad", [{"method": "magic"}, {"samples": 0}, {"depth": 0}, {"width": 0}])
def test_bad_settings_are_refused(bad):
    with pytest.raises(ValueError, match=next(iter(bad))):
        Settings(**bad)
