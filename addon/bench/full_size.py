# SPDX-License-Identifier: GPL-3.0-or-later
"""What tracing costs where the fixed costs of a render count for little: scenes at their own size."""

from __future__ import annotations

import numpy as np

from . import scenes
from .engines import median, open_blend

SAMPLES = 16
SCENES = ("cornell", "interior")


def full_size(bench, plan, folder):
    """Seconds of both engines for as many samples, and Embree's share of Zraka's wall time."""
    rows = []
    for name in SCENES:
        scene = open_blend(scenes.find(name, folder), plan.large)
        cases = {side: {"side": side, "samples": SAMPLES} for side in bench.sides}
        runs = bench.alternate(scene, cases, plan.runs)
        seconds = {side: median(runs[side]) for side in bench.sides}
        share = [run.seen.stats["embree_seconds"] / run.seconds for run in runs["zraka"]]
        faster = seconds[bench.other] / seconds["zraka"]
        rows.append({"scene": name, "seconds": seconds, "faster": faster, "embree_share": float(np.median(share))})
    return rows


def threads(bench, plan, folder):
    """One thread and two, both engines, `cornell`: seconds, and how many times faster two are.

    Of renders that follow one of their own kind, and of those that follow another.
    """
    scene = open_blend(scenes.find("cornell", folder), plan.large)
    cases = {(side, n): {"side": side, "samples": SAMPLES, "threads": n} for n in (1, 2) for side in bench.sides}
    runs = bench.alternate(scene, cases, plan.runs, in_a_row=2)
    found = {}
    for side in bench.sides:
        first, again = (_gain(runs[side, 1][place::2], runs[side, 2][place::2]) for place in (0, 1))
        one, two, gain = again
        found[side] = {"seconds": {"1": one, "2": two}, "gain": gain, "gain_after_another": first[-1]}
    return found


def _gain(one, two):
    """Median seconds of runs on one thread and on two, and their ratio."""
    one, two = median(one), median(two)
    return one, two, one / two


STUDIES = {"full_size": full_size, "threads": threads}
