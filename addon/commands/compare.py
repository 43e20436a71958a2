# SPDX-License-Identifier: GPL-3.0-or-later
"""``zraka compare FILE.blend``."""

from __future__ import annotations

import sys
import time
from pathlib import Path

from ...core.diagnostics import SceneError
from ...core.settings import METHODS
from .arguments import methods, size, whole
from .files import check_blend, check_writable
from .interrupt import interruptible

_REFERENCE = 16  # times the samples


def add_command(commands):
    """Add the command and its arguments."""
    compare = commands.add_parser(
        "compare",
        help="put the methods' pictures beside each other",
        description="Render a scene by each method and make a contact sheet with times and errors.",
    )
    compare.set_defaults(run=_compare)
    add = compare.add_argument
    add("file", type=Path, metavar="FILE.blend")
    add("--methods", type=methods, default=METHODS, metavar="LIST", help=f"of {','.join(METHODS)}; all of them")
    add("--samples", type=whole(1), default=16, metavar="N", help="samples of every method (16)")
    add(
        "--reference-samples",
        type=whole(8),
        metavar="N",
        help=f"of the path-traced picture that errors are measured against; {_REFERENCE} times as many",
    )
    add("--size", type=size, metavar="WxH", help="pixels, e.g. 640x480")
    add("--threads", type=whole(0, 1024), default=0, metavar="N", help="workers; 0 is one for each processor")
    add("--output", type=Path, required=True, metavar="DIR|FILE.png", help="the sheet, or a folder to put it into")


def _compare(args, started):
    """Render, draw and print; return the exit code."""
    check_blend(args.file)
    _check_output(args.output)
    from ..report import compare
    from ..report.measure import Plan

    def say(text):
        print(f"zraka: {time.perf_counter() - started:.0f} s: {text}", file=sys.stderr)

    plan = Plan(
        methods=args.methods,
        reference_samples=args.reference_samples or max(8, _REFERENCE * args.samples),
        size=args.size,
        threads=args.threads,
        rungs=(args.samples,),
    )
    with interruptible() as interrupted:
        measured = compare.compare(args.file, args.output, plan, interrupted.is_set, say)
    if measured.interrupted:
        print("zraka: interrupted before all methods were rendered; nothing was written", file=sys.stderr)
        return 130
    print(compare.lines(measured))
    return 0


def _check_output(path):
    """Refuse what is neither a folder's name nor a PNG's that can be written; raises `SceneError`."""
    if path.suffix.lower() == ".png":
        check_writable(path)
    elif path.suffix and not path.is_dir():
        raise SceneError(f"{path} cannot be written: a contact sheet's name ends in .png")
