# SPDX-License-Identifier: GPL-3.0-or-later
"""A transparent film that is seen through glass: alpha is what Fresnel's formula leaves of it."""

from dataclasses import replace

import numpy as np
import pytest

from zraka.core.compile import compile_scene
from zraka.core.compile.features import Feature
from zraka.core.diagnostics import Diagnostics
from zraka.core.methods import method_of
from zraka.core.methods.clear_glass import ClearGlass
from zraka.core.methods.pathtrace import PathTrace
from zraka.core.render import render
from zraka.core.scene import Material
from zraka.core.settings import Guides, Settings
from zraka.core.visibility import Visibility

from .scenes import film_of, looking_down, placed, quad

MIRRORED = 0.04  # of light that falls straight on glass of the index 1.5
WORLD = 0.5
FILM = {"transparent_film": True, "transparent_glass": True}


def pane(height=0.8, color=(1.0, 1.0, 1.0), roughness=0.0):
    return placed(quad(4, (0, 0, height)), Material.glass(color, roughness))


def pixels(*things, samples=256, depth=8, **settings):
    """Means of red and alpha."""
    image = film_of(looking_down(*things, world=WORLD), 8, samples, depth=depth, **(FILM | settings)).image()
    return image[..., 0].mean(), image[..., 3].mean()


@pytest.mark.parametrize("roughness", [0.0, 0.08, 0.1])
def test_alpha_is_what_the_pane_mirrors(roughness):
    assert pixels(pane(roughness=roughness)) == pytest.approx((MIRRORED * WORLD, MIRRORED), abs=2e-3)


def test_two_panes_and_a_tint():
    """Mirrored to and fro between the panes light is light: only what goes straight down is the film's."""
    through = (1 - MIRRORED) ** 2 * 0.5
    _, alpha = pixels(pane(0.8, (0.5, 0.5, 0.5)), pane(0.5), depth=12)
    assert alpha == pytest.approx(1 - through, abs=4e-3)


def test_as_many_hits_as_there_are_panes_are_enough():
    assert pixels(pane(), depth=1)[1] == pytest.approx(MIRRORED, abs=2e-3)


@pytest.mark.parametrize("settings", [{"transparent_glass": False}, {"transparent_roughness": 0.19}])
def test_other_glass_shows_the_world_as_light(settings):
    assert pixels(pane(roughness=0.2), **settings) == pytest.approx((WORLD, 1.0), abs=5e-3)


def test_what_is_reflected_or_behind_the_glass_is_no_film():
    floor = placed(quad(20), Material.diffuse(0.5))
    assert pixels(pane(), floor)[1] == 1
    mirror = placed(quad(4, (0, 0, 0.5)), Material.single("glossy", roughness=0.0))
    assert pixels(pane(), mirror)[1] == pytest.approx(1, abs=1e-5)


def test_holdouts_are_seen_through_glass():
    floor = placed(quad(20), Material.diffuse(0.5))
    hole = replace(floor, visibility=Visibility(holdout=True))
    assert pixels(pane(), hole)[1] == pytest.approx(MIRRORED, abs=3e-3)


def test_passes_make_up_the_picture():
    guides = Guides(frozenset({"transmission_direct", "glossy_direct", "emission", "environment"}))
    view, own = looking_down(pane(), world=WORLD), {"width": 4, "height": 4, "samples": 64, **FILM}
    plain, passes = (Settings(**own), Settings(**own, guides=guides))
    images = [render(compile_scene(view, s, Diagnostics()), s).image() for s in (plain, passes)]
    assert images[0].tobytes() == images[1].tobytes()


def test_scenes_without_run_the_plain_code():
    compiled = [
        (compile_scene(looking_down(thing), settings, Diagnostics()), settings)
        for thing in (pane(), placed(quad(4), Material.diffuse(0.5)))
        for settings in (Settings(width=4, height=4, transparent_film=True), Settings(width=4, height=4, **FILM))
    ]
    kinds = [type(method_of(*each)) for each in compiled]
    assert kinds[0] is kinds[2] is kinds[3] is PathTrace
    assert issubclass(kinds[1], ClearGlass)


def test_the_superfluous_stage_changes_no_byte():
    settings = Settings(width=8, height=8, samples=16, transparent_film=True)
    view = looking_down(pane(roughness=0.05), placed(quad(1), Material.diffuse(0.5)), world=WORLD)
    plain = compile_scene(view, settings, Diagnostics())
    forced = compile_scene(view, settings, Diagnostics(), plain.needed | Feature.CLEAR_GLASS)
    images = [render(scene, settings).image() for scene in (plain, forced)]
    np.testing.assert_array_equal(*images)
