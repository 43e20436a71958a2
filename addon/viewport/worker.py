# SPDX-License-Identifier: GPL-3.0-or-later
"""The thread that traces what a viewport shows. It knows nothing of Blender, which may delete the viewport any time.

What is wanted is one `Job`; a newer one takes its place at once. Each begins with a few large pixels, so that
something moves while the view does, and ends with the viewport's number of samples.
"""

from __future__ import annotations

import atexit
import logging
import time
import weakref
from dataclasses import dataclass, replace
from threading import Condition, Thread

import numpy as np

from ...core.diagnostics import Diagnostics, SceneError
from ...core.scene import Scene
from ...core.settings import Settings
from .view import View

log = logging.getLogger(__name__)

FIRST_PICTURE = 0.04
"""Seconds that the first picture of a job should take; its pixels are as large as that needs."""

LARGEST_PIXEL = 16

ENOUGH_LANES = 1 << 15
"""Lanes of a pass whose time says what a lane costs; of fewer, it says what a pass costs."""

MANY_TRIANGLES = 1 << 21
"""Of a scene; the tables of two that are larger do not stand side by side, though one may serve the other."""

_live = weakref.WeakSet()


@dataclass(frozen=True, eq=False)
class Job:
    """A picture that is wanted. The scene is compiled when it is another object than that of the job before.

    `settings` lack the frame, which the view gives; `pixel_size` is the side of the smallest pixels, in the screen's;
    `budget` the seconds that the first picture should take.
    """

    scene: Scene
    settings: Settings
    diagnostics: Diagnostics
    view: View
    pixel_size: int = 1
    budget: float = FIRST_PICTURE


@dataclass(frozen=True, eq=False)
class Picture:
    """A picture and where in the region it stands.

    pixels : (H, W, 4) float32, linear, alpha premultiplied, row 0 at the bottom; x, y, width, height : int, in pixels
    of the region.
    """

    pixels: np.ndarray
    x: int
    y: int
    width: int
    height: int


class Worker:
    """A thread and what it has to show.

    Attributes
    ----------
    picture : Picture or None
        The latest; replaced, never changed.
    text : str
        What to say of it.
    """

    def __init__(self):
        self.picture = None
        self.text = ""
        self._changed = Condition()
        self._job = self._done = None
        self._stopped = False
        self._thread = None
        self._scene = self._compiled = None
        self._lane_seconds = None
        _live.add(self)

    @property
    def busy(self):
        """Whether there may be more to show."""
        return self._job is not self._done and not self._stopped

    def want(self, job):
        """Trace this job, and no longer the one before; None clears the picture."""
        with self._changed:
            self._job = job
            if self._thread is None and not self._stopped:
                self._thread = Thread(target=self._run, name="Zraka viewport", daemon=True)
                self._thread.start()
            self._changed.notify()

    def stop(self, wait=0.0):
        """End the thread, and wait some seconds for it."""
        with self._changed:
            self._stopped = True
            self._changed.notify()
        if wait and self._thread is not None:
            self._thread.join(wait)

    def _superseded(self, job):
        return self._stopped or self._job is not job

    def _run(self):
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._stopped or self._job is not self._done)
                job = self._job
            if self._stopped:
                break
            self._try(job)
            self._done = job
        self.picture = self._job = self._done = self._scene = self._compiled = None

    def _try(self, job):
        """Trace a job; what goes wrong is said in the viewport."""
        if job is None:
            self.picture, self.text = None, ""
            return
        try:
            self._trace(job)
        except SceneError as error:
            self.picture, self.text = None, str(error)
        except Exception as error:
            log.exception("Zraka's viewport stopped")
            self.picture, self.text = None, f"Zraka stopped ({type(error).__name__}); the console has the traceback"

    def _trace(self, job):
        from ...core.render import render

        compiled = self._compile(job)
        for divider in self._dividers(job):
            if self._superseded(job):
                return
            frame = job.view.frame(divider)
            last = divider == job.pixel_size
            settings = replace(job.settings, **frame, samples=job.settings.samples if last else 1)
            compiled.look_through(job.view.camera(divider), frame["width"], frame["height"])
            started = time.perf_counter()

            def on_pass(film, _, settings=settings, divider=divider, started=started):
                if film.samples == 1:
                    self._learn(film, time.perf_counter() - started)
                if not self._superseded(job):
                    self._show(film, settings, divider, job)

            render(compiled, settings, on_pass=on_pass, cancelled=lambda: self._superseded(job))

    def _compile(self, job):
        from ...core.compile import compile_scene
        from ...core.compile.again import exchanged, moved

        if self._scene is not job.scene:
            if self._compiled is None:
                self.text = "Compiling"
            before, self._compiled = self._compiled, None
            if before is not None and before.geometry.triangle_count > MANY_TRIANGLES:
                scenes = before.described, job.scene
                can_move = before.accel.parts is not None and moved(*scenes) is not None
                if not can_move and exchanged(*scenes, ()) is None:
                    before = None  # not two large ones at a time
            settings = replace(job.settings, **job.view.frame())
            self._compiled = compile_scene(job.scene, settings, job.diagnostics, before=before, editable=True)
            self._scene = job.scene
        return self._compiled

    def _dividers(self, job):
        """Sides of the pixels, from the first picture's to the last one's."""
        divider = 8
        if self._lane_seconds is not None:
            lanes = job.view.width * job.view.height / job.pixel_size**2
            divider = 1
            while divider < LARGEST_PIXEL and lanes / divider**2 * self._lane_seconds > job.budget:
                divider *= 2
        while divider > 1:
            yield divider * job.pixel_size
            divider //= 4
        yield job.pixel_size

    def _learn(self, film, seconds):
        lanes = film.width * film.height
        if lanes >= ENOUGH_LANES or self._lane_seconds is None:
            self._lane_seconds = seconds / lanes

    def _show(self, film, settings, divider, job):
        x0, y0, _, _ = settings.region
        self.picture = Picture(film.image(), x0 * divider, y0 * divider, film.width * divider, film.height * divider)
        total = job.settings.samples
        self.text = f"Sample {film.samples if divider == job.pixel_size else 0}/{total}"


def stop_all():
    """End all threads and wait for them: Python must not end, nor this module go, while they run."""
    for worker in list(_live):
        worker.stop()
    for worker in list(_live):
        worker.stop(wait=2.0)


atexit.register(stop_all)
