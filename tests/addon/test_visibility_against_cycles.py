# SPDX-License-Identifier: GPL-3.0-or-later
"""Who sees what, beside Cycles.

A floor, a box, a mirror, a glass box and a lamp; means of blocks of pixels within 2% of the brightest. Lamps are points
where they may be, which mirrors and glass do not throw elsewhere, so that little is left to chance.
"""

from __future__ import annotations

import warnings

import bpy
import numpy as np
import pytest

from zraka.addon.bench.engines import match, operate, watched

from .nodes.harness import add, fresh_scene

SIDE, BLOCKS = 24, 4


def give(obj, kind, **inputs):
    """Give an object a material of one shader node."""
    material = bpy.data.materials.new(kind)
    tree = tree_of(material)
    shader, output = add(tree, kind, inputs), add(tree, "OutputMaterial")
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    obj.data.materials.clear()
    obj.data.materials.append(material)


def tree_of(owner):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        owner.use_nodes = True
    owner.node_tree.nodes.clear()
    return owner.node_tree


def cube(name, location, size, kind="BsdfDiffuse", **inputs):
    bpy.ops.mesh.primitive_cube_add(size=size, location=location)
    bpy.context.object.name = name
    give(bpy.context.object, kind, **inputs)


@pytest.fixture
def scene():
    scene = fresh_scene()
    scene.render.resolution_x = scene.render.resolution_y = SIDE
    scene.zraka.method, scene.zraka.depth, scene.zraka.samples = "PATHTRACE", 3, 100
    camera = scene.camera
    camera.data.type, camera.data.lens = "PERSP", 50
    camera.location, camera.rotation_euler = (0, -6, 3.5), (1.05, 0, 0)
    scene.world = bpy.data.worlds.new("World")
    tree = tree_of(scene.world)
    background, output = add(tree, "Background", {"Color": (0.2, 0.3, 0.4, 1)}), add(tree, "OutputWorld")
    tree.links.new(background.outputs[0], output.inputs["Surface"])
    bpy.ops.mesh.primitive_plane_add(size=12)
    bpy.context.object.name = "Floor"
    give(bpy.context.object, "BsdfPrincipled", Roughness=0.4)
    cube("Box", (0, 0, 0.7), 1.2, Color=(0.8, 0.2, 0.2, 1))
    cube("Mirror", (-1.6, 0, 0.7), 1.2, "BsdfAnisotropic", Color=(0.9, 0.9, 0.9, 1), Roughness=0.0)
    cube("Glass", (0.6, -2, 0.5), 0.8, "BsdfGlass", Color=(1, 1, 1, 1), Roughness=0.0, IOR=1.05)
    lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    lamp.data.energy, lamp.data.shadow_soft_size, lamp.location = 200, 0, (1.5, -1, 3.5)
    scene.collection.objects.link(lamp)
    return scene


def large_lamp(location, turn, size, energy=200):
    """Put an area lamp in the place of the other, before surfaces that throw no light about."""
    bpy.data.objects["Mirror"].hide_render = bpy.data.objects["Glass"].hide_render = True
    lamp = bpy.data.objects["Lamp"]
    lamp.data = bpy.data.lights.new("Area", "AREA")
    lamp.data.energy, lamp.data.size = energy, size
    lamp.location, lamp.rotation_euler = location, (turn, 0, 0)


def means(picture):
    """Means of blocks of pixels, (BLOCKS, BLOCKS, 3)."""
    width = SIDE // BLOCKS
    return picture.reshape(BLOCKS, width, BLOCKS, width, 3).mean(axis=(1, 3))


def compare(scene, tolerance=0.02):
    """Assert that both engines agree; returns the means of Zraka's blocks."""
    match(scene)
    bpy.context.view_layer.update()
    with watched() as seen:
        ours = means(operate(scene, "ZRAKA")[0])
    assert seen.messages == []
    theirs = means(operate(scene, "CYCLES")[0])
    difference = float(np.abs(ours - theirs).max() / theirs.max())
    print(f"blocks differ by at most {difference:.2%}, the mean by {ours.mean() / theirs.mean() - 1:.2%}")
    assert difference < tolerance
    return ours


def changes(scene, change, tolerance=0.02):
    """Compare the scene after ``change(objects)``, which must show."""
    before = means(operate(scene, "ZRAKA")[0])
    change(bpy.data.objects)
    assert np.abs(compare(scene, tolerance) - before).max() > 1.5 * tolerance * before.max()


def collection(*names, exclude=False):
    made = bpy.data.collections.new("Set")
    for k, name in enumerate(names):
        made.objects.link(bpy.data.objects[name])
        made.collection_objects[k].light_linking.link_state = "EXCLUDE" if exclude else "INCLUDE"
    return made


