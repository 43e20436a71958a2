# SPDX-License-Identifier: GPL-3.0-or-later
"""``zraka converge FILE.blend``."""

from __future__ import annotations

import sys
import time
from pathlib import Path

from ...core.settings import METHODS
from .arguments import methods, seconds, size, whole
from .files import check_blend
from .interrupt import interruptible


def add_command(commands):
    """Add the command and its arguments."""
    converge = commands.add_parser(
        "converge",
        help="report error against run time",
        description="Render a scene with growing samples by each method and report error against run time; "
        "several files get a folder each, and an index.",
    )
    converge.set_defaults(run=_converge)
    add = converge.add_argument
    add("files", type=Path, nargs="+", metavar="FILE.blend")
    add("--methods", type=methods, default=METHODS, metavar="LIST", help=f"of {','.join(METHODS)}; all of them")
    add("--against", choices=("CYCLES",), help="measure this engine, too")
    reference = converge.add_mutually_exclusive_group()
    reference.add_argument("--reference", type=Path, metavar="FILE.exr", help="linear picture that counts as the truth")
    reference.add_argument(
        "--reference-samples",
        type=whole(8),
        metavar="N",
        help="samples of the reference, whose time does not count; else it takes a share of the time",
    )
    add(
        "--time-limit",
        type=seconds,
        default=60.0,
        metavar="S",
        help="seconds for each file (60); 0 is none, and the ladder ends with the scene's own samples",
    )
    add("--size", type=size, metavar="WxH", help="pixels, e.g. 640x480")
    add("--threads", type=whole(0, 1024), default=0, metavar="N", help="workers; 0 is one for each processor")
    add("--output", type=Path, required=True, metavar="DIR", help="folder of the report; made if it is missing")


def _converge(args, started):
    """Measure, write and print; return the exit code."""
    for path in args.files:
        check_blend(path)
    from ..report import converge, index
    from ..report.measure import Plan

    def say(text):
        print(f"zraka: {time.perf_counter() - started:.0f} s: {text}", file=sys.stderr)

    plan = Plan(
        methods=args.methods,
        against=args.against == "CYCLES",
        reference=args.reference,
        reference_samples=args.reference_samples,
        time_limit=args.time_limit,
        size=args.size,
        threads=args.threads,
    )
    reports = {}
    with interruptible() as interrupted:
        for path in args.files:
            if interrupted.is_set():
                break
            several = len(args.files) > 1
            if several:
                say(path.name)
            folder = args.output / path.stem if several else args.output
            reports[path.stem] = converge.converge(path, plan, folder, interrupted.is_set, say)
            print(converge.summary(reports[path.stem]))
            if several:
                index.write(reports, args.output)
    return 130 if interrupted.is_set() else 0
