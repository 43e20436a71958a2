# SPDX-License-Identifier: GPL-3.0-or-later
"""The Light Path node on real paths, beside Cycles.

A closure fills the picture, and all around it shines what the node says. Cycles does not sample that light, so each
path tells of itself and next to nothing is left to chance.
"""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from zraka.addon.bench.engines import match, operate

from .nodes.harness import add, add_plane, fresh_scene, output

KINDS = ("Is Diffuse Ray", "Is Glossy Ray", "Is Singular Ray")
SIDES = ("Is Reflection Ray", "Is Transmission Ray", "Is Camera Ray")
DEPTHS = ("Diffuse Depth", "Glossy Depth", "Transmission Depth")
WHOLE = ("Ray Depth", "Ray Length", "Is Shadow Ray")
ASKED = {"kinds": KINDS, "sides": SIDES, "depths": DEPTHS, "whole": WHOLE}
CLOSURES = {
    "diffuse": ("BsdfDiffuse", {}),
    "gloss": ("BsdfAnisotropic", {"Roughness": 0.3}),
    "mirror": ("BsdfAnisotropic", {"Roughness": 0.0}),
    "translucent": ("BsdfTranslucent", {}),
    "clear": ("BsdfRefraction", {"Roughness": 0.0, "IOR": 1.3}),
    "frosted": ("BsdfRefraction", {"Roughness": 0.3, "IOR": 1.3}),
    "glass": ("BsdfGlass", {"Roughness": 0.2, "IOR": 1.5}),
    "principled": ("BsdfPrincipled", {"Base Color": (0.6, 0.6, 0.6, 1), "Roughness": 0.4, "Coat Weight": 0.5}),
    "mixed": ("BsdfPrincipled", {"Base Color": (1, 1, 1, 1), "Roughness": 0.1, "Transmission Weight": 0.5}),
}


def path_tracing(depth=2, samples=16):
    """A scene of a plane that fills the picture, of 16 x 16 pixels, and nothing else."""
    scene = fresh_scene()
    scene.render.resolution_x = scene.render.resolution_y = 16
    scene.zraka.method, scene.zraka.depth, scene.zraka.samples = "PATHTRACE", depth, samples
    scene.world = bpy.data.worlds.new("World")
    nodes_of(scene.world).nodes.clear()
    return scene, add_plane(scene)


def nodes_of(owner):
    """The empty or new tree of a material or world."""
    if owner.node_tree is None:
        owner.use_nodes = True
    return owner.node_tree


def give(obj, build):
    """Give an object a material whose surface is the shader that ``build(tree)`` returns."""
    material = bpy.data.materials.new("Material")
    material.cycles.emission_sampling = "NONE"
    tree = nodes_of(material)
    tree.nodes.clear()
    tree.links.new(build(tree), add(tree, "OutputMaterial").inputs["Surface"])
    obj.data.materials.clear()
    obj.data.materials.append(material)


def told(tree, names, scale=0.25):
    """What the Light Path node says, three outputs as a colour."""
    node = add(tree, "LightPath")
    return output(add(tree, "VectorMath", {0: combined(tree, node, names), 1: (scale,) * 3}, operation="MULTIPLY"))


def combined(tree, node, names):
    """Three outputs of a node as a vector."""
    return output(add(tree, "CombineXYZ", {k: node.outputs[name] for k, name in enumerate(names)}))


