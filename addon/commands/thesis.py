# SPDX-License-Identifier: GPL-3.0-or-later
"""``zraka thesis``."""

from __future__ import annotations

import sys
import time
from pathlib import Path

from .arguments import size
from .interrupt import interruptible

EXPERIMENTS = ("4.1", "4.2", "4.3", "4.4", "4.5", "4.6", "table-4.1")


def add_command(commands):
    """Add the command and its arguments."""
    thesis = commands.add_parser(
        "thesis",
        help="make the thesis' experiments anew",
        description="Make the figures and the table of the thesis anew; writes thesis.md and figures/.",
    )
    thesis.set_defaults(run=_thesis)
    add = thesis.add_argument
    add("--experiment", choices=EXPERIMENTS, action="append", help="may be given several times; all when not given")
    add("--size", type=size, metavar="WxH", help="pixels of the figures' pictures; 500x500 when not given")
    add("--output", type=Path, required=True, metavar="DIR", help="folder of the results; made if it is missing")


def _thesis(args, started):
    """Render, write and print; return the exit code."""
    from ..report import thesis_document

    def say(text):
        print(f"zraka: {time.perf_counter() - started:.0f} s: {text}", file=sys.stderr)

    with interruptible() as interrupted:
        names = args.experiment or EXPERIMENTS
        found = thesis_document.make(names, args.output, args.size, interrupted.is_set, say)
    for result in found.values():
        print(f"{result.title}: {result.text}")
    return 130 if interrupted.is_set() else 0
