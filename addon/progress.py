# SPDX-License-Identifier: GPL-3.0-or-later
"""What is said of a film in words, in Blender's header and on the command line."""

from __future__ import annotations

import math

from ..core.report.forecast import Forecast

_GOALS = tuple(step * 10.0**power for power in range(1, -5, -1) for step in (5, 2, 1))
_WORTH_SAYING = 0.75  # of the error so far; a last error that is hardly less is not


def error_text(film):
    """Estimated relative error in percent; one sample tells nothing about it."""
    error = film.stats.get("error", math.inf)
    return f"{error:.2%}" if math.isfinite(error) else "unknown"


def progress_line(film, settings):
    """Say how far a film is, how large its error, and what is to come."""
    parts = [f"Sample {film.samples}/{settings.samples}", f"error {error_text(film)}", forecast_text(film, settings)]
    return ", ".join(part for part in parts if part)


def forecast_text(film, settings):
    """When the next round error will be reached, or the error at the end where that comes first; "" if unknown."""
    forecast = Forecast(film.history)
    if not forecast.is_known:
        return ""
    error, now = film.history[-1].error, film.stats["seconds"]
    end = forecast.seconds_of(settings.samples)
    if settings.time_limit:
        end = min(end, settings.time_limit)
    goal = settings.noise_target or next((goal for goal in _GOALS if goal <= _WORTH_SAYING * error), 0.0)
    if goal and forecast.seconds_to(goal) <= end:
        return f"{_percent(goal)} in {duration(forecast.seconds_to(goal) - now)}"
    last = forecast.error_at(end)
    return f"about {_percent(last)} at the end" if last < _WORTH_SAYING * error else ""


def duration(seconds):
    """In one unit, rounded as a guess deserves."""
    seconds = max(seconds, 1.0)
    size, unit = (1, "s") if seconds < 90 else (60, "min") if seconds < 5400 else (3600, "h")
    return f"about {float(f'{seconds / size:.2g}'):g} {unit}"


def _percent(share):
    return f"{100 * share:.2g}%"


def summary(film, settings):
    """Say what was done: method, samples, seconds, rays a second, estimated error."""
    seconds = film.stats["seconds"]
    rate = sum(film.stats["rays"].values()) / max(seconds, 1e-9) / 1e6
    return (
        f"{settings.method}: {film.samples} samples in {seconds:.2f} s, "
        f"{rate:.2f} M rays/s, estimated error {error_text(film)}"
    )


def stamp(film, settings):
    """What a picture's file tells of it, by field."""
    return {
        "method": settings.method,
        "samples": str(film.samples),
        "seconds": f"{film.stats.get('seconds', 0.0):.3f}",
        "estimated_error": error_text(film),
    }
