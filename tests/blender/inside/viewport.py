# SPDX-License-Identifier: GPL-3.0-or-later
"""Rendered shading while the scene, the view, the engine and the file change under it.

``blender cornell.blend --python viewport.py -- FOLDER``; FOLDER gets ``log.json`` and pictures.
"""

from __future__ import annotations

import importlib
import random
import sys
import threading
import time
from pathlib import Path

import bpy
from mathutils import Matrix, Quaternion

sys.path.insert(0, str(Path(__file__).parent))
from driver import FOLDER, Driver, View, Viewports, shot

module = importlib.import_module("bl_ext.user_default.zraka.addon.viewport.viewport")
METHODS = ("PHONG", "RAYCAST", "RAYTRACE", "PATHTRACE")
SAMPLES = 4
log = {"update": [], "draw": [], "exports": 0, "latency": {}, "region": None}
viewports = None


# -- what is watched ---------------------------------------------------------------------------------------------------


def watch():
    """Note how long Blender waits for us, how often the scene is exported, and which viewports there are."""
    export = module.Viewport._export

    def note_export(*args):
        log["exports"] += 1
        return export(*args)

    module.Viewport._export = note_export
    return Viewports(module.Viewport, SAMPLES, log)


def threads():
    """Number of viewports' threads that run."""
    return sum(thread.name == "Zraka viewport" for thread in threading.enumerate())


def first_picture(name):
    """Wait for the next picture, and note how long it took."""
    worker, before, started = viewports.latest, viewports.latest.picture, time.perf_counter()
    arrived = []
    show = worker._show

    def noted(*args):
        show(*args)
        arrived.append(time.perf_counter() - started)

    worker._show = noted
    yield lambda: arrived and worker.picture is not before
    log["latency"].setdefault(name, []).append(arrived[0])
    worker._show = show


# -- what is done ------------------------------------------------------------------------------------------------------


view = View()


def steps():
    global viewports
    bpy.context.preferences.view.show_splash = False
    bpy.context.preferences.system.viewport_aa = "OFF"
    yield 1.0
    scene = bpy.context.scene
    scene.render.engine = "ZRAKA"
    scene.zraka.samples = scene.zraka.viewport_samples = SAMPLES
    view.bare()
    viewports = watch()
    yield 0.5
    yield from shows_what_f12_shows(scene)
    yield from orbits(scene)
    yield from edits()
    yield from borders(scene)
    yield from switches(scene)
    yield from many_edits(scene)
    yield from loads()


def shows_what_f12_shows(scene):
    """The same view, perspective and orthographic, in the viewport and as a render."""
    space = view.space
    data = space.region_3d
    data.view_perspective = "PERSP"
    data.view_location = (0.2, 0.3, 1.0)
    data.view_distance = 2.5
    data.view_rotation = scene.camera.matrix_world.to_quaternion() @ Quaternion((0, 1, 0), 0.2)
    space.shading.type = "RENDERED"
    yield lambda: viewports.workers and viewports.latest.picture
    yield from viewports.rest()
    region = view.region
    log["region"] = [region.x, region.y, region.width, region.height]
    for method in METHODS:
        scene.zraka.method = method
        scene.update_tag()  # as the panel's buttons do
        yield from viewports.rest()
        shot(f"viewport-{method}")
    render_view(scene, "perspective")
    shot("viewport-perspective")
    data.view_perspective = "ORTHO"
    yield from viewports.rest()
    shot("viewport-orthographic")
    render_view(scene, "orthographic")
    data.view_perspective = "PERSP"
    yield from viewports.rest()


def render_view(scene, name):
    """Render what the viewport shows by a camera of its own."""
    space, region, render = view.space, view.region, scene.render
    data = space.region_3d
    camera = bpy.data.cameras.new(name)
    camera.lens, camera.sensor_width = space.lens / 2, 36
    camera.clip_start, camera.clip_end = space.clip_start, space.clip_end
    thing = bpy.data.objects.new(name, camera)
    thing.matrix_world = data.view_matrix.inverted()
    if name == "orthographic":
        camera.type = "ORTHO"
        camera.ortho_scale = 2 / data.window_matrix[0][0]
        back = 100.0  # the viewport shows what lies behind the viewer as well
        camera.clip_end = 2 * back
        thing.matrix_world @= Matrix.Translation((0, 0, back))
    scene.collection.objects.link(thing)
    before, size = scene.camera, (render.resolution_x, render.resolution_y)
    scene.camera = thing
    render.resolution_x, render.resolution_y, render.resolution_percentage = region.width, region.height, 100
    render.dither_intensity = 0
    render.image_settings.file_format = "PNG"
    render.filepath = str(FOLDER / f"f12-{name}.png")
    bpy.ops.render.render(write_still=True)
    scene.camera = before
    render.resolution_x, render.resolution_y = size
    bpy.data.objects.remove(thing)


def orbits(scene):
    """The view turns, at rest and while it is still being rendered."""
    for method in ("PATHTRACE", "RAYCAST"):
        scene.zraka.method = method
        scene.update_tag()
        yield from viewports.rest()
        for _ in range(5):
            view.space.region_3d.view_rotation @= Quaternion((0, 1, 0), 0.05)
            yield from first_picture(method)
            yield 0.1
        yield from viewports.rest()
    shot("orbited")
    exports = log["exports"]
    view.space.region_3d.view_rotation @= Quaternion((0, 1, 0), -0.25)
    yield from viewports.rest()
    log["exports_of_a_view"] = log["exports"] - exports


