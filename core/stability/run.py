# SPDX-License-Identifier: GPL-3.0-or-later
"""The whole grid: every axis, then the stiff scenes."""

from __future__ import annotations

import time
from typing import NamedTuple

from . import glasses, hair, lamps, meshes, moving, pictures, placing, sight, stiff, surfaces, views
from .axis import holds, run_value, widest

FAMILIES = (placing, lamps, surfaces, views, meshes, pictures, glasses, hair, sight, moving)
AXES = tuple(axis for family in FAMILIES for axis in family.AXES)


class Report(NamedTuple):
    """All that was measured; `interrupted` tells that it is not whole, `processor` the seconds of all threads."""

    quick: bool
    results: list  # of axis.Result
    findings: list  # of stiff.Finding
    seconds: float
    interrupted: bool
    processor: float = 0.0

    @property
    def ranges(self):
        """{name of an axis: (least, greatest) or None} of the numeric axes that were run."""
        axes = dict.fromkeys(result.axis for result in self.results)
        return {axis.name: widest(axis, self.results) for axis in axes if axis.usual is not None}

    @property
    def failures(self):
        """Names of what failed, of axes that are too narrow too."""
        names = [f"{r.axis.name}: {r.value}" for r in self.results if r.verdict == "fail"]
        names += [f"stiff: {f.stiff.name}" for f in self.findings if f.verdict == "fail"]
        axes = {} if self.interrupted else {result.axis.name: result.axis for result in self.results}
        names += [
            f"{name}: narrower than it must be"
            for name, axis in axes.items()
            if not holds(axis, widest(axis, self.results), axis.chosen(self.quick))
        ]
        return names


def run(quick=False, cancelled=lambda: False, say=lambda text: None, axes=AXES, scenes=stiff.STIFF):
    """Render the grid.

    Parameters
    ----------
    quick : bool
        A few values of each axis, in less than a minute.
    cancelled : callable
        Asked between two cases; what was measured until then is in the report.
    say : callable
        Takes a line about how far the run is.
    axes, scenes
        What is run.

    Returns
    -------
    Report
    """
    started, computed, results, findings = time.perf_counter(), time.process_time(), [], []

    def report(interrupted):
        seconds, processor = time.perf_counter() - started, time.process_time() - computed
        return Report(quick, results, findings, seconds, interrupted, processor)

    for axis in axes:
        say(axis.name)
        for value in axis.chosen(quick):
            if cancelled():
                return report(True)
            results.append(run_value(axis, value, quick))
            if results[-1].verdict == "fail":
                say(f"failed: {axis.name}: {value}")
    for scene in scenes:
        if quick and not scene.quick:
            continue
        if cancelled():
            return report(True)
        say(f"stiff: {scene.name}")
        findings.append(stiff.measure(scene))
        if findings[-1].verdict == "fail":
            say(f"failed: stiff: {scene.name}")
    return report(False)
