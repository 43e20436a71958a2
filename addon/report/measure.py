# SPDX-License-Identifier: GPL-3.0-or-later
"""Error against run time: every method on one scene, with growing samples, by turns in one process.

The reference is path-traced by independent runs with seeds of their own. Beside Cycles each engine is judged by the
other's reference, as in `addon.bench.convergence`, so that none is compared with what it made itself. Every rung of
the ladder is rendered twice: two renders tell noise from bias, and no rung rests on one measured time.
"""

from __future__ import annotations

import os
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ...core.diagnostics import SceneError
from ...core.report import metrics
from ...core.report.error import Convergence, agreement, noise, relative_rmse, weights
from ..bench.engines import Bench, Interrupted, match, open_blend, size_of
from .display import read_linear

NAMES = {
    "phong": "Phong",
    "raycast": "Ray casting",
    "raytrace": "Ray tracing",
    "pathtrace": "Path tracing",
    "cycles": "Cycles",
}
RANDOM = ("pathtrace", "cycles")
"""Whose error falls with samples; that of the others is bias, and stays."""

RUNS, REFERENCE_RUNS = 2, 4
_CLASSIC_RUNGS = (1, 4, 16)  # more smooth no edge that is seen
_MOST_SAMPLES, _LEAST_REFERENCE = 1 << 14, 16
_REFERENCE_SHARE = 0.4  # of the time limit


@dataclass(frozen=True)
class Plan:
    """What is measured.

    Parameters
    ----------
    methods : sequence of str
        Of `core.settings.METHODS`.
    against : bool
        Measure Cycles, too.
    reference : Path, optional
        A linear picture in place of a reference of our own.
    reference_samples : int, optional
        Of each pixel of the reference, whose time then does not count; None takes a share of the time limit.
    time_limit : float
        Seconds; 0 is none, and the ladder ends with the scene's own samples.
    size : (width, height), optional
        In place of the scene's.
    threads : int
        0 is one for each processor.
    rungs : sequence of int, optional
        Samples of all methods in place of a ladder that is climbed until time is used up.
    """

    methods: tuple = ("phong", "raycast", "raytrace", "pathtrace")
    against: bool = False
    reference: Path | None = None
    reference_samples: int | None = None
    time_limit: float = 60.0
    size: tuple | None = None
    threads: int = 0
    rungs: tuple | None = None


@dataclass
class Rung:
    """What was measured of a method with one number of samples.

    Seconds are of the quicker run, since what else the machine does only adds; errors are means of the runs.
    """

    method: str
    samples: int
    seconds: float
    error: float
    error_with_fireflies: float
    noise: float
    bias: float
    relative_mse: float
    psnr: float
    flip: float | None
    estimate: float | None
    rays: int | None


@dataclass
class Measured:
    """All that a report says; pictures are linear, (H, W, 3), row 0 at the top.

    Attributes
    ----------
    rungs : dict
        Method → list of `Rung`, samples ascending.
    pictures : dict
        Method → one picture of its last rung.
    references : dict
        "zraka", "cycles" or "file" → (R, H, W, 3), independent runs.
    """

    name: str
    size: tuple
    plan: Plan
    depth: int
    rungs: dict = field(default_factory=dict)
    pictures: dict = field(default_factory=dict)
    references: dict = field(default_factory=dict)
    reference_samples: int | None = None
    reference_seconds: float = 0.0
    seconds: float = 0.0
    interrupted: bool = True  # until it is whole
    diagnostics: list = field(default_factory=list)
    features: dict = field(default_factory=dict)

    def judge(self, method):
        """Runs of the reference that a method is measured against."""
        other = "zraka" if method == "cycles" else "cycles"
        return self.references.get(other, next(iter(self.references.values())))

    def agreement(self):
        """Share of blocks in which the two engines' references agree; None of one reference."""
        return agreement(*self.references.values()) if len(self.references) == 2 else None

    def reference_noise(self):
        """Relative RMSE of the reference itself, 0 of a file."""
        return max(float(np.sqrt(noise(r, weights(r.mean(axis=0))) / len(r))) for r in self.references.values())

    def convergence(self, method):
        """`Convergence` of a method whose error falls; None where too little was measured."""
        rows = [rung for rung in self.rungs.get(method, ()) if rung.error > 0]
        if method not in RANDOM or len(rows) < 2:
            return None
        return Convergence(*([getattr(rung, key) for rung in rows] for key in ("samples", "error", "seconds")))


def measure(path, plan, interrupted=lambda: False, say=lambda text: None):
    """Measure a scene.

    Parameters
    ----------
    path : Path
    plan : Plan
    interrupted : callable
        Asked after every render; True ends the measurement, and what was measured stands.
    say : callable
        Takes a line about how far it is.

    Returns
    -------
    scene : bpy.types.Scene
    measured : Measured

    Raises
    ------
    SceneError
    """
    scene = open_blend(path)
    if plan.size:
        scene.render.resolution_x, scene.render.resolution_y = plan.size
    scene.render.use_border = False
    return scene, _Measurement(scene, path.stem, plan, interrupted, say).run()