@pytest.mark.parametrize("kind", ["camera", "diffuse", "glossy", "transmission", "shadow"])
def test_objects(scene, kind):
    floor_shows = kind == "diffuse"  # what lies beside the box is dark where diffuse rays meet it

    def hide(objects):
        setattr(objects["Floor" if floor_shows else "Box"], f"visible_{kind}", False)

    if kind == "transmission":
        bpy.data.objects["Glass"].location = (0, -1.2, 0.6)
    changes(scene, hide, 0.01)


@pytest.mark.parametrize("kind", ["diffuse", "glossy", "transmission", "camera"])
def test_lamps(scene, kind):
    large_lamp((0, 2, 0.8), -1.4, 2, 50)
    if kind == "transmission":
        give(bpy.data.objects["Box"], "BsdfRefraction", Color=(1, 1, 1, 1), Roughness=0.5, IOR=1.1)
        scene.zraka.samples = 800  # at 100, noise alone is up to 4% in some Blenders
    changes(scene, lambda objects: setattr(objects["Lamp"], f"visible_{kind}", kind == "camera"))


@pytest.mark.parametrize("kind", ["camera", "diffuse", "glossy", "transmission"])
def test_worlds(scene, kind):
    bpy.data.objects["Lamp"].data.energy = 1
    changes(scene, lambda _: setattr(scene.world.cycles_visibility, kind, False))


@pytest.mark.parametrize("role", ["receiver", "blocker"])
@pytest.mark.parametrize("exclude", [False, True])
def test_linking(scene, role, exclude):
    bpy.data.objects["Lamp"].location = (1.5, 0, 2.5)
    linked = ("Box",) if exclude else ("Floor", "Glass")
    settings = bpy.data.objects["Lamp"].light_linking
    changes(scene, lambda _: setattr(settings, f"{role}_collection", collection(*linked, exclude=exclude)))


@pytest.mark.parametrize("role", ["receiver", "blocker"])
def test_linking_of_emitting_meshes(scene, role):
    bpy.data.objects["Lamp"].data.energy = 1
    bpy.data.objects["Mirror"].hide_render = bpy.data.objects["Glass"].hide_render = True
    bpy.ops.mesh.primitive_plane_add(size=0.5, location=(1.5, 0, 2.5))
    give(bpy.context.object, "Emission", Strength=200.0)
    settings = bpy.context.object.light_linking
    changes(scene, lambda _: setattr(settings, f"{role}_collection", collection("Box", exclude=True)))


@pytest.mark.parametrize("kind", ["camera", "diffuse", "glossy", "shadow"])
def test_emitting_meshes(scene, kind):
    bpy.data.objects["Lamp"].data.energy = 1
    bpy.data.objects["Mirror"].hide_render = bpy.data.objects["Glass"].hide_render = True
    bpy.ops.mesh.primitive_plane_add(size=1, location=(1.2, 0, 1.5))
    give(bpy.context.object, "Emission", Strength=20.0)
    emitter = bpy.context.object
    if kind == "shadow":
        bpy.data.objects["Lamp"].data.energy, bpy.data.objects["Lamp"].location = 400, (1.2, 0, 3)
    elif kind == "camera":
        scene.zraka.samples = 800  # the light on the box is all that is left, and noise 1% at 100
    changes(scene, lambda _: setattr(emitter, f"visible_{kind}", False), 0.01)


@pytest.mark.parametrize("bounces", [0, 1])
def test_bounces_of_a_lamp(scene, bounces):
    """Of a point: Cycles limits how lamps are sampled, not how they are met."""
    floor = bpy.data.objects["Floor"]
    give(floor, "BsdfDiffuse", Color=(0.9, 0.9, 0.9, 1))
    bpy.data.objects["Mirror"].location.y = -1
    changes(scene, lambda objects: setattr(objects["Lamp"].data.cycles, "max_bounces", bounces))


@pytest.mark.parametrize("alpha", [1.0, 0.4])
@pytest.mark.parametrize("film", [False, True])
def test_holdouts(scene, alpha, film):
    scene.render.film_transparent = film
    give(bpy.data.objects["Box"], "BsdfPrincipled", Alpha=alpha)
    changes(scene, lambda objects: setattr(objects["Box"], "is_holdout", True))


def test_indirect_only(scene):
    hidden = bpy.data.collections.new("Hidden")
    scene.collection.children.link(hidden)
    hidden.objects.link(bpy.data.objects["Box"])
    scene.collection.objects.unlink(bpy.data.objects["Box"])
    layer = bpy.context.view_layer.layer_collection.children["Hidden"]
    changes(scene, lambda _: setattr(layer, "indirect_only", True))
