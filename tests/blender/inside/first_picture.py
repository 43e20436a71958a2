# SPDX-License-Identifier: GPL-3.0-or-later
"""How soon after its export a render shows something: ``blender [-b] --python first_picture.py -- FOLDER``.

FOLDER gets ``log.json`` with the seconds of each render, of the scene as it is but for the number of samples. With a
window they are begun by F12.
"""

from __future__ import annotations

import importlib
import json
import sys
import time
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from driver import FOLDER, Driver, move, press

RENDERS = 6
F12 = "96"  # a key code: in some keymaps the name would come with Alt

session = importlib.import_module("bl_ext.user_default.zraka.addon.session")
log = {"seconds": [], "ended": 0}


def watch():
    """Note the time from the end of `update` to the return of the first `update_result`."""
    update, on_pass = session.Session.update, session.Display.on_pass
    exported = []

    def updated(self, engine, depsgraph):
        update(self, engine, depsgraph)
        if not engine.is_preview:
            exported.append(time.perf_counter())

    def shown(display, film, progress):
        on_pass(display, film, progress)  # the first is always shown
        if exported:
            log["seconds"].append(time.perf_counter() - exported.pop())

    session.Session.update, session.Display.on_pass = updated, shown
    bpy.app.handlers.render_complete.append(lambda *_: log.update(ended=log["ended"] + 1))


def steps():
    """Press F12 over the viewport, again and again."""
    context = bpy.context
    context.preferences.view.show_splash = False
    context.preferences.view.render_display_type = "NONE"
    window = context.window_manager.windows[0]
    view = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    yield 1.0
    for number in range(1, RENDERS + 1):
        move(window, view.x + view.width / 2, view.y + view.height / 2 + number)
        yield 0.5
        press(F12)
        yield lambda number=number: log["ended"] >= number


watch()
scene = bpy.context.scene
scene.render.engine = "ZRAKA"
scene.zraka.samples = 4
log["size"] = [scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage]
if bpy.app.background:
    for _ in range(RENDERS):
        bpy.ops.render.render()
    (FOLDER / "log.json").write_text(json.dumps(log), encoding="utf-8")
else:
    Driver(steps(), log).start()
