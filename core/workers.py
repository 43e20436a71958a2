# SPDX-License-Identifier: GPL-3.0-or-later
"""Who traces a picture's tasks: threads, which any system has. `core.processes` has the others."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from queue import SimpleQueue
from threading import Event
from typing import NamedTuple

from .methods.wavefront import Worker


class Counters(NamedTuple):
    """What a worker has done so far, and the memory it holds."""

    rays: dict
    embree_seconds: float
    nonfinite: int
    arena_bytes: int

    @classmethod
    def of(cls, worker):
        """Those of a `Worker`."""
        return cls(dict(worker.rays), worker.clock.seconds, worker.nonfinite, worker.nbytes)


class Threads:
    """Workers that share Python's global lock.

    Parameters
    ----------
    trace : callable
        ``trace(worker, *task)`` traces a task.
    count : int
    """

    def __init__(self, trace, count):
        self._trace = trace
        self._stop = Event()
        self._workers = [Worker(stop=self._stop) for _ in range(count)]
        self._idle = SimpleQueue()
        for worker in self._workers:
            self._idle.put(worker)
        self._pool = ThreadPoolExecutor(count)

    def submit(self, task):
        """Have a task traced; returns its `Future`."""
        return self._pool.submit(self._run, task)

    def finish(self, future):
        """Raise what went wrong in a task that is done."""
        future.result()

    def _run(self, task):
        worker = self._idle.get()
        try:
            self._trace(worker, *task)
        finally:
            self._idle.put(worker)

    def counters(self):
        """`Counters` of every worker."""
        return [Counters.of(worker) for worker in self._workers]

    def stop(self):
        """Have all give up what they trace."""
        self._stop.set()

    def close(self):
        """Stop, and wait until all have."""
        self.stop()
        self._pool.shutdown()
