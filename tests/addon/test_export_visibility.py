# SPDX-License-Identifier: GPL-3.0-or-later
"""Where Blender keeps who sees what, and what becomes of it."""

from __future__ import annotations

import bpy
import pytest

from zraka.core.diagnostics import Diagnostics
from zraka.core.visibility import ALL_RAYS, LAMP, SEEN_BY_ALL, UNLIMITED, ObjectSet, Rays

from .test_export_objects import add, export, quads, with_camera


@pytest.fixture
def scene():
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    return with_camera(bpy.context.scene)


def collection_of(*objects):
    collection = bpy.data.collections.new("Set")
    for obj in objects:
        collection.objects.link(obj)
    return collection


def test_defaults(scene):
    add(scene, "Quad", quads())
    add(scene, "Lamp", bpy.data.lights.new("Lamp", "POINT"))
    scene.world = bpy.data.worlds.new("World")
    diagnostics = Diagnostics()
    exported = export(diagnostics)
    assert exported.lights[0].visibility.rays == LAMP.rays
    assert exported.instances[0].visibility.rays == ALL_RAYS
    assert exported.world.visibility == SEEN_BY_ALL
    assert exported.lights[0].visibility.max_bounces == UNLIMITED
    assert diagnostics.messages() == []


@pytest.mark.parametrize("kind", ["camera", "diffuse", "glossy", "transmission", "shadow"])
def test_rays(scene, kind):
    ray = Rays[kind.upper()]
    for name, data in (("Quad", quads()), ("Lamp", bpy.data.lights.new("Lamp", "AREA"))):
        obj = add(scene, name, data)
        setattr(obj, f"visible_{kind}", False)
    diagnostics = Diagnostics()
    exported = export(diagnostics)
    assert exported.instances[0].visibility.rays == ALL_RAYS & ~ray
    assert exported.lights[0].visibility.rays == LAMP.rays & ~ray
    assert diagnostics.messages() == []


@pytest.mark.parametrize("kind", ["camera", "diffuse", "glossy", "transmission"])
def test_worlds(scene, kind):
    scene.world = bpy.data.worlds.new("World")
    setattr(scene.world.cycles_visibility, kind, False)
    scene.world.cycles.max_bounces = 3
    visibility = export().world.visibility
    assert visibility.rays == ALL_RAYS & ~Rays[kind.upper()]
    assert visibility.max_bounces == 3


def test_bounces_of_a_light(scene):
    lamp = add(scene, "Lamp", bpy.data.lights.new("Lamp", "SPOT"))
    lamp.data.cycles.max_bounces = 2
    assert export().lights[0].visibility.max_bounces == 2


def test_instances_are_hidden_from_what_their_instancer_is_hidden_from(scene):
    child = bpy.data.objects.new("Child", quads())
    child.visible_glossy = False
    empty = add(scene, "Empty", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", collection_of(child)
    empty.visible_camera = False
    (instance,) = export().instances
    assert instance.visibility.rays == ALL_RAYS & ~Rays.CAMERA & ~Rays.GLOSSY


def test_collections_that_are_indirect_only_or_hold_out(scene):
    for name in ("indirect_only", "holdout"):
        collection = bpy.data.collections.new(name)
        scene.collection.children.link(collection)
        collection.objects.link(bpy.data.objects.new(name, quads()))
        setattr(bpy.context.view_layer.layer_collection.children[name], name, True)
    add(scene, "own", quads()).is_holdout = True
    found = {i.name: i.visibility for i in export().instances}
    assert found["indirect_only"].rays == ALL_RAYS & ~Rays.CAMERA
    assert {name for name, v in found.items() if v.holdout} == {"holdout", "own"}


def test_shadow_catchers_and_their_lights(scene):
    """As in Cycles an instance is a catcher where its instancer is one, and lights belong to catchers by default."""
    child = bpy.data.objects.new("Child", quads())
    library = collection_of(child)
    for name in ("catcher", "plain"):
        empty = add(scene, name, None)
        empty.instance_type, empty.instance_collection = "COLLECTION", library
        empty.is_shadow_catcher = name == "catcher"
    add(scene, "Floor", quads()).is_shadow_catcher = True
    for name in ("real", "made"):
        add(scene, name, bpy.data.lights.new(name, "POINT"))
    bpy.data.objects["made"].is_shadow_catcher = False
    diagnostics = Diagnostics()
    exported = export(diagnostics)
    assert sorted((i.name, i.visibility.catcher) for i in exported.instances) == [
        ("Child", False),
        ("Child", True),
        ("Floor", True),
    ]
    assert {light.name: light.visibility.catcher for light in exported.lights} == {"real": True, "made": False}
    assert diagnostics.messages() == []


@pytest.mark.parametrize("role", ["receiver", "blocker"])
@pytest.mark.parametrize("kind", ["light", "mesh"])
def test_linking(scene, role, kind):
    a, b, c = (add(scene, name, quads()) for name in "abc")
    nested = collection_of(b)
    linked = collection_of(a)
    linked.children.link(nested)
    emitter = c if kind == "mesh" else add(scene, "Lamp", bpy.data.lights.new("Lamp", "SUN"))

    def found():
        exported = export()
        things = {t.name: t.visibility for t in (*exported.instances, *exported.lights)}
        return getattr(things[emitter.name], f"{role}s")

    assert found() is None
    setattr(emitter.light_linking, f"{role}_collection", linked)
    assert found() == ObjectSet(frozenset({"a", "b"}))
    linked.collection_children[0].light_linking.link_state = "EXCLUDE"
    assert found() == ObjectSet(frozenset({"a"}))
    linked.collection_objects[0].light_linking.link_state = "EXCLUDE"
    assert found() == ObjectSet(frozenset({"a", "b"}), excluded=True)
    linked.objects.unlink(a)
    linked.children.unlink(nested)
    assert "a" in found()


def test_instances_are_found_by_their_instancer_where_it_is_linked(scene):
    child = bpy.data.objects.new("Child", quads())
    library = collection_of(child)
    lamp = add(scene, "Lamp", bpy.data.lights.new("Lamp", "SUN"))
    for name in ("One", "Two"):
        empty = add(scene, name, None)
        empty.instance_type, empty.instance_collection = "COLLECTION", library
    lamp.light_linking.receiver_collection = collection_of(empty)
    assert {i.visibility.receives_as for i in export().instances} == {"Child", "Two"}
    assert {i.visibility.blocks_as for i in export().instances} == {"Child"}
