# SPDX-License-Identifier: GPL-3.0-or-later
"""``zraka render FILE.blend``."""

from __future__ import annotations

import contextlib
import json
import math
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...core.diagnostics import SceneError
from ...core.settings import METHODS
from .. import headless
from ..progress import error_text, summary
from .arguments import seconds, size, whole
from .files import check_blend, check_distinct, check_output, check_writable
from .interrupt import interruptible


def add_command(commands):
    """Add the command and its arguments."""
    render = commands.add_parser(
        "render",
        help="render one frame of a .blend",
        description="Render one frame. What is not given comes from the scene.",
    )
    render.set_defaults(run=_render)
    add = render.add_argument
    add("file", type=Path, metavar="FILE.blend")
    add("--method", choices=METHODS, help="how light is simulated")
    add("--samples", type=whole(1), metavar="N", help="samples of every pixel")
    add("--depth", type=whole(1), metavar="N", help="hits along a path; 1 is direct light only")
    add("--size", type=size, metavar="WxH", help="pixels, e.g. 640x480")
    add("--frame", type=whole(-1048574, 1048574), metavar="F", help="frame of the animation")
    add("--camera", metavar="NAME", help="camera object")
    add("--threads", type=whole(0, 1024), metavar="N", help="workers; 0 is one for each processor")
    add("--seed", type=whole(0, 2**31 - 1), metavar="N", help="number that chooses the noise")
    add("--time-limit", type=seconds, metavar="S", help="seconds after which rendering stops; 0 is none")
    add(
        "--output",
        type=Path,
        action="append",
        metavar="FILE.png|.exr",
        help="PNG through Blender's view transform or linear EXR; may be given twice",
    )
    add("--json", type=Path, metavar="STATS.json", help="write times, rays, the estimated error and more")


# -- rendering ---------------------------------------------------------------------------------------------------------


def _check(args):
    """Refuse files that cannot be read or written, before anything is computed.

    Raises
    ------
    SceneError
    """
    check_blend(args.file)
    for path in args.output or ():
        check_output(path)
    if args.json:
        check_writable(args.json)
    check_distinct([*(args.output or ()), *([args.json] if args.json else ())])


@dataclass
class _Times:
    """Seconds of the stages."""

    export: float = 0.0
    compile: float = 0.0
    render: float = 0.0
    total: float = 0.0


def _render(args, started):
    """Load, export, trace and write; return the exit code."""
    _check(args)
    bpy = headless.load_blender()
    scene = headless.open_scene(bpy, args)
    outputs = [path.absolute() for path in args.output or [headless.scene_output(scene)]]
    for path in outputs:
        check_output(path)

    times = _Times()
    with _timed(times, "export"):
        job = headless.export(bpy, scene, args)
    from ...core.render import render
    from ..session import compile_job

    with _timed(times, "compile"):
        compiled = compile_job(job)
    with _timed(times, "render"), interruptible() as interrupted, _progress_bar(job.settings) as on_pass:
        film = render(compiled, job.settings, on_pass=on_pass, cancelled=interrupted.is_set)

    picture = headless.framed(film.image(), job.settings, crop=scene.render.use_crop_to_border)
    for path in outputs:
        headless.write_picture(bpy, scene, picture, path)
    times.total = time.perf_counter() - started
    for message in job.diagnostics.messages():
        print(f"zraka: warning: {message}", file=sys.stderr)
    if args.json:
        _write_json(args.json, _stats(bpy, job, compiled, film, times))
    print(summary(film, job.settings))
    return 130 if interrupted.is_set() else 0


@contextlib.contextmanager
def _timed(times, stage):
    started = time.perf_counter()
    yield
    setattr(times, stage, time.perf_counter() - started)


@contextlib.contextmanager
def _progress_bar(settings):
    """Show a bar of the samples on a terminal; yields what is called after a pass."""
    try:
        from tqdm import tqdm
    except ImportError:  # inside Blender
        yield None
        return
    with tqdm(total=settings.samples, unit=" samples", desc=settings.method, disable=None) as bar:

        def on_pass(film, progress):
            bar.set_postfix_str(f"error {error_text(film)}", refresh=False)
            bar.update(film.samples - bar.n)

        yield on_pass


# -- results -----------------------------------------------------------------------------------------------------------


def _write_json(path, stats):
    try:
        path.write_text(json.dumps(stats, indent=2) + "\n", encoding="utf-8")
    except OSError as error:
        raise SceneError(f"{path} cannot be written: {error.strerror or error}") from error


def _stats(bpy, job, compiled, film, times):
    """Gather what the JSON file holds; numbers that are not finite become null."""
    from ... import __version__

    settings, error = job.settings, film.stats["error"]
    return {
        "zraka": __version__,
        "bpy": bpy.app.version_string,
        "numpy": np.__version__,
        "method": settings.method,
        "size": [settings.width, settings.height],
        "border": settings.border,
        "samples": film.samples,
        "stopped": film.stats["stopped"],
        "depth": settings.depth,
        "threads": film.stats["threads"],
        "seed": settings.seed,
        "seconds": vars(times),
        "rays": dict(film.stats["rays"]),
        "embree_seconds": film.stats["embree_seconds"],
        "nonfinite": film.stats["nonfinite"],
        "features": compiled.feature_report(),
        "diagnostics": job.diagnostics.messages(),
        "estimated_error": error if math.isfinite(error) else None,
    }
