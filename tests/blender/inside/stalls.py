# SPDX-License-Identifier: GPL-3.0-or-later
"""How long Blender's own thread is busy with Zraka, call by call, under Rendered shading in several files.

``blender cornell.blend --python stalls.py -- FOLDER FILE...``; FOLDER gets ``log.json``.
"""

from __future__ import annotations

import sys
from pathlib import Path

import bpy
from mathutils import Quaternion

sys.path.insert(0, str(Path(__file__).parent))
from driver import FOLDER, Driver, View, Viewports

FILES = sys.argv[sys.argv.index(str(FOLDER)) + 1 :]
SAMPLES = 1
log = {"update": [], "draw": []}
view = View()


def steps():
    bpy.context.preferences.view.show_splash = False
    bpy.context.preferences.system.viewport_aa = "OFF"
    yield 1.0
    bpy.context.scene.render.engine = "ZRAKA"
    view.bare()
    view.space.shading.type = "RENDERED"
    yield lambda: "bl_ext.user_default.zraka.addon.viewport.viewport" in sys.modules
    yield 5.0  # until all is read
    viewports = Viewports(sys.modules["bl_ext.user_default.zraka.addon.viewport.viewport"].Viewport, SAMPLES, log)
    for file in FILES:
        view.space.shading.type = "SOLID"
        bpy.ops.wm.open_mainfile(filepath=file, load_ui=False)
        yield 0.5
        log["update"], log["draw"] = [], []
        yield from edits(viewports)
        log[file] = {name: [busy for _, busy in log[name]] for name in ("update", "draw")}


def edits(viewports):
    """The first picture, turns, moves of objects, changes of materials, a selection, an object that is hidden."""
    scene = bpy.context.scene
    scene.render.engine = "ZRAKA"
    scene.zraka.viewport_samples = SAMPLES
    count = len(viewports.workers)
    view.space.shading.type = "RENDERED"
    yield lambda: len(viewports.workers) > count
    yield from viewports.rest()
    for _ in range(5):
        view.space.region_3d.view_rotation @= Quaternion((0, 1, 0), 0.02)
        yield 0.2
    names = [o.name for o in scene.objects if o.type == "MESH"][:5]
    for name in (names * 5)[:5]:
        bpy.data.objects[name].location.x += 0.01
        yield 0.2
    for material in [m for m in bpy.data.materials if m.node_tree][:3]:
        for node in material.node_tree.nodes:
            if node.type.startswith("BSDF"):
                node.inputs[0].default_value = (0.5, 0.3, 0.2, 1.0)
        yield 0.2
    for change in (False, True):
        bpy.data.objects[names[0]].select_set(change)
        yield 0.2
        bpy.data.objects[names[0]].hide_viewport = not change
        yield 0.2


Driver(steps(), log).start()
