# SPDX-License-Identifier: GPL-3.0-or-later
"""Ambient Occlusion and Bevel beside Cycles: a bent plane with a box on it, by means over blocks."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from zraka.addon.bench.engines import match, operate, watched

from .harness import SIZE, add, add_plane, fresh_scene, output, show, signed

SAMPLES, BLOCK = 16, 8


def occlusion(socket, distance, **properties):
    def build(tree, plane):
        return output(add(tree, "AmbientOcclusion", {"Distance": distance}, **properties), socket)

    return build


def bevel(radius, **properties):
    def build(tree, plane):
        return signed(tree, output(add(tree, "Bevel", {"Radius": radius}, **properties)), 0.5)

    return build


def bumped(tree, plane):
    """A bevel of a normal that another node gave."""
    given = add(tree, "Normal").outputs[0]
    given.default_value = (0.3, 0.2, 0.9)
    return signed(tree, output(add(tree, "Bevel", {"Radius": 0.3, "Normal": given})), 0.5)


def scene_of(build, other=False):
    """Looked at from above: the plane's object has a box, turned, and a smooth ball; `other` gives these to another."""
    scene = fresh_scene()
    plane = add_plane(scene)
    bpy.ops.mesh.primitive_cube_add(size=0.7, location=(-0.35, 0.1, 0.2), rotation=(0.4, 0.3, 0.5))
    box = bpy.context.object
    bpy.ops.mesh.primitive_uv_sphere_add(segments=12, ring_count=6, radius=0.35, location=(0.45, -0.2, 0.3))
    ball = bpy.context.object
    ball.data.polygons.foreach_set("use_smooth", [True] * len(ball.data.polygons))
    for obj in bpy.context.scene.objects:
        obj.select_set(obj.type == "MESH" and not (other and obj is plane))
    bpy.context.view_layer.objects.active = box if other else plane
    bpy.ops.object.join()
    joined = bpy.context.view_layer.objects.active
    show(joined, build)
    if other:
        plane.data.materials.append(joined.data.materials[0])
    scene.zraka.samples, scene.zraka.depth = SAMPLES, 1
    match(scene)
    return scene


def blocks(picture):
    return picture.reshape(SIZE // BLOCK, BLOCK, SIZE // BLOCK, BLOCK, 3).mean(axis=(1, 3))


CASES = {
    "Ambient Occlusion: open": (occlusion("AO", 0.5), False, 0.01),
    "Ambient Occlusion: colour": (occlusion("Color", 2.0, samples=4), False, 0.015),
    "Ambient Occlusion: inside": (occlusion("AO", 0.6, inside=True), False, 0.01),
    "Ambient Occlusion: local": (occlusion("AO", 0.8, only_local=True), True, 0.01),
    "Bevel: narrow": (bevel(0.15), False, 0.01),
    "Bevel: wide": (bevel(0.4, samples=8), True, 0.015),
    "Bevel: of a normal": (bumped, False, 0.01),
}


def apart(scene):
    """How far the blocks of both engines' pictures are apart, and Cycles' picture."""
    with watched() as seen:
        ours, _ = operate(scene, "ZRAKA")
    theirs, _ = operate(scene, "CYCLES")
    assert not seen.messages
    return np.abs(blocks(ours) - blocks(theirs)), theirs


@pytest.mark.parametrize("name", CASES)
def test_agrees_with_cycles(name):
    build, other, tolerance = CASES[name]
    difference, theirs = apart(scene_of(build, other))
    assert theirs.std() > 0.01
    assert difference.max() < 3 * tolerance
    assert difference.mean() < tolerance / 2


def test_the_comparison_can_fail():
    """A radius and a distance that are off by more than half are seen."""
    for make, size in ((bevel, 0.15), (lambda d: occlusion("AO", d), 0.5)):
        a, b = (blocks(operate(scene_of(make(r)), "ZRAKA")[0]) for r in (size, 1.6 * size))
        assert np.abs(a - b).max() > 0.03
