# SPDX-License-Identifier: GPL-3.0-or-later
"""Who sees what: kinds of rays, linked lights, holdouts, limits of bounces. Truths are closed forms."""

import math
from dataclasses import replace

import numpy as np
import pytest

from zraka.core.accel import Accel
from zraka.core.arena import Arena
from zraka.core.compile import compile_scene
from zraka.core.compile.features import Feature
from zraka.core.diagnostics import Diagnostics
from zraka.core.geometry import Geometry
from zraka.core.methods import method_of
from zraka.core.methods.pathtrace import PathTrace
from zraka.core.partial import PartialAccel
from zraka.core.scene import AreaLight, Image, Material, PointLight, SunLight, World
from zraka.core.settings import METHODS, Settings
from zraka.core.visibility import ALL_RAYS, LAMP, SEEN_BY_ALL, ObjectSet, Rays, Visibility

from .scenes import film_of, looking_down, placed, quad, radiance

RHO = 0.5
FLOOR = placed(quad(20), Material.diffuse(RHO))
SUN = SunLight((0, 0, -1), (math.pi,) * 3)  # gives the floor the radiance RHO
SHADED = ("raycast", "raytrace", "pathtrace")
SHINING = ("phong", *SHADED)


def hidden_from(*kinds):
    """Visibility to all rays but `kinds`."""
    rays = ALL_RAYS
    for kind in kinds:
        rays &= ~kind
    return Visibility(rays)


def roof(material=None, **visibility):
    """A square above the camera, in the sun's way."""
    return replace(
        placed(quad(4, (0, 0, 2)), material or Material.diffuse(0.0)), name="roof", visibility=Visibility(**visibility)
    )


def seen(*instances, lights=(SUN,), method="pathtrace", world=0.0, **settings):
    return radiance(looking_down(*instances, lights=lights, world=world), method=method, size=8, **settings)


# -- trees of some of the primitives -----------------------------------------------------------------------------------


def test_part_of_a_geometry_is_met_as_alone_and_numbered_as_in_the_whole():
    rng = np.random.default_rng(5)
    geometry = Geometry.from_arrays(
        triangles=rng.normal(size=(300, 1, 3)) + 0.3 * rng.normal(size=(300, 3, 3)),
        centers=rng.normal(size=(20, 3)),
        radii=rng.uniform(0.05, 0.2, 20),
        plane_points=[[0, 0, -2], [0, 0, -1.5]],
        plane_normals=[[0, 0, 1], [0, 0, 1]],
    )
    kept = rng.random(geometry.count) < 0.5
    kept[-2:] = True, False
    o, d = np.float32(3 * rng.normal(size=(3, 5000))), np.float32(rng.normal(size=(3, 5000)))
    part, whole, arena = PartialAccel(geometry, kept), Accel(geometry), Arena()
    hits, all_hits = part.intersect(o, d, None, arena), whole.intersect(o, d, None, arena)
    met = hits.prim >= 0
    assert kept[hits.prim[met]].all() and {0, 1} == set(np.unique(met))
    unhidden = (all_hits.prim >= 0) & kept[all_hits.prim]
    for k, (ours, theirs) in enumerate(zip(hits, all_hits, strict=True)):
        same = unhidden if k < 2 else unhidden & (all_hits.prim < geometry.triangle_count)
        np.testing.assert_array_equal(ours[same], theirs[same])
    hidden = (all_hits.prim >= 0) & ~kept[all_hits.prim] & met
    assert hidden.any() and (hits.t[hidden] >= all_hits.t[hidden]).all()
    np.testing.assert_array_equal(part.occluded(o, d, None, arena), met)


def test_nothing_left_is_met_by_nothing():
    geometry = Geometry.from_arrays(triangles=np.eye(3)[None])
    part, ray = PartialAccel(geometry, np.zeros(1, bool)), np.float32([[0.3], [0.3], [-1]])
    assert part.intersect(ray, -ray, None, Arena()).prim == -1


# -- kinds of rays -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", SHADED)
def test_shadow_rays(method):
    assert seen(FLOOR, roof(), method=method) == 0
    assert seen(FLOOR, roof(rays=ALL_RAYS & ~Rays.SHADOW), method=method) == pytest.approx(RHO, rel=1e-5)


@pytest.mark.parametrize("method", METHODS)
def test_camera_rays(method):
    lid = placed(quad(4, (0, 0, 0.5)), Material.emission((1, 1, 1), 7.0))
    assert seen(lid, method=method, depth=1) == pytest.approx(7, rel=1e-5)
    unseen = replace(lid, visibility=hidden_from(Rays.CAMERA))
    assert seen(unseen, method=method, depth=1) == 0


