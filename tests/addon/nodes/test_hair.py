# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair shaders beside Cycles, on meshes and on strands."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from mathutils import Vector

from zraka.addon.bench.engines import match, operate, watched
from zraka.tests.addon.geometry_scenes import hair_curves

from .harness import add, fresh_scene
from .slope import Slope, emptied

SAMPLES = 16
COLOR = {"Color": (0.6, 0.3, 0.1, 1.0)}
MELANIN = {"Melanin": 0.5, "Melanin Redness": 0.4, "Tint": (0.9, 0.7, 0.8, 1.0), "Roughness": 0.5}
ABSORPTION = {"Absorption Coefficient": (0.3, 0.8, 0.1), "IOR": 1.4, "Radial Roughness": 0.9, "Roughness": 0.9}
KINDS = {
    "reflection": ("BsdfHair", COLOR | {"RoughnessU": 0.3, "RoughnessV": 0.5}, {"component": "Reflection"}),
    "transmission": ("BsdfHair", COLOR | {"RoughnessU": 0.4, "RoughnessV": 0.6}, {"component": "Transmission"}),
    "colour": ("BsdfHairPrincipled", COLOR | {"Roughness": 0.6, "Radial Roughness": 0.7, "Coat": 0.3}, {}),
    "smooth": ("BsdfHairPrincipled", COLOR | {"Roughness": 0.25, "Radial Roughness": 0.5, "Offset": 0.1}, {}),
    "melanin": ("BsdfHairPrincipled", MELANIN, {"parametrization": "MELANIN"}),
    "absorption": ("BsdfHairPrincipled", ABSORPTION, {"parametrization": "ABSORPTION"}),
    "random": (
        "BsdfHairPrincipled",
        MELANIN | {"Random Color": 0.9, "Random Roughness": 0.8},
        {"parametrization": "MELANIN"},
    ),
}
NARROW = ("melanin", "random")  # few pixels hold most of the light
MORE_SAMPLES = 128  # what the narrow lobes of "smooth" need
HUANG = ("BsdfHairPrincipled", {}, {"model": "HUANG"})


def of_kind(kind, inputs, properties, has_tangent=False):
    """Builds the shader; its inputs, unlike `add`'s, also by sockets that are shown twice."""

    def build(tree, plane):
        node = tree.nodes.new(f"ShaderNode{kind}")
        for name, value in properties.items():
            setattr(node, name, value)
        for name, value in inputs.items():
            node.inputs[name].default_value = value
        if has_tangent:
            tree.links.new(add(tree, "Tangent", direction_type="UV_MAP").outputs[0], node.inputs["Tangent"])
        return node.outputs[0]

    return build


def test_single_values_on_meshes():
    """f·cosθ of pairs of directions, along the triangles' own sides and along a given tangent.

    On meshes Cycles leaves out half of the directions of Principled Hair where it samples lights; these suns are in the
    other half.
    """
    kinds = [of_kind(*kind) for kind in KINDS.values()]
    kinds += [of_kind(*KINDS[name], has_tangent=True) for name in ("reflection", "transmission")]
    for degrees in (30.0, 70.0):
        slope = Slope(kinds)
        slope.tilt(degrees)
        for sun in ((0.0, 0.0, 1.0), (0.3, -0.5, 0.8)):
            slope.add_sun(sun)
            ours, theirs = (slope.render(engine, SAMPLES) for engine in ("ZRAKA", "CYCLES"))
            np.testing.assert_allclose(ours, theirs, rtol=0.015, atol=1e-4)


def strands(kind, sun, shadow=False):
    """Hair curves under a sun, as Cycles' 3D Curves."""
    scene = fresh_scene()
    scene.cycles_curves.shape = "THICK"
    hair_curves(scene)
    material = bpy.data.materials.new("Hair")
    tree = emptied(material)
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(of_kind(*kind)(tree, None), output.inputs["Surface"])
    scene.objects["Object"].data.materials.append(material)
    scene.camera.data.ortho_scale = 4.0
    lamp = bpy.data.lights.new("Sun", "SUN")
    lamp.energy, lamp.angle, lamp.use_shadow = 3.0, 0.0, shadow
    light = bpy.data.objects.new("Sun", lamp)
    light.rotation_euler = Vector(sun).to_track_quat("Z", "Y").to_euler()
    scene.collection.objects.link(light)
    scene.zraka.depth, scene.zraka.samples = 1, SAMPLES
    match(scene)
    return scene


