# SPDX-License-Identifier: GPL-3.0-or-later
"""Light by the way it came, and how free surfaces stand, where the answer is known."""

import dataclasses

import numpy as np
import pytest

from zraka.core.compile import compile_scene
from zraka.core.diagnostics import Diagnostics
from zraka.core.film import Film
from zraka.core.methods import method_of
from zraka.core.methods.light_passes import COLORS, KINDS, LIGHT, OCCLUSION, SEEN, divided, light_pictures
from zraka.core.methods.pathtrace import PathTrace
from zraka.core.methods.visibility import VisibilityPathTrace
from zraka.core.render import render
from zraka.core.scene import Link, Material, Node, PointLight, World
from zraka.core.settings import Guides, Settings
from zraka.core.visibility import Rays, Visibility

from .scenes import box, camera, cornell, disk, looking_down, placed, quad, scene, sphere

ALL = (*LIGHT, *COLORS, *SEEN, OCCLUSION)


def rendered(description, *names, size=24, samples=8, guides=None, **settings):
    """The film, and the light passes `names`."""
    chosen = Guides(names=frozenset(names), **(guides or {}))
    own = {"threads": 1, "depth": 5} | settings
    settings = Settings(width=size, height=size, samples=samples, guides=chosen, **own)
    film = render(compile_scene(description, settings, Diagnostics()), settings)
    return film, light_pictures(film, settings)


def whole(passes):
    """The picture that they make up, (3, H·W)."""
    lit = (passes[f"{k}_color"] * (passes[f"{k}_direct"] + passes[f"{k}_indirect"]) for k in KINDS)
    return sum(lit) + passes["emission"] + passes["environment"]


def veiled():
    """All kinds of lobes behind and beside a half-transparent veil, below a map of the sky."""
    veil = Material.principled(alpha=0.4, base_color=(0.9, 0.5, 0.2), roughness=0.3)
    things = [
        placed(quad(6), Material.diffuse((0.7, 0.5, 0.3))),
        placed(sphere(0.4, (-0.5, 0, 0.4), 12), Material.glass((0.9, 0.8, 1.0), 0.3)),
        placed(sphere(0.4, (0.5, 0, 0.4), 12), Material.principled(transmission=0.5, roughness=0.2, metallic=0.3)),
        placed(sphere(0.3, (0, 0.8, 0.3), 12), Material.single("translucent", color=(0.3, 0.8, 0.3))),
        placed(quad(1.0, (0, -0.7, 0.5), "-y"), veil),
        placed(quad(0.4, (0, 1.0, 1.2), "-y"), Material.glowing((0.5, 0.5, 0.5), (2.0, 1.0, 0.5))),
    ]
    lamp = PointLight((1.0, -1.0, 2.0), (30.0, 30.0, 30.0), 0.2)
    nodes = (Node("tex_coord", {}), Node("background", {"color": Link(0, "generated"), "strength": 0.5}))
    view = scene(camera((0, -3.5, 1.2), (0, 0, 0.5), fov=0.4), *things, lights=(lamp,))
    return dataclasses.replace(view, world=World(nodes=nodes, surface=1))


def hidden():
    """A scene in which not every ray sees everything."""
    view = cornell()
    ball = view.instances[-1]
    only = Visibility(Rays.CAMERA | Rays.DIFFUSE)
    return dataclasses.replace(view, instances=(*view.instances[:-1], dataclasses.replace(ball, visibility=only)))


SCENES = {"cornell": cornell, "veiled": veiled, "hidden": hidden}


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize(
    "settings", [{}, {"clamp_indirect": 0.5, "clamp_direct": 1.0}, {"depth": 1}], ids=["plain", "clamped", "direct"]
)
def test_passes_make_up_the_picture_and_change_no_byte_of_it(name, settings):
    description = SCENES[name]()
    film, passes = rendered(description, *ALL, **settings)
    plain, none = rendered(description, **settings)
    assert none == {} and film.nonfinite == 0
    assert film.image().tobytes() == plain.image().tobytes()
    picture = plain.image()[..., :3].reshape(-1, 3).T
    np.testing.assert_allclose(whole(passes), picture, atol=1e-4 * picture.mean())
    seen = [passes[n].any() for n in LIGHT if "indirect" not in n or settings.get("depth") != 1]
    assert sum(seen) >= 2


@pytest.mark.parametrize("name", SCENES)
def test_passes_are_the_same_however_they_are_traced(name):
    description = SCENES[name]()
    _, one = rendered(description, *ALL, samples=4, size=16)
    for settings in ({"chunk": 300}, {"threads": 2, "chunk": 400, "tile": 5}):
        _, other = rendered(description, *ALL, samples=4, size=16, **settings)
        for key, picture in one.items():
            assert picture.tobytes() == other[key].tobytes(), (key, settings)


def test_nothing_is_composed_where_nothing_is_asked_for():
    for description, method in ((cornell(), PathTrace), (hidden(), VisibilityPathTrace)):
        for names in ((), SEEN, COLORS):
            settings = Settings(guides=Guides(names=frozenset(names)))
            made = method_of(compile_scene(description, settings, Diagnostics()), settings)
            assert type(made) is method and made.extra == 0 and made.channels == 3


def test_rows_are_summed_for_what_is_asked_for_alone():
    film, passes = rendered(cornell(), "glossy_indirect")
    assert set(passes) == {"glossy_indirect"}
    assert len(film._sums) == 3 + 6  # the light and the colour that divides it
    _, every = rendered(cornell(), *ALL)
    assert every["glossy_indirect"].tobytes() == passes["glossy_indirect"].tobytes()


