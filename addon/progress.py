# SPDX-License-Identifier: GPL-3.0-or-later
"""What is said of a film in words, in Blender's header and on the command line."""

from __future__ import annotations

import math

from ..core.report.forecast import Forecast

_GOALS = tuple(step * 10.0**power for power in range(1, -5, -1) for step in (5, 2, 1))
_TARGETS = 0.10, 0.05, 0.02, 0.01
_APART = 1.4  # times the samples of the step before
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
        return f"{percent(goal)} in {duration(forecast.seconds_to(goal) - now)}"
    last = forecast.error_at(end)
    return f"about {percent(last)} at the end" if last < _WORTH_SAYING * error else ""


def ends_text(settings):
    """What ends a render."""
    ends = [f"at {settings.samples} samples"]
    if settings.noise_target:
        ends.insert(0, f"below {percent(settings.noise_target)}")
    if settings.time_limit:
        ends.append(f"after {settings.time_limit:g} s")
    return "Ends " + " or ".join(ends)


def reaches(film):
    """When a film had, or will have, an error of 10, 5, 2 and 1%.

    Returns
    -------
    list of (error, seconds after the start, bool)
        True where it is foretold. Those are left out that were reached before any error was known.
    """
    forecast, found = Forecast(film.history), []
    known = [step for step in film.history if math.isfinite(step.error)]
    for target in _TARGETS if forecast.is_known else ():
        first = next((k for k, step in enumerate(known) if step.error <= target), None)
        if first is None:
            found.append((target, forecast.seconds_to(target), True))
        elif first:
            a, b = known[first - 1 : first + 1]
            share = math.log(a.error / target) / math.log(a.error / b.error) if b.error > 0 else 1.0
            found.append((target, a.seconds * (b.seconds / a.seconds) ** share, False))
    return found


def reaches_text(film):
    """The same, in words."""
    said = []
    for error, seconds, foretold in reaches(film):
        if not foretold:
            when = f"after {seconds:.3g} s"
        elif "stopped" in film.stats:
            when = f"would take {duration(seconds)}"
        else:
            when = f"in {duration(seconds - film.stats['seconds'])}"
        said.append(f"{percent(error)} {when}")
    return said


def thinned(history):
    """Some steps of a film's history, at growing distances, the last one always."""
    kept = []
    for step in reversed(history):
        if not kept or step.samples * _APART <= kept[-1].samples:
            kept.append(step)
    return kept[::-1]


def duration(seconds):
    """In one unit, rounded as a guess deserves."""
    seconds = max(seconds, 1.0)
    size, unit = (1, "s") if seconds < 90 else (60, "min") if seconds < 5400 else (3600, "h")
    return f"about {float(f'{seconds / size:.2g}'):g} {unit}"


def percent(share):
    """With two digits."""
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
    fields = {
        "method": settings.method,
        "samples": str(film.samples),
        "seconds": f"{film.stats.get('seconds', 0.0):.3f}",
        "estimated_error": error_text(film),
        "stopped": film.stats.get("stopped", ""),
        "error_over_time": "; ".join(_step_text(step) for step in thinned(film.history)),
        "seconds_to_error": "; ".join(
            f"{percent(error)} {seconds:.3g} s{' (foretold)' * foretold}" for error, seconds, foretold in reaches(film)
        ),
    }
    return {name: text for name, text in fields.items() if text}


def _step_text(step):
    error = f"{step.error:.2%}" if math.isfinite(step.error) else "unknown"
    return f"{step.samples:.0f} samples {step.seconds:.3g} s {error}"
