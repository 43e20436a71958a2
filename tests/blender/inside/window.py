# SPDX-License-Identifier: GPL-3.0-or-later
"""Drives Blender's window as a user would, and writes down what happened: ``blender --python window.py -- FOLDER``.

FOLDER gets ``log.json`` and pictures of the screen.
"""

from __future__ import annotations

import importlib
import sys
import time
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from driver import FOLDER, Driver, click, move, press, shot

ZRAKA = "bl_ext.user_default.zraka"
TABS = ("RENDER", "OUTPUT", "VIEW_LAYER", "SCENE", "WORLD", "OBJECT", "DATA", "MATERIAL")
F12 = "96"  # a key code: in some keymaps the name would come with Alt

session = importlib.import_module(f"{ZRAKA}.addon.session")
ui = importlib.import_module(f"{ZRAKA}.addon.ui")
log = {
    "panels": [cls.__name__ for cls in ui.CLASSES],
    "drawn": [],
    "previews": 0,
    "shown": [],
    "breaks": [],
    "handlers": [],
}


# -- what is watched ---------------------------------------------------------------------------------------------------


class Watched:
    """An engine that notes when Blender was asked for a cancel and when pictures were shown."""

    def __init__(self, engine):
        self._engine = engine

    def __getattr__(self, name):
        return getattr(self._engine, name)

    def test_break(self):
        cancelled = self._engine.test_break()
        if cancelled:
            log["breaks"].append(time.perf_counter())
        return cancelled

    def update_result(self, result):
        self._engine.update_result(result)
        log["shown"].append(time.perf_counter())


def watch_renders():
    render_job = session.render_job

    def watched(job, engine, view_layer):
        if engine.is_preview:
            log["previews"] += 1
            render_job(job, engine, view_layer)
            return
        log["started"] = time.perf_counter()
        try:
            render_job(job, Watched(engine), view_layer)
        finally:
            log["returned"] = time.perf_counter()

    session.render_job = watched
    for name in ("render_cancel", "render_complete"):
        getattr(bpy.app.handlers, name).append(lambda *_, name=name: log["handlers"].append(name))


def watch_panels():
    """Note which of Zraka's panels were drawn, and open those that are closed at first."""

    def watched(cls, draw):
        def noted(self, context):
            draw(self, context)
            log["drawn"].append(cls.__name__)

        return noted

    ui.unregister()
    for cls in ui.CLASSES:
        cls.bl_options = set()
        cls.draw = watched(cls, cls.draw)
    ui.register()


# -- what is done ------------------------------------------------------------------------------------------------------


def steps():
    """Yield seconds to wait, or a function that is true when the wait is over."""
    context = bpy.context
    context.preferences.view.show_splash = False
    window = context.window_manager.windows[0]
    areas = {area.type: area for area in window.screen.areas}
    yield 1.0

    watch_panels()
    watch_renders()
    properties = areas["PROPERTIES"]
    yield from choose_engine(window, properties)
    log["engine"] = context.scene.render.engine
    context.scene.render.engine = "ZRAKA"
    yield from look_at_panels(context, properties)

    yield from render_and_cancel(context, areas["VIEW_3D"])


def choose_engine(window, properties):
    """Open the drop-down by a click and choose Zraka by its letter."""
    properties.spaces.active.context = "RENDER"
    window.scene.render.engine = "BLENDER_WORKBENCH"
    yield 1.0
    region = next(region for region in properties.regions if region.type == "WINDOW")
    scale = bpy.context.preferences.system.ui_scale
    for patience in (1.5, 3.0, 6.0):  # nothing tells when a menu stands open
        click(window, region.x + 0.65 * region.width, region.y + region.height - 57 * scale)
        yield patience
        shot("engines")
        press("z")
        yield patience
        if window.scene.render.engine == "ZRAKA":
            return
        press("Escape")
        yield patience


def look_at_panels(context, properties):
    """Draw each tab of the properties, for a mesh; the tab of an object for an empty as well."""
    empty = bpy.data.objects.new("Ground", None)
    context.scene.collection.objects.link(empty)
    empty.zraka.plane = True
    mesh = next(thing for thing in context.scene.objects if thing.type == "MESH")
    for method, thing in (("PATHTRACE", mesh), ("RAYTRACE", empty)):
        context.scene.zraka.method = method
        context.view_layer.objects.active = thing
        for tab in TABS if thing is mesh else ("RENDER", "OBJECT"):
            already = len(log["drawn"])
            properties.spaces.active.context = tab
            yield 0.6
            if (tab, thing) in {("RENDER", mesh), ("RENDER", empty), ("OBJECT", empty)}:
                yield lambda already=already: len(log["drawn"]) > already
            elif tab == "MATERIAL":
                yield lambda: log["previews"]
            shot(f"tab-{tab.lower()}-{thing.type.lower()}")
    context.scene.zraka.method = "PATHTRACE"
    bpy.data.objects.remove(empty)


def render_and_cancel(context, view):
    """F12, a picture of the first pass, Escape, and what is left."""
    context.preferences.view.render_display_type = "SCREEN"
    scene = context.scene
    scene.render.resolution_x = scene.render.resolution_y = 400
    scene.zraka.samples = 100000
    move(context.window_manager.windows[0], view.x + view.width / 2, view.y + view.height / 2)
    yield 0.5
    log["f12"] = time.perf_counter()
    press(F12)
    yield lambda: log["shown"]
    yield 1.0
    shot("first-passes")
    yield lambda: len(log["shown"]) >= 4
    shot("later")
    log["escape"] = time.perf_counter()
    press("Escape")
    yield lambda: "returned" in log and log["handlers"]
    yield 1.5
    shot("cancelled")
    scene.render.image_settings.file_format = "PNG"
    bpy.data.images["Render Result"].save_render(str(FOLDER / "kept.png"))


Driver(steps(), log).start()
