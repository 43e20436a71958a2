# SPDX-License-Identifier: GPL-3.0-or-later
"""Limits of diffuse, glossy and transmission bounces: closed forms, and what limits that do not bind leave alone."""

import numpy as np
import pytest

from zraka.core.compile import compile_scene
from zraka.core.compile.features import Feature
from zraka.core.diagnostics import Diagnostics
from zraka.core.scene import AreaLight, Link, Material, Node
from zraka.core.settings import Guides, Settings

from .scenes import box, camera, cornell, film_of, looking_down, placed, quad, radiance, scene

ALBEDO = 0.5


def glowing_room(kind, **inputs):
    """A closed room of albedo `ALBEDO` whose walls have radiance 1."""
    nodes = (
        Node(kind, {"color": (ALBEDO,) * 3, **inputs}),
        Node("emission", {"color": (1.0, 1.0, 1.0), "strength": 1.0}),
        Node("add_shader", {"a": Link(0, "bsdf"), "b": Link(1, "bsdf")}),
    )
    room = placed(box(2, inward=True), Material(kind, nodes, 2))
    return scene(camera((0, 0, 0), (0, 1, 0), fov=1.0), room)


def sheets(count, **settings):
    """A glowing square seen through `count` sheets that refract nothing."""
    pile = [placed(quad(4, (0, 0, 1 + k)), Material.glass(ior=1.0)) for k in range(count)]
    return radiance(looking_down(placed(quad(4), Material.emission()), *pile, height=9.0), 4, **settings)


@pytest.mark.parametrize("bounces", [0, 1, 3])
@pytest.mark.parametrize("kind, inputs", [("diffuse", {}), ("glossy", {"roughness": 0.0})])
def test_closed_room(kind, inputs, bounces):
    """1 + rho + ... + rho^(N+1): after N bounces comes one hit that is lit, and the ray from there sees walls shine."""
    value = radiance(glowing_room(kind, **inputs), 64, depth=16, **{f"{kind}_bounces": bounces})
    expected = (1 - ALBEDO ** (bounces + 2)) / (1 - ALBEDO)
    assert value == pytest.approx(expected, rel=5e-3)


@pytest.mark.parametrize("limits", [{"glossy_bounces": 0}, {"transmission_bounces": 0}, {"diffuse_bounces": 15}])
def test_limits_of_other_kinds_change_nothing(limits):
    room = glowing_room("diffuse")
    free, limited = (film_of(room, depth=16, **more).image() for more in ({}, limits))
    np.testing.assert_array_equal(free, limited)


def test_a_limit_of_the_only_kind_is_that_of_all():
    """N bounces are N + 1 hits, whoever limits them: the same picture, with lights sampled and lights met."""
    walls = placed(box(2, inward=True), Material.diffuse(0.7))
    lamp = AreaLight(np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0.9], [0, 0, 0, 1.0]]), (9.0, 9.0, 9.0))
    panel = placed(quad(0.5, (0.5, 0.5, 0)), Material.emission())
    room = scene(camera((0, -0.9, 0), (0, 1, 0), fov=1.0), walls, panel, lights=(lamp,))
    whole, limited, more = (
        film_of(room, 4, **settings).image()
        for settings in ({"depth": 3}, {"depth": 9, "diffuse_bounces": 2}, {"depth": 9, "diffuse_bounces": 3})
    )
    np.testing.assert_array_equal(whole, limited)
    assert (more != limited).any()


@pytest.mark.parametrize("bounces", [1, 2, 3])
def test_sheets(bounces):
    """What lies behind N + 1 passages is still seen shining by path tracing; ray tracing sends N rays."""
    assert sheets(3, depth=9, transmission_bounces=bounces) == (bounces >= 2)
    assert sheets(3, depth=9, transmission_bounces=bounces, method="raytrace") == pytest.approx(float(bounces >= 3))


@pytest.mark.parametrize("bounces", [0, 1])
def test_mirror_rays(bounces):
    view = looking_down(placed(quad(4), Material.glossy(1.0)), world=1.0)
    for depth in (2, 5):
        assert radiance(view, 1, method="raytrace", depth=depth, glossy_bounces=bounces) == pytest.approx(bounces)


def test_stages_are_there_only_where_a_limit_ends_paths():
    def feature(**settings):
        return Feature.BOUNCE_LIMITS in compile_scene(cornell(), Settings(**settings), Diagnostics()).features

    assert not feature()
    assert not feature(depth=5, diffuse_bounces=4, glossy_bounces=9)
    assert feature(depth=5, diffuse_bounces=3)
    assert feature(depth=9, diffuse_bounces=8, glossy_bounces=12, transmission_bounces=2)


def test_passes_split_the_very_picture():
    limits = {"depth": 8, "diffuse_bounces": 1, "glossy_bounces": 0, "transmission_bounces": 2}
    plain = film_of(cornell(), 4, **limits).image()
    split = film_of(cornell(), 4, guides=Guides(frozenset({"diffuse_indirect", "glossy_direct"})), **limits).image()
    np.testing.assert_array_equal(plain, split)


def test_negative_limits_are_refused():
    with pytest.raises(ValueError, match="at least 0"):
        Settings(glossy_bounces=-1)
