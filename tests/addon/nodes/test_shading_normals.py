# SPDX-License-Identifier: GPL-3.0-or-later
"""Shading on smooth and bumped normals beside Cycles: a coarse smooth ball in a white world."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from zraka.addon.bench.engines import match, operate

from .harness import add, fresh_scene
from .slope import emptied

SAMPLES = 32
WHOLE, BLOCKS = 0.004, 0.03  # how far the pictures may be apart; noise makes up 0.02 of the blocks
BLACK = {"Base Color": (0, 0, 0, 1)}
SHEEN = BLACK | {"Sheen Weight": 1.0, "Sheen Roughness": 0.3, "Roughness": 0.3}
COAT = BLACK | {"Coat Weight": 1.0, "Coat Roughness": 0.3, "Specular IOR Level": 0.0}
PRINCIPLED = "BsdfPrincipled"
CASES = {
    "sheen": (PRINCIPLED, SHEEN, 0.0, True),
    "bumped sheen": (PRINCIPLED, SHEEN, 0.5, True),
    "sheen over coat": (PRINCIPLED, SHEEN | {"Coat Weight": 0.4}, 0.2, True),
    "coat over a bump": (PRINCIPLED, COAT, 0.2, True),
    "uncorrected cloth": ("BsdfDiffuse", {}, 0.5, False),
    "uncorrected gloss": ("BsdfAnisotropic", {"Roughness": 0.2}, 0.5, False),
    "uncorrected smooth gloss": ("BsdfAnisotropic", {"Roughness": 0.2}, 0.0, False),
    "uncorrected Principled": (PRINCIPLED, {}, 0.5, False),  # in part on normals that face away from the viewer
}


def ball(kind, inputs, bump, is_corrected):
    """A ball of 40 faces, smooth, of one shader."""
    scene = fresh_scene()
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.9, segments=8, ring_count=6)
    bpy.ops.object.shade_smooth()
    material = bpy.data.materials.new("Ball")
    tree = emptied(material)
    shader, output = add(tree, kind, inputs), add(tree, "OutputMaterial")
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    if bump:
        height = add(tree, "TexNoise", {"Scale": 3.0}).outputs[0]
        turned = add(tree, "Bump", {"Height": height, "Distance": bump})
        tree.links.new(turned.outputs[0], shader.inputs["Normal"])
    material.cycles.use_bump_map_correction = is_corrected
    bpy.context.object.data.materials.append(material)
    scene.world = bpy.data.worlds.new("World")
    tree = emptied(scene.world)
    white, output = add(tree, "Background", {"Color": (1, 1, 1, 1)}), add(tree, "OutputWorld")
    tree.links.new(white.outputs[0], output.inputs["Surface"])
    scene.zraka.depth, scene.zraka.samples = 1, SAMPLES
    match(scene)
    return scene


def apart(ours, theirs):
    """How far the light of the ball is apart in all, and of blocks of 8 x 8 pixels in the root of the mean square."""
    seen = (theirs < 0.9995)[..., 0]
    ours, theirs = ((p.mean(axis=-1) * seen).reshape(8, 8, 8, 8).sum(axis=(1, 3)) for p in (ours, theirs))
    lit = theirs > 3.0
    return abs(ours.sum() / theirs.sum() - 1), np.sqrt(np.square(ours[lit] / theirs[lit] - 1).mean())


@pytest.mark.parametrize("name", CASES)
def test_as_in_cycles(name):
    scene = ball(*CASES[name])
    whole, blocks = apart(*(operate(scene, engine)[0] for engine in ("ZRAKA", "CYCLES")))
    assert whole < WHOLE
    assert blocks < BLOCKS


def test_emission_under_a_coat():
    """The coat over what is emitted stands on the raised normal; on the one that was given, it is 0.5% darker."""
    inputs = COAT | {"Emission Color": (1, 1, 1, 1), "Emission Strength": 1.0}
    scene = ball(PRINCIPLED, inputs, 0.5, True)
    scene.world = None
    ours, theirs = (operate(scene, engine)[0].mean() for engine in ("ZRAKA", "CYCLES"))
    assert ours == pytest.approx(theirs, rel=0.002)


@pytest.mark.parametrize("name", ["uncorrected cloth", "uncorrected gloss"])
def test_the_comparison_can_fail(name):
    """With and without the correction the pictures differ."""
    *shader, bump, _ = CASES[name]
    with_it, without = (operate(ball(*shader, bump, corrected), "ZRAKA")[0] for corrected in (True, False))
    whole, blocks = apart(with_it, without)
    assert whole > WHOLE or blocks > BLOCKS