@pytest.mark.parametrize("name", [n for n in KINDS if n != "reflection"])
def test_strands_against_the_light(name):
    """Light that passes through."""
    scene = strands(KINDS[name], (0.2, 0.5, -0.8), shadow=True)
    if name == "smooth":
        scene.zraka.samples = MORE_SAMPLES
        match(scene)
    assert_alike(scene, 0.03 if name in NARROW else 0.015)


@pytest.mark.parametrize("name", [n for n in KINDS if n != "transmission"])
def test_strands_in_light(name):
    assert_alike(strands(KINDS[name], (0.3, -0.4, 0.8), shadow=True), 0.03 if name in NARROW else 0.015)


def assert_alike(scene, tolerance):
    ours, theirs = (operate(scene, engine)[0].mean(axis=(0, 1)) for engine in ("ZRAKA", "CYCLES"))
    assert theirs.max() > 1e-3
    np.testing.assert_allclose(ours, theirs, rtol=tolerance)


@pytest.mark.parametrize("kind", ["BsdfDiffuse", "BsdfAnisotropic", "BsdfPrincipled"])
@pytest.mark.parametrize("is_corrected", [True, False])
def test_turned_normals_on_strands(kind, is_corrected):
    """Neither raised nor softened, and light may come from below: without its light tree Cycles samples all of it.

    Before 5.0 strands are softened as other surfaces are, and light that comes from below is tested.
    """
    scene = strands((kind, {}, {}), (0.3, -0.4, 0.8))
    material = bpy.data.materials["Hair"]
    material.cycles.use_bump_map_correction = is_corrected
    tree = material.node_tree
    shader = next(node for node in tree.nodes if "Normal" in node.inputs)
    turned = add(tree, "CombineXYZ", {"X": 0.6, "Y": -0.5, "Z": 0.6})
    tree.links.new(turned.outputs[0], shader.inputs["Normal"])
    scene.cycles.use_light_tree = False
    if bpy.app.version < (5, 0):  # there light ends at an edge across the strands, which is noise
        scene.zraka.samples = MORE_SAMPLES
        match(scene)
    assert_alike(scene, 0.005)


@pytest.mark.parametrize(("thickness", "apart"), [(0.3, False), (1.0, True)])
def test_ribbons_shade_each_other_less_the_thicker_they_are(thickness, apart):
    """Cycles' own shapes differ by 7% where strands stand closer than their width: rays do not meet ribbons there."""
    scene = strands(KINDS["transmission"], (0.2, 0.5, -0.8), shadow=True)
    radius = scene.objects["Object"].data.attributes["radius"].data
    values = np.empty(len(radius), np.float32)
    radius.foreach_get("value", values)
    radius.foreach_set("value", values * np.float32(thickness))
    tubes = operate(scene, "CYCLES")[0].mean()
    scene.cycles_curves.shape = "RIBBONS"
    assert (abs(operate(scene, "CYCLES")[0].mean() / tubes - 1) > 0.05) == apart


def test_cycles_leaves_out_half_of_principled_hair_on_meshes():
    """Of suns mirrored in the plane along the view and the tangent it shows one (from 5.0 on); the lobes have both."""
    slope = Slope([of_kind(*KINDS["colour"])])
    slope.tilt(30.0)
    seen = {}
    for side in (-0.5, 0.5):
        for engine in ("ZRAKA", "CYCLES"):
            slope.add_sun((0.3, side, 0.8))
            seen[engine, side] = slope.render(engine, SAMPLES).max()
    assert min(seen["ZRAKA", side] for side in (-0.5, 0.5)) > 1e-3
    known = seen["ZRAKA", 0.5] if bpy.app.version < (5, 0) else 0
    assert seen["CYCLES", 0.5] == pytest.approx(known, rel=0.015)
    assert seen["CYCLES", -0.5] == pytest.approx(seen["ZRAKA", -0.5], rel=0.015)


def test_the_comparison_can_fail():
    """Another roughness is seen."""
    a, b = (
        operate(strands((kind, inputs | {"Roughness": r}, props), (0.2, 0.5, -0.8)), "ZRAKA")[0].mean()
        for kind, inputs, props in (KINDS["colour"],)
        for r in (0.6, 0.7)
    )
    assert abs(a / b - 1) > 0.06


def test_what_is_not_honoured_is_said():
    scene = strands(HUANG, (0.3, -0.4, 0.8))
    with watched() as seen:
        picture, _ = operate(scene, "ZRAKA")
    assert picture.max() > 0
    assert any("Huang" in message for message in seen.messages)