def shell(tree_of):
    """A large sphere around everything."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16, radius=6)
    give(bpy.context.object, tree_of)
    return bpy.context.object


def pane(z, build, size=40):
    """A level square."""
    bpy.ops.mesh.primitive_plane_add(size=size, location=(0, 0, z))
    give(bpy.context.object, build)


def emission(names, scale=0.25):
    """A builder of an emission of what the node says."""
    return lambda tree: add(tree, "Emission", {"Color": told(tree, names, scale)}).outputs[0]


def closure(name):
    """A builder of one of the closures."""
    kind, inputs = CLOSURES[name]
    return lambda tree: add(tree, kind, inputs).outputs[0]


def compare(scene, tolerance=0.02):
    """Assert that the means of both engines' pictures agree within a share of the largest; returns Cycles' means."""
    match(scene)
    ours, theirs = (operate(scene, engine)[0].mean(axis=(0, 1)) for engine in ("ZRAKA", "CYCLES"))
    print(f"Zraka {ours.round(4)}, Cycles {theirs.round(4)}")
    np.testing.assert_allclose(ours, theirs, atol=tolerance * max(theirs.max(), 0.05))
    return theirs


@pytest.mark.parametrize("asked", ASKED)
@pytest.mark.parametrize("name", CLOSURES)
def test_scattered_rays(name, asked):
    scene, plane = path_tracing(samples=64)
    give(plane, closure(name))
    shell(emission(ASKED[asked]))
    assert compare(scene).max() > 0.01 or asked == "sides"


@pytest.mark.parametrize("asked", ASKED)
def test_rays_that_scatter_twice(asked):
    """Down through a clear boundary, diffusely back up through it; each surface tells of the rays that reach it."""
    scene, plane = path_tracing(depth=5, samples=64)
    give(plane, closure("clear"))
    pane(-0.5, lambda tree: add(tree, "BsdfDiffuse", {"Color": told(tree, ASKED[asked])}).outputs[0])
    shell(lambda tree: add(tree, "Emission").outputs[0])
    compare(scene)
    give(bpy.data.objects["Plane.001"], closure("diffuse"))
    give(bpy.data.objects["Sphere"], emission(ASKED[asked]))
    compare(scene)


@pytest.mark.parametrize("name", ["diffuse", "mirror", "translucent"])
def test_straight_passages(name):
    """Transparent surfaces are counted, add to no other depth, and leave the ray's kind and length alone."""
    scene, plane = path_tracing(samples=64)
    give(plane, closure(name))
    for z in (1.0, 1.5):
        pane(z, lambda tree: add(tree, "BsdfTransparent", {"Color": (1, 1, 1, 1)}).outputs[0])
    shell(emission(("Transparent Depth", "Is Reflection Ray", "Is Diffuse Ray")))
    compare(scene)
    give(bpy.data.objects["Sphere"], emission(("Ray Length", "Ray Depth", "Is Camera Ray")))
    compare(scene)


def test_what_the_camera_sees_through_panes():
    scene, plane = path_tracing(depth=1, samples=1)
    give(plane, emission(("Transparent Depth", "Ray Length", "Is Camera Ray")))
    for z in (1.0, 1.5):
        pane(z, lambda tree: add(tree, "BsdfTransparent", {"Color": (1, 1, 1, 1)}).outputs[0])
    compare(scene, 1e-4)


def sunlit(scene):
    """Parallel light, from a little aside."""
    sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    sun.data.energy, sun.data.angle, sun.rotation_euler = 3, 0, (0.5, 0.2, 0)
    scene.collection.objects.link(sun)


@pytest.mark.parametrize(
    "names",
    [("Is Shadow Ray", "Is Camera Ray", "Ray Length"), ("Ray Depth", "Transparent Depth", "Diffuse Depth"), SIDES],
)
def test_shadow_rays(names):
    """Panes that are clear to the camera and coloured for the light."""

    def coloured(tree):
        node = add(tree, "LightPath")
        clear = add(tree, "BsdfTransparent", {"Color": (1, 1, 1, 1)})
        some = add(tree, "VectorMath", {0: told(tree, names), 1: (0.1,) * 3}, operation="ADD")
        tinted = add(tree, "BsdfTransparent", {"Color": output(some)})
        mix = add(tree, "MixShader", {0: node.outputs["Is Shadow Ray"], 1: clear.outputs[0], 2: tinted.outputs[0]})
        return mix.outputs[0]

    scene, plane = path_tracing(depth=1, samples=16)
    give(plane, closure("diffuse"))
    sunlit(scene)
    for z in (1.0, 1.5):
        pane(z, coloured)
    assert compare(scene, 1e-3).max() > 1e-3


def test_glass_that_casts_no_shadow():
    """The usual trick: glass to all rays but shadow rays."""

    def glass(tree):
        node = add(tree, "LightPath")
        solid, clear = add(tree, "BsdfRefraction", {"Roughness": 0.0, "IOR": 1.0}), add(tree, "BsdfTransparent")
        clear.inputs["Color"].default_value = (0.5, 0.8, 0.9, 1)
        mix = add(tree, "MixShader", {0: node.outputs["Is Shadow Ray"], 1: solid.outputs[0], 2: clear.outputs[0]})
        return mix.outputs[0]

    scene, plane = path_tracing(depth=2, samples=16)
    give(plane, closure("diffuse"))
    sunlit(scene)
    pane(1.0, glass)
    assert compare(scene, 0.01).min() > 0.1


