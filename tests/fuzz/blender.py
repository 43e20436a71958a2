# SPDX-License-Identifier: GPL-3.0-or-later
"""Random scenes made in Blender, exported and rendered the way the command line does it."""

from __future__ import annotations

import argparse
import logging
import warnings

import bpy

import zraka
from zraka.addon import headless
from zraka.core.diagnostics import SceneError
from zraka.core.settings import METHODS

from .check import check, check_sentence
from .numbers import Numbers

SHADERS = sorted(name for name in dir(bpy.types) if name.startswith("ShaderNode") and name != "ShaderNodeTree")
_PRIMITIVES = ("cube", "ico_sphere", "monkey", "plane", "torus", "cone", "grid", "circle", "uv_sphere")
_OTHERS = ("CURVE", "SURFACE", "META", "FONT", "EMPTY", "LATTICE", "SPEAKER", "LIGHT_PROBE", "ARMATURE", "CAMERA")
_MODIFIERS = (
    "ARRAY",
    "BEVEL",
    "DECIMATE",
    "MIRROR",
    "SCREW",
    "SKIN",
    "SOLIDIFY",
    "SUBSURF",
    "WIREFRAME",
    "TRIANGULATE",
)
_MODIFIERS = (*_MODIFIERS, "BUILD", "CAST", "DISPLACE", "EXPLODE", "REMESH", "SHRINKWRAP", "WAVE", "WELD", "EDGE_SPLIT")


def check_blender(seed):
    """Make, export and render the scene of a seed."""
    numbers = Numbers(seed)
    logging.disable(logging.CRITICAL)
    with headless.quiet(), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of Blender's own Python
        scene = random_scene(numbers)
    names = ("method", "samples", "depth", "threads", "seed", "time_limit", "size", "frame", "camera")
    args = argparse.Namespace(**dict.fromkeys(names))
    args.size, args.samples, args.threads = (8, 6), 2, 1
    try:
        job = headless.export(bpy, scene, args)
    except SceneError as error:
        check_sentence(error)
        return
    check(job.scene, job.settings, False, seed % 8 == 0, (numbers.choice(METHODS), "pathtrace"))


def random_scene(numbers):
    """A fresh file with a scene of random things."""
    zraka.register()
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "ZRAKA"
    materials = [_material(numbers, n) for n in range(1 + numbers.count(4))]
    for n in range(1 + numbers.count(6)):
        _dress(numbers, scene, _object(numbers, scene, n), materials)
    for n in range(numbers.count(3)):
        _light(numbers, scene, n)
    if numbers.chance(0.9):
        _camera(numbers, scene)
    if numbers.chance(0.3):
        _instances(numbers, scene)
    _world(numbers, scene)
    _shuffle(numbers, scene.zraka, 0.1, skip=("samples", "depth", "threads", "time_limit"))
    _shuffle(numbers, scene.render, 0.03, skip=("engine", "filepath", "threads", "threads_mode"))
    scene.render.use_motion_blur = scene.render.use_multiview = False
    return scene


# -- settings of any kind ----------------------------------------------------------------------------------------------


def _shuffle(numbers, thing, probability, skip=()):
    """Give properties of a Blender struct other values, each with that probability."""
    for prop in thing.bl_rna.properties:
        name = prop.identifier
        if prop.is_readonly or name in skip or name.startswith(("rna_", "bl_")) or not numbers.chance(probability):
            continue
        value = _value(numbers, prop)
        if value is not None:
            try:
                setattr(thing, name, value)
            except (AttributeError, TypeError, ValueError, RuntimeError):
                continue  # which of them Blender takes now depends on others


def _value(numbers, prop):
    """A value that a property may have, None where it is no plain one."""
    array = getattr(prop, "array_length", 0)
    if prop.type == "BOOLEAN" and not array:
        return numbers.chance(0.5)
    if prop.type == "ENUM" and not prop.is_enum_flag:
        items = [item.identifier for item in prop.enum_items]
        return numbers.choice(items) if items else None
    if prop.type == "FLOAT":
        return numbers.vector(array) if array else numbers.number()
    if prop.type == "INT" and not array:
        low, high = max(prop.soft_min, -100), min(prop.soft_max, 6)
        return int(numbers.rng.integers(low, max(low, high) + 1))
    return None


# -- things ------------------------------------------------------------------------------------------------------------


