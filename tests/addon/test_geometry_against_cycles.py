# SPDX-License-Identifier: GPL-3.0-or-later
"""Every kind of geometry as Cycles shows it."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from zraka.addon.bench.engines import match, operate, watched

from .geometry_cases import CASES, HEIGHT, measure, prepare
from .geometry_scenes import NORMAL, glowing, hair_curves, instanced_by_nodes, primitive, put, shows, tree_of

DEGENERATE = ("surface", "faces without area")  # Blender makes triangles without area for these, which is said


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.item)
def test_as_cycles_shows_it(blender_scene, case):
    share, _, messages = measure(blender_scene, case)
    assert share >= case.agreeing
    assert bool(messages) == (case.item in DEGENERATE)


@pytest.mark.skipif(bpy.app.version >= (4, 5), reason="since Blender 4.5 they are read")
def test_attributes_of_instances_that_cannot_be_read_are_said(blender_scene):
    prepare(blender_scene)
    instanced_by_nodes(blender_scene)
    kind, socket, *settings = HEIGHT
    blender_scene.view_layers[0].material_override = shows(kind, socket, **dict(settings))
    with watched() as seen:
        operate(blender_scene, "ZRAKA")
    assert len(seen.messages) == 1 and "instances of geometry nodes" in seen.messages[0]


def test_a_difference_would_be_seen(blender_scene):
    """Cycles' ribbons have other normals than tubes."""
    prepare(blender_scene)
    hair_curves(blender_scene)
    blender_scene.view_layers[0].material_override = shows(*NORMAL)
    ours, _ = operate(blender_scene, "ZRAKA")
    shares = []
    for shape in ("THICK", "RIBBONS"):
        blender_scene.cycles_curves.shape = shape
        theirs, _ = operate(blender_scene, "CYCLES")
        hit = theirs.any(axis=-1)
        shares.append((np.abs(ours - theirs).max(axis=-1) < 2e-3)[hit].mean())
    assert shares[0] > 0.99
    assert shares[1] < 0.9


def test_a_cube_that_holds_but_a_volume_is_not_there(blender_scene):
    prepare(blender_scene)
    blender_scene.zraka.method = "PATHTRACE"
    primitive("plane", size=6, location=(0, 0, -2)).data.materials.append(glowing((1, 0.5, 0.2)))
    material = bpy.data.materials.new("Smoke")
    tree = tree_of(material)
    output, volume = (tree.nodes.new(f"ShaderNode{name}") for name in ("OutputMaterial", "VolumeAbsorption"))
    tree.links.new(volume.outputs[0], output.inputs["Volume"])
    primitive("cube", size=1.5).data.materials.append(material)
    with watched() as seen:
        ours, _ = operate(blender_scene, "ZRAKA")
    np.testing.assert_allclose(ours[20:40, 30:50], np.broadcast_to((1, 0.5, 0.2), (20, 20, 3)), rtol=1e-5)
    assert seen.messages == ["volume is not rendered yet (material 'Smoke')"]


@pytest.mark.parametrize("method", ["PHONG", "RAYCAST", "RAYTRACE", "PATHTRACE"])
def test_volumes_of_every_kind_are_said_once_and_not_black(blender_scene, method):
    prepare(blender_scene)
    primitive("plane", size=20, location=(0, 0, -2)).data.materials.append(surface("Diffuse", 0.8))
    light(blender_scene, 3, 0.3)
    smoke = bpy.data.materials.new("Smoke")
    for owner, kind in ((smoke, "OutputMaterial"), (blender_scene.world, "OutputWorld")):
        tree = owner.node_tree if kind == "OutputWorld" else tree_of(owner)
        output = next((n for n in tree.nodes if n.type == "OUTPUT_WORLD"), None)
        output = output or tree.nodes.new(f"ShaderNode{kind}")
        tree.links.new(tree.nodes.new("ShaderNodeVolumePrincipled").outputs[0], output.inputs["Volume"])
    primitive("cube", size=1.5).data.materials.append(smoke)
    put(blender_scene, bpy.data.volumes.new("Cloud"), "Cloud")
    blender_scene.zraka.method, blender_scene.zraka.samples = method, 4
    with watched() as seen:
        ours, _ = operate(blender_scene, "ZRAKA")
    said = sorted(message for message in seen.messages if "volume" in message)
    assert said == [
        "volume is not rendered yet (material 'Smoke', world 'World')",
        "volumes are not rendered yet (object 'Cloud')",
    ]
    outside = np.ones(ours.shape[:2], bool)
    if method in ("PHONG", "RAYCAST"):  # there what lets light pass hides what is behind it, which is said
        assert any("transparent surfaces hide" in message for message in seen.messages)
        outside[8:52, 18:62] = False
    assert ours[outside].min() > 0.3


