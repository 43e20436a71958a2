# SPDX-License-Identifier: GPL-3.0-or-later
"""Animations: with persistent data only what changed is exported and compiled again, and every frame is right."""

from __future__ import annotations

import warnings
from collections import Counter

import bpy
import numpy as np
import pytest

from zraka.addon import headless, session
from zraka.addon.export import material as material_export
from zraka.addon.export import scene as scene_export
from zraka.core.compile import scene as compiled_scene


@pytest.fixture
def counts(monkeypatch):
    """How often each thing was exported, by name, and how many trees were built; pictures by frame."""
    seen = Counter()

    def counted(module, name, key):
        original = getattr(module, name)

        def call(*args, **kwargs):
            seen[key(*args)] += 1
            return original(*args, **kwargs)

        monkeypatch.setattr(module, name, call)

    counted(scene_export, "export_mesh", lambda obj, name, needs: f"mesh {obj.name}")
    counted(material_export, "export_material", lambda thing, *_: f"material {thing.name}")
    counted(scene_export, "export_world", lambda world, *_: "world")
    counted(compiled_scene, "Accel", lambda geometry: "tree")
    return seen


@pytest.fixture
def films(monkeypatch):
    """The pictures of all frames, (H, W, 4) each."""
    pictures = []
    original = session.Display.close

    def close(self, film, guides=None, names=None):
        pictures.append(film.image())
        original(self, film, guides, names)

    monkeypatch.setattr(session.Display, "close", close)
    return pictures


def with_nodes(thing):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        thing.use_nodes = True
    return thing


def emit(obj, strength=1.0):
    material = with_nodes(bpy.data.materials.new(obj.name))
    tree = material.node_tree
    tree.nodes.clear()
    node, output = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
    node.inputs["Strength"].default_value = strength
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    obj.data.materials.append(material)
    return node


def keyed(owner, name, *values):
    """Set a property at frames 1, 2, 3..."""
    for frame, value in enumerate(values, 1):
        setattr(owner, name, value)
        owner.keyframe_insert(name, frame=frame)


@pytest.fixture
def scene(blender_scene, add_camera, tmp_path):
    """Two tiles seen from above, of which none moves, 16 x 12 pixels, frames 1 to 4."""
    scene = blender_scene
    add_camera(scene)
    for name, x in (("Still", -0.7), ("Mover", 0.7)):
        bpy.ops.mesh.primitive_plane_add(size=1, location=(x, 0, 0))
        bpy.context.object.name = name
        emit(bpy.context.object)
    scene.world = with_nodes(bpy.data.worlds.new("World"))
    render = scene.render
    render.resolution_x, render.resolution_y = 16, 12
    render.threads_mode, render.threads = "FIXED", 1
    render.filepath = str(tmp_path / "frame")
    render.use_persistent_data = True
    scene.zraka.samples = 4
    scene.frame_start, scene.frame_end = 1, 4
    return scene


def animate():
    with headless.quiet():
        bpy.ops.render.render(animation=True)


def assert_right(scene, films):
    """Frames rendered with persistent data are those rendered without."""
    animate()
    kept = films[:]
    films.clear()
    scene.render.use_persistent_data = False
    animate()
    assert len(kept) == len(films) > 1
    for one, other in zip(kept, films, strict=True):
        np.testing.assert_array_equal(one, other)
    return kept


def test_still_objects_are_exported_once(scene, counts, films):
    scene.frame_end = 24
    keyed(bpy.data.objects["Mover"], "location", *((0.7 + 0.01 * i, 0, 0) for i in range(24)))
    animate()
    assert counts["mesh Still"] == counts["mesh Mover"] == 1
    assert counts["material Still"] == counts["material Mover"] == counts["world"] == 1
    assert counts["tree"] == len(films) == 24
    counts.clear()
    scene.render.use_persistent_data = False
    animate()
    assert counts["mesh Still"] == counts["material Still"] == counts["world"] == 24
    for one, other in zip(films[:24], films[24:], strict=True):
        np.testing.assert_array_equal(one, other)
    assert any((films[0] != film).any() for film in films[1:24])


def test_only_the_camera_moves(scene, counts, films):
    keyed(scene.camera, "location", (0, 0, 5), (0.2, 0, 5), (0.4, 0, 5), (0.6, 0, 5))
    kept = assert_right(scene, films)
    assert counts["tree"] == 1 + 4
    assert not np.array_equal(kept[0], kept[3])


def test_a_lamp_keeps_the_tree(scene, counts, films):
    light = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    light.data.energy = 100
    scene.collection.objects.link(light)
    bpy.ops.mesh.primitive_plane_add(size=20, location=(0, 0, -1))
    keyed(light, "location", (-1, 0, 2), (0, 0, 2), (1, 0, 2), (2, 0, 2))
    keyed(light.data, "energy", 100, 50, 25, 10)
    assert_right(scene, films)
    assert counts["tree"] == 1 + 4


def change_shape(scene):
    mover = bpy.data.objects["Mover"]
    mover.shape_key_add(name="Basis")
    key = mover.shape_key_add(name="Long")
    for point in key.data:
        point.co.y *= 3
    keyed(key, "value", 0, 0.3, 0.6, 1)


def change_color(scene):
    node = bpy.data.materials["Mover"].node_tree.nodes["Emission"].inputs["Strength"]
    keyed(node, "default_value", 1, 2, 3, 4)


