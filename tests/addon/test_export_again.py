# SPDX-License-Identifier: GPL-3.0-or-later
"""What changed is exported again, and nothing else; what comes out is what a first export gives."""

from __future__ import annotations

import random

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from zraka.addon.export import scene as scene_export
from zraka.addon.export.cache import ExportCache
from zraka.addon.export.moved import export_moved
from zraka.addon.export.scene import export_scene
from zraka.addon.viewport.changes import changes_scene, fingerprint
from zraka.core.compile import again
from zraka.core.diagnostics import Diagnostics

COUNT = 12


class Follower:
    """Exports as a viewport does, after each update of the dependency graph."""

    def __init__(self):
        self.cache, self.scene, self.fingerprint = ExportCache(), None, None
        self.moves = self.looks = 0

    def __call__(self, _, depsgraph):
        moved = export_moved(self.scene, depsgraph, self.cache) if self.scene else None
        if moved is not None:
            self.scene = moved
            self.moves += 1
            return
        now = fingerprint(depsgraph, lambda entry: True)
        self.cache.follow(depsgraph)
        if self.scene is None or now != self.fingerprint or changes_scene(depsgraph):
            self.scene = export_scene(depsgraph, Diagnostics(), cache=self.cache)
            self.looks += 1
        self.fingerprint = now


@pytest.fixture
def follower(blender_scene, add_camera):
    """A `Follower` of a row of tiles, of which some share a mesh, with a lamp and an instanced collection."""
    add_camera(blender_scene)
    material = bpy.data.materials.new("Paint")
    if material.node_tree is None:  # before 5.0
        material.use_nodes = True
    shared = None
    for number in range(COUNT):
        bpy.ops.mesh.primitive_plane_add(size=0.5, location=(number, 0, 0))
        tile = bpy.context.object
        tile.name = f"Tile {number}"
        shared = shared or tile.data
        if number % 3 == 0:
            tile.data = shared
        tile.data.materials.append(material)
    bpy.ops.object.light_add(type="POINT", location=(0, 0, 3))
    collection = bpy.data.collections.new("Set")
    bpy.context.scene.collection.children.link(collection)
    collection.objects.link(bpy.data.objects["Tile 1"])
    instancer = bpy.data.objects.new("Instancer", None)
    instancer.instance_type, instancer.instance_collection = "COLLECTION", collection
    instancer.location.y = 2
    bpy.context.scene.collection.objects.link(instancer)
    found = Follower()
    bpy.app.handlers.depsgraph_update_post.append(found)
    evaluate()
    yield found
    bpy.app.handlers.depsgraph_update_post.remove(found)


def evaluate():
    bpy.context.scene.update_tag()
    return bpy.context.evaluated_depsgraph_get()


def edit(function):
    function()
    bpy.context.view_layer.update()


def tile(number):
    return bpy.data.objects[f"Tile {number}"]


def assert_as_first(follower):
    """Equal to an export without a cache but for meshes and materials, which are compared by what they hold."""
    fresh = export_scene(bpy.context.evaluated_depsgraph_get(), Diagnostics())
    kept = follower.scene
    assert [i.name for i in kept.instances] == [i.name for i in fresh.instances]
    for one, other in zip(kept.instances, fresh.instances, strict=True):
        assert again._same(one, other, but=("mesh", "materials")), one.name
        np.testing.assert_array_equal(one.mesh.vertices, other.mesh.vertices)
        assert [m.name for m in one.materials] == [m.name for m in other.materials]
    assert again._same(kept.lights, fresh.lights)
    assert again._same(kept.planes, fresh.planes, but=("material",))


def test_of_many_objects_the_one_that_moved_is_looked_at(follower, monkeypatch):
    before = follower.scene
    monkeypatch.setattr(scene_export, "export_scene", None)
    edit(lambda: setattr(tile(5).location, "z", 1.0))
    assert (follower.moves, follower.looks) == (1, 1)
    same = [a is b for a, b in zip(before.instances, follower.scene.instances, strict=True)]
    assert same.count(False) == 1
    assert follower.scene.instances[same.index(False)].name == "Tile 5"
    assert_as_first(follower)


def test_of_a_parent_the_children_move(follower):
    def parent():
        tile(4).parent = tile(2)

    edit(parent)
    moves = follower.moves
    edit(lambda: setattr(tile(2).location, "y", 3.0))
    assert follower.moves == moves + 1
    assert_as_first(follower)


