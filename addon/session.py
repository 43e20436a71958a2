# SPDX-License-Identifier: GPL-3.0-or-later
"""One view layer of one render: exported while Blender's data is locked, traced and shown afterwards.

A `Job` holds plain arrays. It is made by the thread on which Blender called us, and nothing that the workers see leads
back to Blender: the engine may be deleted while they run.
"""

from __future__ import annotations

import logging
import time
from contextlib import contextmanager
from dataclasses import dataclass, replace

from ..core.diagnostics import Diagnostics, SceneError
from ..core.scene import Scene
from ..core.settings import Settings
from . import error_table, passes, properties, takeover
from .monitor import Shot, monitor
from .progress import progress_line, stamp
from .stereo import view_camera, view_names

log = logging.getLogger(__name__)

SHOW_EVERY = 0.25
"""Seconds between two pictures in the image editor: Blender merges every pass of the result for each."""

STRIPE = 1 << 18
"""Pixels that Blender gets at once, at most, or one row: they are in memory three times until it has them."""

PREVIEW = {"samples": 32, "time_limit": 2.0, "noise_target": 0.01, "chunk": 1 << 15, "processes": False}
"""Of the small pictures of materials; their scene is Blender's own, with settings nobody chose.

They are refined while one looks at them. Few lanes are traced together, so that a preview that is out of date ends at
once: the next one waits for it.
"""


@dataclass(frozen=True)
class Job:
    """What there is to render, without Blender; `view` is the name of a stereo view, "" of the only one.

    `slices` are the scene in the middle of each slice of the time in which the shutter is open, all of them `scene`
    itself where nothing moves; none without motion blur. `around` are those a frame before and a frame after, where
    motion vectors are asked for. `shot` is None where nobody wants to know how it went.
    """

    scene: Scene
    settings: Settings
    diagnostics: Diagnostics
    export_seconds: float
    view: str = ""
    slices: tuple[Scene, ...] = ()
    around: tuple[Scene, ...] = ()
    shot: Shot | None = None


def export_job(depsgraph, camera=None, size=None, frame_set=None, cache=None, **overrides):
    """Read a `Job` from Blender.

    Parameters
    ----------
    depsgraph : bpy.types.Depsgraph
        Evaluated for rendering.
    camera : bpy.types.Object, optional
        In place of the scene's.
    size : (width, height), optional
        In place of the scene's.
    frame_set : callable, optional
        The engine's, with which other moments of a frame are reached; without it nothing is blurred by motion.
    cache : ExportCache, optional
        What the frame before left.
    **overrides
        As of `properties.settings_of`.

    Raises
    ------
    SceneError
        If the scene cannot be rendered.
    """
    # Imported here: enabling the add-on should not load Embree, and should work where it is missing.
    from ..core.shutter import slice_count
    from .export.cache import ExportCache
    from .export.camera import frame_size, render_border
    from .export.motion import Still, export_around, export_slices, shutter_times
    from .export.scene import export_scene

    started = time.perf_counter()
    diagnostics = Diagnostics()
    scene = depsgraph.scene_eval
    width, height = size or frame_size(scene)
    border = render_border(scene, width, height)
    if border and (border[0] >= border[2] or border[1] >= border[3]):
        raise SceneError("the render border holds no pixel; widen it or switch it off")
    guides = passes.guides_of(depsgraph)
    own = {"guides": guides, "pixel_errors": passes.shows_errors(depsgraph.view_layer_eval)}
    settings = properties.settings_of(scene, width=width, height=height, border=border, **own, **overrides)
    cache = cache or ExportCache()
    cache.follow(depsgraph)
    blurred = frame_set is not None and scene.render.use_motion_blur and scene.render.motion_blur_shutter > 0
    still = Still() if blurred else None
    description = export_scene(depsgraph, diagnostics, camera, (width, height), cache=cache, still=still)
    slices = around = ()
    if "vector" in guides.names:
        around = export_around(depsgraph, frame_set, description, camera, (width, height), cache, diagnostics)
    if blurred:
        if getattr(getattr(scene, "cycles", None), "rolling_shutter_type", "NONE") != "NONE":
            diagnostics.warn("a rolling shutter is not supported; all rows are exposed at once")
        times = shutter_times(scene.render, slice_count(settings.samples))
        slices = tuple(export_slices(depsgraph, frame_set, description, times, camera, (width, height), cache, still))
    return Job(description, settings, diagnostics, time.perf_counter() - started, slices=slices, around=around)


