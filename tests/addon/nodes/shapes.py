# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that a plane is too plain for: a smooth ball seen askew, instances of it, islands."""

from __future__ import annotations

import bpy


def ball(obj, smooth=True, scale=(1.0, 0.8, 0.6), inside_out=False):
    """Make `obj` a ball of 24 × 12 faces, turned and moved, seen by a perspective camera from above."""
    materials = list(obj.data.materials)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12, radius=1.0)
    made = bpy.context.object
    mesh = made.data
    bpy.data.objects.remove(made)
    mesh.polygons.foreach_set("use_smooth", [smooth] * len(mesh.polygons))
    if inside_out:
        mesh.flip_normals()
    for material in materials:
        mesh.materials.append(material)
    mesh.update()
    obj.data = mesh
    obj.scale, obj.rotation_euler, obj.location = scale, (0.3, 0.4, 0.5), (0.1, 0.05, 0.2)
    look_askew()
    return obj


def look_askew():
    """Let the scene's camera look from four metres above, with perspective."""
    camera = bpy.context.scene.camera
    camera.data.type, camera.data.lens, camera.data.shift_x = "PERSP", 50, 0.05
    camera.location, camera.rotation_euler = (0.3, -0.2, 4), (0.05, 0.07, 0.2)


def instances(obj, kind):
    """Make `obj` a small ball on each vertex or face of a grid, which is not seen itself."""
    ball(obj, scale=(0.25, 0.25, 0.25))
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=3, y_subdivisions=3, size=1.6)
    grid = bpy.context.object
    grid["of grid"], grid.color = 0.3, (0.3, 0.4, 0.5, 0.6)
    grid.instance_type, grid.show_instancer_for_render = kind, False
    obj.parent, obj.location = grid, (0, 0, 0)
    return grid


def islands(obj):
    """Make `obj` a ball and two cubes, one mesh."""
    ball(obj)
    obj.scale, obj.location = (0.5, 0.5, 0.5), (0.6, 0.5, 0)
    materials = list(obj.data.materials)
    for place in ((-0.5, 0.6, 0), (0.2, -0.6, 0)):
        bpy.ops.mesh.primitive_cube_add(size=0.7, location=place)
        for material in materials:
            bpy.context.object.data.materials.append(material)
    for other in bpy.context.scene.objects:
        other.select_set(other.type == "MESH")
    bpy.context.view_layer.objects.active = obj
    bpy.ops.object.join()
