# SPDX-License-Identifier: GPL-3.0-or-later
"""25 spheres of Principled materials in Zraka and in Cycles: ``python -m tests.addon.nodes.chart [--keep FOLDER]``.

A row each for metallic, roughness, transmission, coat and sheen, which grow from left to right; roughness is that of a
metal. The spheres lie on a floor under an area light and an even sky.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import bpy
import numpy as np

import zraka
from zraka.addon.bench.engines import picture
from zraka.core.report.error import agreement, misfit, power

from .harness import add
from .slope import emptied

VALUES = (0.0, 0.25, 0.5, 0.75, 1.0)
BASE = {"Base Color": (0.7, 0.35, 0.12, 1.0), "Roughness": 0.3}
ROWS = {
    "metallic": lambda v: {"Metallic": v},
    "roughness": lambda v: {"Metallic": 1.0, "Roughness": v},
    "transmission": lambda v: {"Transmission Weight": v, "Roughness": 0.15},
    "coat": lambda v: {"Coat Weight": v, "Coat Roughness": 0.1, "Roughness": 0.7, "Coat Tint": (1.0, 0.7, 0.5, 1.0)},
    "sheen": lambda v: {"Sheen Weight": v, "Sheen Roughness": 0.4, "Sheen Tint": (0.8, 0.9, 1.0, 1.0)},
}
DEPTH = 6


def build(pixels=240):
    """Make the scene and return it."""
    zraka.register()
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    scene = bpy.context.scene
    scene.render.resolution_x = scene.render.resolution_y = pixels
    scene.view_settings.view_transform = "Raw"
    scene.zraka.depth = DEPTH
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler, camera.data.angle = (0.0, -8.0, 9.0), (0.72, 0.0, 0.0), 0.62
    scene.collection.objects.link(camera)
    scene.camera = camera
    _add_light(scene)
    _add_floor(scene)
    ball = _ball()
    for row, inputs_of in enumerate(ROWS.values()):
        for column, value in enumerate(VALUES):
            _add_ball(scene, ball, (1.3 * (column - 2), 1.5 * (2 - row), 0.5), BASE | inputs_of(value))
    bpy.context.view_layer.update()
    return scene


def pictures(scene, samples, runs=4):
    """{engine: (runs, H, W, 3)} of independent renders that together took `samples`, and seconds of each engine."""
    found, seconds = {}, {}
    for engine in ("ZRAKA", "CYCLES"):
        started = time.perf_counter()
        found[engine] = np.stack([picture(scene, engine, samples // runs, seed) for seed in range(1, runs + 1)])
        seconds[engine] = time.perf_counter() - started
    return found, seconds


def _material(name, inputs):
    material = bpy.data.materials.new(name)
    tree = emptied(material)
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(add(tree, "BsdfPrincipled", inputs).outputs[0], output.inputs["Surface"])
    return material


def _ball():
    """Rings and segments of a smooth sphere, as vertices and faces."""
    import bmesh

    mesh = bpy.data.meshes.new("Ball")
    shape = bmesh.new()
    bmesh.ops.create_uvsphere(shape, u_segments=64, v_segments=32, radius=0.5)
    shape.to_mesh(mesh)
    shape.free()
    mesh.shade_smooth()
    return mesh


def _add_ball(scene, mesh, location, inputs):
    mesh = mesh.copy()
    mesh.materials.append(_material("Ball", inputs))
    ball = bpy.data.objects.new("Ball", mesh)
    ball.location = location
    scene.collection.objects.link(ball)


def _add_floor(scene):
    mesh = bpy.data.meshes.new("Floor")
    mesh.from_pydata([(-20, -20, 0), (20, -20, 0), (20, 20, 0), (-20, 20, 0)], [], [(0, 1, 2, 3)])
    mesh.materials.append(_material("Floor", {"Base Color": (0.5, 0.5, 0.5, 1.0), "Roughness": 0.8}))
    scene.collection.objects.link(bpy.data.objects.new("Floor", mesh))


def _add_light(scene):
    lamp = bpy.data.lights.new("Area", "AREA")
    lamp.energy, lamp.size = 500.0, 3.0
    light = bpy.data.objects.new("Area", lamp)
    light.location, light.rotation_euler = (-3.0, -3.0, 6.0), (0.55, -0.4, 0.0)
    scene.collection.objects.link(light)
    scene.world = world = bpy.data.worlds.new("World")
    tree = emptied(world)
    sky = add(tree, "Background", {"Color": (0.5, 0.6, 0.8, 1.0), "Strength": 0.5})
    tree.links.new(sky.outputs[0], tree.nodes.new("ShaderNodeOutputWorld").inputs["Surface"])


def main():
    """Render the chart by both engines and say how far they agree."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--samples", type=int, default=1024)
    parser.add_argument("--pixels", type=int, default=240)
    parser.add_argument("--keep", type=Path, help="folder for the pictures and the misfit, as .npz")
    args = parser.parse_args()
    found, seconds = pictures(build(args.pixels), args.samples)
    ours, theirs = found["ZRAKA"], found["CYCLES"]
    print(
        f"{agreement(ours, theirs):.2%} of the blocks agree, {power(ours, theirs):.1%} would tell a shift of 5%; "
        f"mean {ours.mean() / theirs.mean():.4f} of Cycles'; {seconds['ZRAKA']:.0f} s against {seconds['CYCLES']:.0f} s"
    )
    if args.keep:
        np.savez(args.keep / "chart.npz", misfit=misfit(ours, theirs), **found)


if __name__ == "__main__":
    main()