@pytest.mark.parametrize("name", ["Tile 1", "Instancer"])
def test_instances_follow_what_they_are_made_of(follower, name):
    edit(lambda: setattr(bpy.data.objects[name].location, "z", 2.0))
    assert follower.looks == 2
    assert_as_first(follower)


def test_of_many_objects_the_others_stay_when_one_is_hidden(follower):
    """Blender names all of them then."""
    before = {instance.name: instance for instance in follower.scene.instances}
    edit(lambda: setattr(tile(4), "hide_viewport", True))
    after = {instance.name: instance for instance in follower.scene.instances}
    assert before.keys() - after.keys() == {"Tile 4"}
    assert all(after[name] is before[name] for name in after)
    assert_as_first(follower)


def test_what_an_object_says_of_itself_is_followed(follower):
    edit(lambda: setattr(tile(4), "visible_glossy", False))
    assert_as_first(follower)
    material = tile(4).active_material
    nodes, links = material.node_tree.nodes, material.node_tree.links
    shader = next(node for node in nodes if node.type.startswith("BSDF"))
    edit(lambda: links.new(nodes.new("ShaderNodeObjectInfo").outputs["Color"], shader.inputs[0]))
    edit(lambda: setattr(tile(4), "color", (0.1, 0.2, 0.3, 1.0)))
    info = next(instance.info for instance in follower.scene.instances if instance.name == "Tile 4")
    assert info.color == pytest.approx((0.1, 0.2, 0.3, 1.0))
    assert_as_first(follower)


def test_what_nothing_named_is_not_exported_again(follower):
    before = follower.scene
    edit(lambda: setattr(bpy.data.lights[0], "energy", 7.0))
    assert follower.looks == 2
    assert all(a is b for a, b in zip(before.instances, follower.scene.instances, strict=True))
    assert follower.scene.lights != before.lights


def test_a_collection_becomes_a_holdout(follower):
    edit(lambda: setattr(bpy.context.view_layer.layer_collection.children["Set"], "holdout", True))
    assert sum(i.visibility.holdout for i in follower.scene.instances) == 2
    assert_as_first(follower)


def test_a_material_that_reads_where_an_object_is_moves_with_it(follower):
    """Its graph holds the object's matrix, and no update names it."""
    material = bpy.data.materials["Paint"]
    tree = material.node_tree
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    coordinates.object = tile(7)
    shader = next(node for node in tree.nodes if node.type.startswith("BSDF"))
    edit(lambda: tree.links.new(coordinates.outputs["Object"], shader.inputs[0]))
    before = follower.scene.instances[0].materials[0]
    edit(lambda: setattr(tile(7).location, "z", 1.0))
    assert follower.moves == 0
    assert follower.scene.instances[0].materials[0] is not before


def random_edit(rng):
    """Something that a user does to one of the tiles."""
    thing = bpy.data.objects[rng.choice([o.name for o in bpy.data.objects if o.type in ("MESH", "EMPTY")])]
    kind = rng.randrange(10)
    if kind < 4:
        thing.matrix_world = Matrix.Rotation(rng.uniform(0, 6), 4, "XYZ"[rng.randrange(3)]) @ thing.matrix_world
    elif kind == 4:
        thing.hide_viewport = not thing.hide_viewport
    elif kind == 5:
        thing.visible_camera = not thing.visible_camera
    elif kind == 6 and thing.type == "MESH":
        thing.data.vertices[0].co.z += 0.1
        thing.data.update()
    elif kind == 7 and thing.type == "MESH":
        bpy.context.scene.collection.objects.link(thing.copy())
    elif kind == 8 and thing.type == "MESH":
        thing.material_slots[0].link = "OBJECT"
        thing.material_slots[0].material = bpy.data.materials.new("Other")
    elif kind == 9 and thing.name != "Tile 1" and len(bpy.data.objects) > COUNT:
        bpy.data.objects.remove(thing)


@pytest.mark.parametrize("seed", range(3))
def test_random_edits(follower, seed):
    rng = random.Random(seed)
    for _ in range(40):
        edit(lambda: random_edit(rng))
        assert_as_first(follower)
    assert follower.moves > 3
    assert follower.looks > 3
