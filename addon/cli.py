# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line: ``zraka render FILE.blend``, ``zraka bench``; ``python -m zraka``, ``blender --command zraka``.

Blender is imported after the arguments were found good. Exit codes: 0; 2 with one line for bad input; 130 when
interrupted by Ctrl-C, with the samples so far in the file.
"""

from __future__ import annotations

import argparse
import contextlib
import gzip
import json
import math
import os
import re
import signal
import sys
import threading
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..core.diagnostics import SceneError
from ..core.settings import METHODS
from . import headless
from .progress import error_text, summary


def main(argv=None):
    """Run the program.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments without the program's name; those of the process when None.

    Returns
    -------
    int
        The exit code.
    """
    started = time.perf_counter()
    try:
        args = _parser().parse_args(argv)
        return args.run(args, started)
    except SceneError as error:
        print(f"zraka: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("zraka: interrupted before the first sample; nothing was written", file=sys.stderr)
        return 130


# -- arguments ---------------------------------------------------------------------------------------------------------


class _Parser(argparse.ArgumentParser):
    """Says what is wrong in one line, without the usage before it."""

    def error(self, message):
        self.exit(2, f"{self.prog}: {message}\n")


def _parser():
    from .. import __version__

    parser = _Parser(prog="zraka", description="Render Blender scenes with Zraka.")
    parser.add_argument("--version", action="version", version=f"zraka {__version__}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for add_command in (_add_render, _add_bench):
        add_command(commands)
    return parser


def _add_render(commands):
    render = commands.add_parser(
        "render",
        help="render one frame of a .blend",
        description="Render one frame. What is not given comes from the scene.",
    )
    render.set_defaults(run=_render)
    add = render.add_argument
    add("file", type=Path, metavar="FILE.blend")
    add("--method", choices=METHODS, help="how light is simulated")
    add("--samples", type=_whole(1), metavar="N", help="samples of every pixel")
    add("--depth", type=_whole(1), metavar="N", help="hits along a path; 1 is direct light only")
    add("--size", type=_size, metavar="WxH", help="pixels, e.g. 640x480")
    add("--frame", type=_whole(-1048574, 1048574), metavar="F", help="frame of the animation")
    add("--camera", metavar="NAME", help="camera object")
    add("--threads", type=_whole(0, 1024), metavar="N", help="workers; 0 is one for each processor")
    add("--seed", type=_whole(0, 2**31 - 1), metavar="N", help="number that chooses the noise")
    add("--time-limit", type=_seconds, metavar="S", help="seconds after which rendering stops; 0 is none")
    add(
        "--output",
        type=Path,
        action="append",
        metavar="FILE.png|.exr",
        help="PNG through Blender's view transform or linear EXR; may be given twice",
    )
    add("--json", type=Path, metavar="STATS.json", help="write times, rays, the estimated error and more")


def _add_bench(commands):
    bench = commands.add_parser(
        "bench",
        help="measure time to equal error beside Cycles",
        description="Measure Zraka beside another engine in one process; writes bench.json, bench.md and plots.",
    )
    bench.set_defaults(run=_bench)
    add = bench.add_argument
    add("--suite", choices=("quick", "full"), default="quick", help="quick takes minutes, full hours")
    add(
        "--against",
        choices=("CYCLES", "ZRAKA"),
        default="CYCLES",
        help="the other engine; Zraka against itself shows how steady the machine is",
    )
    add("--output", type=Path, required=True, metavar="DIR", help="folder of the results; made if it is missing")


def _whole(least, most=2**31 - 1):
    """Make a parser of whole numbers from `least` to `most`."""

    def whole_number(text):
        try:
            value = int(text)
        except ValueError:
            raise argparse.ArgumentTypeError(f"{text!r} is not a whole number") from None
        if not least <= value <= most:
            raise argparse.ArgumentTypeError(f"{value} is not between {least} and {most}")
        return value

    return whole_number


def _seconds(text):
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not (value >= 0 and math.isfinite(value)):
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of seconds")
    return value


def _size(text):
    found = re.fullmatch(r"(\d+)[xX×](\d+)", text)
    size = tuple(int(side) for side in found.groups()) if found else (0, 0)
    if not all(1 <= side <= 65536 for side in size):
        raise argparse.ArgumentTypeError(f"bad size {text!r}; write WIDTHxHEIGHT in pixels, e.g. 640x480")
    return size


def _check_files(args):
    """Refuse files that cannot be read or written, before anything is computed.

    Raises
    ------
    SceneError
    """
    _check_blend(args.file)
    for path in args.output or ():
        _check_output(path)
    if args.json:
        _check_writable(args.json)


def _check_blend(path):
    if not path.is_file():
        raise SceneError(f"no such file: {path}")
    try:
        with path.open("rb") as file:
            head = file.read(7)
        if head.startswith(b"\x1f\x8b"):
            with gzip.open(path) as file:
                head = file.read(7)
    except (OSError, EOFError) as error:
        raise SceneError(f"{path} cannot be read: {getattr(error, 'strerror', None) or error}") from error
    zstandard = b"\x28\xb5\x2f\xfd"
    if head != b"BLENDER" and not head.startswith(zstandard):
        raise SceneError(f"{path} is not a .blend file")


def _check_output(path):
    if path.suffix.lower() not in headless.FORMATS:
        raise SceneError(f"{path} cannot be written: the name of a picture ends in {' or '.join(headless.FORMATS)}")
    _check_writable(path)


def _check_writable(path):
    if not path.parent.is_dir():
        raise SceneError(f"{path} cannot be written: there is no folder {path.parent}")
    target = path if path.exists() else path.parent
    if path.is_dir() or not os.access(target, os.W_OK):
        raise SceneError(f"{path} cannot be written: {target} is {'a folder' if path.is_dir() else 'read-only'}")


# -- rendering ---------------------------------------------------------------------------------------------------------


@dataclass
class _Times:
    """Seconds of the stages."""

    export: float = 0.0
    compile: float = 0.0
    render: float = 0.0
    total: float = 0.0


def _render(args, started):
    """Load, export, trace and write; return the exit code."""
    _check_files(args)
    bpy = headless.load_blender()
    scene = headless.open_scene(bpy, args)
    outputs = [path.absolute() for path in args.output or [headless.scene_output(scene)]]
    for path in outputs:
        _check_output(path)

    times = _Times()
    with _timed(times, "export"):
        job = headless.export(bpy, scene, args)
    from ..core.compile import compile_scene
    from ..core.render import render

    with _timed(times, "compile"):
        compiled = compile_scene(job.scene, job.settings, job.diagnostics)
    with _timed(times, "render"), _interruptible() as interrupted, _progress_bar(job.settings) as on_pass:
        film = render(compiled, job.settings, on_pass=on_pass, cancelled=interrupted.is_set)

    picture = headless.framed(film.image(), job.settings, crop=scene.render.use_crop_to_border)
    for path in outputs:
        headless.write_picture(bpy, scene, picture, path)
    times.total = time.perf_counter() - started
    for message in job.diagnostics.messages():
        print(f"zraka: warning: {message}", file=sys.stderr)
    if args.json:
        args.json.write_text(json.dumps(_stats(bpy, job, compiled, film, times), indent=2) + "\n", encoding="utf-8")
    print(summary(film, job.settings))
    return 130 if interrupted.is_set() else 0


@contextlib.contextmanager
def _timed(times, stage):
    started = time.perf_counter()
    yield
    setattr(times, stage, time.perf_counter() - started)


@contextlib.contextmanager
def _interruptible():
    """Make Ctrl-C end the render in good order; a second one ends the program as ever."""
    interrupted = threading.Event()

    def on_interrupt(number, frame):
        interrupted.set()
        signal.signal(signal.SIGINT, before)

    # Python cannot put Blender's own handler back, which it knows as None.
    before = signal.signal(signal.SIGINT, on_interrupt) or signal.SIG_DFL
    try:
        yield interrupted
    finally:
        signal.signal(signal.SIGINT, before)


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


# -- benchmark ---------------------------------------------------------------------------------------------------------


def _bench(args, started):
    """Run a suite and print its table; return the exit code."""
    from .bench import document, suite

    def say(text):
        print(f"zraka: {time.perf_counter() - started:.0f} s: {text}", file=sys.stderr)

    with _interruptible() as interrupted:
        result = suite.run(args.suite, args.against, args.output, interrupted.is_set, say)
    print(document.summary(result))
    return 130 if interrupted.is_set() else 0


# -- results -----------------------------------------------------------------------------------------------------------


def _stats(bpy, job, compiled, film, times):
    """Gather what the JSON file holds; numbers that are not finite become null."""
    from .. import __version__

    settings, error = job.settings, film.error()
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


# -- blender --command zraka -------------------------------------------------------------------------------------------

_commands = []


def register():
    """Add the program to Blender's commands, where it has them (4.2 has)."""
    import bpy

    if hasattr(bpy.utils, "register_cli_command"):
        _commands.append(bpy.utils.register_cli_command("zraka", main))


def unregister():
    """Remove it."""
    import bpy

    while _commands:
        bpy.utils.unregister_cli_command(_commands.pop())
