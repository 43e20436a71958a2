# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects, instances, meshes and point clouds."""

from __future__ import annotations

import time

import bpy
import numpy as np
import pytest

from zraka.addon.export.material import default_material
from zraka.addon.export.scene import export_scene
from zraka.core.diagnostics import Diagnostics


@pytest.fixture
def scene():
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    return with_camera(bpy.context.scene)


def with_camera(scene):
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(camera)
    scene.camera = camera
    return scene


def add(scene, name, data):
    obj = bpy.data.objects.new(name, data)
    scene.collection.objects.link(obj)
    return obj


def quads(name="Quads", count=1):
    """A row of unit squares in the XY plane."""
    mesh = bpy.data.meshes.new(name)
    vertices = [(x + dx, dy, 0) for x in range(count) for dx, dy in ((0, 0), (1, 0), (1, 1), (0, 1))]
    mesh.from_pydata(vertices, [], [tuple(range(4 * i, 4 * i + 4)) for i in range(count)])
    return mesh


def export(diagnostics=None):
    bpy.context.view_layer.update()
    return export_scene(bpy.context.evaluated_depsgraph_get(), diagnostics or Diagnostics())


def areas(mesh):
    a, b, c = (mesh.vertices[mesh.triangles[:, i]] for i in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


# -- which objects -----------------------------------------------------------------------------------------------------


def add_text(scene):
    text = bpy.data.curves.new("Text", "FONT")
    text.body = "Z"
    return add(scene, "Text", text)


def add_curve(scene):
    curve = bpy.data.curves.new("Curve", "CURVE")
    curve.dimensions, curve.bevel_depth = "3D", 0.1
    curve.splines.new("POLY").points.add(1)
    curve.splines[0].points[1].co = (1, 0, 0, 1)
    return add(scene, "Curve", curve)


def add_metaball(scene):
    ball = bpy.data.metaballs.new("Ball")
    ball.elements.new()
    return add(scene, "Ball", ball)


def add_surface(scene):
    bpy.ops.surface.primitive_nurbs_surface_sphere_add()
    return bpy.context.object


@pytest.mark.parametrize("make", [add_text, add_curve, add_metaball, add_surface])
def test_what_blender_lists_twice_is_exported_once(scene, make):
    obj = make(scene)
    bpy.context.view_layer.update()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    assert len([i for i in depsgraph.object_instances if i.object.name == obj.name]) == 2  # the trap is there
    (instance,) = export().instances
    evaluated = obj.evaluated_get(depsgraph)
    twin = evaluated.to_mesh()
    twin.calc_loop_triangles()
    expected = len(twin.loop_triangles)
    evaluated.to_mesh_clear()
    assert len(instance.mesh.triangles) == expected > 0


def test_a_curve_without_faces_is_nothing(scene):
    add_curve(scene).data.bevel_depth = 0
    assert export().instances == ()


def test_shared_meshes_are_exported_once(scene):
    mesh = quads()
    for x in range(3):
        add(scene, f"Object{x}", mesh).location.x = x
    instances = export().instances
    assert len({id(i.mesh) for i in instances}) == 1
    assert sorted(i.transform[0, 3] for i in instances) == [0, 1, 2]


def test_a_modifier_parts_shared_meshes(scene):
    mesh = quads()
    add(scene, "Plain", mesh)
    add(scene, "Modified", mesh).modifiers.new("Array", "ARRAY")
    sizes = {i.name: len(i.mesh.triangles) for i in export().instances}
    assert sizes == {"Plain": 2, "Modified": 4}


def test_collection_instances(scene):
    hidden = bpy.data.collections.new("Library")
    child = bpy.data.objects.new("Child", quads())
    child.location = (1, 0, 0)
    hidden.objects.link(child)
    for y in (2, 5):
        empty = add(scene, f"Empty{y}", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", hidden
        empty.location.y = y
        empty.scale = (2, 2, 2)
    instances = export().instances
    assert [i.name for i in instances] == ["Child", "Child"]
    assert instances[0].mesh is instances[1].mesh
    np.testing.assert_allclose(sorted(i.transform[1, 3] for i in instances), [2, 5])
    np.testing.assert_allclose(instances[0].transform[0], [2, 0, 0, 2])


def test_an_instancer_that_hides_itself(scene):
    emitter, child = add(scene, "Emitter", quads()), add(scene, "Child", quads("Small"))
    child.parent = emitter
    emitter.instance_type = "VERTS"
    emitter.show_instancer_for_viewport = emitter.show_instancer_for_render = False
    assert {i.name for i in export().instances} == {"Child"}


def test_negative_scale_is_kept(scene):
    add(scene, "Mirrored", quads()).scale = (-1, 2, 3)
    (instance,) = export().instances
    assert instance.transform.dtype == np.float64
    assert np.linalg.det(instance.transform[:3, :3]) == pytest.approx(-6)
    a, b, c = instance.mesh.vertices[instance.mesh.triangles[0]]
    assert np.cross(b - a, c - a)[2] > 0  # the mesh itself is untouched


class HiddenProbe(bpy.types.RenderEngine):
    """Exports a render's dependency graph."""

    bl_idname, bl_label = "ZRAKA_TEST_HIDDEN", "Hidden probe"
    names: list = []  # noqa: RUF012

    def update(self, data, depsgraph):
        self.names.extend(i.name for i in export_scene(depsgraph, Diagnostics()).instances)

    def render(self, depsgraph):
        pass


def test_what_is_hidden_in_renders_is_left_out(scene):
    add(scene, "Shown", quads())
    add(scene, "Hidden", quads()).hide_render = True
    bpy.utils.register_class(HiddenProbe)
    try:
        scene.render.engine = HiddenProbe.bl_idname
        HiddenProbe.names.clear()
        bpy.ops.render.render()
    finally:
        bpy.utils.unregister_class(HiddenProbe)
    assert HiddenProbe.names == ["Shown"]


# -- meshes ------------------------------------------------------------------------------------------------------------


def test_triangles_corners_and_uvs_of_a_cube(scene):
    bpy.ops.mesh.primitive_cube_add(size=2)
    data = bpy.context.object.data
    data.uv_layers.new(name="Second")
    data.uv_layers["Second"].active_render = True
    (instance,) = export().instances
    mesh = instance.mesh
    assert mesh.triangles.shape == mesh.corners.shape == (12, 3)
    np.testing.assert_allclose(areas(mesh).sum(), 24)
    assert set(mesh.uvs) == {"UVMap", "Second"}
    assert mesh.active_uv == "Second"
    assert mesh.uvs["UVMap"].shape == (24, 2)
    # A corner of a triangle must show the UV of the very vertex it stands on.
    loops = {loop.index: loop.vertex_index for loop in data.loops}
    assert all(loops[c] == v for c, v in zip(mesh.corners.flat, mesh.triangles.flat, strict=True))
    expected = [tuple(data.uv_layers["UVMap"].uv[c].vector) for c in mesh.corners.flat]
    np.testing.assert_allclose(mesh.uvs["UVMap"][mesh.corners.reshape(-1)], expected)
    assert mesh.normals is None  # all flat
    assert mesh.material_index is None


def test_normals_by_domain(scene):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16)
    data = bpy.context.object.data
    data.polygons.foreach_set("use_smooth", [True] * len(data.polygons))
    data.update()
    mesh = export().instances[0].mesh
    assert mesh.normals_domain == "vertex"
    np.testing.assert_allclose(mesh.normals, mesh.vertices, atol=0.02)
    data.polygons[0].use_smooth = False
    data.update()
    mesh = export().instances[0].mesh
    assert mesh.normals_domain == "corner"
    assert mesh.normals.shape == (len(data.loops), 3)
    np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1, atol=1e-5)


