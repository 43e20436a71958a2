# SPDX-License-Identifier: GPL-3.0-or-later
"""The engine as Blender sees it; `session` does the work."""

from __future__ import annotations

import sys

import bpy

from . import passes, preload
from .properties import ENGINE
from .session import Session


class ZrakaRenderEngine(bpy.types.RenderEngine):
    """Ray casting, ray tracing and path tracing in numpy over Embree."""

    bl_idname = ENGINE
    bl_label = "Zraka"
    bl_use_preview = True
    bl_use_shading_nodes_custom = False
    bl_use_eevee_viewport = True
    bl_use_postprocess = True

    def __init__(self, *args, **kwargs):
        # Blender makes engines only to ask for their passes, too: nothing may happen here.
        super().__init__(*args, **kwargs)
        self.session = Session()
        self.viewport = self.baker = None

    def update_render_passes(self, scene, view_layer):
        """Tell which passes a view layer will have."""
        passes.register_passes(self, scene, view_layer)

    def update(self, data, depsgraph):
        """Export, while Blender's data is locked."""
        preload.wait()
        self.baker = None
        # Blender calls this before `bake`, too. Without a window that shows only where nothing was rendered before.
        if self.resolution_x and not bpy.app.is_job_running("OBJECT_BAKE"):
            self.session.update(self, depsgraph)

    def render(self, depsgraph):
        """Trace what was exported."""
        self.session.render(self, depsgraph)

    def bake(self, depsgraph, obj, pass_type, pass_filter, width, height):
        """Bake one picture of an object."""
        if self.baker is None:
            from .bake import Baker  # like the viewport, only where it is wanted

            self.baker = Baker()
        self.baker.bake(self, depsgraph, obj, pass_type, pass_filter, (width, height))

    def view_update(self, context, depsgraph):
        """Export what Rendered shading shows; called first, and when something changed."""
        if not preload.is_done():
            preload.redraw_when_done(self)
            return
        if self.viewport is None:
            from .viewport.viewport import Viewport  # a Blender without a window has no use for it

            self.viewport = Viewport(self)
        self.viewport.update(context, depsgraph)

    def view_draw(self, context, depsgraph):
        """Draw Rendered shading."""
        if self.viewport is None:
            self.view_update(context, depsgraph)
        if self.viewport is None:
            self.update_stats("", "Loading Zraka")
            return
        self.viewport.draw(context, depsgraph)


def register():
    """Add the engine."""
    bpy.utils.register_class(ZrakaRenderEngine)


def unregister():
    """Remove it, and end what it still does."""
    preload.finish()
    if worker := sys.modules.get(f"{__package__}.viewport.worker"):
        worker.stop_all()
    bpy.utils.unregister_class(ZrakaRenderEngine)
