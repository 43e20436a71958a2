# SPDX-License-Identifier: GPL-3.0-or-later
"""``zraka stability``."""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

from ...core.diagnostics import SceneError
from ..machine import make_folder
from .interrupt import interruptible


def add_command(commands):
    """Add the command and its arguments."""
    stability = commands.add_parser(
        "stability",
        help="render extreme and stiff scenes whose answers are known",
        description=(
            "Render scenes of known answers, driven to their extremes; writes stability.md, stability.json and "
            "stability.html. Exits with 1 if a case fails."
        ),
    )
    stability.set_defaults(run=_stability)
    add = stability.add_argument
    add("--quick", action="store_true", help="a few values of each quantity: a minute instead of a quarter of an hour")
    add("--output", type=Path, required=True, metavar="DIR", help="folder of the results; made if it is missing")


def _stability(args, started):
    """Run the grid and write what came of it; return the exit code."""
    from ...core.stability import document
    from ...core.stability.run import run

    def say(text):
        print(f"zraka: {time.perf_counter() - started:.0f} s: {text}", file=sys.stderr)

    make_folder(args.output)
    try:
        with interruptible() as interrupted:
            report = run(args.quick, interrupted.is_set, say)
        texts = {
            "stability.md": document.markdown(report),
            "stability.json": json.dumps(document.data(report), indent=1, allow_nan=False) + "\n",
            "stability.html": document.page(report),
        }
        for name, text in texts.items():
            (args.output / name).write_text(text, encoding="utf-8")
    except OSError as error:
        raise SceneError(f"{error.filename or args.output} cannot be written: {error.strerror or error}") from error
    for name in report.failures:
        print(f"zraka: failed: {name}", file=sys.stderr)
    count = sum(len(r.outcomes) for r in report.results)
    print(
        f"{count} renders, {len(report.failures)} failing, {report.seconds:.0f} s; see {args.output / 'stability.md'}"
    )
    return 130 if report.interrupted else 1 if report.failures else 0