def test_several_materials_and_slots_of_the_object(scene):
    red, green, blue = (bpy.data.materials.new(n) for n in ("Red", "Green", "Blue"))
    mesh = quads(count=3)
    for material in (red, green, None):
        mesh.materials.append(material)
    mesh.polygons.foreach_set("material_index", [0, 1, 2])
    add(scene, "Data", mesh)
    other = add(scene, "Own", mesh)
    other.material_slots[1].link = "OBJECT"
    other.material_slots[1].material = blue
    by_name = {i.name: i for i in export().instances}
    names = {n: [m.name for m in i.materials] for n, i in by_name.items()}
    assert names == {"Data": ["Red", "Green", "default_surface"], "Own": ["Red", "Blue", "default_surface"]}
    assert by_name["Data"].mesh is by_name["Own"].mesh
    assert by_name["Data"].materials[0] is by_name["Own"].materials[0]
    assert by_name["Data"].mesh.material_index.tolist() == [0, 0, 1, 1, 2, 2]


def test_material_override_of_the_view_layer(scene):
    mesh = quads()
    mesh.materials.append(bpy.data.materials.new("Own"))
    add(scene, "Object", mesh)
    bpy.context.view_layer.material_override = bpy.data.materials.new("Clay")
    assert [m.name for m in export().instances[0].materials] == ["Clay"]


def geometry_nodes(obj, *chain):
    """Give `obj` a modifier that sends its geometry through `chain` of node types; the nodes."""
    group = bpy.data.node_groups.new("Geometry", "GeometryNodeTree")
    group.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    end = group.nodes.new("NodeGroupInput").outputs[0]
    nodes = [group.nodes.new(name) for name in chain]
    for node in nodes:
        group.links.new(end, node.inputs[0])
        end = node.outputs[0]
    group.links.new(end, group.nodes.new("NodeGroupOutput").inputs[0])
    obj.modifiers.new("Nodes", "NODES").node_group = group
    return nodes


def test_a_material_set_by_geometry_nodes(scene):
    obj = add(scene, "Object", quads())
    (node,) = geometry_nodes(obj, "GeometryNodeSetMaterial")
    node.inputs["Material"].default_value = bpy.data.materials.new("Set")
    (instance,) = export().instances
    slots = instance.mesh.material_index
    assert instance.materials[0 if slots is None else slots[0]].name == "Set"