def _object(numbers, scene, number):
    """An object of a random type."""
    if numbers.chance(0.65):
        kind = numbers.choice(_PRIMITIVES)
        add = getattr(bpy.ops.mesh, f"primitive_{kind}_add")
        add(**({"subdivisions": 2} if kind == "ico_sphere" else {}))
        return bpy.context.object
    kind = numbers.choice((*_OTHERS, "SOUP", "SOUP", "POINTCLOUD", "CURVES", "GREASEPENCIL", "VOLUME"))
    makers = {
        "CURVE": lambda: bpy.ops.curve.primitive_bezier_circle_add(),
        "SURFACE": lambda: bpy.ops.surface.primitive_nurbs_surface_sphere_add(),
        "META": lambda: bpy.ops.object.metaball_add(),
        "FONT": lambda: bpy.ops.object.text_add(),
        "EMPTY": lambda: bpy.ops.object.empty_add(),
        "LATTICE": lambda: bpy.ops.object.add(type="LATTICE"),
        "SPEAKER": lambda: bpy.ops.object.speaker_add(),
        "LIGHT_PROBE": lambda: bpy.ops.object.lightprobe_add(),
        "ARMATURE": lambda: bpy.ops.object.armature_add(),
        "CAMERA": lambda: bpy.ops.object.camera_add(),
        "POINTCLOUD": lambda: bpy.ops.object.pointcloud_random_add(),
        "CURVES": lambda: bpy.ops.object.curves_random_add(),
        "GREASEPENCIL": lambda: bpy.ops.object.grease_pencil_add(type="MONKEY"),
        "VOLUME": lambda: bpy.ops.object.volume_add(),
    }
    if kind in makers:
        try:
            makers[kind]()
        except (RuntimeError, AttributeError):  # an operator that this Blender does not have
            bpy.ops.object.empty_add()
        return bpy.context.object
    return _soup(numbers, scene, number)


def _soup(numbers, scene, number):
    """A mesh of random corners, edges and faces, some without either."""
    count = numbers.count(30)
    data = bpy.data.meshes.new(f"Soup {number}")
    faces = []
    if count > 3:
        for _ in range(numbers.count(20)):
            faces.append(numbers.rng.choice(count, int(numbers.rng.integers(3, min(count, 7))), replace=False).tolist())
    data.from_pydata(numbers.array((count, 3)).tolist(), [], faces)
    for name, kind, domain in (("heat", "FLOAT", "POINT"), ("paint", "FLOAT_COLOR", "CORNER"), ("n", "INT", "FACE")):
        if numbers.chance(0.4):
            data.attributes.new(name, kind, domain)
    if numbers.chance(0.5):
        data.uv_layers.new(name="UVMap")
    obj = bpy.data.objects.new(f"Soup {number}", data)
    scene.collection.objects.link(obj)
    return obj


def _dress(numbers, scene, obj, materials):
    """Place an object, give it materials and modifiers."""
    matrix = numbers.matrix()
    if obj.type != "META":  # Blender cuts large ones into cells of a fixed size, for ever
        obj.matrix_world = [list(row) for row in matrix]
    _fill_slots(numbers, obj, materials)
    if obj.type in ("MESH", "CURVE", "FONT"):
        for _ in range(numbers.count(2)):
            _modify(numbers, obj)
    if obj.type == "EMPTY" and numbers.chance(0.5):
        obj.zraka.plane, obj.zraka.plane_material = True, numbers.choice(materials)
    if numbers.chance(0.2):
        _shuffle(numbers, obj, 0.1, skip=("rotation_mode", "mode", "parent_type", "instance_type"))
    if numbers.chance(0.15):
        obj.hide_render = True


def _fill_slots(numbers, obj, materials):
    if hasattr(obj.data, "materials"):
        for _ in range(numbers.count(3)):
            obj.data.materials.append(numbers.choice((*materials, None)))
        for slot in obj.material_slots:
            if numbers.chance(0.2):
                slot.link = "OBJECT"
                slot.material = numbers.choice(materials)
    if obj.type == "MESH":
        for polygon in obj.data.polygons:
            polygon.material_index = numbers.count(3)
            polygon.use_smooth = numbers.chance(0.5)


