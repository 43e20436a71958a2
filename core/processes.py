# SPDX-License-Identifier: GPL-3.0-or-later
"""Who traces a picture's tasks where a system can fork: processes, none of which waits for another's Python.

A thread that comes back from numpy waits for Python's global lock; a fork has one of its own. It sees the compiled
scene and Embree's tree as they are, without a copy, and adds to a film in shared memory. It runs nothing but `trace`
and ends without touching what it has inherited, Blender's windows among it.
"""

from __future__ import annotations

import ctypes
import gc
import multiprocessing
import os
import signal
import warnings
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool

from .diagnostics import SceneError
from .methods.wavefront import Worker
from .workers import Counters

_PARENT_DEATH_SIGNAL = 1  # PR_SET_PDEATHSIG of Linux' prctl(2)
_MMAP_THRESHOLD, _TRIM_THRESHOLD = -3, -1  # glibc's M_MMAP_THRESHOLD and M_TRIM_THRESHOLD of mallopt(3)
_KEPT_BYTES = 1 << 25

_own = None  # of a forked process: what traces its tasks, and its worker


def shared_lock():
    """A lock that holds among processes."""
    return multiprocessing.get_context("fork").Lock()


class Processes:
    """Forked workers, which begin when this is made; the interface is that of `core.workers.Threads`.

    Parameters
    ----------
    trace : callable
        ``trace(worker, *task)`` traces a task.
        It may take no lock that another thread may hold, but a `shared_lock`.
    count : int

    Raises
    ------
    OSError
        If the system has no memory or no right for another process.
    """

    def __init__(self, trace, count):
        context = multiprocessing.get_context("fork")
        self._stop = context.Event()
        self._counters = {}
        self._pool = ProcessPoolExecutor(count, context, _begin, (trace, self._stop))
        before = set(multiprocessing.active_children())
        try:
            with warnings.catch_warnings():
                # Python 3.12 warns of threads whose locks a fork would find taken: `trace` takes none of theirs.
                warnings.simplefilter("ignore", DeprecationWarning)
                self._pool.submit(os.getpid).result()
        except OSError:  # of some of them; the pool forgets the others, which would wait for ever
            for child in set(multiprocessing.active_children()) - before:
                child.kill()
                child.join()
            raise

    def submit(self, task):
        """Have a task traced; returns its `Future`."""
        return self._pool.submit(_run, task)

    def finish(self, future):
        """Raise what went wrong in a task that is done."""
        try:
            process, counters = future.result()
        except BrokenProcessPool as error:
            raise SceneError(
                "a process that traced the picture was ended from outside, most often because memory ran out; "
                "close other programs, or switch off Separate Processes in the add-on's preferences"
            ) from error
        self._counters[process] = counters

    def counters(self):
        """`Counters` of every worker that has done something."""
        return list(self._counters.values())

    def stop(self):
        """Have all give up what they trace."""
        self._stop.set()

    def close(self):
        """Stop, and wait until all have ended."""
        self.stop()
        self._pool.shutdown(cancel_futures=True)


def _begin(trace, stop):
    """What a forked process does first."""
    global _own
    _own = trace, Worker(stop=stop)
    gc.freeze()  # what is inherited is not looked through, and so not copied
    _keep_memory()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides
    # A parent that is killed takes its workers with it.
    ctypes.CDLL(None).prctl(_PARENT_DEATH_SIGNAL, signal.SIGKILL)


def _keep_memory():
    """Have malloc keep what is freed: each of Embree's answers would come in new pages, at 0.5 µs a page."""
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)  # the C libraries of some systems have none
    if mallopt is not None:
        for parameter in (_MMAP_THRESHOLD, _TRIM_THRESHOLD):
            mallopt(parameter, _KEPT_BYTES)


def _run(task):
    trace, worker = _own
    trace(worker, *task)
    return os.getpid(), Counters.of(worker)
