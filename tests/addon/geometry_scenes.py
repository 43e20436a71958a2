# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scenes of every kind of geometry in Blender, and surfaces that emit what nodes say of it."""

from __future__ import annotations

import math
import warnings

import bpy
import numpy as np

GEOMETRY = "ShaderNodeNewGeometry"
POSITION, NORMAL = (GEOMETRY, "Position"), (GEOMETRY, "Normal")


# -- materials ---------------------------------------------------------------------------------------------------------


def tree_of(material):
    """An empty node tree."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        material.use_nodes = True
    material.node_tree.nodes.clear()
    return material.node_tree


def shows(node_type, socket=0, **settings):
    """A material that emits what an output of a node says."""
    material = bpy.data.materials.new("Shown")
    tree = tree_of(material)
    node, emission, output = (tree.nodes.new(t) for t in (node_type, "ShaderNodeEmission", "ShaderNodeOutputMaterial"))
    for name, value in settings.items():
        setattr(node, name, value)
    tree.links.new(node.outputs[socket], emission.inputs["Color"])
    tree.links.new(emission.outputs[0], output.inputs["Surface"])
    return material


def glowing(color):
    """A material that emits a colour."""
    material = bpy.data.materials.new("Glow")
    tree = tree_of(material)
    emission, output = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
    emission.inputs["Color"].default_value = (*color, 1)
    tree.links.new(emission.outputs[0], output.inputs["Surface"])
    return material


# -- objects -----------------------------------------------------------------------------------------------------------


def put(scene, data, name="Object", **settings):
    """A new object in the scene."""
    obj = bpy.data.objects.new(name, data)
    scene.collection.objects.link(obj)
    for key, value in settings.items():
        setattr(obj, key, value)
    return obj


def mesh_of(vertices, faces, edges=()):
    """A mesh from lists."""
    mesh = bpy.data.meshes.new("Mesh")
    mesh.from_pydata(vertices, edges, faces)
    mesh.update()
    return mesh


def primitive(kind, **settings):
    """A mesh object that an operator adds, e.g. ``"cube"``."""
    getattr(bpy.ops.mesh, f"primitive_{kind}_add")(**settings)
    return bpy.context.object


def smooth_sphere(**settings):
    """A coarse sphere, shaded smooth."""
    obj = primitive("uv_sphere", segments=16, ring_count=8, radius=1.2)
    obj.data.polygons.foreach_set("use_smooth", [True] * len(obj.data.polygons))
    for key, value in settings.items():
        setattr(obj, key, value)
    return obj


def grid_of(obj, kind, *chain):
    """Give `obj` a modifier that sends its geometry through `chain` of (node type, {input or property: value})."""
    group = bpy.data.node_groups.new("Geometry", "GeometryNodeTree")
    for side in ("INPUT", "OUTPUT"):
        group.interface.new_socket("Geometry", in_out=side, socket_type="NodeSocketGeometry")
    end = group.nodes.new("NodeGroupInput").outputs[0]
    nodes = []
    for node_type, values in chain:
        node = group.nodes.new(node_type)
        for key, value in values.items():
            if key in node.inputs:
                node.inputs[key].default_value = value
            else:
                setattr(node, key, value)
        group.links.new(end, node.inputs[0])
        end = node.outputs[0]
        nodes.append(node)
    group.links.new(end, group.nodes.new("NodeGroupOutput").inputs[0])
    obj.modifiers.new("Nodes", "NODES").node_group = group
    return nodes


# -- curves, surfaces, text, metaballs ---------------------------------------------------------------------------------


def curve(scene):
    """A bent tube."""
    data = bpy.data.curves.new("Curve", "CURVE")
    data.dimensions, data.bevel_depth = "3D", 0.3
    points = data.splines.new("BEZIER").bezier_points
    points.add(2)
    for point, place in zip(points, ((-1.5, -0.5, 0), (0, 0.8, 0.3), (1.5, -0.5, 0)), strict=True):
        point.co, point.handle_left_type, point.handle_right_type = place, "AUTO", "AUTO"
    put(scene, data)


def surface(scene):
    """A NURBS sphere."""
    bpy.ops.surface.primitive_nurbs_surface_sphere_add(radius=1.3)


def text(scene):
    """A solid letter."""
    data = bpy.data.curves.new("Text", "FONT")
    data.body, data.extrude, data.bevel_depth, data.size = "Z&", 0.2, 0.03, 2
    put(scene, data, location=(-1.3, -0.6, 0), rotation_euler=(0.2, 0.3, 0))


def metaballs(scene):
    """Two that flow together."""
    data = bpy.data.metaballs.new("Ball")
    data.resolution = data.render_resolution = 0.15
    for x in (-0.6, 0.6):
        data.elements.new().co.x = x
    put(scene, data)


# -- instances ---------------------------------------------------------------------------------------------------------


def collection(scene):
    """A collection, placed twice, turned and scaled."""
    library = bpy.data.collections.new("Library")
    child = bpy.data.objects.new("Child", smooth_sphere().data)
    bpy.data.objects.remove(bpy.context.object)
    child.location = (0.3, 0, 0)
    library.objects.link(child)
    for x in (-1, 1):
        put(scene, None, f"Empty{x}", instance_type="COLLECTION", instance_collection=library,
            location=(x, 0, 0), rotation_euler=(0.3 * x, 0.5, 0), scale=(0.7, 0.4, 0.5))  # fmt: skip


def instanced_by_particles(scene):
    """Cubes on the vertices of a plane by a particle system."""
    cube = primitive("cube", size=0.4, location=(50, 0, 0))
    plane = primitive("grid", x_subdivisions=3, y_subdivisions=3, size=2.4, rotation=(0.3, 0.2, 0))
    plane.modifiers.new("Particles", "PARTICLE_SYSTEM")
    settings = plane.particle_systems[0].settings
    settings.count, settings.emit_from, settings.use_emit_random = 16, "VERT", False
    settings.frame_start = settings.frame_end = 1
    settings.physics_type, settings.render_type, settings.instance_object = "NO", "OBJECT", cube
    settings.particle_size = 1.0
    plane.show_instancer_for_render = plane.show_instancer_for_viewport = False


def instanced_by_nodes(scene):
    """Cubes on the points of a grid by geometry nodes, with a named attribute of the instances."""
    plane = primitive("grid", x_subdivisions=3, y_subdivisions=3, size=2.4, rotation=(0.3, 0.2, 0))
    on_points, store = grid_of(
        plane,
        None,
        ("GeometryNodeInstanceOnPoints", {}),
        ("GeometryNodeStoreNamedAttribute", {"data_type": "FLOAT", "domain": "INSTANCE", "Name": "height"}),
    )
    group = on_points.id_data
    cube, index = group.nodes.new("GeometryNodeMeshCube"), group.nodes.new("GeometryNodeInputIndex")
    cube.inputs["Size"].default_value = (0.4, 0.5, 0.6)
    group.links.new(cube.outputs[0], on_points.inputs["Instance"])
    value = next(s for s in store.inputs if s.name == "Value" and s.enabled)
    group.links.new(index.outputs[0], value)


# -- meshes ------------------------------------------------------------------------------------------------------------


def mirrored(scene):
    """Negative scale."""
    smooth_sphere(scale=(-1, 1, 1), rotation_euler=(0.3, 0.4, 0.5))
    primitive("cube", size=0.7, location=(1.4, 0, 0.5), rotation=(0.4, 0.3, 0)).scale = (-1, -1, -1)


def sheared(scene):
    """A turned child of an unevenly scaled parent."""
    parent = put(scene, None, "Parent", scale=(1.6, 0.6, 1))
    obj = smooth_sphere(rotation_euler=(0.4, 0.5, 0.7))
    obj.parent = parent


def uneven(scene):
    """Smooth shading under an uneven scale."""
    smooth_sphere(scale=(1.3, 0.5, 0.9), rotation_euler=(0.3, 0.2, 0.4))


def uneven_shared(scene):
    """The same, the mesh being shared."""
    obj = smooth_sphere(scale=(0.7, 0.4, 0.9), rotation_euler=(0.3, 0.2, 0.4), location=(-0.9, 0, 0))
    put(scene, obj.data, "Other", scale=(0.9, 1, 0.3), location=(0.9, 0, 0))


def non_manifold(scene):
    """Three faces on one edge, and a face that turns the other way."""
    vertices = [
        (0, -1, 0),
        (0, 1, 0),
        (1.3, -1, 0.4),
        (1.3, 1, 0.4),
        (-1.3, -1, 0.5),
        (-1.3, 1, 0.5),
        (0, -1, 1),
        (0, 1, 1),
    ]
    mesh = mesh_of(vertices, [(0, 2, 3, 1), (0, 4, 5, 1), (0, 1, 7, 6)])
    mesh.polygons.foreach_set("use_smooth", [True] * 3)
    put(scene, mesh, rotation_euler=(0.3, 0.2, 0.1))


def n_gon(scene):
    """A star of one face, not quite flat."""
    ring = [(math.sin(k * math.pi / 7), math.cos(k * math.pi / 7)) for k in range(14)]
    vertices = [((1.6, 0.7)[k % 2] * x, (1.6, 0.7)[k % 2] * y, 0.05 * (k % 3)) for k, (x, y) in enumerate(ring)]
    put(scene, mesh_of(vertices, [tuple(range(13, -1, -1))]), rotation_euler=(0.2, 0.1, 0))


def loose(scene):
    """Edges and vertices without a face, beside a face."""
    vertices = [(-1, -1, 0), (1, -1, 0), (1, 1, 0.3), (-1, 1, 0), (1.5, 1.5, 0), (-1.5, 1, 0.5)]
    put(scene, mesh_of(vertices, [(0, 1, 2, 3)], [(3, 4), (4, 5)]))


def without_area(scene):
    """A face that is a line and one that is a point, beside a face."""
    vertices = [(-1, -1, 0), (1, -1, 0), (1, 1, 0.3), (-1, 1, 0), (0, 1.3, 0), (0.5, 1.3, 0), (1, 1.3, 0)]
    vertices += [(0, -1.3, 0)] * 3
    put(scene, mesh_of(vertices, [(0, 1, 2, 3), (4, 5, 6), (7, 8, 9)]))


def custom_normals(scene):
    """A cube with normals of its own."""
    obj = primitive("cube", size=1.8, rotation=(0.4, 0.5, 0.2))
    mesh = obj.data
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    rng = np.random.default_rng(0)
    corners = np.array([mesh.vertices[loop.vertex_index].co for loop in mesh.loops]) + 0.3 * rng.normal(size=(24, 3))
    mesh.normals_split_custom_set((corners / np.linalg.norm(corners, axis=1, keepdims=True)).tolist())


def sharp_edges(scene):
    """A smooth cylinder with sharp rims."""
    mesh = primitive("cylinder", vertices=12, radius=1.1, depth=1.4, rotation=(0.8, 0.3, 0)).data
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    mesh.set_sharp_from_angle(angle=math.radians(40))


def uv_maps(scene):
    """Two UV maps, the second of which is rendered."""
    mesh = primitive("cube", size=1.8, rotation=(0.4, 0.5, 0.2)).data
    layer = mesh.uv_layers.new(name="Second")
    rng = np.random.default_rng(1)
    layer.uv.foreach_set("vector", rng.random(2 * len(mesh.loops)).astype(np.float32))
    layer.active_render = True


def attribute(data_type, domain):
    """A builder of a grid with an attribute of a type and a domain, and what shows it."""

    def build(scene):
        mesh = primitive("grid", x_subdivisions=3, y_subdivisions=2, size=2.6, rotation=(0.3, 0.2, 0.1)).data
        made = mesh.attributes.new("Own", data_type, domain)
        rng, count = np.random.default_rng(2), len(made.data)
        member, width = {
            "FLOAT": ("value", 1), "INT": ("value", 1), "INT8": ("value", 1), "BOOLEAN": ("value", 1),
            "FLOAT2": ("vector", 2), "FLOAT_VECTOR": ("vector", 3), "QUATERNION": ("value", 4),
        }.get(data_type, ("color", 4))  # fmt: skip
        values = rng.random(count * width)
        if data_type in ("INT", "INT8"):
            values = np.floor(5 * values).astype(np.int32)
        made.data.foreach_set(member, values > 0.5 if data_type == "BOOLEAN" else values)

    return build


def vertex_groups(scene):
    """Weights of a vertex group, read as an attribute."""
    obj = primitive("grid", x_subdivisions=3, y_subdivisions=2, size=2.6)
    group = obj.vertex_groups.new(name="Own")
    for vertex in range(0, len(obj.data.vertices), 2):
        group.add([vertex], 0.1 * vertex, "REPLACE")


# -- materials of objects ----------------------------------------------------------------------------------------------


def by_face(scene):
    """A material for each face, with an empty slot and one that does not exist."""
    mesh = primitive("cube", size=1.8, rotation=(0.4, 0.5, 0.2)).data
    for color in ((1, 0, 0), (0, 1, 0), (0, 0, 1)):
        mesh.materials.append(glowing(color))
    mesh.polygons.foreach_set("material_index", [0, 1, 2, 1, 2, 7])


def of_object(scene):
    """Slots linked to the object, the mesh being shared with one that keeps the mesh's."""
    first = primitive("cube", size=1.2, rotation=(0.4, 0.5, 0.2), location=(-1, 0, 0))
    first.data.materials.append(glowing((1, 0, 0)))
    other = put(scene, first.data, "Other", location=(1, 0, 0), rotation_euler=(0.1, 0.2, 0.3))
    other.material_slots[0].link = "OBJECT"
    other.material_slots[0].material = glowing((0, 1, 0.5))


