# SPDX-License-Identifier: GPL-3.0-or-later
"""Closures in Zraka beside the same in Cycles: a tilted plane of several materials under an orthographic camera.

In a white world a material's radiance is its directional albedo at the angle of the tilt; under a sun without extent it
is, without noise, f·cosθ of one pair of directions.
"""

from __future__ import annotations

import math
import tempfile
import warnings
from pathlib import Path

import bpy
import numpy as np
import OpenImageIO as oiio
from mathutils import Vector

import zraka
from zraka.addon import headless
from zraka.addon.bench.engines import match, operate

ROWS = 16
_STEEPEST = 1e-3  # least cosine of a tilt


class Slope:
    """A scene with a plane tilted about the x axis, a column of the picture for each material.

    Parameters
    ----------
    materials : sequence of callable
        ``build(tree, plane) -> closure output socket``.
    width, rows : int
        Pixels of a column.
    world : callable, optional
        ``build(tree) -> closure output socket``; None is a white world.
    below : bool
        Show the plane's back.
    """

    def __init__(self, materials, width=16, rows=ROWS, world=None, below=False):
        zraka.register()
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
        self.scene = scene = bpy.context.scene
        self._shape = rows, len(materials), width
        self._below = below
        render = scene.render
        render.resolution_x, render.resolution_y = len(materials) * width, rows
        render.threads_mode, render.threads = "FIXED", 1
        scene.view_settings.view_transform = "Raw"
        camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
        self._side = max(len(materials), rows / width)
        camera.data.type = "ORTHO"
        camera.data.ortho_scale = self._side
        scene.collection.objects.link(camera)
        scene.camera = camera
        self.plane = self._add_plane([self._material(build) for build in materials])
        self._light(world or _white)
        scene.zraka.depth = 1
        match(scene)

    def tilt(self, degrees):
        """Turn the plane's normal by an angle from the camera, towards -y."""
        angle = math.radians(degrees)
        self.plane.rotation_euler.x = angle + (math.pi if self._below else 0.0)
        length = self._side / max(math.cos(angle), _STEEPEST)  # fills the picture
        self.plane.scale.y = length
        self.scene.camera.location.z, self.scene.camera.data.clip_end = 2 * length, 4 * length
        bpy.context.view_layer.update()

    def add_sun(self, direction):
        """A sun of irradiance 1 without extent, from `direction`, in the place of the world and of earlier suns."""
        for sun in [o for o in self.scene.objects if o.type == "LIGHT"]:
            bpy.data.objects.remove(sun)
        self.scene.world = None
        lamp = bpy.data.lights.new("Sun", "SUN")
        lamp.energy, lamp.angle, lamp.use_shadow = 1.0, 0.0, False
        sun = bpy.data.objects.new("Sun", lamp)
        sun.rotation_euler = Vector(direction).to_track_quat("Z", "Y").to_euler()
        self.scene.collection.objects.link(sun)
        bpy.context.view_layer.update()

    def render(self, engine, samples=1, seed=0):
        """Mean radiance of each material, (materials, 3) float64."""
        self.scene.zraka.samples, self.scene.zraka.seed = samples, seed
        match(self.scene)
        picture, _ = operate(self.scene, engine)
        rows, count, width = self._shape
        return picture.reshape(rows, count, width, 3).mean(axis=(0, 2), dtype=np.float64)

    def alphas(self, engine, samples):
        """Mean alpha of each material before a transparent film, (materials,)."""
        scene, kind = self.scene, self.scene.render.image_settings
        self.render(engine, samples)  # sets both engines and the file's format
        scene.render.film_transparent, kind.color_mode = True, "RGBA"
        with tempfile.TemporaryDirectory() as folder, headless.quiet():
            scene.render.filepath = str(Path(folder) / "picture.exr")
            bpy.ops.render.render(write_still=True)
            picture = oiio.ImageBuf(scene.render.filepath).get_pixels(oiio.FLOAT)
        rows, count, width = self._shape
        return picture[..., 3].reshape(rows, count, width).mean(axis=(0, 2))

    def _add_plane(self, materials):
        count = len(materials)
        edges = np.arange(count + 1) - count / 2
        edges[0], edges[-1] = edges[0] - 1, edges[-1] + 1
        corners = [(x, y, 0.0) for x in edges for y in (-1.0, 1.0)]
        mesh = bpy.data.meshes.new("Plane")
        mesh.from_pydata(corners, [], [(2 * k, 2 * k + 2, 2 * k + 3, 2 * k + 1) for k in range(count)])
        layer = mesh.uv_layers.new(name="UVMap")
        for loop, corner in zip(mesh.loops, layer.uv, strict=True):
            corner.vector = mesh.vertices[loop.vertex_index].co[:2]
        for k, material in enumerate(materials):
            mesh.materials.append(material)
            mesh.polygons[k].material_index = k
        plane = bpy.data.objects.new("Plane", mesh)
        self.scene.collection.objects.link(plane)
        return plane

    def _material(self, build):
        material = bpy.data.materials.new("Closure")
        tree = emptied(material)
        output = tree.nodes.new("ShaderNodeOutputMaterial")
        tree.links.new(build(tree, None), output.inputs["Surface"])
        return material

    def _light(self, build):
        self.scene.world = world = bpy.data.worlds.new("World")
        tree = emptied(world)
        output = tree.nodes.new("ShaderNodeOutputWorld")
        tree.links.new(build(tree), output.inputs["Surface"])


def _white(tree):
    background = tree.nodes.new("ShaderNodeBackground")
    background.inputs["Color"].default_value = (1, 1, 1, 1)
    return background.outputs[0]


def emptied(data):
    """The node tree of a material or world, without nodes."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        data.use_nodes = True
    data.node_tree.nodes.clear()
    return data.node_tree