def compile_job(job, before=None):
    """What `core.render.render` takes: a CompiledScene, or a Shutter where something moves.

    Parameters
    ----------
    job : Job
    before : CompiledScene, optional
        Of another frame.
    """
    from ..core.compile import compile_scene
    from ..core.shutter import compile_shutter

    if any(scene is not job.scene for scene in job.slices):
        return compile_shutter(job.slices, job.settings, job.diagnostics, before)
    return compile_scene(job.scene, job.settings, job.diagnostics, before=before)


def export_views(engine, depsgraph, cache):
    """Read a `Job` for each stereo view, or one where there are none; the scene is exported once."""
    names = view_names(depsgraph.scene_eval)
    chosen = {"camera": engine.camera_override, "cache": cache}
    if engine.is_preview:
        return [export_job(depsgraph, **chosen, **PREVIEW)]
    if not names:
        return [export_job(depsgraph, frame_set=engine.frame_set, **chosen)]
    first = export_job(depsgraph, **chosen)
    if depsgraph.scene_eval.render.use_motion_blur:
        first.diagnostics.warn("stereo views are rendered without motion blur")
    cameras = [view_camera(engine, depsgraph, name, first.diagnostics) for name in names]
    seed = first.settings.seed
    # Each eye sees noise of its own: the same in both would hang in the air as a pattern.
    return [
        replace(
            first,
            scene=replace(first.scene, camera=camera),
            settings=replace(first.settings, seed=seed + number),
            view=name,
        )
        for number, (name, camera) in enumerate(zip(names, cameras, strict=True))
    ]


def shot_of(engine, scene):
    """Name what an engine renders; None for Blender's own small pictures."""
    if engine.is_preview:
        return None
    table = engine.is_animation and scene.zraka.use_error_table
    return Shot(scene.name, scene.frame_current, error_table.table_path(scene.render) if table else None)


