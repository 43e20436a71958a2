# SPDX-License-Identifier: GPL-3.0-or-later
"""Things that only some rays see, and lights that shine on some things or are shaded by some."""

from __future__ import annotations

from dataclasses import replace

from ..scene import Instance, Material, PointLight, SunLight
from ..settings import METHODS
from ..visibility import ALL_RAYS, LAMP, ObjectSet, Rays, Visibility
from .axis import Axis
from .case import PATH, Case
from .lamps import by_point_truth
from .placing import ALBEDO, SCALES, SOME_SCALES, SUNLIT
from .shapes import box, camera, looking_down, placed, quad, scene

DIRECT = {"depth": 1}
NOBODY = ObjectSet()
SHADED = ("raycast", "raytrace", "pathtrace")  # the methods that know shadows


def named(mesh, name, material=None, **visibility):
    """An instance that some rays see."""
    materials = (material or Material.diffuse(ALBEDO),)
    return Instance(mesh, materials=materials, name=name, visibility=Visibility(**visibility))


def under_a_roof(scale=1.0, height=0.5, light=None, **visibility):
    """A sunlit floor below a black roof that some rays do not see; the camera is below the roof if that is high."""
    floor = named(quad(4 * scale), "floor")
    roof = named(quad(4 * scale, (0, 0, height * scale)), "roof", Material.diffuse(0.0), **visibility)
    sun = SunLight((0, 0, -1), (3, 3, 3), visibility=replace(LAMP, **(light or {})))
    return looking_down(floor, roof, lights=[sun], height=scale)


def sunlit_floor(world=0.0, light=None, **visibility):
    """A floor in the sun and in a grey world."""
    sun = SunLight((0, 0, -1), (3, 3, 3), visibility=replace(LAMP, **(light or {})))
    return looking_down(named(quad(4), "floor", **visibility), lights=[sun], world=world)


def room_for_the_camera():
    """The glowing room in a white world; scattered light does not see it."""
    walls = named(box(2, inward=True), "room", Material.glowing(0.5, 1.0), rays=ALL_RAYS & ~Rays.DIFFUSE)
    return scene(camera((0, 0, 0), (0, 1, 0), fov=1.0), walls, world=1.0)


def with_blockers_of_their_own(count):
    """A floor below as many lamps as roofs; each lamp is shaded by one roof, which is aside."""
    roofs = [named(quad(0.1, (5, 0.01 * k, 0.5)), f"roof {k}") for k in range(count)]
    shut = named(quad(4, (0, 0, 0.7)), "shut", Material.diffuse(0.0))
    lights = [
        PointLight(
            (0, 0, 1),
            (100 / count,) * 3,
            visibility=replace(LAMP, blockers=ObjectSet(frozenset({f"roof {k}"}))),
        )
        for k in range(count)
    ]
    view = camera((0.1, 0, 0.5), (0, 0, 0), fov=1e-4)
    return scene(view, placed(quad(40), Material.diffuse(ALBEDO)), shut, *roofs, lights=lights)


def _direct(build, truth=SUNLIT, methods=METHODS):
    return Case(build, truth, methods, samples=16, settings=DIRECT)


NO_SHADOW, NO_CAMERA = ALL_RAYS & ~Rays.SHADOW, ALL_RAYS & ~Rays.CAMERA
SEEN = {
    "roof that shades": _direct(lambda: under_a_roof(height=2.0), 0.0, SHADED),
    "roof unseen by shadow rays": _direct(lambda: under_a_roof(height=2.0, rays=NO_SHADOW)),
    "roof unseen by the camera": _direct(lambda: under_a_roof(rays=NO_CAMERA), 0.0, SHADED),
    "roof seen by none": _direct(lambda: under_a_roof(rays=Rays(0))),
    "floor unseen by the camera": _direct(lambda: sunlit_floor(0.7, rays=NO_CAMERA), 0.7),
    "floor held out": _direct(lambda: sunlit_floor(0.7, holdout=True), 0.0, PATH),
    "room unseen by diffuse rays": Case(room_for_the_camera, 1.5, settings={"depth": 8}),
    "sun that lights nothing": _direct(lambda: sunlit_floor(light={"receivers": NOBODY}), 0.0),
    "sun that lights all but another": _direct(
        lambda: sunlit_floor(light={"receivers": ObjectSet(frozenset({"other"}), True)})
    ),
    "sun that nothing blocks": _direct(lambda: under_a_roof(height=2.0, light={"blockers": NOBODY})),
    "sun that all but the roof block": _direct(
        lambda: under_a_roof(height=2.0, light={"blockers": ObjectSet(frozenset({"roof"}), True)})
    ),
    "sun for one bounce": _direct(lambda: sunlit_floor(light={"max_bounces": 0})),
    "sun unseen by diffuse rays": _direct(
        lambda: sunlit_floor(light={"rays": ALL_RAYS & ~Rays.DIFFUSE}), 0.0, ("pathtrace",)
    ),
}

AXES = (
    Axis(
        "scene scale, roof unseen by shadow rays",
        "sunlit floor below a roof that shades nothing: ρ/π · E",
        lambda s: _direct(lambda: under_a_roof(s, 2.0, rays=NO_SHADOW)),
        SCALES,
        1.0,
        (1e-5, 1e7),
        SOME_SCALES,
    ),
    Axis(
        "height of a roof unseen by the camera",
        "floor in its shadow: 0",
        lambda h: _direct(lambda: under_a_roof(height=h, rays=NO_CAMERA), 0.0, SHADED),
        (1e-4, 1e-3, 1e-2, 0.1, 0.5),
        0.5,
        (1e-4, 0.5),
        (1e-4, 0.5),
    ),
    Axis(
        "number of lamps with blockers of their own",
        "floor below lamps at one place, each shaded by another roof aside: ρ/π · P/(4πd²)",
        lambda n: Case(lambda: with_blockers_of_their_own(n), by_point_truth(), METHODS, samples=64, settings=DIRECT),
        (1, 2, 16, 64),
        1,
        (1, 64),
        (1, 16),
    ),
    Axis("who sees what", "floor in the sun, or the closed room, in closed form", SEEN.get, tuple(SEEN)),
)