# -- points ------------------------------------------------------------------------------------------------------------


def points(scene):
    """A point cloud whose points have radii of their own."""
    mesh = primitive("grid", x_subdivisions=3, y_subdivisions=3, size=2.4, rotation=(0.3, 0.2, 0))
    convert, radius = grid_of(mesh, None, ("GeometryNodeMeshToPoints", {}), ("GeometryNodeSetPointRadius", {}))
    group = convert.id_data
    noise = group.nodes.new("FunctionNodeRandomValue")
    low, high = (next(s for s in noise.inputs if s.name == n and s.enabled) for n in ("Min", "Max"))
    low.default_value, high.default_value = 0.1, 0.45
    group.links.new(next(s for s in noise.outputs if s.enabled), radius.inputs["Radius"])


def instanced_points(scene):
    """A point cloud in a collection that is placed twice."""
    points(scene)
    cloud = bpy.context.object
    cloud.scale = (0.5, 0.5, 0.5)
    library = bpy.data.collections.new("Library")
    scene.collection.objects.unlink(cloud)
    library.objects.link(cloud)
    for x in (-0.8, 0.8):
        put(scene, None, f"Empty{x}", instance_type="COLLECTION", instance_collection=library, location=(x, 0, 0))


# -- hair --------------------------------------------------------------------------------------------------------------