def edits():
    """A selection exports nothing; materials, transforms, a deletion and its undo are seen."""
    with view.override():
        bpy.ops.object.mode_set(mode="OBJECT") if bpy.context.object else None
        bpy.ops.object.select_all(action="DESELECT")
        bpy.ops.ed.undo_push(message="Start")
    yield from viewports.rest()
    exports = log["exports"]
    with view.override():
        bpy.data.objects["Tall box"].select_set(True)
        bpy.context.view_layer.objects.active = bpy.data.objects["Tall box"]
    yield 1.0
    log["exports_of_a_selection"] = log["exports"] - exports
    shot("before")
    material = bpy.data.objects["Tall box"].active_material.copy()
    bpy.data.objects["Tall box"].active_material = material
    shader = next(node for node in material.node_tree.nodes if node.type.startswith("BSDF"))
    shader.inputs[0].default_value = (0.8, 0.02, 0.02, 1)
    yield from viewports.rest()
    shot("red")
    with view.override():
        bpy.ops.ed.undo_push(message="Red")
        bpy.ops.object.delete()
        bpy.ops.ed.undo_push(message="Delete")
    yield from viewports.rest()
    shot("deleted")
    with view.override():
        bpy.ops.ed.undo()
    yield from viewports.rest()
    shot("undone")


def borders(scene):
    """The region's border, and the camera's in a camera view."""
    scene = bpy.context.scene
    space = view.space
    space.use_render_border = True
    space.render_border_min_x, space.render_border_max_x = 0.25, 0.75
    space.render_border_min_y, space.render_border_max_y = 0.25, 0.75
    yield from viewports.rest()
    shot("border")
    space.use_render_border = False
    space.region_3d.view_perspective = "CAMERA"
    yield from viewports.rest()
    shot("camera")
    scene.render.use_border = True
    scene.render.border_min_x, scene.render.border_max_x = 0.5, 1.0
    scene.render.border_min_y, scene.render.border_max_y = 0.0, 0.5
    yield from viewports.rest()
    shot("camera-border")
    scene.render.use_border = False
    yield from viewports.rest()


def switches(scene):
    """Other engines and back, four views, edit mode, local view; nothing is left running."""
    scene = bpy.context.scene
    for engine in ("BLENDER_WORKBENCH", "CYCLES"):
        if engine == "CYCLES":
            scene.cycles.preview_samples = 1
        view.space.region_3d.view_distance += 0.01
        yield 0.2
        scene.render.engine = engine
        yield 1.5
        log[f"threads_in_{engine}"] = threads()
        scene.render.engine = "ZRAKA"
        yield 1.0
        yield from viewports.rest()
    shot("back")
    with view.override():
        bpy.ops.screen.region_quadview()
    yield lambda: threads() == 4
    yield lambda: all(not worker.busy for worker in viewports.workers)
    yield 1.0
    shot("quad")
    with view.override():
        bpy.ops.screen.region_quadview()
    yield lambda: threads() == 1
    with view.override():
        bpy.ops.object.mode_set(mode="EDIT")
    yield from viewports.rest()
    with view.override():
        bpy.ops.object.mode_set(mode="OBJECT")
        bpy.ops.view3d.localview()
    yield from viewports.rest()
    shot("local")
    with view.override():
        bpy.ops.view3d.localview()
    yield from viewports.rest()


def many_edits(scene):
    """Random edits, some of them undone, faster than pictures come."""
    rng = random.Random(1)
    names = ("Tall box", "Short box")
    for step in range(60):
        thing = bpy.data.objects[rng.choice(names)]
        kind = rng.randrange(4)
        if kind == 0:
            thing.location.x += rng.uniform(-0.1, 0.1)
        elif kind == 1:
            bpy.context.scene.zraka.method = rng.choice(METHODS)
            bpy.context.scene.update_tag()
        elif kind == 2:
            thing.hide_viewport = not thing.hide_viewport
        else:
            view.space.region_3d.view_distance += rng.uniform(-0.2, 0.2)
        with view.override():
            bpy.ops.ed.undo_push(message=f"Edit {step}")
            if rng.random() < 0.4:
                bpy.ops.ed.undo()
        yield rng.choice((0.0, 0.02, 0.2))
    for _ in range(20):
        with view.override():
            if bpy.ops.ed.undo.poll():
                bpy.ops.ed.undo()
        yield 0.02
    yield from viewports.rest()
    shot("many")
    log["threads_after_edits"] = threads()


def loads():
    """Another file while this one is rendered; the window is closed while that one is."""
    bpy.context.scene.zraka.viewport_samples = 10000
    bpy.context.scene.update_tag()
    yield 0.5
    bpy.ops.wm.read_homefile(use_factory_startup=False, load_ui=True)
    yield 1.5
    log["threads_after_load"] = threads()
    bpy.context.scene.render.engine = "ZRAKA"
    view.space.shading.type = "RENDERED"
    yield lambda: viewports.latest.picture is not None and viewports.latest.busy
    yield 1.0
    shot("loaded")


Driver(steps(), log).start()
