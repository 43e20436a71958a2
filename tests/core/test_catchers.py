# SPDX-License-Identifier: GPL-3.0-or-later
"""Shadow catchers: how much of the light that they would receive alone is left."""

import math
from dataclasses import replace

import numpy as np
import pytest

from zraka.core.compile import compile_scene
from zraka.core.compile.features import Feature
from zraka.core.diagnostics import Diagnostics
from zraka.core.methods import method_of
from zraka.core.methods.catchers import Catchers
from zraka.core.methods.pathtrace import PathTrace
from zraka.core.render import render
from zraka.core.scene import Material, Panorama, PointLight, SunLight
from zraka.core.settings import Guides, Settings
from zraka.core.shutter import compile_shutter
from zraka.core.visibility import LAMP, SEEN_BY_ALL, Rays, Visibility

from .scenes import camera, cornell, film_of, looking_down, placed, quad, scene, sphere

CATCHER = Visibility(catcher=True)
SUN = SunLight((0, 0, -1), (math.pi,) * 3, visibility=LAMP)
FLOOR = replace(placed(quad(40), Material.diffuse(0.5)), name="floor", visibility=CATCHER)
WORLD = 0.3


def roof(height=2.0, size=1.0, **visibility):
    """A black square that the camera does not see, being below it."""
    black = placed(quad(size, (0, 0, height)), Material.diffuse(0.0))
    return replace(black, name="roof", visibility=Visibility(**visibility))


def image_of(*things, size=4, samples=64, **view):
    settings = {name: view.pop(name) for name in tuple(view) if name in Settings.__dataclass_fields__}
    return film_of(looking_down(*things, **view), size, samples, **({"depth": 3} | settings)).image()


def color_alpha(*things, **view):
    image = image_of(*things, **view)
    return float(image[..., :3].mean()), float(image[..., 3].mean())


# -- what is left of the light -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("exposure", [1.0, 3.0])
def test_a_catcher_alone_is_what_is_behind(exposure):
    assert color_alpha(FLOOR, lights=(SUN,), world=WORLD, transparent_film=True, exposure=exposure) == (0, 0)
    seen = color_alpha(FLOOR, lights=(SUN,), world=WORLD, exposure=exposure)
    assert seen == (pytest.approx(WORLD * exposure, rel=1e-6), 1)


def test_what_a_square_hides_of_the_sky():
    """The form factor of a square s wide at distance h above its middle: (4/π)·X/√(1+X²)·atan(X/√(1+X²)), X = s/2h."""
    x = 0.5
    root = math.sqrt(1 + x * x)
    hidden = 4 / math.pi * x / root * math.atan(x / root)
    _, alpha = color_alpha(FLOOR, roof(2.0, 2.0), world=WORLD, transparent_film=True, samples=512)
    assert alpha == pytest.approx(hidden, abs=0.015)
    color, _ = color_alpha(FLOOR, roof(2.0, 2.0), world=WORLD, samples=512)
    assert color == pytest.approx(WORLD * (1 - hidden), abs=0.015 * WORLD)


def test_the_shade_of_one_of_two_lamps():
    """A point above the roof and a sun aslant give as much light; of one of them nothing is left."""
    slant = SunLight((1, 0, -1), (2 * math.sqrt(2),) * 3, visibility=LAMP)
    point = PointLight((0, 0, 4), (32 * 4 * math.pi,) * 3, visibility=LAMP)  # 32/4² = 2
    assert color_alpha(FLOOR, roof(), lights=(slant, point), transparent_film=True)[1] == pytest.approx(0.5, abs=2e-3)


def test_the_shade_of_a_lamp_that_is_not_behind_is_none():
    own = replace(SUN, visibility=replace(LAMP, catcher=False))
    assert color_alpha(FLOOR, roof(), lights=(own,), world=WORLD, transparent_film=True)[1] < 0.2  # of the sky alone
    assert color_alpha(FLOOR, roof(), lights=(SUN,), world=0.0, transparent_film=True)[1] == 1


def test_catchers_do_not_shade_each_other():
    lid = replace(roof(), visibility=CATCHER)
    assert color_alpha(FLOOR, lid, lights=(SUN,), world=WORLD, transparent_film=True)[1] == 0


