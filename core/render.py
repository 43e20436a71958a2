# SPDX-License-Identifier: GPL-3.0-or-later
"""Passes × tiles × threads: the loop that fills a film.

A pass adds samples to every pixel; passes grow, so that a picture stands after the first and only improves. Workers
take chunks (a tile and some sample numbers) until the pass is done. Sums are made in the order of the samples, so the
picture does not depend on threads, tiles or chunks.
"""

from __future__ import annotations

import os
import time
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from queue import SimpleQueue
from threading import Event

import numpy as np

from .film import Film
from .methods import METHODS
from .methods.wavefront import Chunk, Worker

_POLL = 0.05  # seconds between two looks at `cancelled`
_SHOW_EVERY = 0.5  # seconds between two calls of `on_pass` within a pass
_LEAST_SAMPLES = 16  # of every pixel before adaptive sampling leaves any out
_LONGEST_PASS = 64  # samples; more would make the picture, and a cancel, wait


def render(compiled, settings, on_pass=None, cancelled=None):
    """Render a compiled scene.

    Parameters
    ----------
    compiled : CompiledScene
    settings : Settings
    on_pass : callable, optional
        ``on_pass(film, progress)`` on the calling thread after every pass, and during long ones; progress is in [0, 1].
    cancelled : callable, optional
        Polled on the calling thread; True stops the render and keeps what is there.

    Returns
    -------
    Film
        With `stats`: seconds, rays, embree_seconds, nonfinite, threads, stopped ("samples", "time", "noise" or
        "cancelled").
    """
    return _Render(compiled, settings).run(on_pass or (lambda film, progress: None), cancelled or (lambda: False))


class _Render:
    def __init__(self, compiled, settings):
        self._settings = settings
        self._method = METHODS[settings.method](compiled, settings)
        x0, y0, x1, y1 = settings.region
        self._film = Film(x1 - x0, y1 - y0, settings.transparent_film)
        self._tiles = _tiles(settings.region, settings.width, settings.tile)
        self._stop = Event()
        self._workers = [Worker(stop=self._stop) for _ in range(settings.threads or os.cpu_count() or 1)]
        self._idle = SimpleQueue()
        for worker in self._workers:
            self._idle.put(worker)
        self._shown = self._start = time.perf_counter()

    def run(self, on_pass, cancelled):
        film, settings = self._film, self._settings
        stopped = None
        with ThreadPoolExecutor(len(self._workers)) as pool:
            try:
                for first, count in passes(settings.samples):
                    stopped = self._pass(pool, first, count, on_pass, cancelled)
                    if stopped:
                        break
                    film.samples = first + count
                    self._show(on_pass, film.samples)
                    stopped = self._reached()
                    if stopped:
                        break
            finally:
                self._stop.set()
        self._write_stats()
        film.stats["stopped"] = stopped or "samples"
        return film

    def _pass(self, pool, first, count, on_pass, cancelled):
        """Add samples to all tiles; says why it stopped early, or None."""
        waiting = {pool.submit(self._tile, *tile, first, count) for tile in self._noisy_tiles(first)}
        total = len(waiting)
        try:
            while waiting:
                done, waiting = wait(waiting, timeout=_POLL, return_when=FIRST_COMPLETED)
                for future in done:
                    future.result()
                if waiting and cancelled():
                    return "cancelled"
                if waiting and first and self._out_of_time():
                    return "time"
                if first and time.perf_counter() - self._shown > _SHOW_EVERY:
                    self._show(on_pass, first + count * (1 - len(waiting) / total))
        finally:
            if waiting:
                self._stop.set()
                for future in waiting:
                    future.cancel()
                wait(waiting)
        return None

    def _noisy_tiles(self, first):
        """The tiles, less the pixels that need no further samples."""
        settings = self._settings
        if not (settings.adaptive and settings.noise_target > 0 and first >= _LEAST_SAMPLES):
            return self._tiles
        noisy = self._film.noisy(settings.noise_target)
        kept = [(pixels[noisy[places]], places[noisy[places]]) for pixels, places in self._tiles]
        return [tile for tile in kept if tile[0].size]

    def _show(self, on_pass, samples):
        self._write_stats()
        done = samples / self._settings.samples
        if self._settings.time_limit:
            done = max(done, (time.perf_counter() - self._start) / self._settings.time_limit)
        on_pass(self._film, min(done, 1.0))
        self._shown = time.perf_counter()

    def _tile(self, pixels, places, first, count):
        """Trace a tile's samples, chunk by chunk, into the film."""
        settings = self._settings
        at_once = max(1, settings.chunk // pixels.size)
        worker = self._idle.get()
        try:
            for start in range(first, first + count, at_once):
                samples = tuple(range(start, min(start + at_once, first + count)))
                for part in np.array_split(np.arange(pixels.size), -(-pixels.size // settings.chunk)):
                    radiance = self._method.trace(Chunk(pixels[part], samples), worker)
                    if radiance is None:
                        return
                    worker.nonfinite += self._film.add(places[part], radiance, samples)
        finally:
            self._idle.put(worker)

    def _reached(self):
        """Which stopping rule is met, or None."""
        settings, film = self._settings, self._film
        if self._out_of_time():
            return "time"
        if settings.noise_target and film.error() <= settings.noise_target:
            return "noise"
        return None

    def _out_of_time(self):
        limit = self._settings.time_limit
        return bool(limit) and time.perf_counter() - self._start >= limit

    def _write_stats(self):
        workers = self._workers
        self._film.nonfinite = sum(w.nonfinite for w in workers)
        self._film.stats.update(
            seconds=time.perf_counter() - self._start,
            rays={kind: sum(w.rays[kind] for w in workers) for kind in workers[0].rays},
            embree_seconds=sum(w.clock.seconds for w in workers) / len(workers),
            nonfinite=self._film.nonfinite,
            threads=len(workers),
            arena_bytes=sum(w.nbytes for w in workers),
        )


def passes(samples):
    """Yield (first sample, count) of each pass: up to 1, 4, 16, 64 samples, then by a limit.

    Powers of four leave the Sobol points of every pass balanced, and few passes have chunks too small to be worth it.
    """
    first, count = 0, 1
    while first < samples:
        count = min(count, samples - first)
        yield first, count
        first += count
        count = min(3 * first, _LONGEST_PASS)


def _tiles(region, width, side):
    """[(pixel numbers in the frame, places in the film)] of tiles of equal size, from the region's middle outwards."""
    x0, y0, x1, y1 = region
    tiles = []
    for y in np.array_split(np.arange(y0, y1, dtype=np.int32)[:, None], -(-(y1 - y0) // side)):
        for x in np.array_split(np.arange(x0, x1, dtype=np.int32), -(-(x1 - x0) // side)):
            far = abs(x.mean() - (x0 + x1) / 2) + abs(y.mean() - (y0 + y1) / 2)
            tiles.append((far, (y * np.int32(width) + x).ravel(), ((y - y0) * (x1 - x0) + (x - x0)).ravel()))
    tiles.sort(key=lambda tile: tile[0])
    return [(pixels, places) for _, pixels, places in tiles]
