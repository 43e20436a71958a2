# SPDX-License-Identifier: GPL-3.0-or-later
"""Passes × tasks × workers: the loop that fills a film.

A pass adds samples to every pixel, or to those that need them most; passes grow, so that a picture stands after the
first and only improves. Workers take tasks (some pixels and some sample numbers) until the pass is done. Sums are made
in the order of the samples, so the picture does not depend on workers, tiles or chunks.
"""

from __future__ import annotations

import os
import time
from concurrent.futures import FIRST_COMPLETED, wait

import numpy as np

from . import adaptive
from .compile.memory import check_picture
from .film import Film, Step
from .methods import method_of
from .methods.wavefront import RAY_KINDS, Chunk
from .report.forecast import Forecast
from .settings import can_fork
from .shutter import Shutter
from .tile_order import TileOrder, ranges
from .workers import Threads

_POLL = 0.02  # seconds between two looks at `cancelled`
_SHOW_EVERY = 0.5  # seconds between two calls of `on_pass` within a pass
_FEWEST_LANES = 8192  # of a task; fewer are not worth the calls
_MANY_TASKS = 4  # of a worker in a pass; among so many, the last may be small
_FIRST_LANES = 1 << 18  # of the first pass, at most, where somebody waits for it
_MOST_SAMPLES = 256  # of a chunk: their numbers in it are bytes
_LONG_LANES = 1 << 22  # of a pass that is worth an end of its own: four seconds, about
_JUDGED_LANES = 1 << 20  # the same where an end may be the last: a second
_LEAST_STEP = 4  # samples between such ends but powers of two: so many are traced together
_LONGEST_PASS = 64  # samples; more would make the picture, and a cancel, wait
_FIRST_JUDGED = 4  # samples of the first pass, at most, where an error is to be met: fewer tell little of it
# Of a render, for forks: they begin after some hundredths of a second.
_LANES_WORTH_FORKS, _LANES_A_TRIANGLE, _SECONDS_WORTH_FORKS = 1 << 18, 4, 1.0
_MOST = 1 << 30  # samples; more are as good as no goal
_SHARE_OF_WAY = 0.8  # of the doublings to a noise target, made in one pass: falling short costs a pass, not time


def render(compiled, settings, on_pass=None, cancelled=None, method=method_of):
    """Render a compiled scene.

    Parameters
    ----------
    compiled : CompiledScene or Shutter
    settings : Settings
    on_pass : callable, optional
        ``on_pass(film, progress)`` on the calling thread after every pass, while the next is traced, and during long
        ones; progress is in [0, 1].
    cancelled : callable, optional
        Polled on the calling thread; True stops the render and keeps what is there.
    method : callable, optional
        ``method(compiled, settings)`` makes the `Wavefront`, by default the one that the settings name.

    Returns
    -------
    Film
        With `history`, a step for each pass, and `stats`: seconds, error, rays, embree_seconds, nonfinite, threads,
        stopped ("samples", "time", "noise" or "cancelled").
    """
    return _Render(compiled, settings, method).run(
        on_pass or (lambda film, progress: None), cancelled or (lambda: False)
    )