def test_emission_is_of_what_is_behind_if_it_is_a_catcher():
    """Over a dark floor in the sun a lamp that is none adds light: nothing is shaded, and it is no darker."""
    lamp = placed(quad(1, (0, 0, 2), "-z"), Material.emission((1, 1, 1), 5.0))
    hidden = Visibility(Rays.DIFFUSE | Rays.GLOSSY)
    for catcher in (False, True):
        glowing = replace(lamp, name="lamp", visibility=replace(hidden, catcher=catcher))
        assert color_alpha(FLOOR, glowing, world=0.1, transparent_film=True)[1] == pytest.approx(0, abs=1e-3)
    thing = replace(lamp, name="lamp", visibility=replace(hidden, catcher=True))
    shade = roof(1.5, 8.0)
    assert color_alpha(FLOOR, thing, shade, transparent_film=True)[1] == pytest.approx(1, abs=1e-3)


# -- who is split, and when --------------------------------------------------------------------------------------------


def test_objects_before_a_catcher_are_opaque_and_keep_their_colour():
    thing = placed(quad(0.5, (0, 0, 0.2)), Material.diffuse(0.5))
    assert color_alpha(FLOOR, thing, lights=(SUN,), transparent_film=True) == (pytest.approx(0.5, rel=1e-3), 1)
    assert color_alpha(FLOOR, thing, lights=(SUN,))[0] == pytest.approx(0.5, rel=1e-3)


@pytest.mark.parametrize("film", [False, True])
def test_half_transparent_objects_before_catchers(film):
    veil = placed(quad(0.5, (0, 0, 0.2)), Material.principled(alpha=0.5, base_color=(0.0,) * 3, specular=0.0))
    seen = color_alpha(FLOOR, veil, roof(), lights=(SUN,), world=WORLD, transparent_film=film, samples=256, depth=1)
    shade = color_alpha(FLOOR, roof(), lights=(SUN,), world=WORLD, transparent_film=True, samples=256, depth=1)[1]
    assert seen[film] == pytest.approx(0.5 + 0.5 * shade if film else 0.5 * WORLD * (1 - shade), abs=0.05)


def test_catchers_in_mirrors_are_ordinary():
    mirror = placed(quad(8, (0, 0, 0.0)), Material.single("glossy", roughness=0.0))
    above = replace(placed(quad(8, (0, 0, 3), "-z"), Material.diffuse(0.8)), name="above", visibility=CATCHER)
    picture = {
        catcher: image_of(
            mirror, replace(above, visibility=CATCHER if catcher else SEEN_BY_ALL), world=WORLD, samples=16
        )
        for catcher in (False, True)
    }
    np.testing.assert_allclose(picture[True], picture[False], rtol=1e-5)


def test_a_catcher_that_is_a_holdout_is_a_hole():
    hole = replace(FLOOR, visibility=Visibility(holdout=True, catcher=True))
    assert color_alpha(hole, roof(), lights=(SUN,), transparent_film=True)[1] == 0
    assert color_alpha(hole, roof(), lights=(SUN,), world=WORLD)[0] == 0


def test_a_catcher_hidden_from_the_camera_is_not_split():
    unseen = replace(FLOOR, visibility=Visibility(~Rays.CAMERA & SEEN_BY_ALL.rays, catcher=True))
    assert color_alpha(unseen, lights=(SUN,), world=WORLD)[0] == pytest.approx(WORLD)


def test_beyond_clear_glass():
    pane = placed(quad(2, (0, 0, 0.5)), Material.glass((1, 1, 1), 0.0))
    film = {"transparent_film": True, "depth": 6}
    assert color_alpha(FLOOR, pane, world=WORLD, **film)[1] == 1
    assert color_alpha(FLOOR, pane, world=WORLD, transparent_glass=True, **film)[1] < 0.3


# -- the machine -------------------------------------------------------------------------------------------------------


def caught():
    """A box with a catcher for a floor."""
    view = cornell()
    floor = replace(view.instances[0], visibility=CATCHER)
    return replace(view, instances=(floor, *view.instances[1:]), lights=(PointLight((0, 0, 0.5), (3.0,) * 3),))