def test_a_million_triangles_in_well_under_a_tenth_of_a_second(scene):
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=708, y_subdivisions=708)
    export()  # Blender makes normals and triangles when first asked
    times = []
    for _ in range(3):
        start = time.perf_counter()
        instances = export().instances
        times.append(time.perf_counter() - start)
    assert len(instances[0].mesh.triangles) > 1_000_000
    assert min(times) < 0.1


# -- points and planes -------------------------------------------------------------------------------------------------


def test_point_clouds_are_spheres(scene):
    obj = add(scene, "Points", quads())
    (node,) = geometry_nodes(obj, "GeometryNodeMeshToPoints")
    node.inputs["Radius"].default_value = 0.25
    obj.scale, obj.location = (2, 2, 2), (0, 0, 3)
    diagnostics = Diagnostics()
    result = export(diagnostics)
    assert result.instances == ()
    (spheres,) = result.spheres
    np.testing.assert_allclose(spheres.radii, 0.5)
    np.testing.assert_allclose(sorted(spheres.centers.tolist()), [(0, 0, 3), (0, 2, 3), (2, 0, 3), (2, 2, 3)])
    assert diagnostics.messages() == []
    obj.scale.x = 3
    export(diagnostics)
    assert "non-uniform scale" in diagnostics.messages()[0]


def test_an_empty_may_be_an_infinite_plane(blender_scene):
    with_camera(blender_scene)
    empty = add(blender_scene, "Ground", None)
    add(blender_scene, "Ordinary", None)
    empty.zraka.plane = True
    empty.zraka.plane_material = bpy.data.materials.new("Grass")
    empty.location, empty.scale, empty.rotation_euler.x = (1, 2, 3), (-1, 2, 2), np.pi / 2
    (plane,) = export().planes
    assert plane.name == "Ground"
    assert plane.material.name == "Grass"
    np.testing.assert_allclose(plane.point, (1, 2, 3))
    np.testing.assert_allclose(plane.normal, (0, -1, 0), atol=1e-6)


# -- what is said ------------------------------------------------------------------------------------------------------


def test_volumes_are_said_once(scene):
    for name in "AB":
        add(scene, name, bpy.data.volumes.new(name))
    material = bpy.data.materials.new("Smoke")
    if material.node_tree is None:  # before 5.0
        material.use_nodes = True
    material.node_tree.nodes.clear()
    output, volume = (material.node_tree.nodes.new(f"ShaderNode{n}") for n in ("OutputMaterial", "VolumeScatter"))
    material.node_tree.links.new(volume.outputs[0], output.inputs["Volume"])
    for name in "CD":
        add(scene, name, quads()).data.materials.append(material)
    scene.world = bpy.data.worlds.new("Fog")
    if scene.world.node_tree is None:  # before 5.0
        scene.world.use_nodes = True
    tree = scene.world.node_tree
    output = next(n for n in tree.nodes if n.type == "OUTPUT_WORLD")
    tree.links.new(tree.nodes.new("ShaderNodeVolumeScatter").outputs[0], output.inputs["Volume"])
    diagnostics = Diagnostics()
    (exported,) = {i.materials for i in export(diagnostics).instances}
    assert sorted(diagnostics.messages()) == [
        "volume is not rendered yet (material 'Smoke', world 'Fog')",
        "volumes are not rendered yet (object 'A', object 'B')",
    ]
    assert [n.op for n in exported[0].nodes] == ["transparent"]  # not black


def test_a_volume_alone_may_be_displaced(scene):
    material = bpy.data.materials.new("Smoke")
    if material.node_tree is None:  # before 5.0
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    output, volume, noise = (tree.nodes.new(f"ShaderNode{n}") for n in ("OutputMaterial", "VolumeScatter", "TexNoise"))
    tree.links.new(volume.outputs[0], output.inputs["Volume"])
    tree.links.new(noise.outputs["Color"], output.inputs["Displacement"])
    add(scene, "Cloud", quads()).data.materials.append(material)
    ((exported,),) = {i.materials for i in export(Diagnostics()).instances}
    assert exported.nodes[exported.surface].op == "transparent"
    assert exported.nodes[exported.displacement.node].op in ("noise", "convert")


@pytest.mark.skipif(bpy.app.version < (5, 0), reason="the working space can be chosen since Blender 5.0")
def test_another_working_space_is_said(scene):
    bpy.ops.wm.set_working_color_space(working_space="Linear Rec.2020")
    diagnostics = Diagnostics()
    export_scene(bpy.context.evaluated_depsgraph_get(), diagnostics)
    assert any("Linear Rec.2020" in message for message in diagnostics.messages())
    bpy.ops.wm.set_working_color_space(working_space="Linear Rec.709")


def test_materials_are_exported_once(scene):
    material = bpy.data.materials.new("Shared")
    for name in ("One", "Other", "Bare"):
        mesh = quads(name)
        if name != "Bare":
            mesh.materials.append(material)
        add(scene, name, mesh)
    one, other, bare = export().instances
    assert one.materials[0] is other.materials[0] is not None
    assert bare.materials == (default_material(),)
