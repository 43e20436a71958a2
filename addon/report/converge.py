# SPDX-License-Identifier: GPL-3.0-or-later
"""A report of error against run time: a table of numbers, a plot, and a page that holds all."""

from __future__ import annotations

import datetime

import numpy as np

from ...core.diagnostics import SceneError
from ...core.report.error import weights
from ...core.report.plot import plot
from ...core.report.table import number, percent
from ...core.report.table import table as markdown
from .. import headless, machine
from . import display, page, text
from .measure import NAMES, REFERENCE_RUNS, RUNS, measure

PLOT = "error-vs-time"
_WIDTH = 480  # of embedded pictures, in pixels


def converge(path, plan, folder, interrupted=lambda: False, say=lambda text: None):
    """Measure a scene and write ``error-vs-time.csv``, ``.png``, ``.svg`` and ``report.html``.

    Parameters
    ----------
    path : Path
        A .blend file.
    plan : measure.Plan
    folder : Path
        Made if it is missing.
    interrupted, say : callable
        As of `measure.measure`.

    Returns
    -------
    measure.Measured

    Raises
    ------
    SceneError
    """
    machine.make_folder(folder)
    bpy = headless.load_blender()
    before = machine.machine()
    scene, measured = measure(path, plan, interrupted, say)
    try:
        text.write_csv(measured, folder / f"{PLOT}.csv")
        drawn = _draw(measured, folder, say)
        html = _page(bpy, scene, measured, before, folder / f"{PLOT}.svg" if drawn else None)
        (folder / "report.html").write_text(html, encoding="utf-8")
    except OSError as error:
        raise SceneError(f"{folder} cannot be written: {error.strerror or error}") from error
    return measured


def summary(measured):
    """What is printed: seconds to errors, and the findings."""
    head, rows = text.targets_table(measured)
    parts = [f"{measured.name}, {measured.size[0]} × {measured.size[1]}"]
    return "\n\n".join([*parts, *([markdown(head, rows)] if rows else []), "\n".join(text.findings(measured))]).rstrip()


def _draw(measured, folder, say):
    """Draw the plot; tell whether there is one."""
    lines = text.curves(measured)
    if not lines:
        return False
    title = f"{measured.name}: error over time"
    try:
        for kind in ("png", "svg"):
            plot(folder / f"{PLOT}.{kind}", lines, title, "seconds", "error: relative RMSE, %", own_range=False)
    except ImportError:
        say("no plot: matplotlib is missing; pip install 'zraka[bench]'")
        return False
    return True


# -- the page ----------------------------------------------------------------------------------------------------------


def _page(bpy, scene, measured, before, svg):
    parts = []
    if measured.interrupted:
        parts.append(page.paragraph("Interrupted: what follows is not whole."))
    parts += [page.plot(svg) if svg else page.paragraph("No plot was drawn; the numbers stand below.")]
    parts.append(page.items(text.findings(measured)))
    head, rows = text.targets_table(measured)
    if rows:
        note = "An asterisk marks what was extrapolated beyond the samples measured."
        parts += [page.heading("Seconds to an error"), page.table(head, rows), page.paragraph(note, "note")]
    if measured.references:
        parts += [page.heading("Pictures"), page.pictures(_pictures(scene, measured))]
    parts += [page.heading("All that was measured"), page.table(*text.rungs_table(measured))]
    parts += [page.paragraph(_method(measured), "note"), page.heading("Settings"), page.terms(_settings(measured))]
    parts += [page.heading("Machine"), page.terms(_machine(bpy, measured, before))]
    parts += [page.heading("What the scene did not need"), page.terms(_features(measured))]
    parts += [page.heading("Diagnostics"), page.items(measured.diagnostics) or page.paragraph("None.")]
    return page.page(f"{measured.name}: error against run time", *parts)


def _pictures(scene, measured):
    """The reference, and each method's last picture with where it errs."""
    truth = next(iter(measured.references.values())).mean(axis=0)
    shown = [(truth, f"Reference, {_reference_text(measured)}")]
    for method, picture in measured.pictures.items():
        shown.append((picture, f"{NAMES[method]}: {text.rung_text(measured.rungs[method][-1])}"))
    pictures = [(display.shrunk(display.shown(scene, picture), _WIDTH), caption) for picture, caption in shown]
    for method, picture in measured.pictures.items():
        heat = _heat(picture, measured.judge(method).mean(axis=0))
        pictures.append((display.shrunk(heat, _WIDTH), f"Where {NAMES[method]} errs: black 0, white 50% and more"))
    return pictures


def _heat(picture, truth, most=0.5):
    """Relative error of each pixel in black, red, yellow and white, (H, W, 3) uint8."""
    error = np.sqrt(((picture - truth) ** 2).sum(axis=-1) * weights(truth)) / most
    return display.as_uint8(np.stack([3 * error, 3 * error - 1, 3 * error - 2], axis=-1))


def _reference_text(measured):
    if measured.plan.reference:
        return measured.plan.reference.name
    return f"{measured.reference_samples} samples in {REFERENCE_RUNS} runs"


def _method(measured):
    against = "Each engine is judged by the other's reference. " if len(measured.references) > 1 else ""
    return (
        "Relative RMSE: |I - R|² / (|R|² + (0.1 mean)²) by pixel, without the thousandth that err most, less the noise "
        f"of the reference. {against}Seconds are the wall time of Blender's whole render operator, the quicker of "
        f"{RUNS} runs, all methods by turns in one process. Noise is told from two runs; bias is what is left of the "
        "error in the mean over blocks of 8 × 8 pixels beyond their noise. relMSE: (I - R)² / (R² + 0.01), Rousselle "
        "2011. PSNR and FLIP (Andersson 2020; where flip-evaluator is installed) compare colours as an sRGB screen "
        "shows them."
    )


def _settings(measured):
    width, height = measured.size
    plan = measured.plan
    limit = f"{plan.time_limit:g} s" if plan.time_limit else "none"
    return [
        ("Picture", f"{width} × {height} pixels"),
        ("Depth", f"{measured.depth} hits along a path"),
        ("Set alike", "plain path tracing: box filter of one pixel, no clamps, no denoising, nothing adaptive"),
        ("Reference", f"{_reference_text(measured)}; {number(measured.reference_seconds)} s"),
        ("Noise of the reference", percent(measured.reference_noise()) if measured.references else "–"),
        ("Threads", plan.threads or "one for each processor"),
        ("Time limit", limit),
        ("Measured in", f"{measured.seconds:.0f} s"),
    ]


def _machine(bpy, measured, before):
    load = ", ".join(f"{x:.1f}" for x in (*before["load"], *machine.load()[:1])) or "unknown"
    return [
        ("Processor", f"{before['processor']}, {before['processors']} processors"),
        ("System", before["system"]),
        ("Load before and after", load),
        ("Versions", ", ".join(f"{name} {version}" for name, version in machine.versions(bpy).items())),
        ("Date", datetime.datetime.now().astimezone().isoformat(timespec="minutes")),
    ]


def _features(measured):
    groups = {}
    for method, found in measured.features.items():
        words = (", ".join(found[key]) or "nothing" for key in ("left_out", "in_use"))
        groups.setdefault("left out: {}; used: {}".format(*words), []).append(NAMES[method])
    return [(", ".join(names), said) for said, names in groups.items()]
