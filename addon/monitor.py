# SPDX-License-Identifier: GPL-3.0-or-later
"""How the error of renders fell: written by the render's thread, read by the window's and by reports.

What is written are whole new objects in place of old ones, so that a reader never sees half of one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..core.film import Step
from ..core.settings import Settings

KEPT = 2
"""Renders of a scene that are remembered: the latest and the one before."""

_MOST_PIXELS = 1 << 15  # of the picture of where the error is


@dataclass(frozen=True)
class Shot:
    """What is rendered.

    Parameters
    ----------
    scene : str
    frame : int
    table : Path, optional
        The file of the errors of an animation's frames.
    """

    scene: str
    frame: int = 0
    table: Path | None = None


@dataclass
class Record:
    """One render, with a film's names for what it knows of it.

    Attributes
    ----------
    shot : Shot
    place : str
        View layer and stereo view.
    settings : Settings
    history : tuple of core.film.Step
    samples : int
    stats : dict
        Of the film; with "stopped" when it is done.
    where : (H, W) float32, optional
        Relative error of each pixel, row 0 at the bottom; made smaller where the picture is large.
    messages : list of str
        What the user was told.
    """

    shot: Shot
    place: str = ""
    settings: Settings = field(default_factory=Settings)
    history: tuple[Step, ...] = ()
    samples: int = 0
    stats: dict = field(default_factory=dict)
    where: np.ndarray | None = None
    messages: list[str] = field(default_factory=list)

    @property
    def is_done(self):
        """Whether the render has ended."""
        return "stopped" in self.stats

    @property
    def rays(self):
        """Rays a second."""
        return sum(self.stats.get("rays", {}).values()) / max(self.stats.get("seconds", 0.0), 1e-9)


class Monitor:
    """The latest renders of each scene.

    Attributes
    ----------
    changes : int
        Grows with whatever is noted.
    """

    def __init__(self):
        self.changes = 0
        self._records = {}

    def begin(self, shot, place, settings):
        """Begin a render's `Record`."""
        known = self._records.get(shot.scene, ())
        self._records[shot.scene] = (Record(shot, place, settings), *known)[:KEPT]
        self.changes += 1

    def note(self, shot, film):
        """Take down how far the latest render of a scene is."""
        latest = self.latest(shot.scene)
        if latest is not None:  # else another file was loaded meanwhile
            latest.samples, latest.stats, latest.history = film.samples, dict(film.stats), tuple(film.history)
            self.changes += 1

    def end(self, shot, film, messages):
        """Take down the whole of it, and where the error is of what is no animation."""
        latest = self.latest(shot.scene)
        if latest is None:
            return
        if film is not None:
            self.note(shot, film)
        latest.messages = list(messages)
        latest.stats = {"stopped": "cancelled"} | latest.stats  # where the film was not asked to say so
        if film is not None and shot.table is None and latest.stats["stopped"] != "cancelled":
            latest.where = error_picture(film)
        self.changes += 1

    def latest(self, scene):
        """`Record` of the latest render of the scene of that name, or None."""
        return next(iter(self._records.get(scene, ())), None)

    def before(self, scene):
        """That of the render before, or None."""
        return next(iter(self._records.get(scene, ())[1:]), None)

    def forget(self):
        """Forget all."""
        self._records = {}
        self.changes += 1


def error_picture(film):
    """Relative error of a film's pixels, (H, W) float32, or None where nothing is known of it.

    Of a large picture, pixels at even distances.
    """
    if not film.history or not np.isfinite(film.history[-1].error):
        return None
    step = math.ceil(math.sqrt(film.height * film.width / _MOST_PIXELS))
    step = -(-step // film.error_step) * film.error_step
    return film.relative_pixel_error(step).astype(np.float32)


monitor = Monitor()
