# SPDX-License-Identifier: GPL-3.0-or-later
"""The error of one render over its time, as lines and texts that `raster` and `svg` draw.

Both axes are logarithmic: noise falls along a line of slope -1/2.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ...core.report.forecast import Forecast
from . import glyphs

_LEFT, _RIGHT, _TOP, _BOTTOM = 52, 12, 26, 24  # pixels around the axes
_GAP = 14  # pixels between two names
_APART = 50, 24  # pixels between two ticks, at least, on the average
_AHEAD = 30.0  # times the seconds so far that are looked ahead, at most
_PAD = 0.04  # of an axis, at both ends


class Line(NamedTuple):
    """A line through points (N, 2), in pixels from the upper left; one point is a dot. `role` chooses the colour."""

    points: np.ndarray
    role: str
    width: float = 1.0
    dashed: bool = False


class Text(NamedTuple):
    """A text on a line of its own, `anchor` "start", "middle" or "end" at x, its middle at y."""

    x: float
    y: float
    text: str
    role: str = "text"
    anchor: str = "start"


class Chart(NamedTuple):
    """What is drawn, in this order."""

    width: int
    height: int
    lines: list
    texts: list


def error_chart(record, before=None, width=640, height=360):
    """The curve of a render, its forecast, the line of slope -1/2, what it aims at, and the render before.

    Parameters
    ----------
    record : monitor.Record
    before : monitor.Record, optional
    width, height : int
        Pixels.

    Returns
    -------
    Chart or None
        None where no error is known yet.
    """
    points = _points(record)
    if not len(points):
        return None
    ahead = _forecast(record)
    target, limit = record.settings.noise_target, record.settings.time_limit
    seen = [points, ahead] if ahead is not None else [points]
    seen += [np.array([[points[-1, 0], target]])] if target else []
    axes = _Axes(np.concatenate(seen), width, height)
    lines, texts = axes.ticks()
    if before is not None and len(_points(before)):
        lines.append(axes.line(_points(before), "before"))
    span = np.array([points[0, 0], axes.seconds[1]])
    lines.append(axes.line(np.stack([span, points[0, 1] * (span / span[0]) ** -0.5], axis=1), "root"))
    if target:
        lines.append(axes.line(np.array([[x, target] for x in axes.seconds]), "target"))
    if limit and axes.seconds[0] < limit < axes.seconds[1]:
        lines.append(axes.line(np.array([[limit, y] for y in axes.errors]), "target"))
    if ahead is not None:
        lines.append(axes.line(ahead, "forecast", 2.0, dashed=True))
    lines.append(axes.line(points, "curve", 2.0))
    lines += [axes.line(point[None], "curve", 6.0) for point in points]
    return Chart(width, height, [line for line in lines if len(line.points)], texts + _legend(record, before, width))


def _points(record):
    """Seconds and errors, (N, 2)."""
    known = [(step.seconds, step.error) for step in record.history if step.seconds > 0 and step.error > 0]
    points = np.array(known, np.float64).reshape(-1, 2)
    return points[np.isfinite(points).all(axis=1)]


def _forecast(record):
    """What is to come until the render ends, (N, 2), or None."""
    forecast, settings = Forecast(record.history), record.settings
    if record.is_done or not forecast.is_known:
        return None
    last = record.history[-1]
    end = min(forecast.seconds_of(settings.samples), settings.time_limit or math.inf, _AHEAD * last.seconds)
    if settings.noise_target:
        end = min(end, forecast.seconds_to(settings.noise_target))
    if end <= last.seconds:
        return None
    seconds = np.geomspace(last.seconds, end, 24)
    return np.array([(s, forecast.error_at(s)) for s in seconds])


def _legend(record, before, width):
    names = [("error", "curve"), ("time^-1/2", "root")]
    names += [("forecast", "forecast")] if _forecast(record) is not None else []
    names += [("target", "target")] if record.settings.noise_target else []
    names += [("before", "before")] if before is not None and len(_points(before)) else []
    texts, x = [], _LEFT
    for name, role in names:
        if x + glyphs.width(name) <= width:
            texts.append(Text(x, _TOP / 2, name, role))
        x += glyphs.width(name) + _GAP
    return texts


class _Axes:
    """From seconds and errors to pixels.

    Attributes
    ----------
    seconds, errors : (low, high)
    """

    def __init__(self, points, width, height):
        low, high = np.log10(points.min(axis=0)), np.log10(points.max(axis=0))
        middle, half = (low + high) / 2, np.maximum((high - low) * (0.5 + _PAD), 0.15)
        self._low, self._high = middle - half, middle + half
        self.seconds, self.errors = (10 ** np.array([self._low[k], self._high[k]]) for k in (0, 1))
        self._ticks = (width - _LEFT - _RIGHT) // _APART[0], (height - _TOP - _BOTTOM) // _APART[1]
        self._most = width - 2 * _RIGHT  # of the middle of a text
        self._corner = np.array([_LEFT, height - _BOTTOM])
        self._size = np.array([width - _LEFT - _RIGHT, -(height - _TOP - _BOTTOM)])

    def line(self, points, role, width=1.0, dashed=False):
        """A `Line` through seconds and errors, as much of it as the axes hold."""
        logs = (np.log10(points) - self._low) / (self._high - self._low)
        return Line(self._corner + self._size * _clipped(logs), role, width, dashed)

    def ticks(self):
        """Lines of the grid, and the texts beside them."""
        lines, texts = [], []
        for second in _round_numbers(*self.seconds, self._ticks[0]):
            lines.append(self.line(np.array([[second, y] for y in self.errors]), "grid"))
            x, y = lines[-1].points[0]
            texts.append(Text(min(x, self._most), y + _BOTTOM / 2, f"{second:g} s", "faint", "middle"))
        for error in _round_numbers(*self.errors, self._ticks[1]):
            lines.append(self.line(np.array([[x, error] for x in self.seconds]), "grid"))
            x, y = lines[-1].points[0]
            texts.append(Text(x - 6, y, f"{100 * error:.10g}%", "faint", "end"))
        return lines, texts


def _clipped(points):
    """The part of a line (N, 2) within the unit square; the line is straight or goes along an axis."""
    inside = ((points >= -1e-9) & (points <= 1 + 1e-9)).all(axis=1)
    if inside.all() or len(points) < 2:
        return points if inside.all() else points[:0]
    kept = []
    for a, b in pairwise(points):
        way = b - a
        with np.errstate(divide="ignore", invalid="ignore"):
            at = np.sort(np.stack([-a / way, (1 - a) / way]), axis=0)
        outside = (way == 0) & ((a < 0) | (a > 1))
        enter, leave = (
            np.max(np.where(way == 0, 0, at[0]), initial=0.0),
            np.min(np.where(way == 0, 1, at[1]), initial=1.0),
        )
        if enter < leave and not outside.any():
            kept += [a + enter * way] if not kept else []
            kept.append(a + leave * way)
    return np.array(kept).reshape(-1, 2)


def _round_numbers(low, high, most):
    """1, 2 and 5 times powers of ten from `low` to `high`, fewer of them where they are more than `most`."""
    powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    for factors in ((1, 2, 5), (1, 3), (1,)):
        found = [factor * 10.0**power for power in powers for factor in factors]
        found = [number for number in found if low <= number <= high]
        if len(found) <= most:
            return found
    return found[:: -(-len(found) // most)]
