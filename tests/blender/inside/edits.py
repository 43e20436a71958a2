# SPDX-License-Identifier: GPL-3.0-or-later
"""Random edits under Rendered shading, many of them undone; then the picture beside one of a fresh start.

``blender cornell.blend --python edits.py -- FOLDER COUNT``; FOLDER gets ``log.json`` and pictures.
"""

from __future__ import annotations

import ctypes
import gc
import random
import sys
import threading
import time
from pathlib import Path

import bpy
import numpy as np
from mathutils import Quaternion

sys.path.insert(0, str(Path(__file__).parent))
from driver import Driver, View, Viewports, shot

COUNT = int(sys.argv[-1])
SAMPLES = 4
MOST_OBJECTS = 16
log = {"update": [], "draw": [], "first": [], "cancel": [], "compile": [], "megabytes": [], "pauses": []}
view = View()
rng = random.Random(7)


# -- what is watched ---------------------------------------------------------------------------------------------------


def watch(module):
    """Note how long Blender waits for Zraka, and how long Zraka takes to begin with what is newly wanted."""
    viewports, worker = Viewports(module.Viewport, SAMPLES, log), module.Worker
    want, attempt, show = worker.want, worker._try, worker._show
    asked = {}

    def note_want(self, job):
        asked[self] = time.perf_counter(), self.busy, job
        want(self, job)

    def note_attempt(self, job):
        when, was_busy, of = asked[self]
        if was_busy and of is job:
            log["cancel"].append(time.perf_counter() - when)
        attempt(self, job)

    def note_show(self, film, settings, divider, job):
        show(self, film, settings, divider, job)
        when, _, of = asked[self]
        if of is job:
            log["first"].append(time.perf_counter() - when)
            asked[self] = when, False, None

    worker.want, worker._try, worker._show = note_want, note_attempt, note_show
    worker._compile = viewports.timed("compile", worker._compile)
    return viewports


def ticks():
    """A timer that notes pauses of Blender's own thread, from whatever."""
    last = time.perf_counter()

    def tick():
        nonlocal last
        before, last = last, time.perf_counter()
        log["pauses"].append(last - before - 0.01)
        return 0.01

    return tick


def megabytes():
    """Memory in use, without what the allocator keeps for itself: glibc's, or the one that Debian's Blender brings."""
    gc.collect()
    program = ctypes.CDLL(None)
    program.malloc_trim(0)
    if hasattr(program, "mallctl"):  # jemalloc, in 4.3: the dirty pages of all arenas
        program.mallctl(b"arena.4096.purge", None, None, None, 0)
    if hasattr(program, "scalable_allocation_command"):  # TBB's, in 5.2
        program.scalable_allocation_command(0, None)
    text = Path("/proc/self/status").read_text(encoding="utf-8")
    return int(text.split("VmRSS:")[1].split()[0]) / 1024


# -- edits -------------------------------------------------------------------------------------------------------------


def meshes():
    """Objects that may be changed, the same ones in every run."""
    return sorted((o for o in bpy.context.scene.objects if o.type == "MESH"), key=lambda o: o.name)


def boxes():
    """Those of them that may go."""
    return [o for o in meshes() if "box" in o.name or o.name.startswith("Cube")]


def color():
    return rng.random(), rng.random(), rng.random(), 1.0


def move():
    thing = rng.choice(boxes())
    thing.location = [v + rng.uniform(-0.1, 0.1) for v in thing.location]


def paint():
    material = rng.choice(boxes()).active_material
    shader = next((n for n in material.node_tree.nodes if n.type.startswith("BSDF")), None) if material else None
    if shader is not None:
        shader.inputs[0].default_value = color()


def repaint():
    """A new material, with a texture at times."""
    material = bpy.data.materials.new("Paint")
    if not material.use_nodes:  # until 5.2 they begin without
        material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    shader = next(n for n in nodes if n.type.startswith("BSDF"))
    shader.inputs[0].default_value = color()
    if rng.random() < 0.5:
        texture = nodes.new("ShaderNodeTexChecker")
        links.new(texture.outputs[0], shader.inputs[0])
    thing = rng.choice(boxes())
    thing.data.materials.clear()
    thing.data.materials.append(material)


def add():
    if len(bpy.context.scene.objects) < MOST_OBJECTS:
        place = [rng.uniform(-0.5, 0.5) for _ in range(3)]
        bpy.ops.mesh.primitive_cube_add(size=rng.uniform(0.05, 0.3), location=place)


def copy():
    if len(bpy.context.scene.objects) < MOST_OBJECTS:
        select(rng.choice(boxes()))
        bpy.ops.object.duplicate(linked=rng.random() < 0.5)
        bpy.context.object.location.x += 0.2


def delete():
    if len(boxes()) > 2:
        select(rng.choice(boxes()))
        bpy.ops.object.delete()


def hide():
    thing = rng.choice(boxes())
    thing.hide_viewport = not thing.hide_viewport


def sculpt():
    vertex = rng.choice(rng.choice(boxes()).data.vertices)
    vertex.co.x += rng.uniform(-0.05, 0.05)
    vertex.id_data.update()


def edit_mode():
    shown = [o for o in boxes() if o.visible_get()]
    if shown:
        select(rng.choice(shown))
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_all(action="SELECT")
        bpy.ops.transform.translate(value=(0.02, 0.0, 0.0))
        bpy.ops.object.mode_set(mode="OBJECT")


