# SPDX-License-Identifier: GPL-3.0-or-later
"""The three classic methods on every scene of docs/coverage.md: finite, and not black where direct light falls.

What each light and material means to them stands in docs/classic.md.
"""

from __future__ import annotations

from functools import partial

import bpy
import numpy as np
import pytest

from zraka.addon.bench.engines import match, operate, watched

from . import camera_cases, catcher_cases, geometry_cases, light_cases, motion_cases, visibility_cases, world_cases
from .geometry_scenes import shows

METHODS = ("PHONG", "RAYCAST", "RAYTRACE")


def of_geometry(case, scene):
    geometry_cases.prepare(scene)
    case.build(scene)
    if case.shown:
        scene.view_layers[0].material_override = shows(*geometry_cases.POSITION)
    return scene


def of_visibility(case, _):
    scene = visibility_cases.room()
    case.setup(bpy.data.objects)
    case.change(bpy.data.objects, scene)
    return scene


def of_motion(case, scene):
    motion_cases.tiles(scene)
    case.move(scene)
    return scene


def of_others(module, case, scene):
    build = module.set_up if module is camera_cases else module.build
    build(scene, case)
    return scene


BUILDERS = {
    geometry_cases: of_geometry,
    visibility_cases: of_visibility,
    catcher_cases: of_visibility,
    motion_cases: of_motion,
    **{module: partial(of_others, module) for module in (camera_cases, light_cases, world_cases)},
}
SCENES = [
    pytest.param(partial(build, case), id=case.item, marks=[] if k % 16 == 0 else pytest.mark.slow)
    for module, build in BUILDERS.items()
    for k, case in enumerate(c for c in module.CASES if bpy.app.version >= getattr(c, "since", (4, 2)))
]


FAINT = 1e-3  # of the brightest that direct light makes: as good as black


def picture(scene, method, samples):
    """The scene by a method."""
    scene.zraka.method, scene.zraka.samples = method, samples
    return operate(scene, "ZRAKA")[0]


def black_where_lit(scene):
    """By method, the share of the pixels that are black though direct light falls on what they show."""
    match(scene)
    scene.zraka.depth = 1
    catchers = [o for o in scene.objects if o.is_shadow_catcher]  # to these methods, objects like others
    for caught in catchers:
        caught.is_shadow_catcher = False
    bright = np.abs(picture(scene, "PATHTRACE", 16)).max(axis=-1)
    for caught in catchers:
        caught.is_shadow_catcher = True
    lit = bright > 0.1 * bright.max()
    assert bright.max() > 0
    scene.zraka.depth = 4
    shares = {}
    for method in METHODS:
        seen = picture(scene, method, 16)
        assert np.isfinite(seen).all()
        shares[method] = float((np.abs(seen).max(axis=-1) < FAINT * bright.max())[lit].mean())
    return shares


# Without ambient light, floor, mirror and glass show what only mirror and refracted rays bring.
ONLY_BY_FURTHER_RAYS = ("world hidden from diffuse rays", "transparent glass", "shadow catcher, in a mirror")


@pytest.mark.parametrize("build", SCENES)
def test_nothing_is_silently_black(blender_scene, build):
    shares = black_where_lit(build(blender_scene))
    if build.args[-1].item.startswith(ONLY_BY_FURTHER_RAYS):
        shares = {"RAYTRACE": shares["RAYTRACE"]}
    assert max(shares.values()) < 0.1, shares  # edges in other places, of what moves in 4 moments


def test_glass_before_the_world_is_black_without_further_rays():
    """As docs/classic.md says; so black is found where it is."""
    scene = visibility_cases.room()
    for name in ("Floor", "Box", "Mirror"):
        visibility_cases.give(bpy.data.objects[name], "BsdfGlass", Roughness=0.0)
    match(scene)
    shares = [float((picture(scene, method, 1).max(axis=-1) < FAINT).mean()) for method in METHODS]
    assert shares[0] > 0.5 and shares[1] > 0.5
    assert shares[2] < 0.1


def test_what_transparent_surfaces_hide_is_said():
    scene = visibility_cases.room()
    visibility_cases.half_transparent(bpy.data.objects)
    match(scene)
    messages = {}
    for method in (*METHODS, "PATHTRACE"):
        with watched() as seen:
            picture(scene, method, 1)
        messages[method] = seen.messages
    assert messages["RAYTRACE"] == messages["PATHTRACE"] == []
    for method in METHODS[:2]:
        (message,) = messages[method]
        assert "transparent surfaces hide" in message