def _modify(numbers, obj):
    try:
        modifier = obj.modifiers.new("Random", numbers.choice(_MODIFIERS))
    except (TypeError, RuntimeError):
        return
    if modifier is not None and modifier.type not in ("REMESH", "SUBSURF", "ARRAY", "SCREW", "BEVEL"):
        _shuffle(numbers, modifier, 0.2)


def _light(numbers, scene, number):
    data = bpy.data.lights.new(f"Light {number}", numbers.choice(("POINT", "SPOT", "SUN", "AREA")))
    _shuffle(numbers, data, 0.3, skip=("type",))
    data.energy = numbers.size() * 100
    obj = bpy.data.objects.new(data.name, data)
    obj.matrix_world = [list(row) for row in numbers.matrix()]
    scene.collection.objects.link(obj)


def _camera(numbers, scene):
    data = bpy.data.cameras.new("Camera")
    if numbers.chance(0.5):
        _shuffle(numbers, data, 0.15)
        _shuffle(numbers, data.dof, 0.2)
    obj = bpy.data.objects.new("Camera", data)
    scene.collection.objects.link(obj)
    scene.camera = obj
    obj.location = (3.0, -3.0, 2.0)
    obj.rotation_euler = (1.1, 0.0, 0.8)
    if numbers.chance(0.2):
        obj.matrix_world = [list(row) for row in numbers.matrix()]


def _instances(numbers, scene):
    """Make an object repeat others: a collection's instance, or one on the faces or corners of a mesh."""
    obj = numbers.choice(list(scene.objects))
    if obj.type == "EMPTY":
        things = bpy.data.collections.new("Things")
        for other in list(scene.objects):
            if other is not obj and numbers.chance(0.5):
                things.objects.link(other)
        obj.instance_type, obj.instance_collection = "COLLECTION", things
    elif obj.type == "MESH" and len(obj.data.polygons) < 200:
        obj.instance_type = numbers.choice(("VERTS", "FACES"))
        other = numbers.choice(list(scene.objects))
        if other is not obj and other is not scene.camera:
            other.parent = obj


# -- node trees --------------------------------------------------------------------------------------------------------


def _material(numbers, number):
    material = bpy.data.materials.new(f"Material {number}")
    if numbers.chance(0.9):
        material.use_nodes = True
        _grow(numbers, material.node_tree)
    return material


def _world(numbers, scene):
    if numbers.chance(0.3):
        return
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    if numbers.chance(0.15):
        _grow(numbers, scene.world.node_tree)


def _grow(numbers, tree):
    """Add random nodes with random settings, and links between any sockets."""
    if numbers.chance(0.4):
        tree.nodes.clear()
    for _ in range(1 + numbers.count(14)):
        try:
            node = tree.nodes.new(numbers.choice(SHADERS))
        except RuntimeError:  # a base class, or of another kind of tree
            continue
        _shuffle(numbers, node, 0.3, skip=("parent", "location", "width", "height", "name", "label", "select"))
        node.mute = numbers.chance(0.05)
        _attach_picture(numbers, node)
        for socket in node.inputs:
            if hasattr(socket, "default_value") and numbers.chance(0.3):
                prop = socket.bl_rna.properties["default_value"]
                value = _value(numbers, prop)
                if value is not None:
                    socket.default_value = value
    nodes = list(tree.nodes)
    for node in nodes:
        for socket in node.inputs:
            sources = numbers.choice(nodes).outputs
            if len(sources) and numbers.chance(0.5):
                tree.links.new(numbers.choice(list(sources)), socket)
    _link_output(numbers, tree)


def _attach_picture(numbers, node):
    if not hasattr(node, "image") or not numbers.chance(0.8):
        return
    image = bpy.data.images.new("Picture", 1 + numbers.count(4), 1 + numbers.count(4), float_buffer=numbers.chance(0.5))
    image.source = numbers.choice(("GENERATED", "FILE"))
    node.image = image


def _link_output(numbers, tree):
    """Some shader reaches the output."""
    outputs = [n for n in tree.nodes if n.bl_idname in ("ShaderNodeOutputMaterial", "ShaderNodeOutputWorld")]
    sources = [s for n in tree.nodes for s in n.outputs if s.type == "SHADER" and s.enabled]
    for node in outputs:
        if sources and not node.inputs["Surface"].is_linked:
            tree.links.new(numbers.choice(sources), node.inputs["Surface"])