def drive_color(scene):
    node = bpy.data.materials["Mover"].node_tree.nodes["Emission"].inputs["Strength"]
    driver = node.driver_add("default_value").driver
    variable = driver.variables.new()
    variable.name, variable.type = "x", "TRANSFORMS"
    variable.targets[0].id = bpy.data.objects["Mover"]
    variable.targets[0].transform_type = "LOC_X"
    driver.expression = "x"
    keyed(bpy.data.objects["Mover"], "location", (0.7, 0, 0), (0.8, 0, 0), (0.9, 0, 0), (1, 0, 0))


def change_group(scene):
    """The strength comes out of a node group in a node group."""
    inner = None
    for name in ("Inner", "Outer"):
        group = bpy.data.node_groups.new(name, "ShaderNodeTree")
        group.interface.new_socket("Value", in_out="OUTPUT", socket_type="NodeSocketFloat")
        source = group.nodes.new("ShaderNodeGroup" if inner else "ShaderNodeValue")
        if inner:
            source.node_tree = inner
        else:
            keyed(source.outputs[0], "default_value", 1, 2, 3, 4)
        group.links.new(source.outputs[0], group.nodes.new("NodeGroupOutput").inputs[0])
        inner = group
    tree = bpy.data.materials["Mover"].node_tree
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = inner
    tree.links.new(node.outputs[0], tree.nodes["Emission"].inputs["Strength"])


def change_world(scene):
    keyed(scene.world.node_tree.nodes["Background"].inputs["Strength"], "default_value", 1, 2, 3, 4)


def follow_object(scene):
    """Texture coordinates are those of an object that moves."""
    tree = bpy.data.materials["Still"].node_tree
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    coordinates.object = bpy.data.objects["Mover"]
    tree.links.new(coordinates.outputs["Object"], tree.nodes["Emission"].inputs["Color"])
    keyed(bpy.data.objects["Mover"], "location", (-3, -3, 0), (-2, -2, 0), (-1.6, -2, 0), (-2, -3, 0))


def hide(scene):
    keyed(bpy.data.objects["Mover"], "hide_render", False, True, True, False)


def wave(scene):
    bpy.data.objects["Mover"].modifiers.new("Wave", "WAVE")
    bpy.data.objects["Mover"].location.z = 1


def lens(scene):
    keyed(scene.camera.data, "lens", 30, 40, 50, 60)


def markers(scene):
    """Another camera takes over at frame 3."""
    other = bpy.data.objects.new("Other", bpy.data.cameras.new("Other"))
    other.location = (0.5, 0, 4)
    scene.collection.objects.link(other)
    for frame, camera in ((1, scene.camera), (3, other)):
        scene.timeline_markers.new(camera.name, frame=frame).camera = camera


def instances(scene):
    """A collection is shown in several places, of which one moves."""
    collection = bpy.data.collections.new("Tiles")
    collection.objects.link(bpy.data.objects["Mover"])
    for y in (-1, 1):
        empty = bpy.data.objects.new("Empty", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", collection
        scene.collection.objects.link(empty)
        keyed(empty, "location", *((0.2 * i, y, 0) for i in range(4)))


CHANGES = (change_shape, change_color, drive_color, change_group, change_world, follow_object, hide, wave, lens)
BLURRED = (change_shape, change_color, drive_color, follow_object, hide)


@pytest.mark.parametrize("change", [*CHANGES, markers, instances], ids=lambda f: f.__name__)
def test_what_changes_is_seen(scene, films, change):
    change(scene)
    kept = assert_right(scene, films)
    assert not np.array_equal(kept[0], kept[2])


def test_a_border_and_steps_of_frames(scene, films):
    scene.frame_end, scene.frame_step = 7, 3
    scene.render.use_border, scene.render.border_max_x = True, 0.5
    keyed(scene.camera, "location", *((0.2 * i, 0, 5) for i in range(7)))
    kept = assert_right(scene, films)
    assert [film.shape for film in kept] == [(12, 8, 4)] * 3
    assert not np.array_equal(kept[0], kept[2])


@pytest.mark.parametrize("change", BLURRED, ids=lambda f: f.__name__)
def test_the_same_with_motion_blur(scene, films, change):
    scene.render.use_motion_blur, scene.zraka.samples = True, 8
    change(scene)
    kept = assert_right(scene, films)
    assert not np.array_equal(kept[0], kept[2])


def test_two_view_layers(scene, films):
    layer = scene.view_layers.new("Second")
    layer.material_override = bpy.data.materials["Still"]
    change_color(scene)
    kept = assert_right(scene, films)
    assert len(kept) == 8
    assert not np.array_equal(kept[4], kept[5])


def test_edits_between_two_renders(scene, films):
    """Persistent data lasts until the file is closed."""

    def render():
        with headless.quiet():
            bpy.ops.render.render()
        return films[-1]

    first = render()
    np.testing.assert_array_equal(render(), first)
    mesh = bpy.data.objects["Mover"].data
    mesh.vertices[0].co.x -= 0.5
    mesh.update()
    second = render()
    bpy.data.materials["Still"].node_tree.nodes["Emission"].inputs["Strength"].default_value = 3
    third = render()
    bpy.data.objects.remove(bpy.data.objects["Mover"])
    fourth = render()
    for one, other in ((first, second), (second, third), (third, fourth)):
        assert not np.array_equal(one, other)
