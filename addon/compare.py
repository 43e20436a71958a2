# SPDX-License-Identifier: GPL-3.0-or-later
"""*Compare Methods*: the scene by Phong, ray casting, ray tracing and path tracing, side by side in one image.

The scene is exported once, on Blender's own thread. A thread of ours traces; a modal operator looks at it ten times a
second, so that the interface stays free.
"""

from __future__ import annotations

import atexit
import logging
import weakref
from dataclasses import replace
from threading import Event, Thread

import bpy

from ..core.diagnostics import SceneError
from ..core.settings import METHODS, Guides
from . import headless
from .progress import error_text
from .properties import ENGINE
from .properties import METHODS as LABELS
from .report.sheet import contact_sheet
from .session import compile_job

log = logging.getLogger(__name__)

IMAGE = "Zraka Methods"
LOOK_EVERY = 0.1  # seconds

_NAMES = {identifier.lower(): label for identifier, label, _ in LABELS}
_live = weakref.WeakSet()


class Comparison:
    """Renders one exported scene by one method after the other.

    Parameters
    ----------
    job : session.Job

    Attributes
    ----------
    films : dict of str to core.film.Film
        By method, those that are done.
    error : Exception or None
        What ended it early.
    """

    def __init__(self, job):
        self.films = {}
        self.error = None
        self._job = job
        self._method = METHODS[0]
        self._progress = 0.0
        self._stop = Event()
        self._thread = None
        _live.add(self)

    def run(self):
        """Render all; returns when done or stopped."""
        from ..core.render import render

        try:
            for method in METHODS:
                self._method, self._progress = method, 0.0
                settings = replace(self._job.settings, method=method, guides=Guides())
                film = render(
                    compile_job(replace(self._job, settings=settings)),
                    settings,
                    on_pass=self._on_pass,
                    cancelled=self._stop.is_set,
                )
                if self._stop.is_set():
                    return
                self.films[method] = film
        except Exception as error:
            self.error = error

    def start(self):
        """Render all on a thread of its own."""
        self._thread = Thread(target=self.run, name="Zraka comparison", daemon=True)
        self._thread.start()

    @property
    def busy(self):
        """Whether the thread still runs."""
        return self._thread is not None and self._thread.is_alive()

    def stop(self, wait=2.0):
        """End the thread; what is done stays."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join(wait)

    @property
    def progress(self):
        """How much is done, in [0, 1]."""
        return (METHODS.index(self._method) + self._progress) / len(METHODS)

    @property
    def text(self):
        """Say what is being done."""
        return f"Zraka compares methods: {_NAMES[self._method]} {self._progress:.0%}   |   Esc: cancel"

    def captions(self):
        """Name, seconds and estimated error of what is done."""
        return [
            f"{_NAMES[method]}\n{film.stats['seconds']:.2f} s, error {error_text(film)}"
            for method, film in self.films.items()
        ]

    def sheet(self):
        """All pictures in one, (H, W, 4) float32, row 0 at the bottom."""
        pictures = [film.image()[::-1] for film in self.films.values()]
        return contact_sheet(pictures, self.captions(), columns=2)[::-1]

    def _on_pass(self, film, progress):
        self._progress = progress


class ZRAKA_OT_compare_methods(bpy.types.Operator):
    """Render the scene by all four methods into one image."""

    bl_idname = "zraka.compare_methods"
    bl_label = "Compare Methods"
    bl_description = (
        f"Render the scene by Phong, ray casting, ray tracing and path tracing into the image '{IMAGE}', with times "
        "and estimated errors. Takes as long as all four renders together; Esc ends it"
    )

    @classmethod
    def poll(cls, context):
        """Offer it where Zraka renders."""
        return context.scene is not None and context.scene.render.engine == ENGINE

    def execute(self, context):
        """Do it all at once, for scripts."""
        if not self._export(context):
            return {"CANCELLED"}
        self._comparison.run()
        return self._finish(context)

    def invoke(self, context, event):
        """Begin, and leave the interface free."""
        if bpy.app.background or context.window is None:
            return self.execute(context)
        if not self._export(context):
            return {"CANCELLED"}
        self._timer = context.window_manager.event_timer_add(LOOK_EVERY, window=context.window)
        context.window_manager.modal_handler_add(self)
        context.window_manager.progress_begin(0, 100)
        context.workspace.status_text_set(self._comparison.text)
        self._comparison.start()
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        """Look how far it is."""
        if event.type == "ESC" and event.value == "PRESS":
            self._leave(context)
            self.report({"INFO"}, "The comparison was cancelled")
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        if self._comparison.busy:
            context.window_manager.progress_update(round(100 * self._comparison.progress))
            context.workspace.status_text_set(self._comparison.text)
            return {"PASS_THROUGH"}
        self._leave(context)
        return self._finish(context)

    def cancel(self, context):
        """Blender ends it: a file is loaded or the window closed."""
        self._comparison.stop()

    def _export(self, context):
        scene, layer = context.scene, context.view_layer.name
        try:
            with _spare_slot():
                self._comparison = Comparison(headless.export_layer(bpy, scene, layer))
        except SceneError as error:
            self.report({"ERROR"}, str(error))
            return False
        return True

    def _leave(self, context):
        self._comparison.stop(wait=0.2)  # longer would hold the window
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        context.workspace.status_text_set(None)

    def _finish(self, context):
        comparison = self._comparison
        if comparison.error is not None:
            log.error("Zraka's comparison stopped", exc_info=comparison.error)
            self.report({"ERROR"}, f"The comparison stopped: {comparison.error}")
            return {"CANCELLED"}
        show(context, write_image(comparison.sheet()))
        self.report({"INFO"}, "; ".join(caption.replace("\n", ": ") for caption in comparison.captions()))
        return {"FINISHED"}


class _spare_slot:
    """Let renders go to the last slot of the render result meanwhile, so that the user's picture stays."""

    def __enter__(self):
        self._slots = getattr(bpy.data.images.get("Render Result"), "render_slots", None)
        self._index = self._slots.active_index if self._slots else 0
        if self._slots:
            self._slots.active_index = len(self._slots) - 1

    def __exit__(self, *_):
        if self._slots:
            self._slots.active_index = self._index


