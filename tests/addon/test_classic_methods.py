# SPDX-License-Identifier: GPL-3.0-or-later
"""The three classic methods on every scene of docs/coverage.md: finite, and not silently black where light falls.

What each light and material means to them stands in docs/classic.md.
"""

from __future__ import annotations

import bpy
import pytest

from zraka.addon.bench.engines import match

from . import visibility_cases
from .classic_cases import CASES, FAINT, METHODS, measure, picture

SCENES = [pytest.param(case, marks=[] if k % 16 == 0 else pytest.mark.slow) for k, case in enumerate(CASES)]


@pytest.mark.parametrize("case", SCENES, ids=lambda case: case.item)
def test_nothing_is_silently_black(blender_scene, case):
    found = measure(blender_scene, case)
    for method in METHODS:
        # Edges are in other places, of what moves in 4 moments.
        assert found.black[method] < 0.1 or found.messages[method], found


def test_glass_before_the_world_is_black_without_further_rays():
    """As docs/classic.md says; so black is found where it is."""
    scene = visibility_cases.room()
    for name in ("Floor", "Box", "Mirror"):
        visibility_cases.give(bpy.data.objects[name], "BsdfGlass", Roughness=0.0)
    match(scene)
    shown, messages = zip(*(picture(scene, method, 1) for method in METHODS), strict=True)
    shares = [float((one.max(axis=-1) < FAINT).mean()) for one in shown]
    assert shares[0] > 0.5 and shares[1] > 0.5
    assert shares[2] < 0.1
    assert [any("mirrors and glass" in message for message in said) for said in messages] == [True, True, False]


def test_mirrors_without_glossy_bounces_are_said():
    scene = visibility_cases.room()
    match(scene)
    scene.zraka.glossy_bounces = 0
    _, (message,) = picture(scene, "RAYTRACE", 1)
    assert "limited to 0" in message


@pytest.mark.parametrize(("radius", "by_camera", "said"), [(0.0, True, False), (0.3, False, True), (0.3, True, True)])
def test_lamps_that_are_not_seen_are_said(radius, by_camera, said):
    """Where the camera or a mirror would show them."""
    scene = visibility_cases.room()
    lamp = bpy.data.objects["Lamp"]
    lamp.data.shadow_soft_size, lamp.visible_camera = radius, by_camera
    match(scene)
    for method, others in (("RAYCAST", 1), ("RAYTRACE", 0)):
        expected = said and (by_camera or method == "RAYTRACE")
        _, messages = picture(scene, method, 1)
        assert len(messages) == others + expected
        assert any("lamps are not seen" in message for message in messages) == expected


def test_what_transparent_surfaces_hide_is_said():
    scene = visibility_cases.room()
    visibility_cases.half_transparent(bpy.data.objects)
    match(scene)
    messages = {method: picture(scene, method, 1)[1] for method in (*METHODS, "PATHTRACE")}
    assert messages["RAYTRACE"] == messages["PATHTRACE"] == []
    for method in METHODS[:2]:
        assert sum("transparent surfaces hide" in message for message in messages[method]) == 1
