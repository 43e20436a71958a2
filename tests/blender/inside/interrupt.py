# SPDX-License-Identifier: GPL-3.0-or-later
"""Ctrl-C after the second picture of a long render: ``blender -b FILE.blend --python interrupt.py -- FILE.json``."""

from __future__ import annotations

import importlib
import json
import os
import signal
import sys
import time
from pathlib import Path

import bpy

session = importlib.import_module("bl_ext.user_default.zraka.addon.session")
facts = {"shown": 0}
on_pass = session.Display.on_pass


def interrupt(display, film, progress):
    on_pass(display, film, progress)
    facts["shown"] += 1
    if facts["shown"] == 2:
        facts["interrupted"] = time.perf_counter()
        os.kill(os.getpid(), signal.SIGINT)


session.Display.on_pass = interrupt
scene = bpy.context.scene
scene.render.engine = "ZRAKA"
scene.render.resolution_x = scene.render.resolution_y = 256
scene.zraka.samples = 100000
facts["operator"] = sorted(bpy.ops.render.render())
facts["seconds"] = time.perf_counter() - facts["interrupted"]
scene.render.image_settings.file_format = "OPEN_EXR"
bpy.data.images["Render Result"].save_render("kept.exr")
Path(sys.argv[-1]).write_text(json.dumps(facts), encoding="utf-8")
