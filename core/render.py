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

import numpy as np

from .film import Film
from .methods import METHODS
from .methods.wavefront import Chunk, Worker

_POLL = 0.05  # seconds between two looks at `cancelled`
_LONGEST_PASS = 64  # samples; more would make the picture, and a cancel, wait


def render(compiled, settings, on_pass=None, cancelled=None):
    """Render a compiled scene.

    Parameters
    ----------
    compiled : CompiledScene
    settings : Settings
    on_pass : callable, optional
        ``on_pass(film, progress)`` after every pass, on the calling thread; progress is in [0, 1].
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
        self._compiled, self._settings = compiled, settings
        self._method = METHODS[settings.method](compiled, settings)
        x0, y0, x1, y1 = settings.region
        self._film = Film(x1 - x0, y1 - y0, settings.transparent_film)
        self._tiles = _tiles(settings.region, settings.width, settings.tile)
        self._workers = [Worker() for _ in range(settings.threads or os.cpu_count() or 1)]
        self._idle = SimpleQueue()
        for worker in self._workers:
            self._idle.put(worker)
        self._stop = False
        self._start = time.perf_counter()

    def run(self, on_pass, cancelled):
        film, settings = self._film, self._settings
        stopped = "samples"
        with ThreadPoolExecutor(len(self._workers)) as pool:
            try:
                for first, count in passes(settings.samples):
                    if not self._pass(pool, first, count, cancelled):
                        stopped = "cancelled"
                        break
                    film.samples = first + count
                    self._write_stats()
                    on_pass(film, self._progress())
                    stopped = self._reached()
                    if stopped:
                        break
                stopped = stopped or "samples"
            finally:
                self._stop = True
        self._write_stats()
        film.stats["stopped"] = stopped
        return film

    def _pass(self, pool, first, count, cancelled):
        """Add samples to all tiles; False when cancelled."""
        waiting = {pool.submit(self._tile, *tile, first, count) for tile in self._tiles}
        try:
            while waiting:
                done, waiting = wait(waiting, timeout=_POLL, return_when=FIRST_COMPLETED)
                for future in done:
                    future.result()
                if waiting and cancelled():
                    return False
        finally:
            if waiting:
                self._stop = True
                for future in waiting:
                    future.cancel()
                wait(waiting)
        return not self._stop

    def _tile(self, pixels, places, first, count):
        """Trace a tile's samples, chunk by chunk, into the film."""
        settings = self._settings
        if settings.adaptive and settings.noise_target > 0:
            noisy = self._film.noisy(places, settings.noise_target)
            pixels, places = pixels[noisy], places[noisy]
            if pixels.size == 0:
                return
        at_once = max(1, settings.chunk // pixels.size)
        worker = self._idle.get()
        try:
            for start in range(first, first + count, at_once):
                if self._stop:
                    return
                samples = tuple(range(start, min(start + at_once, first + count)))
                for part in np.array_split(np.arange(pixels.size), -(-pixels.size // settings.chunk)):
                    radiance = self._method.trace(Chunk(pixels[part], samples), worker)
                    worker.nonfinite += self._film.add(places[part], radiance, samples)
        finally:
            self._idle.put(worker)

    def _reached(self):
        """Which stopping rule is met, or None."""
        settings, film = self._settings, self._film
        if settings.time_limit and time.perf_counter() - self._start >= settings.time_limit:
            return "time"
        if settings.noise_target and film.error() <= settings.noise_target:
            return "noise"
        return None

    def _progress(self):
        done = self._film.samples / self._settings.samples
        if self._settings.time_limit:
            done = max(done, (time.perf_counter() - self._start) / self._settings.time_limit)
        return min(done, 1.0)

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
    """Yield (first sample, count) of each pass: 1, 1, 2, 4, ... up to a limit."""
    first, count = 0, 1
    while first < samples:
        count = min(count, samples - first)
        yield first, count
        first += count
        count = min(first, _LONGEST_PASS)


def _tiles(region, width, side):
    """[(pixel numbers in the frame, places in the film)] of square tiles, from the middle of the region outwards."""
    x0, y0, x1, y1 = region
    tiles = []
    for top in range(y0, y1, side):
        for left in range(x0, x1, side):
            x = np.arange(left, min(left + side, x1), dtype=np.int32)
            y = np.arange(top, min(top + side, y1), dtype=np.int32)[:, None]
            far = abs(left + side / 2 - (x0 + x1) / 2) + abs(top + side / 2 - (y0 + y1) / 2)
            tiles.append((far, (y * np.int32(width) + x).ravel(), ((y - y0) * (x1 - x0) + (x - x0)).ravel()))
    tiles.sort(key=lambda tile: tile[0])
    return [(pixels, places) for _, pixels, places in tiles]
