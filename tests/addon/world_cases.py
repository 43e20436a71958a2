# SPDX-License-Identifier: GPL-3.0-or-later
"""Worlds of every kind, seen over a floor that they light."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import bpy
import numpy as np

from zraka.addon.bench.engines import match, operate, watched

from .geometry_scenes import put
from .light_cases import white
from .nodes.harness import add, output
from .visibility_cases import SIDE, means, tree_of


@dataclass(frozen=True)
class Case:
    """A world whose shader is what ``build(tree)`` returns."""

    item: str
    build: Callable
    note: str = ""


def background(tree, color, strength=1.0):
    """A background of a colour or a socket."""
    return output(add(tree, "Background", {"Color": color, "Strength": strength}))


def constant(tree):
    """One colour."""
    return background(tree, (0.2, 0.5, 0.8, 1), 1.5)


def image(tree, projection="EQUIRECTANGULAR"):
    """A picture of waves with a bright spot."""
    width, height = 128, 64
    x, y = np.meshgrid(np.linspace(0, 2 * math.pi, width), np.linspace(0, math.pi, height))
    pixels = np.ones((height, width, 4), np.float32)
    for channel in range(3):
        pixels[..., channel] = 0.6 + 0.4 * np.sin(x * (channel + 1)) * np.sin(y)
    pixels[40:44, 20:24, :3] = 100.0
    sky = bpy.data.images.new("Sky", width, height, alpha=False, float_buffer=True)
    sky.pixels.foreach_set(pixels.ravel())
    sky.update()
    sky.pack()
    return background(tree, output(add(tree, "TexEnvironment", image=sky, projection=projection)))


def mirror_ball(tree):
    """A picture of a ball that mirrors."""
    return image(tree, "MIRROR_BALL")


def sky(tree):
    """A simulated sky with its sun."""
    kind = "MULTIPLE_SCATTERING" if bpy.app.version >= (5, 0) else "NISHITA"
    return background(tree, output(add(tree, "TexSky", sky_type=kind, sun_elevation=0.6)), 0.05)


def gradient(tree):
    """A texture of directions."""
    coordinates = add(tree, "TexCoord")
    return background(tree, output(add(tree, "TexNoise", {"Vector": output(coordinates, "Generated"), "Scale": 3.0})))


def by_ray(tree):
    """One colour for the camera, another light."""
    mix = add(tree, "MixShader", {"Fac": output(add(tree, "LightPath"), "Is Camera Ray")})
    tree.links.new(background(tree, (1.0, 0.6, 0.3, 1)), mix.inputs[1])
    tree.links.new(background(tree, (0.1, 0.2, 0.9, 1)), mix.inputs[2])
    return output(mix)


CASES = (
    Case("one colour", constant),
    Case("environment texture, equirectangular", image),
    Case("environment texture, mirror ball", mirror_ball),
    Case("sky with its sun", sky),
    Case("textures of the direction", gradient),
    Case("Light Path", by_ray),
)


def build(scene, case):
    """A floor under the world, above it the horizon."""
    bpy.ops.mesh.primitive_plane_add(size=4)
    bpy.context.object.data.materials.append(white())
    bpy.ops.mesh.primitive_cube_add(size=0.8, location=(0, 0.3, 0.4), rotation=(0, 0, 0.4))
    bpy.context.object.data.materials.append(white())
    scene.camera = put(scene, bpy.data.cameras.new("Camera"), "Camera", location=(0, -5, 2), rotation_euler=(1.3, 0, 0))
    scene.camera.data.lens = 30
    scene.world = bpy.data.worlds.new("World")
    tree = tree_of(scene.world)
    tree.links.new(case.build(tree), add(tree, "OutputWorld").inputs["Surface"])
    scene.render.resolution_x = scene.render.resolution_y = SIDE
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    scene.zraka.samples, scene.zraka.depth = 256, 3


def measure(scene, case):
    """Greatest difference of the blocks' means as a share of the brightest, messages."""
    build(scene, case)
    match(scene)
    with watched() as seen:
        ours = means(operate(scene, "ZRAKA")[0])
    theirs = means(operate(scene, "CYCLES")[0])
    return float(np.abs(ours - theirs).max() / theirs.max()), seen.messages
