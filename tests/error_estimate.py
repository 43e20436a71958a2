# SPDX-License-Identifier: GPL-3.0-or-later
"""The estimated error of pictures against the true one, and what is foretold from it: the tables of docs/error.md.

``python tests/error_estimate.py`` measures all sample scenes; ``--keep FOLDER`` keeps the references between runs.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import threading
import time
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from zraka.addon import headless
from zraka.addon.bench.engines import open_blend
from zraka.addon.bench.scenes import find
from zraka.addon.monitor import error_picture
from zraka.core.compile import compile_scene
from zraka.core.film import INTERVAL_95, Film
from zraka.core.render import render
from zraka.core.report.error import relative_rmse, weights
from zraka.core.report.forecast import Forecast
from zraka.core.sampling.color import luminance

SCENES = ("cornell", "interior", "many", "room_closed", "room_open", "spheres", "thesis", "whitted", "lamps", "sky")
LADDER = (4, 8, 16, 64)
PIXELS = 5184
RUNS = 4
FIRST_SEED = 1000  # of the references; no measured picture has one of these


def main():
    """Print a line for each scene and number of samples."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("scenes", nargs="*", default=SCENES)
    parser.add_argument("--reference", type=int, default=4096, help="samples of the reference")
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--adaptive", action="store_true")
    parser.add_argument("--keep", type=Path, help="folder for the references")
    parser.add_argument("--pixels", type=int, default=PIXELS)
    parser.add_argument("--samples", type=int, default=256, help="of which the last error is foretold")
    parser.add_argument("--first-seed", type=int, default=3, help="of the render whose error is foretold")
    parser.add_argument("--what", choices=("error", "stop", "forecast", "cost"), default="error")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for name in args.scenes:
            job = job_of(name, Path(folder), args.pixels)
            if args.what == "stop":
                stops(name, job, args)
            elif args.what == "forecast":
                forecasts(name, job, args)
            elif args.what == "cost":
                cost(name, job)
            else:
                errors(name, job, args)


def job_of(name, folder, pixels=PIXELS):
    """A scene to be rendered by path tracing, of about so many pixels, with no stopping rule."""
    scene = open_blend(find(name, folder))
    aspect = scene.render.resolution_x / scene.render.resolution_y
    height = round((pixels / aspect) ** 0.5)
    args = SimpleNamespace(method="pathtrace", samples=1, depth=None, threads=None, seed=None, time_limit=0)
    args.size = round(height * aspect), height
    job = headless.export(headless.load_blender(), scene, args)
    return replace(job, settings=replace(job.settings, noise_target=0.0, adaptive=False, pixel_errors=True))


def film_of(job, samples, seed, **settings):
    """Render a job."""
    settings = replace(job.settings, samples=samples, seed=seed, **settings)
    return render(compile_scene(job.scene, settings, job.diagnostics), settings)


def colors(film):
    """The picture without alpha, (H, W, 3) float64."""
    return film.mean()[:3].T.reshape(film.height, film.width, 3)


def references(name, job, args):
    """Independent runs, (RUNS, H, W, 3)."""
    kept = args.keep / f"{name}.npz" if args.keep else None
    if kept and kept.exists():
        return np.load(kept)["refs"]
    runs = np.stack([colors(film_of(job, args.reference // RUNS, FIRST_SEED + k)) for k in range(RUNS)])
    if kept:
        np.savez(kept, refs=runs)
    return runs


# -- the estimate ------------------------------------------------------------------------------------------------------


def errors(name, job, args):
    """Estimate against truth, and the share of pixels whose interval holds the truth."""
    runs = references(name, job, args)
    for samples in LADDER:
        for seed in range(1, args.seeds + 1):
            film = film_of(job, samples, seed, adaptive=args.adaptive)
            true, told = relative_rmse(colors(film), runs, weights(runs.mean(axis=0))), film.error()
            print(
                f"| {name} | {samples} | {true:.2%} | {told:.2%} | {told / true:.2f} | {coverage(film, runs):.1%} |",
                flush=True,
            )


def coverage(film: Film, runs):
    """Share of pixels whose mean is within `INTERVAL_95` errors, its own and the reference's, of the reference."""
    brightness = luminance(np.moveaxis(runs, -1, 0))
    noise = brightness.var(axis=0, ddof=1).mean() / len(runs)
    apart = luminance(film.mean()).reshape(film.height, film.width) - brightness.mean(axis=0)
    return float((np.abs(apart) <= INTERVAL_95 * np.sqrt(film.pixel_error() ** 2 + noise)).mean())


# -- what is foretold --------------------------------------------------------------------------------------------------


def stops(name, job, args):
    """How near to a noise target rendering stops: the error over the target."""
    for share in (0.7, 0.4, 0.2):
        target = share * film_of(job, 4, 1).error()
        film = film_of(job, 4096, 2, noise_target=target, adaptive=args.adaptive)
        told = film.error()
        print(f"| {name} | {target:.2%} | {film.samples} | {told:.2%} | {told / target:.2f} |", flush=True)


def forecasts(name, job, args):
    """Foretell at a quarter of the seconds when the last error is reached: in samples, and in seconds."""
    film_of(job, 4, 1)  # what is done once
    history = film_of(job, args.samples, args.first_seed, adaptive=args.adaptive).history
    last = history[-1]
    known = [step for step in history if step.seconds <= last.seconds / 4]
    told = Forecast(known)
    samples, seconds = told.samples_to(last.error), told.seconds_to(last.error)
    print(
        f"| {name} | {last.error:.2%} | {known[-1].samples:.0f} | {samples:.0f} | {samples / last.samples:.2f} | "
        f"{seconds:.1f} s | {last.seconds:.1f} s | {seconds / last.seconds:.2f} |",
        flush=True,
    )


def cost(name, job):
    """Share of the run time that the estimate takes: the marks, the errors, and the picture of where the error is."""
    film_of(job, 4, 1)  # what is done once
    for samples in (16, 128):
        clock = Clock()
        with pytest.MonkeyPatch.context() as patch:
            for method in ("_mark", "error"):
                patch.setattr(Film, method, clock.timing(getattr(Film, method)))
            start = time.perf_counter()
            film = film_of(job, samples, 1)
            clock.timing(error_picture)(film)
            seconds = time.perf_counter() - start
        print(f"| {name} | {samples} | {seconds:.2f} s | {clock.seconds / seconds:.2%} |", flush=True)


class Clock:
    """Seconds of wall time in calls; those of workers count by their share of the processors."""

    def __init__(self):
        self.seconds = 0.0

    def timing(self, call):
        """The same call, timed."""

        def timed(*args):
            start = time.perf_counter()
            result = call(*args)
            share = 1 if threading.current_thread() is threading.main_thread() else os.cpu_count()
            self.seconds += (time.perf_counter() - start) / share
            return result

        return timed


if __name__ == "__main__":
    main()