def hair_curves(scene, radius=True):
    """Bent strands of hair curves."""
    curves = bpy.data.hair_curves.new("Hair")
    curves.add_curves([5] * 12)
    rng = np.random.default_rng(3)
    t = np.linspace(0, 1, 5)[None, :, None]
    root = np.stack([np.linspace(-1.5, 1.5, 12), np.full(12, -1.0), rng.normal(0, 0.1, 12)], axis=1)[:, None]
    places = root + t * (0, 2, 0.3) + 0.25 * np.sin(4 * t + 6 * rng.random((12, 1, 3)))
    curves.attributes["position"].data.foreach_set("vector", places.astype(np.float32).ravel())
    if radius:
        radii = (0.1 - 0.06 * t) * np.ones((12, 1, 1))
        curves.attributes.new("radius", "FLOAT", "POINT").data.foreach_set("value", radii.astype(np.float32).ravel())
    uv = curves.attributes.new("surface_uv_coordinate", "FLOAT2", "CURVE")
    uv.data.foreach_set("vector", rng.random(24).astype(np.float32))
    tint = curves.attributes.new("Tint", "FLOAT_COLOR", "POINT")
    tint.data.foreach_set("color", rng.random(240).astype(np.float32))
    put(scene, curves, rotation_euler=(0.2, 0.1, 0), scale=(1.1, 1.1, 1.1))


def particle_hair(scene, children="NONE", **settings):
    """Hair of a particle system on a plane with a UV map and a colour attribute."""
    plane = primitive("plane", size=2.6, rotation=(-0.9, 0.1, 0))
    plane.scale = (1.1, 1.1, 1.1)
    color = plane.data.color_attributes.new("Tint", "BYTE_COLOR", "CORNER")
    color.data.foreach_set("color", np.random.default_rng(4).random(16).astype(np.float32))
    plane.modifiers.new("Hair", "PARTICLE_SYSTEM")
    made = plane.particle_systems[0].settings
    made.type, made.count, made.hair_length = "HAIR", 20, 1.0
    made.root_radius, made.tip_radius, made.radius_scale = 1.0, 0.4, 0.12
    made.child_type = children
    made.rendered_child_count = 5
    made.brownian_factor = 0.2
    made.use_close_tip = False
    for name, value in settings.items():
        setattr(made, name, value)


def hidden_emitter(scene):
    """Children that hide their emitter, thin, with closed tips."""
    particle_hair(scene, "SIMPLE", shape=-0.4, use_close_tip=True)
    bpy.context.object.show_instancer_for_render = False