class _Render:
    def __init__(self, compiled, settings, method):
        self._settings = settings
        self._shutter = compiled if isinstance(compiled, Shutter) else None
        moments = self._shutter.moments if self._shutter else (compiled,)
        self._methods = [method(moment, settings) for moment in moments]
        x0, y0, x1, y1 = settings.region
        check_picture(x1 - x0, y1 - y0)
        self._order = TileOrder(settings.region, settings.width, settings.tile)
        any_of = self._methods[0]
        composed = any_of.behind, any_of.compose
        self._chunk = settings.chunk or any_of.chunk
        self._waves = any_of.waves
        self._adaptive = settings.adaptive and settings.samples > adaptive.LEAST_SAMPLES
        told = settings.pixel_errors or self._adaptive
        self._count = settings.threads or os.cpu_count() or 1
        forks = settings.processes and can_fork() and self._count > 1 and self._is_worth_forks()
        self._film = Film(
            *(x1 - x0, y1 - y0, settings.transparent_film, self._order, any_of.extra),
            *composed,
            pixel_errors=told,
            most=None if self._adaptive else settings.samples,
            shared=forks,
        )
        self._shown = self._start = time.perf_counter()
        self._workers = self._forks() if forks else Threads(self._trace, self._count)

    def run(self, on_pass, cancelled):
        film, settings = self._film, self._settings
        stopped = None
        try:
            for first, count in passes(settings.samples, self._order.size, self._longest, *self._lanes()):
                stopped = self._pass(first, count, on_pass, cancelled)
                if stopped:
                    break
                film.samples = first + count
                self._note(film.samples)
                stopped = self._reached()
                if stopped:
                    break
            if film.samples == first + count:  # not stopped within a pass
                self._show(on_pass, film.samples)
        finally:
            self._workers.close()
            film.unshare()
        if stopped in ("time", "cancelled") and film.counts().mean() > film.samples:
            self._note(float(film.counts().mean()))
        self._write_stats()
        film.stats["stopped"] = stopped or "samples"
        return film

    def _note(self, samples):
        """Add a step to the film's history."""
        seconds = time.perf_counter() - self._start
        self._film.history.append(Step(samples, seconds, self._film.error()))

    def _lanes(self):
        """Of the first pass, at most, and of one that is worth an end of its own.

        An end costs some hundredths of a second, which no worker traces, and fewer samples are traced together.
        """
        settings = self._settings
        if settings.noise_target or settings.time_limit or self._adaptive:
            return _FIRST_LANES, _JUDGED_LANES
        return _FIRST_LANES if settings.shown else _LONG_LANES, _LONG_LANES

    def _longest(self, first):
        """How many samples the pass after `first` may have at most, for the stopping rules not to be overrun."""
        settings, forecast = self._settings, Forecast(self._film.history)
        longest = _LONGEST_PASS
        if settings.noise_target and not first:
            longest = _FIRST_JUDGED
        if settings.noise_target and forecast.is_known:
            more = forecast.samples_to(settings.noise_target) / first
            longest = min(longest, step_towards(first, first * more**_SHARE_OF_WAY))
        if settings.time_limit and first:
            left = settings.time_limit - (time.perf_counter() - self._start)
            longest = min(longest, max(1, int(left / forecast.seconds_a_sample())))
        return longest

    def _is_worth_forks(self):
        """Whether the render takes so long that it does not matter how long forks take to begin.

        Of one sample it does: memory that is shared comes by small pages, and is then touched but once. And where
        there is much geometry: tables of its pages are copied, and Embree, which waits for nobody, takes most time.
        """
        settings = self._settings
        if settings.samples == 1:
            return False
        least = max(_LANES_WORTH_FORKS, _LANES_A_TRIANGLE * self._methods[0].scene.geometry.triangle_count)
        limit = settings.time_limit or _SECONDS_WORTH_FORKS
        return settings.samples * self._order.size >= least and limit >= _SECONDS_WORTH_FORKS

    def _forks(self):
        """`Processes`; `Threads` where the system refuses."""
        from .processes import Processes, shared_lock  # many renders never need them

        try:
            self._film.share(shared_lock())
            return Processes(self._trace, self._count)
        except (OSError, ImportError, NotImplementedError):  # the last two from systems without semaphores
            self._film.unshare()
            return Threads(self._trace, self._count)

    def _pass(self, first, count, on_pass, cancelled):
        """Add samples to the pixels; says why it stopped early, or None."""
        waiting = {self._workers.submit(task) for task in self._tasks(first, count)}
        total = len(waiting)
        try:
            if first:  # the pass before, while this one is traced
                self._show(on_pass, first)
            while waiting:
                done, waiting = wait(waiting, timeout=_POLL, return_when=FIRST_COMPLETED)
                for future in done:
                    self._workers.finish(future)
                if waiting and cancelled():
                    return "cancelled"
                if waiting and first and self._out_of_time():
                    return "time"
                if first and time.perf_counter() - self._shown > _SHOW_EVERY:
                    self._show(on_pass, first + count * (1 - len(waiting) / total))
        finally:
            if waiting:
                self._workers.stop()
                for future in waiting:
                    future.cancel()
                for future in wait(waiting).done:
                    if not future.cancelled() and future.exception() is None:
                        self._workers.finish(future)
        return None

    def _tasks(self, first, count):
        """[(pixels, by their numbers in the order of tracing, first sample, count)] of a pass."""
        if not (self._adaptive and first >= adaptive.LEAST_SAMPLES):
            parts = self._parts(self._order.size, count)
            return [(slice(start, stop), first, count) for start, stop in parts]
        film = self._film
        counts = film.counts()
        goal = adaptive.targets(counts, adaptive.importance(film), first + count)
        places = self._order[:]
        have, want = counts[places], goal[places]
        tasks = []
        for start, stop in sorted(set(zip(have.tolist(), want.tolist(), strict=True))):
            if stop > start:
                group = np.flatnonzero((have == start) & (want == stop))
                tasks += [(group[a:b], start, stop - start) for a, b in self._parts(group.size, stop - start)]
        return tasks

    def _parts(self, pixels, count):
        """Ranges of `pixels` whose `count` samples make tasks of equal size."""
        workers, lanes = self._count, pixels * count
        together = self._chunk * min(count, self._waves * len(self._methods))  # each moment's samples fill a chunk
        number = max(-(-lanes // together), min(workers, lanes // _FEWEST_LANES), 1)
        parts = ranges(pixels, -(-number // workers) * workers)
        if number < _MANY_TASKS * workers:
            return parts
        # Whoever is done first waits for half a task at most.
        halves = [(a + edge, a + end) for a, b in parts[-workers:] for edge, end in ranges(b - a, 2)]
        return parts[:-workers] + halves

    def _show(self, on_pass, samples):
        self._write_stats()
        done = samples / self._settings.samples
        if self._settings.time_limit:
            done = max(done, (time.perf_counter() - self._start) / self._settings.time_limit)
        on_pass(self._film, min(done, 1.0))
        self._shown = time.perf_counter()

    def _trace(self, worker, where, first, count):
        """Trace samples of the pixels `where`, chunk by chunk, into the film."""
        pixels = self._order.pixels(where)
        for method, samples in self._batches(first, count, pixels.size):
            for a, b in ranges(pixels.size, -(-pixels.size // self._chunk)):
                radiance = method.radiance(Chunk(pixels[a:b], samples), worker)
                if radiance is None:
                    return
                if self._settings.exposure != 1:
                    radiance[:3] *= self._settings.exposure
                part = slice(where.start + a, where.start + b) if isinstance(where, slice) else where[a:b]
                worker.nonfinite += self._film.add(part, radiance, samples)

    def _batches(self, first, count, pixels):
        """Yield (method, sample numbers) of chunks, moment after moment where the shutter is open for a time."""
        at_once = max(1, min(self._waves * self._chunk // pixels, _MOST_SAMPLES))
        if self._shutter:
            # The film marks powers of two, before which all samples of lower numbers must have been added.
            shares = [share for doubling in _doublings(first, count) for share in self._shutter.share(doubling)]
        else:
            shares = [(0, range(first, first + count))]
        for moment, numbers in shares:
            for start in range(0, len(numbers), at_once):
                yield self._methods[moment], tuple(numbers[start : start + at_once])

    def _reached(self):
        """Which stopping rule is met, or None."""
        settings, film = self._settings, self._film
        if self._out_of_time():
            return "time"
        if settings.noise_target and film.history[-1].error <= settings.noise_target:
            return "noise"
        return None

    def _out_of_time(self):
        limit = self._settings.time_limit
        return bool(limit) and time.perf_counter() - self._start >= limit

    def _write_stats(self):
        done = self._workers.counters()
        self._film.nonfinite = sum(c.nonfinite for c in done)
        self._film.stats.update(
            seconds=time.perf_counter() - self._start,
            error=self._film.history[-1].error if self._film.history else float("inf"),
            rays={kind: sum(c.rays[kind] for c in done) for kind in RAY_KINDS},
            embree_seconds=sum(c.embree_seconds for c in done) / self._count,
            nonfinite=self._film.nonfinite,
            threads=self._count,
            arena_bytes=sum(c.arena_bytes for c in done),
        )


def passes(samples, pixels, longest=lambda first: _LONGEST_PASS, first_lanes=_FIRST_LANES, long_lanes=_LONG_LANES):
    """Yield (first sample, count) of each pass: up to 1, 4, 16, 64 samples, then by a limit.

    Powers of four leave the Sobol points of every pass balanced. The first pass has as many as make `first_lanes` or
    less. Where the way to the next is long, passes of `long_lanes` or more end at powers of two, halfway between or at
    quarters, so that the error is known as of late. ``longest(first)`` is asked before each pass.
    """
    first, count = 0, 1
    while 4 * count * pixels <= first_lanes and count < adaptive.LEAST_SAMPLES:
        count *= 4
    while first < samples:
        count = min(count, longest(first), samples - first)
        yield first, count
        first += count
        power = 1 << first.bit_length() - 1
        steps = *(step for step in (power // 4, power // 2) if step >= _LEAST_STEP), power
        counts = (step - first % step for step in steps)
        count = next((count for count in counts if count * pixels >= long_lanes), 4 * power - first)


def _doublings(first, count):
    """Ranges that make up `count` numbers from `first` on, cut at powers of two."""
    while count:
        part = min(count, (1 << first.bit_length()) - first)
        yield range(first, first + part)
        first, count = first + part, count - part


def step_towards(first, goal):
    """Samples from `first` to the last number before the goal of 4, 5, 6 or 7 times a power of two, or below 8.

    Or to the next after `first`. Between them Sobol points are out of balance; an error that falls by their root meets
    a target within 6% to 12%.
    """
    goal = int(min(max(goal, first + 1), _MOST))
    grain = max(1, (1 << goal.bit_length() - 1) // 4)
    return max(goal // grain * grain, (first // grain + 1) * grain) - first
