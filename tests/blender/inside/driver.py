# SPDX-License-Identifier: GPL-3.0-or-later
"""Hands and eyes for scripts that use Blender's window.

Blender's timer calls a generator of steps whenever it has waited for what that yielded. Clicks and keys are real ones,
by xdotool; they reach Blender when the timer has returned.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
import traceback
from pathlib import Path

import bpy

FOLDER = Path(sys.argv[sys.argv.index("--") + 1])
LIMIT = 120.0  # seconds for one step; other programs may want the processor too
LOOK_EVERY = 0.05  # seconds
COUNTED_AFTER = 0.02  # seconds until the kernel has counted what was stolen of a virtual machine's time
TICKS = os.sysconf("SC_CLK_TCK")


def move(window, x, y):
    """Put the pointer on a point of the window, given in Blender's way: from the bottom left."""
    subprocess.run(["xdotool", "mousemove", str(round(x)), str(round(window.height - y))], check=True)


def click(window, x, y):
    """Click on a point of the window."""
    move(window, x, y)
    subprocess.run(["xdotool", "click", "1"], check=True)


def press(key):
    """Press a key, given by name or code."""
    subprocess.run(["xdotool", "key", key], check=True)


def shot(name):
    """Keep the screen as a picture; Blender's own operator for that gives a black one without a window manager."""
    subprocess.run(["import", "-window", "root", "-depth", "8", FOLDER / f"{name}.png"], check=True)


def stolen(before=None):
    """Seconds that the host took from each of a virtual machine's processors, or the most that it took since `before`.

    Linux counts them as the threads' own: now and then a loop that takes 1 ms is said to take 40 to 100.
    """
    with open("/proc/stat", encoding="ascii") as counts:
        of_each = [int(line.split()[8]) / TICKS for line in counts if line[:3] == "cpu" and line[3] != " "]
    return of_each if before is None else max(now - then for now, then in zip(of_each, before, strict=True))


class View:
    """The 3D viewport; looked up each time, as Blender's screen does not outlive a file."""

    @property
    def area(self):
        screen = bpy.context.window_manager.windows[0].screen
        return next(area for area in screen.areas if area.type == "VIEW_3D")

    @property
    def space(self):
        return self.area.spaces.active

    @property
    def region(self):
        return next(region for region in self.area.regions if region.type == "WINDOW")

    def override(self):
        window = bpy.context.window_manager.windows[0]
        return bpy.context.temp_override(window=window, area=self.area, region=self.region)

    def bare(self):
        """Nothing but the picture."""
        space = self.space
        space.overlay.show_overlays = space.show_gizmo = False
        space.show_region_header = space.show_region_tool_header = False
        space.show_region_toolbar = space.show_region_ui = False


class Viewports:
    """Zraka's viewports from now on: their workers, and how long Blender waits for their calls.

    Parameters
    ----------
    viewport : type
        `addon.viewport.viewport.Viewport`, whose methods are replaced.
    samples : int
        How many all of them are to show.
    log : dict
        Gets the seconds of wall clock and of the thread's processor time of each call, as lists "update" and "draw";
        what the host of a virtual machine took meanwhile does not count as the thread's.
    """

    def __init__(self, viewport, samples, log):
        self.workers = []
        self._samples = samples
        self._log = log
        made = viewport.__init__

        def note_made(viewport, engine):
            made(viewport, engine)
            self.workers.append(viewport._worker)

        viewport.__init__ = note_made
        viewport.update, viewport.draw = self.timed("update", viewport.update), self.timed("draw", viewport.draw)

    def timed(self, name, function):
        """A method that notes how long it took."""

        def noted(*args):
            lost, started, busy = stolen(), time.perf_counter(), time.thread_time()
            try:
                return function(*args)
            finally:
                wall, busy = time.perf_counter() - started, time.thread_time() - busy
                if busy > COUNTED_AFTER:
                    time.sleep(COUNTED_AFTER)
                    busy = max(busy - stolen(lost), 0.0)
                self._log[name].append((wall, busy))

        return noted

    @property
    def latest(self):
        """The worker of the newest viewport."""
        return self.workers[-1]

    def settled(self):
        """Whether the newest viewport shows its last sample."""
        assert "stopped" not in self.latest.text, self.latest.text
        return not self.latest.busy and self.latest.text.startswith(f"Sample {self._samples}/")

    def rest(self):
        """Wait until the newest viewport is ready, and drawn."""
        yield 0.5
        yield self.settled
        yield 0.5


class Driver:
    """Takes one step after another; a step yields seconds to wait, or a function that is true when the wait is over.

    The window is closed after the last step; `log` is then written to ``log.json``, with "stopped" where a step failed.
    """

    def __init__(self, steps, log):
        self._steps = steps
        self._log = log
        self._condition = None
        self._waited = self._looked = 0.0

    def start(self):
        """Begin when the window stands."""
        bpy.app.timers.register(self._take, first_interval=1.0, persistent=True)

    def _take(self):
        try:
            if self._condition is not None and not self._condition():
                now = time.perf_counter()
                self._waited += min(now - self._looked, 1.0)  # the whole program may have been stopped meanwhile
                self._looked = now
                if self._waited > LIMIT:
                    raise TimeoutError(f"waited {LIMIT:.0f} s in vain in line {self._steps.gi_frame.f_lineno}")
                return LOOK_EVERY
            wait = next(self._steps)
        except StopIteration:
            self._end()
            return None
        except BaseException:
            self._log["stopped"] = traceback.format_exc()
            self._end()
            raise
        self._condition = wait if callable(wait) else None
        self._waited, self._looked = 0.0, time.perf_counter()
        return LOOK_EVERY if callable(wait) else wait

    def _end(self):
        (FOLDER / "log.json").write_text(json.dumps(self._log), encoding="utf-8")
        bpy.ops.wm.quit_blender()