SURFACES = {
    Rays.DIFFUSE: Material.diffuse(1.0),
    Rays.GLOSSY: Material.glossy((1, 1, 1), 0.0),
    Rays.TRANSMISSION: Material.glass((1, 1, 1), ior=1.0001),
}


@pytest.mark.parametrize("kind", SURFACES)
@pytest.mark.parametrize("other", SURFACES)
def test_scattered_rays(kind, other):
    """A closed room of radiance 1 around a surface; rays that do not see it come out in a world of radiance 0."""
    room = placed(quad(2000, (0, 0, 5 if kind != Rays.TRANSMISSION else -5)), Material.emission((1, 1, 1), 1.0))
    room = replace(room, visibility=hidden_from(other))
    value = seen(placed(quad(4), SURFACES[kind]), room, lights=(), depth=2, samples=64)
    assert value == pytest.approx(0.0 if kind == other else 1.0, abs=0.02)


@pytest.mark.parametrize("kind, surface", [(Rays.GLOSSY, "glossy"), (Rays.TRANSMISSION, "glass")])
def test_whitted_rays(kind, surface):
    material = Material.glossy((1, 1, 1), 0.0) if surface == "glossy" else Material.glass((1, 1, 1), ior=1.0001)
    lit = placed(quad(40, (0, 0, 5 if surface == "glossy" else -5)), Material.emission((1, 1, 1), 1.0))
    common = {"lights": (), "method": "raytrace", "depth": 3}
    plain = seen(placed(quad(4), material), lit, **common)
    assert plain > 0.9
    for other in SURFACES:
        value = seen(placed(quad(4), material), replace(lit, visibility=hidden_from(other)), **common)
        assert value == pytest.approx(0 if other == kind else plain, abs=1e-3)


@pytest.mark.parametrize("kind", SURFACES)
def test_worlds(kind):
    world = World((1.0,) * 3, visibility=hidden_from(kind))
    for own, surface in SURFACES.items():
        view = replace(looking_down(placed(quad(4), surface)), world=world)
        assert radiance(view, samples=16, size=8) == pytest.approx(float(own != kind), abs=0.01)
    view = replace(looking_down(), world=World((1.0,) * 3, visibility=hidden_from(Rays.CAMERA)))
    assert radiance(view, size=4) == 0


def test_a_world_with_a_map_is_sampled_for_who_sees_it():
    """Half the sky shines: a sampled map."""
    pixels = np.zeros((8, 16, 4), np.float32)
    pixels[:, :8] = 1
    world = World.textured(Image("sky", pixels, colorspace="Non-Color"))

    def floor(visibility, depth=1):
        view = replace(looking_down(FLOOR), world=replace(world, visibility=visibility))
        return radiance(view, samples=64, size=8, depth=depth)

    assert floor(SEEN_BY_ALL) == pytest.approx(RHO / 2, rel=0.05)
    assert floor(hidden_from(Rays.GLOSSY)) == pytest.approx(floor(SEEN_BY_ALL), rel=1e-6)
    assert floor(hidden_from(Rays.DIFFUSE)) == 0


@pytest.mark.parametrize("kind", [Rays.GLOSSY, Rays.TRANSMISSION])
def test_worlds_of_whitted_rays(kind):
    view = replace(
        looking_down(placed(quad(4), Material.glossy((1, 1, 1), 0.0))),
        world=World((1.0,) * 3, visibility=hidden_from(kind, Rays.DIFFUSE)),
    )
    value = radiance(view, method="raytrace", depth=2, size=8)
    assert value == pytest.approx(0.0 if kind == Rays.GLOSSY else 1.0, abs=1e-3)


@pytest.mark.parametrize("method", SHINING)
def test_lights_hidden_from_diffuse_rays(method):
    unseen = replace(SUN, visibility=Visibility(LAMP.rays & ~Rays.DIFFUSE))
    assert seen(FLOOR, lights=(SUN, unseen), method=method) == pytest.approx(RHO, rel=0.02)
    assert seen(FLOOR, lights=(unseen,), method=method) == 0


def test_the_camera_may_see_a_lamp():
    lamp = np.diag([1.0, -1, -1, 1])  # shines up, to the camera
    light = AreaLight(lamp, (4 * math.pi,) * 3, (2, 2))
    assert seen(lights=(light,)) == 0
    shown = replace(light, visibility=Visibility())
    assert seen(lights=(shown,)) == pytest.approx(1, rel=1e-5)


