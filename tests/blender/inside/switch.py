# SPDX-License-Identifier: GPL-3.0-or-later
"""Switch the extension off and on, twice: nothing of it may stay behind in Blender."""

import addon_utils
import bpy

NAME = "bl_ext.user_default.zraka"

for _ in range(2):
    addon_utils.disable(NAME)
    left = [
        p for p in bpy.types.Panel.__subclasses__() if p.is_registered and "ZRAKA" in getattr(p, "COMPAT_ENGINES", ())
    ]
    assert not left, left
    assert not hasattr(bpy.types.Scene, "zraka")
    addon_utils.enable(NAME)
    bpy.context.scene.render.engine = "ZRAKA"
    assert bpy.context.scene.zraka.samples