class Display:
    """The picture in Blender while it is rendered.

    It is refreshed on a budget of time, not by the pass; stripe after stripe, each a render result of its own: one that
    stayed open would hold all passes a second time.
    """

    def __init__(self, engine, view_layer, settings, view=""):
        self._engine = engine
        self._view = view
        self._view_layer = view_layer
        self._settings = settings
        self._next = 0.0

    def missing_passes(self):
        """Name the passes of the layer that stay empty; none when the view layer is switched off."""
        result = self._begin(0, 0, 1, 1)
        try:
            layer = _layer_of(result)
            return [] if layer is None else passes.missing_passes(layer, self._view_layer, self._settings.method)
        finally:
            self._engine.end_result(result, cancel=True)

    def on_pass(self, film, progress):
        """Show the film when it is time for it; called after every pass."""
        if time.perf_counter() < self._next:
            return
        if self._settings.shown:
            self._write(film)
        self._engine.update_progress(progress)
        self._engine.update_stats("", progress_line(film, self._settings))
        self._next = time.perf_counter() + SHOW_EVERY

    def close(self, film, guides=None, names=None):
        """Leave the last picture standing, with all passes; a render that was cancelled keeps what it has."""
        if film is None:  # black
            self._engine.end_result(self._begin(0, 0, self._settings.width, self._settings.height))
            return
        self._write(film, self._settings, guides)
        self._stamp(film, names or {})

    def _stamp(self, film, names):
        """Tell the files' readers how the picture was made, and what the ids of the mattes stand for."""
        result = self._engine.get_result()
        place = _place(self._view_layer, self._view)
        for field, value in stamp(film, self._settings).items():
            result.stamp_data_add_field(f"zraka.{place}.{field}", value)
        passes.write_metadata(result, self._view_layer, names)

    def _begin(self, *rectangle):
        """A render result; Blender counts from the corner of the border, and cuts off what is beyond."""
        return self._engine.begin_result(*rectangle, layer=self._view_layer.name, view=self._view)

    def _write(self, film, settings=None, guides=None):
        readers = passes.readers_of(film, self._view_layer, settings, guides)
        height = max(1, STRIPE // film.width)
        for y in range(0, film.height, height):
            rows = slice(y, min(y + height, film.height))
            result = self._begin(0, y, film.width, rows.stop - y)
            try:
                layer = _layer_of(result)
                if layer is not None:
                    passes.write_passes(readers, rows, layer)
            finally:
                self._engine.end_result(result)


def _layer_of(result):
    """Blender's render layer, None when the view layer is switched off."""
    return next(iter(result.layers), None)


def render_job(job, engine, view_layer, before=None):
    """Trace a job and show it in Blender until it is done, cancelled or interrupted.

    Returns the CompiledScene, of the middle of the time where it is blurred, which is `before` to the next frame.
    """
    from ..core.render import render

    engine.update_stats("", "Compiling")
    settings = job.settings
    compiled = compile_job(job, before)
    middle = getattr(compiled, "middle", compiled)
    display = Display(engine, view_layer, settings, job.view)
    film = guides = names = None
    if job.shot:
        monitor.begin(job.shot, _place(view_layer, job.view), settings)

    def on_pass(latest, progress):
        nonlocal film
        film = latest
        if job.shot:
            monitor.note(job.shot, latest)
        display.on_pass(latest, progress)

    try:
        for name in display.missing_passes():
            job.diagnostics.warn(f"the pass {name!r} is not rendered; it stays empty")
        film = render(compiled, settings, on_pass=on_pass, cancelled=engine.test_break)
        if settings.guides.names and film.stats.get("stopped") != "cancelled":
            engine.update_stats("", "Rendering passes")
            guides, names = _guides(middle, film, settings, engine.test_break, job.around)
    finally:
        display.close(film, guides, names)
        if job.shot:
            _keep(job, film, _place(view_layer, job.view))
    return middle


def _place(view_layer, view):
    return ".".join(name for name in (view_layer.name, view) if name)


def _keep(job, film, place):
    """Note how a render went, for the panel and beside an animation's frames."""
    shot = job.shot
    whole = film is not None and film.stats.get("stopped", "cancelled") != "cancelled"
    if shot.table and whole:  # of others Blender writes no file
        try:
            error_table.write_row(shot.table, shot.frame, place, film)
        except SceneError as error:
            job.diagnostics.warn(str(error))
    monitor.end(shot, film, job.diagnostics.messages())


def _guides(compiled, film, settings, cancelled, around=()):
    """The pictures that passes show, and the names that their ids stand for."""
    from ..core.methods.cryptomatte import matte_names
    from ..core.methods.guides import render_guides
    from ..core.methods.light_passes import light_pictures

    guides = render_guides(compiled, compiled.described, settings, cancelled, around)
    guides |= light_pictures(film, settings)
    return guides, matte_names(compiled, compiled.described, settings.guides)


class Session:
    """What an engine does, layer after layer; the engine itself only delegates.

    With persistent data Blender keeps the engine from frame to frame, and the session what the next frame can use.
    """

    def __init__(self):
        self._jobs = []
        self._cache = self._compiled = self._failure = None
        self._said = set()

    def update(self, engine, depsgraph):
        """Export; the only time Blender's data is read. What fails is for `render` to tell: a bake can do without."""
        self._jobs, self._failure = [], None
        try:
            from .export.cache import ExportCache

            engine.update_stats("", "Exporting")
            cache, self._cache = self._cache, None  # what fails halfway is not to be used again
            if cache is None:
                cache, self._compiled = ExportCache(), None
            shot = shot_of(engine, depsgraph.scene)
            self._jobs = [replace(job, shot=shot) for job in export_views(engine, depsgraph, cache)]
            self._cache = cache if depsgraph.scene.render.use_persistent_data else None
        except (Exception, KeyboardInterrupt) as error:
            self._failure = error
            return
        if not engine.is_preview:
            for sentence in takeover.pop_unsaid():
                engine.report({"INFO"}, sentence)

    def render(self, engine, depsgraph):
        """Trace what `update` exported, view after view; when that failed, tell why."""
        jobs, self._jobs = self._jobs, []
        failure, self._failure = self._failure, None
        before, self._compiled = self._compiled, None
        with reported(engine):
            if failure:
                raise failure
            for job in jobs:
                self._warn(engine, job)
                try:
                    before = render_job(job, engine, depsgraph.view_layer_eval, before)
                finally:
                    self._warn(engine, job)
                if engine.test_break():
                    break
            self._compiled = before if self._cache else None

    def _warn(self, engine, job):
        if engine.is_preview:  # Its scene is not the user's.
            return
        for message in job.diagnostics.messages():
            if message not in self._said:
                self._said.add(message)
                engine.report({"WARNING"}, message)


@contextmanager
def reported(engine):
    """Turn an exception into one sentence for the user, with the traceback on the console.

    Blender itself would print it and show a black picture; only a report of an error stops an animation.
    """
    try:
        yield
    except SceneError as error:
        engine.report({"ERROR"}, str(error))
    except ImportError as error:
        log.exception("Zraka lacks a library")
        engine.report({"ERROR"}, f"Zraka lacks a library ({error}); install Zraka's extension .zip of this platform")
    except KeyboardInterrupt:
        engine.report({"ERROR"}, "The render was interrupted; the samples so far were kept")
    except Exception as error:
        log.exception("Zraka stopped")
        text = " ".join(str(error).split())
        engine.report({"ERROR"}, f"Zraka stopped ({type(error).__name__}: {text}); the console has the traceback")