def test_no_material_looks_like_cycles_default(blender_scene):
    prepare(blender_scene)
    primitive("uv_sphere", radius=1.2)
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy, sun.angle = 3, 0.5
    put(blender_scene, sun, "Sun", rotation_euler=(0.5, 0.3, 0))
    blender_scene.zraka.samples = 64
    match(blender_scene)
    ours, theirs = operate(blender_scene, "ZRAKA")[0], operate(blender_scene, "CYCLES")[0]
    ours, theirs = (p.reshape(6, 10, 8, 10, 3).mean((1, 3, 4)) for p in (ours, theirs))  # plain diffuse is 3% off
    lit = theirs > 0.05
    np.testing.assert_allclose(ours[lit], theirs[lit], rtol=0.01)


# -- hair in light -----------------------------------------------------------------------------------------------------


def light(scene, energy, tilt):
    """A sun that comes from a side."""
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy, sun.angle = energy, 0.0
    put(scene, sun, "Sun", rotation_euler=(tilt, 0, 0))


def surface(name, color):
    """A material of one shader."""
    material = bpy.data.materials.new(name)
    tree = tree_of(material)
    shader, output = tree.nodes.new(f"ShaderNodeBsdf{name}"), tree.nodes.new("ShaderNodeOutputMaterial")
    shader.inputs["Color"].default_value = (color, color, color, 1)
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return material


def blocks(scene, size):
    """Means of `size` x `size` pixels, ours and Cycles'."""
    scene.zraka.samples = 64
    match(scene)
    shape = 60 // size, size, 80 // size, size, 3
    return (operate(scene, engine)[0].reshape(shape).mean((1, 3, 4)) for engine in ("ZRAKA", "CYCLES"))


def test_lit_hair(blender_scene):
    """Tubes that shade each other and what is below them."""
    prepare(blender_scene)
    hair_curves(blender_scene)
    bpy.data.objects["Object"].data.materials.append(surface("Diffuse", 0.8))
    primitive("plane", size=5, location=(0, 0, -0.5)).data.materials.append(surface("Diffuse", 0.8))
    blender_scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 10
    light(blender_scene, 2, 0.5)
    ours, theirs = blocks(blender_scene, 20)
    np.testing.assert_allclose(ours, theirs, rtol=0.02)


def test_a_half_transparent_strand_is_met_once(blender_scene):
    """Behind it and in its shadow is half the light, as with Cycles' ribbons: rays leave a strand unseen."""
    prepare(blender_scene)
    blender_scene.cycles_curves.shape = "RIBBONS"
    curves = bpy.data.hair_curves.new("Strand")
    curves.add_curves([5])
    x = np.linspace(-4, 4, 5)
    curves.attributes["position"].data.foreach_set("vector", np.stack([x, 0 * x, 0 * x], 1).astype(np.float32).ravel())
    curves.attributes.new("radius", "FLOAT", "POINT").data.foreach_set("value", np.full(5, 0.3, np.float32))
    curves.materials.append(surface("Transparent", 0.5))
    put(blender_scene, curves)
    primitive("plane", size=9, location=(0, 0, -1)).data.materials.append(surface("Diffuse", 1.0))
    light(blender_scene, np.pi, np.pi / 4)
    ours, theirs = blocks(blender_scene, 10)
    np.testing.assert_allclose(ours, theirs, rtol=0.02)
    assert ours.min() == pytest.approx(0.5 * ours.max(), rel=0.1)
