# SPDX-License-Identifier: GPL-3.0-or-later
"""Many instances, large meshes, animations: what they cost. Each case is measured in a process of its own.

``python -m zraka.tests.addon.large_cases NUMBER`` measures one and prints words for it.
"""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from unittest import mock

import bpy

from zraka.addon import headless
from zraka.addon.bench.engines import match, operate
from zraka.addon.export import scene as scene_export
from zraka.core.accel import Accel
from zraka.core.compile import compile_scene, memory
from zraka.core.diagnostics import Diagnostics, SceneError
from zraka.core.settings import Settings

from .geometry_scenes import grid_of, primitive, put

NODE = "GeometryNodeInstanceOnPoints"
FREE = 8 * 10**9  # bytes where many instances are refused
FRAMES = 24


@dataclass(frozen=True)
class Case:
    """``run(scene)`` returns words for what it measured."""

    item: str
    run: Callable
    note: str = ""


def prepare(scene):
    """A camera high above, a sun, a small picture of one sample."""
    scene.camera = scene.camera or put(scene, bpy.data.cameras.new("Camera"), "Camera", location=(0, 0, 30))
    bpy.ops.object.light_add(type="SUN")
    render = scene.render
    render.resolution_x = render.resolution_y = 16
    render.threads_mode, render.threads = "FIXED", 2
    scene.zraka.samples = 1
    match(scene)


def instances(number, triangles):
    """A square of `number` instances of a grid of about `triangles` triangles, by geometry nodes."""
    rock = primitive("grid", x_subdivisions=(side := round((triangles / 2) ** 0.5)), y_subdivisions=side, size=0.5)
    rock.location.z = -50
    points = round(number**0.5)
    plane = primitive("grid", x_subdivisions=points - 1, y_subdivisions=points - 1, size=20)
    (on_points,) = grid_of(plane, None, (NODE, {}))
    group = on_points.id_data
    source = group.nodes.new("GeometryNodeObjectInfo")
    source.inputs["Object"].default_value = rock
    source.inputs["As Instance"].default_value = True
    group.links.new(source.outputs["Geometry"], on_points.inputs["Instance"])


def peak():
    """Words for the most memory that this process had."""
    import resource

    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)
    return f"{most / 1e9:.1f} GB at most"


def too_many(scene):
    """What becomes of instances that do not fit."""
    instances(10_000, 10_000)
    started = time.perf_counter()
    try:
        with mock.patch.object(memory, "available_bytes", lambda: FREE):
            operate(scene, "ZRAKA")
    except SceneError as error:
        return f"ends after {time.perf_counter() - started:.1f} s, {peak()}: “{error}”"
    raise AssertionError("100 million triangles were rendered in 8 GB")


def many(scene):
    """Render instances that do."""
    instances(1024, 10_000)
    _, seconds = operate(scene, "ZRAKA")
    return f"render in {seconds:.1f} s, {peak()}"


def export_share(scene, smooth):
    """Least processor time of an export of a million triangles and of Embree's tree over them, in seconds."""
    grid = primitive("grid", x_subdivisions=708, y_subdivisions=708)
    grid.data.polygons.foreach_set("use_smooth", [smooth] * len(grid.data.polygons))
    bpy.context.view_layer.update()
    seconds = {"export": [], "tree": []}
    for _ in range(4):  # Blender makes normals and triangles when first asked
        started = time.process_time()
        exported = scene_export.export_scene(bpy.context.evaluated_depsgraph_get(), Diagnostics())
        seconds["export"].append(time.process_time() - started)
    geometry = compile_scene(exported, Settings(width=16, height=16), Diagnostics()).geometry
    for _ in range(3):
        started = time.process_time()
        Accel(geometry)
        seconds["tree"].append(time.process_time() - started)
    return min(seconds["export"]), min(seconds["tree"])


def export_beside_tree(smooth):
    """A case's function."""

    def run(scene):
        export, tree = export_share(scene, smooth)
        return (
            f"{100 * export / tree:.0f}% of the time of Embree's tree, {export:.3f} of {tree:.2f} s of processor time"
        )

    return run


@contextlib.contextmanager
def counted():
    """Counts exports of meshes by the objects' names."""
    seen, original = Counter(), scene_export.export_mesh

    def call(obj, *args):
        seen[obj.name] += 1
        return original(obj, *args)

    with mock.patch.object(scene_export, "export_mesh", call):
        yield seen


def animate(scene, persistent):
    """How often each mesh is exported in an animation of a cube that moves before still ones."""
    names = [primitive("cube", size=0.5, location=(k - 2, 0, 0)).name for k in range(5)]
    mover = bpy.data.objects[names[0]]
    for frame, y in ((1, 0.0), (FRAMES, 1.0)):
        mover.location.y = y
        mover.keyframe_insert("location", frame=frame)
    scene.frame_start, scene.frame_end = 1, FRAMES
    scene.render.engine, scene.render.use_persistent_data = "ZRAKA", persistent
    with tempfile.TemporaryDirectory() as folder, counted() as seen, headless.quiet():
        scene.render.filepath = f"{folder}/"
        bpy.ops.render.render(animation=True)
    return [seen[name] for name in names]


def animation(persistent):
    """A case's function."""

    def run(scene):
        moved, *still = animate(scene, persistent)
        return f"each still mesh exported {max(still)}×, the one that moves {moved}×"

    return run


CASES = (
    Case("10,000 instances of a mesh of 10,000 triangles", too_many, f"where {FREE / 1e9:.0f} GB are free"),
    Case("1,024 instances of a mesh of 10,000 triangles", many, "Blender's own memory included"),
    *(
        Case(f"export of a million triangles, {'smooth' if smooth else 'flat'}", export_beside_tree(smooth))
        for smooth in (False, True)
    ),
    *(
        Case(
            f"{FRAMES} frames with one moving object, {'with' if kept else 'without'} persistent data", animation(kept)
        )
        for kept in (True, False)
    ),
)


def measure(case):
    """Words for a case, measured in a fresh process."""
    command = [sys.executable, "-m", __spec__.name, str(CASES.index(case))]
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=os.environ)
    return done.stdout.strip().splitlines()[-1]


if __name__ == "__main__":
    import zraka

    zraka.register()
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    prepare(bpy.context.scene)
    print(CASES[int(sys.argv[1])].run(bpy.context.scene))