# -- linking -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", SHINING)
@pytest.mark.parametrize("names, excluded, lit", [("f", False, 1), ("g", False, 0), ("f", True, 0), ("g", True, 1)])
def test_receivers(method, names, excluded, lit):
    floor = replace(FLOOR, name="f")
    light = replace(SUN, visibility=replace(LAMP, receivers=ObjectSet(frozenset(names), excluded)))
    assert seen(floor, lights=(light,), method=method) == pytest.approx(lit * RHO, rel=1e-5)
    floor = replace(floor, name="instance", visibility=Visibility(receives_as="f"))
    assert seen(floor, lights=(light,), method=method) == pytest.approx(lit * RHO, rel=1e-5)


@pytest.mark.parametrize("method", SHADED)
@pytest.mark.parametrize("shadowless", [False, True])
def test_blockers(method, shadowless):
    """Two suns, one of which the roof does not shade."""
    free = replace(SUN, visibility=replace(LAMP, blockers=ObjectSet(frozenset({"roof"}), True)))
    lights = (SUN, free, replace(SUN, casts_shadow=False)) if shadowless else (SUN, free)
    value = seen(FLOOR, roof(), lights=lights, method=method, samples=256)
    assert value == pytest.approx((1 + shadowless) * RHO, rel=0.05 if method == "pathtrace" else 1e-5)


def test_blockers_that_let_light_pass():
    glassy = roof(Material.principled(alpha=0.25))
    for names, through in (("roof", 0.75), ("none", 1.0)):
        light = replace(SUN, visibility=replace(LAMP, blockers=ObjectSet(frozenset({names}))))
        assert seen(FLOOR, glassy, lights=(light,), depth=1) == pytest.approx(through * RHO, rel=1e-3)


def test_a_lamp_of_any_size_keeps_its_blockers():
    """Scattered rays that meet the lamp add nothing to what its samples carry already."""
    lamp = np.diag([1.0, 1, 1, 1])
    lamp[2, 3] = 3
    light = AreaLight(lamp, (40.0,) * 3, (3, 3))
    open_sky = seen(FLOOR, lights=(light,), depth=2, samples=256)
    free = replace(light, visibility=replace(LAMP, blockers=ObjectSet(frozenset({"roof"}), True)))
    assert seen(FLOOR, roof(), lights=(free,), depth=2, samples=256) == pytest.approx(open_sky, rel=0.01)
    assert seen(FLOOR, roof(), lights=(light,), depth=2, samples=256) < 0.5 * open_sky


# -- bounces and holdouts ----------------------------------------------------------------------------------------------


def test_a_light_shines_for_so_many_bounces():
    """A floor under a lid that alone is lit: its light comes in by one bounce."""
    lid = placed(quad(400, (0, 0, 3)), Material.diffuse(1.0))
    floor = replace(FLOOR, name="floor")
    only_lid = ObjectSet(frozenset({"floor"}), True)
    light = PointLight((0, 0, 1.5), (100.0,) * 3, visibility=replace(LAMP, receivers=only_lid))
    values = [
        seen(floor, lid, lights=(replace(light, visibility=replace(light.visibility, max_bounces=b)),), depth=2)
        for b in (0, 1, 1 << 30)
    ]
    assert values[0] == 0 < values[1] == values[2]


@pytest.mark.parametrize("alpha", [1.0, 0.25])
def test_holdouts_cut_holes(alpha):
    lid = replace(placed(quad(4, (0, 0, 0.5)), Material.principled(alpha=alpha)), visibility=Visibility(holdout=True))
    description = looking_down(FLOOR, lid, lights=(SUN,))
    image = film_of(description, size=16, samples=64, depth=1, transparent_film=True).image()
    assert image[..., 3].mean() == pytest.approx(1 - alpha, abs=0.01)
    assert image[..., :3].mean() == pytest.approx(RHO * (1 - alpha) ** 2, abs=0.02)
    assert seen(FLOOR, lid, samples=256, depth=1) == pytest.approx(RHO * (1 - alpha) ** 2, abs=0.02)


# -- no cost -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("visibility, asked", [(Visibility(receives_as="x"), False), (hidden_from(Rays.GLOSSY), True)])
def test_scenes_without_run_the_plain_code(visibility, asked):
    settings = Settings(width=4, height=4)
    compiled = compile_scene(looking_down(replace(FLOOR, visibility=visibility)), settings, Diagnostics())
    assert (Feature.VISIBILITY in compiled.features) == asked
    assert (type(method_of(compiled, settings)) is PathTrace) != asked
    assert (compiled.visibility.camera is compiled.accel) and (compiled.visibility.shadow is compiled.accel)


def test_the_classic_methods_say_that_they_do_not_hold_out():
    diagnostics = Diagnostics()
    scene = looking_down(replace(FLOOR, visibility=Visibility(holdout=True)))
    compile_scene(scene, Settings(width=4, height=4, method="phong"), diagnostics)
    assert diagnostics.messages() == ["objects that are holdouts are rendered as any other by this method"]
