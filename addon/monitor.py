# SPDX-License-Identifier: GPL-3.0-or-later
"""How the error of the latest render fell, for a panel; written by the render's thread, read by the window's."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass
class Monitor:
    """The latest render.

    Attributes
    ----------
    method : str
        "" before the first render.
    points : list of (samples, seconds, error)
        Ascending; the error is relative, infinite after a single sample.
    rays : float
        A second.
    """

    method: str = ""
    points: list[tuple[int, float, float]] = field(default_factory=list)
    rays: float = 0.0

    def begin(self, settings):
        """Forget the render before."""
        self.method, self.points, self.rays = settings.method, [], 0.0

    def note(self, film):
        """Take down how far a film is, if it has more samples of every pixel than before."""
        seconds = film.stats.get("seconds", 0.0)
        if not self.points or film.samples > self.points[-1][0]:
            # Another list: a reader keeps a whole one.
            self.points = [*self.points, (film.samples, seconds, film.error())]
        self.rays = sum(film.stats.get("rays", {}).values()) / max(seconds, 1e-9)


monitor = Monitor()
