# SPDX-License-Identifier: GPL-3.0-or-later
"""What an engine's previews show: ``blender --python previews.py -- FOLDER ENGINE``.

FOLDER gets ``log.json`` and a picture of the screen for each thing that is previewed. Each engine's stand in the
same place: in a panel of our own, before all others of a wide region. A script that changes the engine while a preview
is rendered waits for ever, in Blender itself, with Cycles too; so this looks at one engine.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from driver import Driver, shot

ENGINE = sys.argv[-1]
TABS = {"material": "MATERIAL", "world": "WORLD", "light": "DATA"}  # by the context's names
LOOK_EVERY, LOOKS = 1.0, 6  # seconds; what has not changed so many times is done
MARGIN = 32  # pixels of the screen, where the panel begins
ROW = {"material": 300, "world": 215, "light": 215}  # from the screen's top, in the middle of the preview
log = {}


def preview_panel(name):
    """A panel that shows nothing but the preview of what the tab is about."""

    class Shown(bpy.types.Panel):
        bl_idname = f"PREVIEW_PT_{name}"
        bl_label = "Shown"
        bl_space_type = "PROPERTIES"
        bl_region_type = "WINDOW"
        bl_context = "data" if name == "light" else name
        bl_order = -1000  # before all others

        @classmethod
        def poll(cls, context):
            return getattr(context, name, None) is not None

        def draw(self, context):
            self.layout.template_preview(getattr(context, name))

    Shown.bl_options = {"HIDE_HEADER"}
    return Shown


def steps():
    """Yield seconds to wait, or a function that is true when the wait is over."""
    context = bpy.context
    context.scene.render.engine = ENGINE
    context.preferences.view.show_splash = False
    for name in TABS:
        bpy.utils.register_class(preview_panel(name))
    areas = {area.type: area for area in context.window_manager.windows[0].screen.areas}
    wide, narrow = areas["VIEW_3D"], areas["PROPERTIES"]
    wide.type = "PROPERTIES"
    yield 1.0
    things = things_of(context)
    for name, (kind, choose) in things.items():
        for area in (wide, narrow):
            area.spaces.active.context = "SCENE"
        choose()
        yield 1.0  # a tab is there when the editors were drawn
        for area in (wide, narrow):  # one waits for the other's end
            area.spaces.active.context = TABS[kind]
        yield from stands_still(kind)
        shot(f"{ENGINE}-{name}")
    log["things"] = {name: kind for name, (kind, _) in things.items()}


def things_of(context):
    """What is previewed, by name: of what kind it is, and a function that makes the tab show it."""
    scene, objects = context.scene, context.view_layer.objects
    mesh = next(thing for thing in scene.objects if thing.type == "MESH")
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.1, 0.3, 0.9, 1)  # it was black
    things = {
        "material": ("material", lambda: setattr(objects, "active", mesh)),
        "world": ("world", lambda: None),
    }
    for kind in ("SPOT", "AREA"):
        lamp = bpy.data.objects.new(kind, bpy.data.lights.new(kind, kind))
        scene.collection.objects.link(lamp)
        things[kind.lower()] = "light", lambda lamp=lamp: setattr(objects, "active", lamp)
    return things


def stands_still(kind):
    """Wait until there is a picture that does not change any more."""
    seen = []
    while len(seen) < LOOKS or len(set(seen[-LOOKS:])) > 1:
        yield LOOK_EVERY
        yield lambda: is_there(look(kind))
        seen.append(look(kind))


def look(kind):
    """The bytes of a strip of the screen, RGB, from the panel's margin to the middle of the preview."""
    row = ROW[kind]
    strip = ["-window", "root", "-crop", f"560x60+{MARGIN}+{row - 30}", "-depth", "8", "rgb:-"]
    return subprocess.run(["import", *strip], check=True, capture_output=True).stdout


def is_there(strip):
    """Whether something in the strip is brighter than the panel, which is seen where there is no picture yet."""
    return max(strip) > 90


Driver(steps(), log).start()
