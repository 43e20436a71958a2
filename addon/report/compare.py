# SPDX-License-Identifier: GPL-3.0-or-later
"""The methods beside each other: a contact sheet with times and errors."""

from __future__ import annotations

from .. import headless, machine
from . import display, text
from .measure import NAMES, measure
from .sheet import contact_sheet

_WIDTH = 640  # of a picture, at most


def compare(path, target, plan, interrupted=lambda: False, say=lambda text: None):
    """Render a scene by each method and write a contact sheet.

    Parameters
    ----------
    path : Path
        A .blend file.
    target : Path
        A .png, or a folder in which ``compare.png`` is made.
    plan : measure.Plan
        With `rungs` of one number.
    interrupted, say : callable
        As of `measure.measure`.

    Returns
    -------
    measure.Measured
        Nothing is written where it was interrupted.

    Raises
    ------
    SceneError
    """
    if target.suffix.lower() != ".png":
        machine.make_folder(target)
        target /= "compare.png"
    headless.load_blender()
    scene, measured = measure(path, plan, interrupted, say)
    if not measured.interrupted:
        display.write(display.as_uint8(draw(scene, measured)), target)
    return measured


def draw(scene, measured):
    """The contact sheet of a measurement, (H, W, 4) float32: each method's picture, and the reference."""
    pictures = [
        (NAMES[method], text.rung_text(measured.rungs[method][-1]), p) for method, p in measured.pictures.items()
    ]
    truth = measured.references["zraka"].mean(axis=0)
    pictures.append(("Reference", f"path tracing, {measured.reference_samples} samples", truth))
    width, height = measured.size
    return contact_sheet(
        [display.shrunk(display.shown(scene, picture), _WIDTH) for *_, picture in pictures],
        [f"{name}\n{said}" for name, said, _ in pictures],
        title=f"{measured.name}, {width} × {height}",
    )


def lines(measured):
    """What is printed: a line a method."""
    return "\n".join(f"{NAMES[name]}: {text.rung_text(rungs[-1])}" for name, rungs in measured.rungs.items())
