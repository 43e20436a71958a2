# SPDX-License-Identifier: GPL-3.0-or-later
"""``zraka bench``."""

from __future__ import annotations

import sys
import time
from pathlib import Path

from .interrupt import interruptible


def add_command(commands):
    """Add the command and its arguments."""
    bench = commands.add_parser(
        "bench",
        help="measure time to equal error beside Cycles",
        description="Measure Zraka beside another engine in one process; writes bench.json, bench.md and plots.",
    )
    bench.set_defaults(run=_bench)
    add = bench.add_argument
    add("--suite", choices=("quick", "full"), default="quick", help="quick takes minutes, full an hour")
    add(
        "--against",
        choices=("CYCLES", "ZRAKA"),
        default="CYCLES",
        help="the other engine; Zraka against itself shows how steady the machine is",
    )
    add("--output", type=Path, required=True, metavar="DIR", help="folder of the results; made if it is missing")


def _bench(args, started):
    """Run a suite and print its table; return the exit code."""
    from ..bench import document, suite

    def say(text):
        print(f"zraka: {time.perf_counter() - started:.0f} s: {text}", file=sys.stderr)

    with interruptible() as interrupted:
        result = suite.run(args.suite, args.against, args.output, interrupted.is_set, say)
    print(document.summary(result))
    return 130 if interrupted.is_set() else 0
