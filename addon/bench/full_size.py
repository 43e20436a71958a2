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
    """One thread and two, both engines, `cornell`: seconds, and how many times faster two are."""
    scene = open_blend(scenes.find("cornell", folder), plan.large)
    cases = {(side, n): {"side": side, "samples": SAMPLES, "threads": n} for n in (1, 2) for side in bench.sides}
    runs = bench.alternate(scene, cases, plan.runs)
    found = {}
    for side in bench.sides:
        one, two = (median(runs[side, n]) for n in (1, 2))
        found[side] = {"seconds": {"1": one, "2": two}, "gain": one / two}
    return found


STUDIES = {"full_size": full_size, "threads": threads}