def modify():
    thing = rng.choice(boxes())
    if thing.modifiers:
        thing.modifiers.clear()
    else:
        thing.modifiers.new("Bevel", "BEVEL").width = 0.02


def light():
    lamps = [o.data for o in bpy.context.scene.objects if o.type == "LIGHT"]
    if lamps:
        lamps[0].energy *= rng.uniform(0.7, 1.3)
    else:
        bpy.ops.object.light_add(type="POINT", location=(0.0, 0.0, 0.5))
        bpy.context.object.data.energy = 5.0


def sky():
    scene = bpy.context.scene
    if scene.world is None:
        scene.world = bpy.data.worlds.new("World")
    scene.world.color = color()[:3]
    for node in scene.world.node_tree.nodes if scene.world.node_tree else ():
        if node.type == "BACKGROUND":
            node.inputs[0].default_value = color()


def setting():
    """As a script does: nothing is tagged."""
    group = bpy.context.scene.zraka
    name = rng.choice(("method", "depth", "seed"))
    value = {"method": rng.choice(("PHONG", "RAYCAST", "RAYTRACE", "PATHTRACE"))}.get(name, rng.randrange(1, 6))
    setattr(group, name, value)


def orbit():
    view.space.region_3d.view_rotation @= Quaternion((0, 1, 0), rng.uniform(-0.1, 0.1))


def frame():
    bpy.context.scene.frame_set(rng.randrange(1, 5))


def undo():
    for _ in range(rng.randrange(1, 4)):
        if bpy.ops.ed.undo.poll():
            bpy.ops.ed.undo()


def redo():
    if bpy.ops.ed.redo.poll():
        bpy.ops.ed.redo()


EDITS = (
    *(move, paint, repaint, add, copy, delete, hide, sculpt, edit_mode, modify, light, sky, setting, orbit, frame),
    *(move, paint, orbit),
    *[undo] * 6,
    *[redo] * 2,
)


def select(thing):
    bpy.ops.object.select_all(action="DESELECT")
    thing.hide_viewport = False
    thing.hide_set(False)
    thing.select_set(True)
    bpy.context.view_layer.objects.active = thing


# -- the run -----------------------------------------------------------------------------------------------------------


def steps():
    bpy.context.preferences.view.show_splash = False
    bpy.context.preferences.system.viewport_aa = "OFF"
    yield 1.0
    scene = bpy.context.scene
    bpy.app.timers.register(ticks(), persistent=True)
    yield 1.0
    scene.render.engine = "ZRAKA"
    scene.zraka.viewport_samples = SAMPLES
    view.bare()
    before = len(log["pauses"])
    view.space.shading.type = "RENDERED"
    data = view.space.region_3d
    data.view_perspective = "PERSP"
    data.view_location, data.view_distance = (0.2, 0.3, 1.0), 2.5
    data.view_rotation = scene.camera.matrix_world.to_quaternion()
    yield lambda: "bl_ext.user_default.zraka.addon.viewport.worker" in sys.modules
    yield 5.0
    log["pause_of_the_first_use"] = max(log["pauses"][before:])
    # That modules are read meanwhile must not leave the viewport empty.
    threads = [thread.name for thread in threading.enumerate()]
    log["began"] = "Zraka viewport" in threads
    # Only now: what watches reads the modules too.
    viewports = watch(sys.modules["bl_ext.user_default.zraka.addon.viewport.viewport"])
    yield from fresh(viewports)
    region = view.region
    log["region"] = [region.width, region.height]
    yield from orbits(viewports)
    for number in range(COUNT):
        if number == COUNT // 5:
            yield from viewports.rest()
            log["megabytes"].append(megabytes())
        with view.override():
            if bpy.context.object is not None and bpy.context.object.mode != "OBJECT":  # an undo led there
                bpy.ops.object.mode_set(mode="OBJECT")
            edit = rng.choice(EDITS)
            edit()
            if edit not in (undo, redo):
                bpy.ops.ed.undo_push(message=f"{number} {edit.__name__}")
        yield rng.choice((0.0, 0.02, 0.1, 0.3))
    if bpy.context.scene.zraka.method == "PHONG":
        bpy.context.scene.zraka.method = "PATHTRACE"
    yield from viewports.rest()
    log["megabytes"].append(megabytes())
    log["threads"] = sum(thread.name == "Zraka viewport" for thread in threading.enumerate())
    shot("edited")
    edited = viewports.latest.picture.pixels.copy()
    yield from fresh(viewports)
    shot("fresh")
    anew = viewports.latest.picture.pixels
    log["mean"] = float(anew[..., :3].mean())
    log["different"] = float((np.abs(edited - anew) > 1e-4 * (1 + np.abs(anew))).any(axis=2).mean())


def fresh(viewports):
    """Rendered shading from its beginning."""
    count = len(viewports.workers)
    view.space.shading.type = "SOLID"
    yield 0.5
    view.space.shading.type = "RENDERED"
    yield lambda: len(viewports.workers) > count and viewports.latest.picture is not None
    yield from viewports.rest()


def orbits(viewports):
    """The first picture after the view turned, by ray casting."""
    bpy.context.scene.zraka.method = "RAYCAST"
    yield from viewports.rest()
    log["first"].clear()
    for _ in range(20):
        view.space.region_3d.view_rotation @= Quaternion((0, 1, 0), 0.02)
        yield 0.5
    log["first_of_orbits"] = list(log["first"])
    bpy.context.scene.zraka.method = "PATHTRACE"
    yield from viewports.rest()


Driver(steps(), log).start()
