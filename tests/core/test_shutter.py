# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of several moments: how samples are shared, what they show, what is compiled but once."""

from dataclasses import replace

import numpy as np
import pytest

from zraka.core import shutter
from zraka.core.compile import compile_scene
from zraka.core.diagnostics import Diagnostics
from zraka.core.render import render
from zraka.core.sampling.sampler import Sampler, scrambled_sobol
from zraka.core.scene import Camera, Image, Instance, Link, Material, Node, PointLight, Scene, ThinLens, World
from zraka.core.settings import Settings
from zraka.core.shutter import Shutter, between, compile_shutter, slice_count

from .scenes import quad

BAR = quad(sides=(0.2, 4.0))
GLOW = Material.emission()
FLOOR = Instance(quad(20.0, (0, 0, -1)), materials=(Material.diffuse(),))
SETTINGS = Settings(width=32, height=8, samples=64, threads=1)
SLICES = 16


def moved(*place):
    matrix = np.eye(4)
    matrix[:3, 3] = place
    return matrix


def bar_at(x, camera=0.0, **more):
    """A bright bar 0.2 wide, seen from above in a window 2 wide: 32 pixels."""
    view = Camera(moved(camera, 0, 5), (-1.0, 1.0, -0.25, 0.25), "ORTHOGRAPHIC", 0.1, 100.0)
    return Scene(view, (Instance(BAR, moved(x, 0, 0), (GLOW,)),), **more)


def run(way, count=SLICES, start=-0.5, end=0.5):
    """Scenes in the middle of equal slices of a way."""
    return [way(start + (end - start) * (i + 0.5) / count) for i in range(count)]


def film_of(scenes, **changes):
    settings = replace(SETTINGS, **changes)
    return render(compile_shutter(scenes, settings, Diagnostics()), settings)


def trapezoid(x, width=0.2, way=1.0):
    """How long a bar covers the place `x` while its middle runs from -way/2 to way/2."""
    return np.clip(np.minimum(x + width / 2, way / 2) - np.maximum(x - width / 2, -way / 2), 0, None) / way


def expected():
    fine = np.linspace(-1, 1, 32 * 64 + 1)
    fine = 0.5 * (fine[1:] + fine[:-1])
    return trapezoid(fine).reshape(32, 64).mean(axis=1)


# -- how samples are shared --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(8))
def test_samples_in_a_row_fall_into_different_slices(seed):
    sampler = Sampler(seed)
    for count in (2, 8, 16, 64):
        for first in (0, count, 5 * count):
            found = {int(sampler.moment(s) * count) for s in range(first, first + count)}
            assert found == set(range(count))


@pytest.mark.parametrize("seed", range(8))
def test_both_halves_of_a_film_see_every_slice_alike(seed):
    sampler = Sampler(seed)
    for count in (1, 4, 16, 32):
        halves = np.zeros((2, count), int)
        for sample in range(4 * count):
            halves[sample.bit_count() & 1, int(sampler.moment(sample) * count)] += 1
        assert (halves == 2).all()


def test_the_moment_has_nothing_to_do_with_the_place_in_the_pixel():
    """Means of the places of the samples in each slice, for many seeds: as uniform numbers would have them."""
    means = []
    for seed in range(64):
        sampler = Sampler(seed)
        slices = np.array([int(sampler.moment(s) * 4) for s in range(64)])
        x = np.array([scrambled_sobol(0, s, seed)[0] / 2**32 for s in range(64)])
        means.append([x[slices == k].mean() for k in range(4)])
    means = np.array(means)
    np.testing.assert_allclose(means.mean(axis=0), 0.5, atol=0.03)
    assert means.std() < 0.1


def test_slices_are_as_many_as_samples_allow():
    assert [slice_count(n) for n in (1, 2, 3, 4, 16, 31, 32, 100, 4096)] == [1, 1, 1, 2, 8, 8, 16, 16, 16]
    assert slice_count(4096, shutter.MOST_CAMERAS) == shutter.MOST_CAMERAS


# -- what is seen ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("way", [bar_at, lambda x: bar_at(0.0, camera=-x)], ids=["object", "camera"])
@pytest.mark.parametrize("method", ["pathtrace", "raytrace"])
def test_a_bar_leaves_a_trapezoid(way, method):
    rows = film_of(run(way), samples=1024, method=method).image()[..., 0].mean(axis=0)
    # Of 16 slices, a pixel is covered by a multiple of 1/16 of 1/16: steps of a third of its light at most.
    np.testing.assert_allclose(rows, expected(), atol=0.015)
    assert np.abs(np.roll(rows, 1) - expected()).max() > 0.02


def test_adaptive_sampling_does_not_shift_it():
    rows = np.mean([film_of(run(bar_at), samples=256, adaptive=True, seed=s).image()[..., 0] for s in range(4)], axis=0)
    np.testing.assert_allclose(rows.mean(axis=0), expected(), atol=0.015)


@pytest.mark.parametrize("way", [bar_at, lambda x: bar_at(0.0, camera=-x)], ids=["object", "camera"])
@pytest.mark.parametrize("adaptive", [False, True])
def test_the_same_bytes_whatever_the_schedule(way, adaptive):
    base = film_of(run(way), adaptive=adaptive).image()
    for schedule in ({"threads": 3}, {"chunk": 500}, {"tile": 5, "threads": 2}):
        np.testing.assert_array_equal(film_of(run(way), adaptive=adaptive, **schedule).image(), base)