def test_threads_and_chunks_change_no_byte():
    own = {"width": 16, "height": 16, "samples": 16, "depth": 4, "transparent_film": True}
    images = []
    for more in ({"threads": 1}, {"threads": 2, "chunk": 300}):
        settings = Settings(**own, **more)
        images.append(render(compile_scene(caught(), settings, Diagnostics()), settings).image().tobytes())
    assert images[0] == images[1]


@pytest.mark.parametrize("film", [False, True])
def test_passes_change_no_byte_and_leave_catchers_out(film):
    from zraka.core.methods.light_passes import light_pictures

    names = ("diffuse_direct", "diffuse_indirect", "diffuse_color", "emission")
    own = {"width": 16, "height": 16, "samples": 16, "depth": 4, "transparent_film": film}
    plain, passes = Settings(**own), Settings(**own, guides=Guides(frozenset(names)))
    floor = replace(FLOOR, name="caught")
    ball = placed(sphere(0.5, (0, 0, 0.5), 12), Material.diffuse((0.5, 0.3, 0.2)))
    view = scene(camera((0, -4, 2), (0, 0, 0.4), fov=0.5), floor, ball, lights=(SUN,), world=0.2)
    films = [render(compile_scene(view, s, Diagnostics()), s) for s in (plain, passes)]
    assert films[0].image().tobytes() == films[1].image().tobytes()
    found = light_pictures(films[1], passes)
    lit = found["diffuse_color"] * (found["diffuse_direct"] + found["diffuse_indirect"]) + found["emission"]
    only_ball = films[1].image()[..., :3].reshape(-1, 3).T
    inside = found["diffuse_color"].min(axis=0) > 0.19
    assert inside.any()
    np.testing.assert_allclose(lit[:, inside], only_ball[:, inside], atol=1e-4)
    assert (found["diffuse_color"][:, only_ball.max(axis=0) == 0] == 0).all()


def test_moments_without_catchers_have_the_same_channels():
    settings = Settings(width=4, height=4, samples=8, transparent_film=True, threads=1)
    views = [looking_down(FLOOR, lights=(SUN,)), looking_down(replace(FLOOR, visibility=SEEN_BY_ALL), lights=(SUN,))]
    for order in (views, views[::-1]):
        shutter = compile_shutter(order, settings, Diagnostics())
        image = render(shutter, settings).image()
        assert image[..., 3].mean() == pytest.approx(0.5, abs=0.13)


def test_a_round_picture_is_black_beside_it():
    panorama = Panorama("FISHEYE_EQUIDISTANT")
    round_view = replace(looking_down(FLOOR, world=WORLD).camera, projection="PANORAMIC", panorama=panorama)
    for film in (False, True):
        view = replace(looking_down(FLOOR, world=WORLD), camera=round_view)
        image = film_of(view, 16, 4, transparent_film=film).image()
        assert (image[0, 0] == (0, 0, 0, 1)).all()


def test_scenes_without_run_the_plain_code():
    settings = Settings(width=4, height=4)
    plain = compile_scene(looking_down(replace(FLOOR, visibility=SEEN_BY_ALL)), settings, Diagnostics())
    caught = compile_scene(looking_down(FLOOR), settings, Diagnostics())
    assert Feature.CATCHERS not in plain.features and type(method_of(plain, settings)) is PathTrace
    assert isinstance(method_of(caught, settings), Catchers)


def test_the_superfluous_stage_changes_no_byte():
    settings = Settings(width=12, height=12, samples=16, transparent_film=True)
    plain = compile_scene(cornell(), settings, Diagnostics())
    forced = compile_scene(cornell(), settings, Diagnostics(), Feature.all())
    images = [render(compiled, settings).image() for compiled in (plain, forced)]
    np.testing.assert_allclose(*images, rtol=1e-6)


def test_the_classic_methods_say_that_they_do_not_catch():
    diagnostics = Diagnostics()
    compile_scene(looking_down(FLOOR), Settings(width=4, height=4, method="raytrace"), diagnostics)
    assert diagnostics.messages() == ["shadow catchers are rendered as any other object by this method"]
