# SPDX-License-Identifier: GPL-3.0-or-later
"""A long render by threads and by forked processes: ``blender FILE.blend --python forks.py -- FILE.json``."""

from __future__ import annotations

import importlib
import json
import sys
from multiprocessing import active_children
from pathlib import Path

import bpy

importlib.import_module("bl_ext.user_default.zraka.addon.preload").wait()
processes = importlib.import_module("bl_ext.user_default.zraka.core.processes")
facts = {"forks": []}
begin = processes.Processes.__init__


def counted(self, trace, count):
    begin(self, trace, count)
    facts["forks"].append(len(active_children()))


processes.Processes.__init__ = counted
scene = bpy.context.scene
scene.render.engine = "ZRAKA"
scene.render.threads_mode, scene.render.threads = "FIXED", 2
scene.render.resolution_x = scene.render.resolution_y = 256
scene.zraka.samples = 64
scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.image_settings.color_depth = "32"
preferences = bpy.context.preferences.addons["bl_ext.user_default.zraka"].preferences
for preferences.processes in (False, True):
    bpy.ops.render.render()
    bpy.data.images["Render Result"].save_render(f"processes_{preferences.processes}.exr")
facts["left"] = len(active_children())
Path(sys.argv[-1]).write_text(json.dumps(facts), encoding="utf-8")
bpy.ops.wm.quit_blender()