def test_the_error_is_told():
    """The estimate is that of pictures with other seeds about their mean."""
    lamp = PointLight((0, 0, 1), (50.0, 50.0, 50.0), 0.3)

    def way(x):
        return replace(bar_at(x, lights=(lamp,)), instances=(Instance(BAR, moved(x, 0, 0)), FLOOR))

    films = [film_of(run(way), seed=seed) for seed in range(8)]
    pictures = np.stack([film.image()[..., 0] for film in films]).astype(np.float64)
    true = np.sqrt(pictures.var(axis=0, ddof=1).mean()) / pictures.mean()
    told = np.mean([film.error() for film in films])
    assert 0.6 < told / true < 1.7


def test_nothing_moves():
    scene = bar_at(0.0)
    for scenes in ([scene] * SLICES, [bar_at(0.0) for _ in range(SLICES)]):
        compiled = compile_shutter(scenes, SETTINGS, Diagnostics())
        assert not isinstance(compiled, Shutter)
        np.testing.assert_array_equal(
            render(compiled, SETTINGS).image(),
            render(compile_scene(scene, SETTINGS, Diagnostics()), SETTINGS).image(),
        )


def test_little_memory_leaves_fewer_slices(monkeypatch):
    monkeypatch.setattr(shutter, "SLICE_BYTES", 5 * 2 * 320)
    diagnostics = Diagnostics()
    compiled = compile_shutter(run(bar_at), SETTINGS, diagnostics)
    assert len(compiled.moments) == 4
    assert "4 steps" in diagnostics.messages()[0]
    by_camera = compile_shutter(run(lambda x: bar_at(0.0, camera=x)), SETTINGS, diagnostics)
    assert len(by_camera.moments) == 32
    assert len(diagnostics.messages()) == 1


def test_cameras_between_go_on_evenly():
    cameras = [
        replace(bar_at(0, camera=x).camera, window=(-x, x, -1, 1), lens=ThinLens(x, 2 * x))
        for x in (1.0, 3.0, 5.0, 7.0)
    ]
    x = np.array(
        [(c.transform[0, 3], c.window[1], c.lens.radius, c.lens.focus_distance / 2) for c in between(cameras, 8)]
    )
    np.testing.assert_allclose(x, np.repeat(np.arange(0.5, 8)[:, None], 4, axis=1))
    assert [c.transform[0, 3] for c in between(cameras, 4)] == [1, 3, 5, 7]
    assert [c.transform[0, 3] for c in between(cameras[:1], 2)] == [1, 1]


# -- what is compiled but once -----------------------------------------------------------------------------------------

SKY = World.textured(Image("sky", np.linspace(0, 1, 96, dtype=np.float32).reshape(4, 8, 3)))
ROOM = bar_at(0.0, lights=(PointLight((0, 0, 1), (5.0, 5.0, 5.0)),), world=SKY)
ROOM = replace(ROOM, instances=(*ROOM.instances, FLOOR))
CHECKED = Material(
    "checked",
    nodes=(Node("checker", {"scale": 3.0}), Node("emission", {"color": Link(0, "color"), "strength": 1.0})),
    surface=1,
)
LAMP = replace(ROOM, lights=(PointLight((0.5, 0, 1), (5.0, 5.0, 5.0)),))
CHANGED = {
    "camera": replace(ROOM, camera=bar_at(0, camera=0.3).camera),
    "lamp": LAMP,
    "object": replace(ROOM, instances=(Instance(BAR, moved(0.5, 0, 0), (GLOW,)), FLOOR)),
    "material": replace(ROOM, instances=(Instance(BAR, moved(0, 0, 0), (Material.emission((1, 0, 0)),)), FLOOR)),
    "shared": replace(ROOM, instances=(replace(ROOM.instances[0], materials=FLOOR.materials), FLOOR)),
    "coordinates": replace(ROOM, instances=(Instance(BAR, moved(0, 0, 0), (CHECKED,)), FLOOR)),
    "world": replace(ROOM, world=World((1.0, 0.0, 0.0))),
    "fewer": replace(ROOM, instances=ROOM.instances[:1]),
}
SHARED = {
    "camera": {"accel", "lights", "materials"},
    "lamp": {"accel", "materials"},
    "object": {"materials"},
    "material": {"accel"},
    "shared": set(),
    "coordinates": set(),
    "world": {"accel", "materials"},
    "fewer": set(),
}


@pytest.mark.parametrize("name", CHANGED)
def test_tables_serve_again(name):
    before = compile_scene(ROOM, SETTINGS, Diagnostics())
    first = render(before, SETTINGS).image()
    again = compile_scene(CHANGED[name], SETTINGS, Diagnostics(), before=before)
    fresh = compile_scene(CHANGED[name], SETTINGS, Diagnostics())
    assert {
        part for part in ("accel", "lights", "materials") if getattr(again, part) is getattr(before, part)
    } == SHARED[name]
    np.testing.assert_array_equal(render(again, SETTINGS).image(), render(fresh, SETTINGS).image())
    np.testing.assert_array_equal(render(before, SETTINGS).image(), first)  # which is left as it was
    assert (render(again, SETTINGS).image() != first).any()


def test_a_world_that_follows_the_camera_is_compiled_again():
    nodes = (Node("tex_coord"), Node("background", {"color": Link(0, "window"), "strength": 1.0}))
    scenes = run(lambda x: bar_at(0.0, camera=x, world=World(nodes=nodes, surface=1)), 2)
    compiled = compile_shutter(scenes, SETTINGS, Diagnostics())
    assert len(compiled.moments) == 2
    assert compiled.moments[0].seen_by(scenes[1].camera, 32, 8) is None
    assert len({id(moment.lights) for moment in compiled.moments}) == 2
    assert len({id(moment.accel) for moment in compiled.moments}) == 1