@pytest.mark.parametrize("name", ["diffuse", "mirror", "frosted"])
@pytest.mark.parametrize("names", [KINDS, SIDES, DEPTHS, ("Ray Depth", "Is Shadow Ray", "Is Camera Ray")])
def test_worlds(name, names):
    scene, plane = path_tracing(samples=64)
    scene.world.cycles.sampling_method = "NONE"
    tree = scene.world.node_tree
    shine = add(tree, "Background", {"Color": told(tree, names)})
    tree.links.new(shine.outputs[0], add(tree, "OutputWorld").inputs["Surface"])
    plane.scale = (0.7, 0.7, 1)  # the camera sees the world beside it
    give(plane, closure(name))
    compare(scene)


def test_a_world_that_hides_its_sky_from_the_camera_is_sampled_for_the_rest():
    scene, plane = path_tracing(samples=64)
    tree = scene.world.node_tree
    kind = "MULTIPLE_SCATTERING" if bpy.app.version >= (5, 0) else "NISHITA"
    sky = add(tree, "TexSky", sky_type=kind, sun_elevation=0.7)
    seen, rest = add(tree, "Background", {"Color": (0.2, 0.3, 0.4, 1)}), add(tree, "Background", {"Color": output(sky)})
    camera = add(tree, "LightPath").outputs["Is Camera Ray"]
    mix = add(tree, "MixShader", {0: camera, 1: rest.outputs[0], 2: seen.outputs[0]})
    tree.links.new(mix.outputs[0], add(tree, "OutputWorld").inputs["Surface"])
    plane.scale = (0.7, 0.7, 1)
    give(plane, closure("diffuse"))
    compare(scene)


def test_emission_that_depends_on_the_view():
    """A panel that shines upwards only along its normal, sampled as a light by both."""

    def beam(tree):
        facing = add(tree, "LayerWeight", {"Blend": 0.5}).outputs["Facing"]
        inverse = add(tree, "Math", {0: 1.0, 1: facing}, operation="SUBTRACT")
        strength = add(tree, "Math", {0: output(inverse), 1: 4.0}, operation="POWER")
        return add(tree, "Emission", {"Strength": output(strength)}).outputs[0]

    scene, plane = path_tracing(depth=2, samples=256)
    give(plane, closure("diffuse"))
    pane(4.0, beam, size=4)
    bpy.context.object.data.materials[0].cycles.emission_sampling = "FRONT_BACK"
    scene.camera.location.z = 3.0
    compare(scene)


@pytest.mark.parametrize("method", ["PATHTRACE", "RAYCAST"])
@pytest.mark.parametrize("kind", ["SUN", "POINT", "AREA"])
def test_lights_without_shadow(kind, method):
    """A board between lamp and floor, beside a lamp that casts its shadow."""
    scene, plane = path_tracing(depth=1, samples=64)
    give(plane, closure("diffuse"))
    pane(2.0, closure("diffuse"), size=1)
    for name, x in (("Through", 0.5), ("Shadowed", -0.5)):
        lamp = bpy.data.lights.new(name, kind)
        lamp.energy, lamp.use_shadow = (3 if kind == "SUN" else 100), name == "Shadowed"
        if hasattr(lamp.cycles, "cast_shadow"):  # before Blender 5
            lamp.cycles.cast_shadow = lamp.use_shadow
        obj = bpy.data.objects.new(name, lamp)
        obj.location = (x, 0, 4)
        if kind != "AREA":
            setattr(lamp, *(("angle", 0) if kind == "SUN" else ("shadow_soft_size", 0)))
        scene.collection.objects.link(obj)
    scene.camera.location.z = 1.5
    theirs = compare(scene)
    if method == "RAYCAST" and kind != "AREA":
        scene.zraka.method = method
        ours, _ = operate(scene, "ZRAKA")
        np.testing.assert_allclose(ours.mean(axis=(0, 1)), theirs, rtol=0.02)


def test_another_kind_of_ray_would_be_seen():
    scene, plane = path_tracing(samples=64)
    shell(emission(KINDS))
    match(scene)
    found = []
    for engine, name in (("ZRAKA", "mirror"), ("CYCLES", "gloss")):
        give(plane, closure(name))
        found.append(operate(scene, engine)[0].mean(axis=(0, 1)))
    assert abs(found[0] - found[1]).max() > 0.1 * found[1].max()
