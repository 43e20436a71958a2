# SPDX-License-Identifier: GPL-3.0-or-later
"""Drives Blender's window as a user would, and writes down what happened: ``blender --python window.py -- FOLDER``.

FOLDER gets ``log.json`` and pictures of the screen.
"""

from __future__ import annotations

import importlib
import sys
import time
from itertools import pairwise
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from driver import FOLDER, Driver, click, move, press, shot

ZRAKA = "bl_ext.user_default.zraka"
TABS = {
    "mesh": ("RENDER", "OUTPUT", "VIEW_LAYER", "SCENE", "WORLD", "OBJECT", "DATA", "MATERIAL"),
    "empty": ("RENDER", "OBJECT"),
    "light": ("OBJECT", "DATA"),
    "camera": ("DATA",),
}
F12 = "96"  # a key code: in some keymaps the name would come with Alt

session = importlib.import_module(f"{ZRAKA}.addon.session")
ui = importlib.import_module(f"{ZRAKA}.addon.ui")
compare = importlib.import_module(f"{ZRAKA}.addon.compare")
log = {
    "panels": [cls.__name__ for cls in ui.CLASSES],
    "drawn": [],
    "previews": [],
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

    def end_result(self, result, **how):
        self._engine.end_result(result, **how)
        if not how:
            log["shown"].append(time.perf_counter())


class Previewed(Watched):
    """A preview's engine, of which is noted when the first picture comes; it is refined then."""

    def __init__(self, engine):
        super().__init__(engine)
        self._started = time.perf_counter()

    def test_break(self):
        return self._engine.test_break()

    def end_result(self, result, **how):
        self._engine.end_result(result, **how)
        if not how and self._started is not None:
            log["previews"].append(time.perf_counter() - self._started)
            self._started = None


def watch_renders():
    render_job = session.render_job

    def watched(job, engine, *rest):
        if engine.is_preview:
            return render_job(job, Previewed(engine), *rest)
        log["started"] = time.perf_counter()
        try:
            return render_job(job, Watched(engine), *rest)
        finally:
            log.setdefault("returned", time.perf_counter())  # of the first

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
    for closed in (bpy.types.OBJECT_PT_visibility, bpy.types.DATA_PT_preview):  # Blender's own
        bpy.utils.unregister_class(closed)
        closed.bl_options = set()
        bpy.utils.register_class(closed)
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
    areas = areas_of(window)
    yield 1.0

    watch_panels()
    watch_renders()
    properties = areas["PROPERTIES"]
    yield from choose_engine(window, properties)
    log["engine"] = context.scene.render.engine
    context.scene.render.engine = "ZRAKA"
    areas["VIEW_3D"].type = "PROPERTIES"  # for a long look
    yield 1.0  # its tabs are known when it was drawn
    yield from look_at_panels(context, (properties, areas["VIEW_3D"]))
    areas["VIEW_3D"].type = "VIEW_3D"
    yield from take_over_from_cycles(context)
    yield from compare_methods(context, areas["VIEW_3D"])

    yield from render_and_cancel(context, areas["VIEW_3D"])
    yield from look_at_the_latest_render(window)
    yield from watch_the_error(context, areas_of(window)["VIEW_3D"])


def areas_of(window):
    return {area.type: area for area in window.screen.areas}


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
    """Draw the tabs of the properties, for objects of each kind."""
    scene = context.scene
    empty = bpy.data.objects.new("Ground", None)
    scene.collection.objects.link(empty)
    empty.zraka.plane = True
    lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "AREA"))
    scene.collection.objects.link(lamp)
    camera = bpy.data.objects.new("All around", bpy.data.cameras.new("All around"))
    camera.data.type = "PANO"
    scene.collection.objects.link(camera)
    mesh = next(thing for thing in scene.objects if thing.type == "MESH")
    things = {"mesh": mesh, "empty": empty, "light": lamp, "camera": camera}
    for kind, tabs in TABS.items():
        scene.zraka.method = "RAYTRACE" if kind == "empty" else "PATHTRACE"
        context.view_layer.objects.active = things[kind]
        for tab in tabs:
            already, previews = len(log["drawn"]), len(log["previews"])
            for area in properties:
                area.spaces.active.context = tab
            yield 0.6
            if tab == "RENDER" or (tab, kind) in {("OBJECT", "empty"), ("DATA", "light")}:
                yield lambda already=already: len(log["drawn"]) > already
            if tab in {"MATERIAL", "WORLD"} or (tab, kind) == ("DATA", "light"):
                yield lambda previews=previews: len(log["previews"]) > previews
                yield 3.0  # the other editor's comes after
            shot(f"tab-{tab.lower()}-{kind}")
    scene.zraka.method = "PATHTRACE"
    for thing in (empty, lamp, camera):
        bpy.data.objects.remove(thing)