class _Measurement:
    def __init__(self, scene, name, plan, interrupted, say):
        self._scene, self._plan, self._say = scene, plan, say
        self._samples = scene.zraka.samples  # the scene's own, before it is changed
        self._methods = list(plan.methods) + ["cycles"] * plan.against
        self._bench = Bench(
            {"zraka": "ZRAKA", "cycles": "CYCLES"}, plan.threads or os.cpu_count() or 1, interrupted, say
        )
        self.measured = Measured(name, size_of(scene), plan, scene.zraka.depth)
        self._file = _reference_of(plan.reference, self.measured.size)

    def run(self):
        started = time.perf_counter()
        try:
            self._warm()
            self._make_references()
            counted = time.perf_counter() if self._plan.reference_samples else started
            self._climb(counted + (self._plan.time_limit or np.inf))
            self.measured.interrupted = False
        except Interrupted:
            self._say("interrupted; what was measured is written")
        self.measured.seconds = time.perf_counter() - started
        return self.measured

    def _warm(self):
        """Render once untimed: libraries are loaded, and Zraka says what it leaves out."""
        for method in dict.fromkeys((*self._methods, "pathtrace")):
            seen = self._render(method, 1).seen
            if seen.stats:
                self.measured.features[method] = seen.features
                known = self.measured.diagnostics
                known += [message for message in seen.messages if message not in known]

    def _render(self, method, samples):
        """One `Run`; all are set as plain unbiased path tracing is."""
        if method == "cycles":
            return self._bench.run(self._scene, "cycles", samples)
        match(self._scene)
        self._scene.zraka.method = method.upper()
        return self._bench.run(self._scene, "zraka", samples, matched=False)

    # -- reference -----------------------------------------------------------------------------------------------------

    def _make_references(self):
        if self._file is not None:
            self.measured.references["file"] = np.stack([self._file] * 2)  # which leaves it without noise
            return
        engines = {"zraka": "pathtrace"} | ({"cycles": "cycles"} if self._plan.against else {})
        share = _REFERENCE_SHARE * self._plan.time_limit / len(engines)
        counts = {name: self._reference_samples(method, share) for name, method in engines.items()}
        count = min(counts.values())
        self.measured.reference_samples = count * REFERENCE_RUNS
        self._say(f"reference of {count * REFERENCE_RUNS} samples")
        runs = {name: [] for name in engines}
        before = time.perf_counter()
        for _ in range(REFERENCE_RUNS):
            for name, method in engines.items():
                runs[name].append(self._render(method, count).picture)
        self.measured.reference_seconds = time.perf_counter() - before
        self.measured.references = {name: np.stack(pictures) for name, pictures in runs.items()}

    def _reference_samples(self, method, share):
        """Of one run, a power of two where time decides."""
        if self._plan.reference_samples:
            return -(-self._plan.reference_samples // REFERENCE_RUNS)
        if not self._plan.time_limit:
            return 16 * self._samples // REFERENCE_RUNS
        one, more = (self._render(method, n).seconds for n in (1, 8))
        each = max((more - one) / 7, 1e-4)
        most = (share / REFERENCE_RUNS - max(one - each, 0.0)) / each
        return int(2 ** np.floor(np.log2(np.clip(most, _LEAST_REFERENCE, _MOST_SAMPLES))))

    # -- ladder --------------------------------------------------------------------------------------------------------

    def _climb(self, deadline):
        """Double the samples until time, or what the reference can judge, is used up."""
        if self._plan.rungs:
            for samples in self._plan.rungs:
                self._rung(self._methods, samples)
            return
        samples, most = 1, self._most_samples()
        while samples <= most:
            due = [method for method in self._methods if self._is_due(method, samples, deadline)]
            if due:
                self._rung(due, samples)
            samples *= 2

    def _most_samples(self):
        if self._plan.time_limit:
            return self.measured.reference_samples or _MOST_SAMPLES
        return max(self._samples, _CLASSIC_RUNGS[-1])

    def _is_due(self, method, samples, deadline):
        if method not in RANDOM and samples not in _CLASSIC_RUNGS:
            return False
        rungs = self.measured.rungs.get(method)
        if not rungs:
            return samples == 1
        growth = samples / rungs[-1].samples
        return time.perf_counter() + RUNS * growth * rungs[-1].seconds < deadline

    def _rung(self, methods, samples):
        """Render by turns, every other turn backwards, and measure."""
        self._say(f"{samples} samples by {', '.join(methods)}")
        runs = {method: [] for method in methods}
        for turn in range(RUNS):
            for method in reversed(methods) if turn % 2 else methods:
                runs[method].append(self._render(method, samples))
        for method in methods:
            self.measured.rungs.setdefault(method, []).append(_judged(method, samples, runs[method], self.measured))
            self.measured.pictures[method] = runs[method][-1].picture


def _reference_of(path, size):
    """The picture at `path`, which must have the scene's size; None of None."""
    if path is None:
        return None
    picture = read_linear(path)
    height, width = picture.shape[:2]
    if (width, height) != tuple(size):
        raise SceneError(f"{path} has {width} × {height} pixels and the scene {size[0]} × {size[1]}; give --size")
    return picture


def _judged(method, samples, runs, measured):
    """The `Rung` of some runs."""
    reference = measured.judge(method)
    truth = reference.mean(axis=0)
    weight, pictures = weights(truth), [run.picture for run in runs]

    def error(**kwargs):
        return float(np.sqrt(np.mean([relative_rmse(p, reference, weight, **kwargs) ** 2 for p in pictures])))

    parts = metrics.noise_and_bias(np.stack(pictures), reference)
    shown, shown_truth = metrics.displayed(pictures[-1]), metrics.displayed(truth)
    estimates = [run.estimate for run in runs if run.estimate is not None and np.isfinite(run.estimate)]
    stats = runs[-1].seen.stats
    return Rung(
        method=method,
        samples=samples,
        seconds=min(run.seconds for run in runs),
        error=error(),
        error_with_fireflies=error(trim=0.0),
        noise=parts.noise,
        bias=parts.bias,
        relative_mse=float(np.mean([metrics.relative_mse(p, truth) for p in pictures])),
        psnr=metrics.psnr(shown, shown_truth),
        flip=metrics.flip(shown, shown_truth),
        estimate=float(np.mean(estimates)) if estimates else None,
        rays=sum(stats["rays"].values()) if stats else None,
    )