# -- closed forms ------------------------------------------------------------------------------------------------------


def test_a_floor_below_an_even_sky():
    """All that comes is direct, and diffuse light is free of the colour."""
    color = (0.8, 0.4, 0.2)
    for material, kind in ((Material.diffuse(color), "diffuse"), (Material.glossy(color), "glossy")):
        _, passes = rendered(looking_down(placed(quad(4), material), world=0.5), *ALL, samples=16)
        np.testing.assert_allclose(passes.pop(f"{kind}_direct"), 0.5, rtol=1e-5)
        np.testing.assert_allclose(passes.pop(f"{kind}_color").T, [color] * 576, rtol=1e-5)
        np.testing.assert_allclose(passes.pop(OCCLUSION), 1.0)
        assert all(not picture.any() for picture in passes.values())


def test_what_is_seen_directly():
    shining = placed(quad(4), Material.glowing((0.5, 0.5, 0.5), (3.0, 2.0, 1.0)))
    _, passes = rendered(looking_down(shining), *ALL)
    np.testing.assert_allclose(passes["emission"].T, [(3, 2, 1)] * 576, rtol=1e-6)
    for film in (False, True):
        _, passes = rendered(looking_down(world=0.5), *ALL, transparent_film=film)
        np.testing.assert_allclose(passes["environment"], 0.5)
        assert not passes["emission"].any() and not passes["diffuse_direct"].any()


def test_mirrors_and_glass_show_what_is_direct():
    """A pane of colourless glass of equal index sends everything through: transmitted, and met by the first ray."""
    pane = placed(quad(4), Material.glass((0.9, 0.6, 0.3), ior=1.0))
    _, passes = rendered(looking_down(pane, world=0.5), *ALL)
    np.testing.assert_allclose(passes["transmission_direct"], 0.5, rtol=1e-4)
    assert not passes["glossy_direct"].any() and not passes["transmission_indirect"].any()


def test_light_from_a_second_surface_is_indirect():
    """In a closed box of albedo ρ that emits L the k-th bounce brings ρ^(k-1) L."""
    walls = placed(box(2.0, inward=True), Material.glowing((0.5, 0.5, 0.5), (1.0, 1.0, 1.0)))
    view = scene(camera((0, 0, 0), (0, 1, 0.1), fov=0.5), walls)
    _, passes = rendered(view, *ALL, samples=64, depth=3, size=16)
    for name, truth in (("emission", 1.0), ("diffuse_direct", 1.0), ("diffuse_indirect", 0.5 + 0.25)):
        assert passes[name].mean() == pytest.approx(truth, rel=0.01), name


def test_passes_are_blended_through_alpha():
    veil = placed(quad(4, (0, 0, 0.2)), Material.principled(alpha=0.25, base_color=(0, 0, 0), specular=0.0))
    floor = placed(quad(4), Material.glowing((0.8, 0.8, 0.8), (1.0, 1.0, 1.0)))
    _, passes = rendered(looking_down(veil, floor), *ALL, samples=64, guides={"ambient_distance": 0.1})
    assert passes["emission"].mean() == pytest.approx(0.75, rel=0.02)
    assert passes["diffuse_color"].mean() == pytest.approx(0.6, rel=0.02)
    assert passes[OCCLUSION].mean() == pytest.approx(1.0, rel=0.02)


def test_channels_without_colour_are_grey():
    light = np.float32([[2, 2, 0, 1], [3, 0, 0, 1], [4, 4, 0, 1]])
    color = np.float32([[1, 1, 0, 0], [1, 0, 0, 0], [2, 2, 0, 1]])
    np.testing.assert_array_equal(divided(light, color), np.float32([[2, 2, 0, 1], [3, 2, 0, 1], [2, 2, 0, 1]]))


def test_a_colour_next_to_nothing_gives_no_infinite_light():
    found = divided(np.float32([[1e10], [1], [0]]), np.float32([[1e-38], [1], [1]]))
    np.testing.assert_array_equal(found, np.float32([[0], [1], [0]]))


def test_means_stay_exact_over_many_samples():
    """Sums of float32 would drift by more than 1e-5 within 4,096 samples of one value."""
    film, sample = Film(1, 1, extra=3), np.full((6, 256), 0.1, np.float32)
    for first in range(0, 4096, 256):
        film.add(slice(0, 1), sample.copy(), range(first, first + 256))
    np.testing.assert_allclose(film.extra(0, 3), 0.1, rtol=1e-7)
    drifting = np.cumsum(np.full(4096, 0.1, np.float32), dtype=np.float32)[-1] / 4096
    assert abs(drifting / 0.1 - 1) > 1e-5


# -- ambient occlusion -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("distance, expected", [(np.inf, 0.8), (0.5, 1.0)])
def test_occlusion_below_a_disk(distance, expected):
    """A disk of radius r at height h hides r²/(r² + h²) of the hemisphere."""
    floor, roof = placed(quad(20), Material.diffuse()), placed(disk(0.5, (0, 0, 1.0)), Material.diffuse())
    view = scene(camera((0, 0, 0.9), (0, 0, 0), fov=0.005), floor, roof)
    _, passes = rendered(view, OCCLUSION, samples=64, guides={"ambient_distance": distance})
    assert passes[OCCLUSION].mean() == pytest.approx(expected, rel=0.01)
