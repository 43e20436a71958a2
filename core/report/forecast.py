# SPDX-License-Identifier: GPL-3.0-or-later
"""What further seconds buy: a film's errors so far, carried on.

The error falls as N^-a. How a shows in a film's own history is uncertain: a few doublings, each from one picture, and a
trimmed error that stands still while fireflies still spread over new pixels. So a lies between 1/2, where samples end
that are many, and the median slope between the last steps (Theil and Sen), within limits. A steeper slope is the
balance of Sobol points, which lasts, and is believed more than a flatter one, the spreading of fireflies, which ends.
Seconds grow by what a sample took lately.

Source of the slope: Sen, "Estimates of the regression coefficient based on Kendall's tau", JASA 63, 1968.
"""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np

_LIMITS = 0.35, 0.75  # of the slope
_REACH = 16  # times fewer samples than the last step: older ones tell nothing of what comes
_APART = 1.5  # times the samples that two steps differ by, at least, to tell a slope
_TRUST = 0.8, 0.35  # in a steeper slope than 1/2, and in a flatter; chosen by measurement: docs/error.md
_SHARE = 0.25  # of the samples, at least, that tell how long one takes


class Forecast:
    """Error over samples and seconds of a film to come.

    Parameters
    ----------
    history : sequence of core.film.Step
        Those without an error tell the time only.

    Attributes
    ----------
    slope : float
        a.
    """

    def __init__(self, history):
        self._steps = list(history)
        self._known = [step for step in self._steps if math.isfinite(step.error) and step.error > 0]
        self.slope = _slope(self._known)

    @property
    def is_known(self):
        """Whether there is an error to carry on."""
        return bool(self._known)

    def samples_to(self, error):
        """Samples of a pixel at which the error is that low; NaN where nothing is known."""
        if not self.is_known:
            return math.nan
        last = self._known[-1]
        return last.samples * (last.error / error) ** (1 / self.slope)

    def error_of(self, samples):
        """Error after that many samples of a pixel; NaN where nothing is known."""
        if not self.is_known:
            return math.nan
        last = self._known[-1]
        return last.error * (last.samples / samples) ** self.slope

    def seconds_to(self, error):
        """Seconds after the start at which the error is that low; NaN where nothing is known."""
        return self.seconds_of(self.samples_to(error))

    def error_at(self, seconds):
        """Error that many seconds after the start; NaN where nothing is known."""
        last = self._steps[-1] if self._steps else None
        if last is None:
            return math.nan
        return self.error_of(max(1.0, last.samples + (seconds - last.seconds) / self.seconds_a_sample()))

    def seconds_of(self, samples):
        """Seconds after the start at which that many samples are done."""
        last = self._steps[-1] if self._steps else None
        return last.seconds + (samples - last.samples) * self.seconds_a_sample() if last else math.nan

    def seconds_a_sample(self):
        """Of a sample of every pixel: that of the last steps which together took a quarter of the samples."""
        last = self._steps[-1]
        before = [(s.samples, s.seconds) for s in self._steps[:-1] if s.samples <= (1 - _SHARE) * last.samples]
        samples, seconds = before[-1] if before else (0.0, 0.0)
        return max(last.seconds - seconds, 1e-9) / (last.samples - samples)


def _slope(steps):
    recent = [step for step in steps if step.samples * _REACH >= steps[-1].samples]
    slopes = [
        math.log(a.error / b.error) / math.log(b.samples / a.samples)
        for a, b in combinations(recent, 2)
        if b.samples >= _APART * a.samples
    ]
    if not slopes:
        return 0.5
    beyond = float(np.median(slopes)) - 0.5
    return min(max(0.5 + _TRUST[beyond < 0] * beyond, _LIMITS[0]), _LIMITS[1])
