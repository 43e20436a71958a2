# SPDX-License-Identifier: GPL-3.0-or-later
"""Two engines set alike, rendering by the same operator in the same process."""

from __future__ import annotations

import contextlib
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ...core.diagnostics import SceneError
from .. import headless


def open_blend(path, percentage=100):
    """Open a file, drawn `percentage` of its size, and return its scene.

    Raises
    ------
    SceneError
        If Blender cannot open it.
    """
    bpy = headless.load_blender()
    try:
        with headless.quiet():
            bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False)
    except RuntimeError as error:
        raise SceneError(f"{path} cannot be opened: {' '.join(str(error).split())}") from error
    scene = bpy.context.scene
    scene.render.resolution_percentage = percentage
    return scene


def match(scene):
    """Set Cycles to what `scene.zraka` says, and switch off whatever is not plain unbiased path tracing."""
    cycles, group, render = scene.cycles, scene.zraka, scene.render
    group.method, group.clamp_direct, group.clamp_indirect, group.noise_target = "PATHTRACE", 0.0, 0.0, 0.0
    group.time_limit, group.adaptive = 0.0, False
    cycles.device, cycles.samples, cycles.seed = "CPU", group.samples, group.seed
    cycles.use_adaptive_sampling = cycles.use_denoising = cycles.use_animated_seed = False
    cycles.max_bounces = group.depth - 1
    for name in ("diffuse_bounces", "glossy_bounces", "transmission_bounces"):
        setattr(cycles, name, min(getattr(group, name), group.depth - 1))
    cycles.transparent_max_bounces = group.transparent_depth
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.blur_glossy, cycles.light_sampling_threshold = 0.0, 0.0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.pixel_filter_type, cycles.filter_width, cycles.film_exposure = "BOX", 1.0, 1.0
    group.pixel_filter, group.filter_width = "BOX", 1.0
    cycles.film_transparent_glass = group.film_transparent_glass
    cycles.film_transparent_roughness = group.film_transparent_roughness
    cycles.time_limit = 0.0
    render.use_compositing = render.use_sequencer = render.use_motion_blur = False


def set_threads(scene, threads):
    """Give both engines `threads` workers."""
    scene.render.threads_mode, scene.render.threads = "FIXED", threads


