# SPDX-License-Identifier: GPL-3.0-or-later
"""What is said of a film in words, in Blender's header and on the command line."""

from __future__ import annotations

import math


def error_text(film):
    """Estimated relative error in percent; one sample tells nothing about it."""
    error = film.error()
    return f"{error:.2%}" if math.isfinite(error) else "unknown"


def progress_line(film, settings):
    """Say how far a film is."""
    return f"Sample {film.samples}/{settings.samples}, estimated error {error_text(film)}"


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