def take_over_from_cycles(context):
    """A scene that was made for Cycles, when Zraka is chosen for it."""
    scene = bpy.data.scenes.new("From Cycles")
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.max_bounces = 77, 3
    scene.render.engine = "ZRAKA"
    yield lambda: scene.zraka.took_over
    log["took_over"] = [scene.zraka.samples, scene.zraka.depth]
    bpy.data.scenes.remove(scene)


def compare_methods(context, area):
    """Into one image, with the interface free; then once more until Escape."""
    scene = context.scene
    scene.render.resolution_x = scene.render.resolution_y = 200
    scene.zraka.samples = 16
    beats = [time.perf_counter()]

    def finished():
        beats.append(time.perf_counter())
        image = bpy.data.images.get(compare.IMAGE)
        return image is not None and image.has_data

    area.type = "IMAGE_EDITOR"
    yield 1.0
    begin_comparison(context, area)
    beats.append(time.perf_counter())
    yield finished
    log["longest_pause"] = max(after - before for before, after in pairwise(beats[1:]))
    yield 1.0
    shot("compared")
    bpy.data.images[compare.IMAGE].save_render(str(FOLDER / "methods.png"))
    area.type = "VIEW_3D"
    scene.zraka.samples = 100000
    begin_comparison(context, area)
    yield 3.0
    shot("comparing")
    running = next(comparison for comparison in compare._live if comparison.busy)
    move(context.window_manager.windows[0], area.x + area.width / 2, area.y + area.height / 2)
    press("Escape")
    yield lambda: not running.busy
    log["left"] = len(running.films)


def begin_comparison(context, area):
    window = context.window_manager.windows[0]
    region = next(region for region in area.regions if region.type == "WINDOW")
    with context.temp_override(window=window, area=area, region=region):
        bpy.ops.zraka.compare_methods("INVOKE_DEFAULT")


def render_and_cancel(context, view):
    """F12, a picture of the first pass, Escape, and what is left."""
    context.preferences.view.render_display_type = "SCREEN"
    scene = context.scene
    scene.render.resolution_x = scene.render.resolution_y = 400
    scene.zraka.samples = 100000
    move(context.window_manager.windows[0], view.x + view.width / 2, view.y + view.height / 2)
    yield 0.5
    log["handlers"].clear()
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


def look_at_the_latest_render(window):
    """Its curve of errors, in the render tab, all other panels of Zraka's gone."""
    with bpy.context.temp_override(window=window, area=window.screen.areas[0]):
        bpy.ops.screen.back_to_previous()
    yield 1.0
    properties = next(area for area in window.screen.areas if area.type == "PROPERTIES")
    properties.spaces.active.context = "RENDER"
    others = [cls for cls in ui.CLASSES if cls.__name__ != "RENDER_PT_zraka_latest"]
    for cls in reversed(others):
        bpy.utils.unregister_class(cls)
    properties.tag_redraw()
    yield 1.5
    shot("latest")
    for cls in others:
        bpy.utils.register_class(cls)


def watch_the_error(context, area):
    """The curve in an image editor while a render goes on, and the page that is saved at its end."""
    context.preferences.view.render_display_type = "NONE"
    window = context.window_manager.windows[0]
    area.type = "IMAGE_EDITOR"
    yield 1.0
    bpy.ops.render.render("INVOKE_DEFAULT")
    yield lambda: goes_on(context.scene)
    region = next(region for region in area.regions if region.type == "WINDOW")
    with context.temp_override(window=window, area=area, region=region):
        bpy.ops.zraka.error_curve()
    image = bpy.data.images["Zraka Error"]
    first = image_sum(image)
    yield lambda: image_sum(image) != first  # drawn anew by itself
    yield 3.0
    shot("curve")
    move(window, area.x + area.width / 2, area.y + area.height / 2)
    press("Escape")
    yield lambda: session.monitor.latest(context.scene.name).is_done
    yield lambda: image.packed_file is not None
    shot("curve-at-the-end")
    bpy.ops.zraka.error_report(filepath=str(FOLDER / "report.html"))
    log["errors"] = len(session.monitor.latest(context.scene.name).history)


def goes_on(scene):
    latest = session.monitor.latest(scene.name)
    return latest is not None and not latest.is_done and latest.samples > 4


def image_sum(image):
    pixels = np.zeros(len(image.pixels), np.float32)
    image.pixels.foreach_get(pixels)
    return float(pixels.sum())


Driver(steps(), log).start()