def size_of(scene):
    """(Width, height) in pixels as rendered."""
    render = scene.render
    return tuple(side * render.resolution_percentage // 100 for side in (render.resolution_x, render.resolution_y))


def picture(scene, engine, samples, seed):
    """Path-trace with `engine`.

    Returns
    -------
    (H, W, 3) float32
        Linear, scene-referred; row 0 is the top row.
    """
    scene.zraka.samples, scene.zraka.seed = samples, seed
    match(scene)
    return operate(scene, engine)[0]


def operate(scene, engine, alpha=False):
    """Render the scene as it is set.

    Returns
    -------
    picture : (H, W, 3) float32
        With `alpha`, (H, W, 4).
    seconds : float
        Wall time of the whole operator, from Blender's evaluation to the closed file.

    Raises
    ------
    SceneError
        With what the engine reported.
    """
    import bpy
    import OpenImageIO as oiio

    scene.render.engine = engine
    kind = scene.render.image_settings
    if hasattr(kind, "media_type"):  # Blender 5
        kind.media_type = "IMAGE"
    kind.file_format, kind.color_mode, kind.color_depth, kind.exr_codec = "OPEN_EXR", "RGB", "32", "NONE"
    if alpha:
        kind.color_mode = "RGBA"
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(Path(folder) / "picture.exr")
        try:
            with headless.quiet():
                started = time.perf_counter()
                bpy.ops.render.render(write_still=True)
                seconds = time.perf_counter() - started
        except RuntimeError as error:
            raise SceneError(" ".join(str(error).removeprefix("Error: ").split())) from error
        return oiio.ImageBuf(scene.render.filepath).get_pixels(oiio.FLOAT)[..., : 3 + alpha], seconds


# -- what Zraka measures of itself -------------------------------------------------------------------------------------


@dataclass
class Seen:
    """What passed between the add-on and the core in one render; None and empty for another engine."""

    export_seconds: float | None = None
    compile_seconds: float | None = None
    compiled: object = None
    settings: object = None
    film: object = None
    features: dict = field(default_factory=dict)
    stats: dict = field(default_factory=dict)
    messages: list = field(default_factory=list)


@contextlib.contextmanager
def watched(force_features=None, interrupted=None):
    """Stand between Zraka's add-on and its core while it renders; yields a `Seen`.

    Blender deletes an engine after its render, and with it what the engine knows.

    Parameters
    ----------
    force_features : Feature, optional
        Compile with these.
    interrupted : callable, optional
        True ends the render; asked beside Blender's own test.
    """
    from ...core import compile as compiling
    from ...core import render as rendering
    from .. import session

    seen, export_job, compile_scene, render = Seen(), session.export_job, compiling.compile_scene, rendering.render

    def watched_export(*args, **kwargs):
        job = export_job(*args, **kwargs)
        seen.export_seconds = job.export_seconds
        return job

    def watched_compile(scene, settings, diagnostics, before=None):
        started = time.perf_counter()
        seen.compiled = compile_scene(scene, settings, diagnostics, force_features, before)
        seen.compile_seconds = time.perf_counter() - started
        return seen.compiled

    def watched_render(compiled, settings, on_pass=None, cancelled=None):
        tests = [test for test in (cancelled, interrupted) if test]
        film = render(compiled, settings, on_pass, lambda: any(test() for test in tests))
        seen.settings, seen.stats, seen.messages = settings, film.stats, compiled.diagnostics.messages()
        seen.film, seen.features = film, compiled.feature_report()
        return film

    session.export_job, compiling.compile_scene, rendering.render = watched_export, watched_compile, watched_render
    try:
        yield seen
    finally:
        session.export_job, compiling.compile_scene, rendering.render = export_job, compile_scene, render


# -- a bench -----------------------------------------------------------------------------------------------------------


class Interrupted(Exception):
    """Ctrl-C was pressed; what was measured so far stands."""


@dataclass
class Run:
    """One render: its picture, the operator's wall time, and what Zraka said of it, its own estimate of the error."""

    picture: np.ndarray
    seconds: float
    seen: Seen
    estimate: float | None = None


class Bench:
    """The two engines of a run.

    Parameters
    ----------
    sides : dict
        Names, as results are kept under, of Blender's engines; the first is Zraka.
    threads : int
    interrupted : callable
        Asked after every render.
    say : callable
        Takes a line about how far the run is.
    """

    def __init__(self, sides, threads, interrupted=lambda: False, say=lambda text: None):
        self.sides, self.threads, self.interrupted, self.say = sides, threads, interrupted, say
        self._seed = 0

    @property
    def other(self):
        """Name of the engine that Zraka is measured against."""
        return list(self.sides)[1]

    def run(self, scene, side, samples=1, threads=None, force_features=None, matched=True):
        """Render with a seed that no render of this bench had before.

        Parameters
        ----------
        matched : bool
            Path-trace with both engines set alike; else render by what `scene.zraka` says.

        Raises
        ------
        Interrupted, SceneError
        """
        self._seed += 1
        scene.zraka.samples, scene.zraka.seed = samples, self._seed
        if matched:
            match(scene)
        set_threads(scene, threads or self.threads)
        with watched(force_features, self.interrupted) as seen:
            picture, seconds = operate(scene, self.sides[side])
        if self.interrupted():
            raise Interrupted
        estimate = seen.film.error() if seen.film else None
        seen.compiled = seen.film = None  # they may be large, and runs are kept
        return Run(picture, seconds, seen, estimate)

    def alternate(self, scene, cases, runs, warm=True, in_a_row=1):
        """Render the cases by turns, each once untimed if `warm` and then `runs` times; every other turn backwards.

        Parameters
        ----------
        cases : dict
            Key → keyword arguments of `run`.
        in_a_row : int
            Renders of a case in each turn. The first finds the memory and the caches that another case left, and
            memory that a virtual machine has given back meanwhile; the others find their own.

        Returns
        -------
        dict
            Key → list of `Run`.
        """
        order, found = list(cases), {key: [] for key in cases}
        for turn in range(0 if warm else 1, runs + 1):
            for key in order if turn % 2 else reversed(order):
                done = [self.run(scene, **cases[key]) for _ in range(in_a_row if turn else 1)]
                if turn:
                    found[key] += done
        return found


def median(runs):
    """Median wall time in seconds."""
    return float(np.median([run.seconds for run in runs]))