def write_image(pixels):
    """Put a picture (H, W, 4), linear, into the image data-block `IMAGE`, made where there is none."""
    height, width, _ = pixels.shape
    image = bpy.data.images.get(IMAGE)
    if image is None:
        image = bpy.data.images.new(IMAGE, width, height, alpha=True, float_buffer=True)
    elif tuple(image.size) != (width, height):
        image.scale(width, height)
    image.pixels.foreach_set(pixels.reshape(-1))
    image.update()
    image.pack()
    return image


def show(context, image):
    """Show an image in an open image editor, where there is one."""
    for area in context.screen.areas if context.screen else ():
        if area.type == "IMAGE_EDITOR":
            area.spaces.active.image = image
            return


def stop_all():
    """End all threads: Python must not end, nor this module go, while they run."""
    for comparison in list(_live):
        comparison.stop()


atexit.register(stop_all)


def _draw_menu(self, context):
    if ZRAKA_OT_compare_methods.poll(context):
        self.layout.separator()
        self.layout.operator(ZRAKA_OT_compare_methods.bl_idname, icon="IMGDISPLAY")


def register():
    """Add the operator and its line in the menu *Render*."""
    bpy.utils.register_class(ZRAKA_OT_compare_methods)
    bpy.types.TOPBAR_MT_render.append(_draw_menu)


def unregister():
    """Remove them."""
    stop_all()
    bpy.types.TOPBAR_MT_render.remove(_draw_menu)
    bpy.utils.unregister_class(ZRAKA_OT_compare_methods)
