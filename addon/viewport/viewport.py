# SPDX-License-Identifier: GPL-3.0-or-later
"""Rendered shading of one region: exports what changed, asks a `Worker` for pictures, draws them.

Everything here runs on Blender's main thread. Blender's data is read while it calls us and never kept: after an undo
none of it exists any more.
"""

from __future__ import annotations

import contextlib
import gc
import logging
import weakref

import bpy
import gpu
from gpu_extras.presets import draw_texture_2d

from ...core.diagnostics import Diagnostics, SceneError
from .. import properties
from ..export.moved import export_moved
from ..preferences import viewport_budget
from .changes import changes_scene, fingerprint
from .view import view_of
from .worker import Job, Worker

log = logging.getLogger(__name__)

LOOK_EVERY = 0.02
"""Seconds between two looks at whether the worker has something new."""

CHUNK = 1 << 16
"""Lanes that are traced together: few, so that a change does not wait for a long bounce."""


class Viewport:
    """What an engine keeps for the region that it was made for."""

    def __init__(self, engine):
        self._engine = weakref.ref(engine)
        self._worker = Worker()
        weakref.finalize(engine, self._worker.stop)
        self._exported = self._fingerprint = self._cache = None
        self._wanted = None
        self._error = ""
        self._said = set()
        self._texture = self._drawn = None
        self._looking = False

    def update(self, context, depsgraph):
        """Export the scene if it changed."""
        if self._move(depsgraph):
            self._engine().tag_redraw()
            return
        with _no_collection():
            self._follow(context, depsgraph)
        self._engine().tag_redraw()

    def _follow(self, context, depsgraph):
        visible = _visible_in(context.space_data)
        now = fingerprint(depsgraph, visible)
        if self._cache is not None:
            self._cache.follow(depsgraph)
        if self._exported is None or now != self._fingerprint or changes_scene(depsgraph):
            self._fingerprint, self._wanted = now, None
            try:
                self._exported, self._error = self._export(context, depsgraph, visible), ""
            except SceneError as error:
                self._exported, self._error = None, str(error)
            except Exception as error:
                log.exception("Zraka's viewport stopped")
                self._exported = None
                self._error = f"Zraka stopped ({type(error).__name__}); the console has the traceback"

    def draw(self, context, depsgraph):
        """Draw the latest picture, and ask for another one when the view is another one."""
        engine, scene = self._engine(), depsgraph.scene_eval
        self._ask(engine, context, depsgraph)
        picture = self._worker.picture
        if picture is not self._drawn:
            self._texture, self._drawn = _texture_of(picture), picture
        if picture is not None:
            gpu.state.blend_set("ALPHA_PREMULT")
            engine.bind_display_space_shader(scene)
            draw_texture_2d(self._texture, (picture.x, picture.y), picture.width, picture.height)
            engine.unbind_display_space_shader()
            gpu.state.blend_set("NONE")
        engine.update_stats("", self._error or self._worker.text + self._warnings())
        self._look_out()

    def _move(self, depsgraph):
        """Follow objects that moved; False where more is to be done."""
        if self._exported is None or self._cache is None:
            return False
        before, *others = self._exported
        scene = export_moved(before, depsgraph, self._cache)
        if scene is None:
            return False
        if scene is not before:
            self._exported, self._wanted = (scene, *others), None
        return True

    def _export(self, context, depsgraph, visible):
        """Scene, settings and diagnostics of a `Job`, of the objects that are `visible`."""
        from ..export.cache import ExportCache
        from ..export.scene import export_scene

        cache, self._cache = self._cache, None  # what fails halfway is not to be used again
        if cache is None:
            cache = ExportCache()
            cache.follow(depsgraph)  # from here on
        diagnostics = Diagnostics()
        scene = depsgraph.scene_eval
        chosen = {"samples": scene.zraka.viewport_samples, "noise_target": scene.zraka.viewport_noise_target}
        chosen |= {"time_limit": 0.0, "chunk": CHUNK, "pixel_errors": False, "processes": False, "shown": True}
        settings = properties.settings_of(scene, **chosen)
        view = view_of(context, depsgraph)
        description = export_scene(depsgraph, diagnostics, camera=view.camera(), visible=visible, cache=cache)
        self._cache = cache
        return description, settings, diagnostics

    def _ask(self, engine, context, depsgraph):
        job = None
        wanted = None
        if self._exported is not None:
            view = view_of(context, depsgraph)
            wanted = view, engine.get_preview_pixel_size(depsgraph.scene_eval)
            if not view.is_empty:
                job = Job(*self._exported, *wanted, viewport_budget())
        if wanted != self._wanted or (wanted is None and self._worker.picture is not None):
            self._wanted = wanted
            self._worker.want(job)

    def _warnings(self):
        """Say each warning once, on the console; a number of them in the viewport."""
        messages = self._exported[2].messages() if self._exported else []
        for message in messages:
            if message not in self._said:
                self._said.add(message)
                log.warning("%s", message)
        return f" | {len(messages)} warnings on the console" if messages else ""

    def _look_out(self):
        """Let Blender's timer look for pictures as long as there may be some."""
        if self._worker.busy and not self._looking:
            self._looking = True
            bpy.app.timers.register(self._look, first_interval=LOOK_EVERY, persistent=True)

    def _look(self):
        busy = self._worker.busy  # before the picture: none may come unseen in between
        engine = self._engine()
        self._looking = False
        try:
            if engine is not None and (self._worker.picture is not self._drawn or not busy):
                engine.tag_redraw()
        except ReferenceError:  # Blender deleted the engine
            engine = None
        if engine is None:
            self._worker.stop()
        elif busy:
            self._looking = True
            return LOOK_EVERY
        return None


@contextlib.contextmanager
def _no_collection():
    """Put off Python's search for garbage: an export leaves none, but makes thousands of things to look at."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


def _visible_in(space):
    """A function that tells whether an entry of the dependency graph is shown in a viewport, local view included."""
    known = {}  # by the address of what Blender is asked of; all instances of one instancer are asked of that

    def visible(instance):
        thing = instance.parent if instance.is_instance else instance.object
        key = thing.as_pointer()
        if key not in known:
            known[key] = True
            with contextlib.suppress(RuntimeError):  # of objects that are not of the view layer
                known[key] = thing.visible_in_viewport_get(space)
        return known[key]

    return visible


def _texture_of(picture):
    if picture is None:
        return None
    height, width, _ = picture.pixels.shape
    pixels = gpu.types.Buffer("FLOAT", picture.pixels.size, picture.pixels.reshape(-1))
    return gpu.types.GPUTexture((width, height), format="RGBA32F", data=pixels)
