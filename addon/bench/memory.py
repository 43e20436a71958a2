# SPDX-License-Identifier: GPL-3.0-or-later
"""Peak memory of one render, in a process of its own: a process' peak never falls."""

from __future__ import annotations

import importlib
import json
import subprocess
import sys
from contextlib import suppress
from multiprocessing import active_children
from pathlib import Path
from threading import Event, Thread

SAMPLES = 8
"""More take no more memory: the means at the last powers of two are all there."""

_LOOK_EVERY = 0.01  # seconds


def peak_memory(path, engine, percentage=100, threads=2, size=None):
    """Megabytes of a fresh process, its forks included, after one render, and how many of them the render added.

    Scene, acceleration structure and picture are in both; Python and Blender are in the first alone.

    Parameters
    ----------
    path : Path
        Of a .blend file.
    size : (width, height), optional
        In place of the scene's.

    Returns
    -------
    dict
        `peak_mb` and `render_mb`; None where the system does not tell.
    """
    nothing = {"peak_mb": None, "render_mb": None}
    order = json.dumps([str(path), engine, percentage, threads, size])
    command = [sys.executable, "-m", __name__, order]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=600, check=True)
        return json.loads(done.stdout.splitlines()[-1])
    except (OSError, subprocess.SubprocessError, ValueError, IndexError):
        return nothing


class _Peak:
    """The most memory, in MB, that this process and its forks have at once while the context is open.

    What they share counts once. It is asked often, not always, so this process' own mark, which never falls, counts
    too.
    """

    def __enter__(self):
        self._done, self._most = Event(), 0.0
        self._thread = Thread(target=self._watch)
        self._thread.start()
        return self

    def __exit__(self, *error):
        self._done.set()
        self._thread.join()

    @property
    def mb(self):
        """It, in MB."""
        return max(self._most, _peak_mb())

    def _watch(self):
        while not self._done.wait(_LOOK_EVERY):
            with suppress(OSError):  # one has just ended, or the system does not tell
                self._most = max(self._most, sum(_held_mb(p) for p in ("self", *(c.pid for c in active_children()))))


def _held_mb(process):
    lines = Path(f"/proc/{process}/smaps_rollup").read_text().splitlines()
    return sum(int(line.split()[1]) for line in lines if line.startswith("Pss:")) / 2**10


def _peak_mb():
    try:  # A child's `ru_maxrss` starts at its parent's on Linux.
        lines = Path("/proc/self/status").read_text().splitlines()
        return next(int(line.split()[1]) for line in lines if line.startswith("VmHWM")) / 2**10
    except (OSError, StopIteration):
        import resource

    unit = 2**20 if sys.platform == "darwin" else 2**10  # bytes there, kilobytes elsewhere
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit


def _main(order):
    from .engines import open_blend, picture, set_threads

    path, engine, percentage, threads, size = json.loads(order)
    importlib.import_module("OpenImageIO")  # with which the picture is read; neither engine needs it
    scene = open_blend(path, percentage)
    set_threads(scene, threads)
    if size:
        scene.render.resolution_x, scene.render.resolution_y = size
    before = _peak_mb()
    with _Peak() as most:
        picture(scene, engine, SAMPLES, seed=1)
    peak = most.mb
    sys.stdout.write(json.dumps({"peak_mb": peak, "render_mb": peak - before}) + "\n")


if __name__ == "__main__":
    _main(sys.argv[1])
