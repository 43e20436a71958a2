# SPDX-License-Identifier: GPL-3.0-or-later
"""``thesis.md``: the thesis' experiments with their figures."""

from __future__ import annotations

import os

from ...core.diagnostics import SceneError
from ...core.report.table import table
from .. import headless, machine
from ..bench.engines import Bench, Interrupted
from . import thesis

_HEAD = """# The thesis' experiments, anew

Davor Najev, *Postupak praćenja zrake i praćenja puta* (Ray tracing and path tracing), FER, University of Zagreb, 2024,
shows its methods by six figures and a table. `zraka thesis --output docs` makes them anew with Zraka; what follows is
what it wrote.

The scene is the thesis' own (`sample_blends/thesis.blend`; the table's are `room_open.blend` and `room_closed.blend`),
500 × 500 pixels. Its light falls off linearly, Blender's with the square of the distance; the light's power was chosen
so that the pictures look alike. Milliseconds are wall time of Blender's whole render operator, of the quickest
of some runs; the table's are medians."""


def make(names, folder, size=None, interrupted=lambda: False, say=lambda text: None):
    """Run experiments and write ``thesis.md`` and, in ``figures``, their pictures.

    Parameters
    ----------
    names : sequence of str
        Of `thesis.EXPERIMENTS`.
    folder : Path
    size : (width, height), optional
        In place of 500 × 500; the table's stay as they are.
    interrupted, say : callable
        As of `measure.measure`.

    Returns
    -------
    dict
        Name → `thesis.Found`, of those that were run to their end.

    Raises
    ------
    SceneError
    """
    machine.make_folder(folder / "figures")
    bpy = headless.load_blender()
    threads = os.cpu_count() or 1
    lab = thesis.Lab(Bench({"zraka": "ZRAKA"}, threads, interrupted, say), size)
    before, found, parts = machine.machine(), {}, [_HEAD]
    parts.append(_on(before, machine.versions(bpy), threads))
    for name in names:
        say(f"experiment {name}")
        try:
            found[name] = thesis.EXPERIMENTS[name](lab)
        except Interrupted:
            say("interrupted; what was done is written")
            break
        parts += _section(name, found[name], folder, say)
        _write(folder, parts)
    return found


def _on(before, versions, threads):
    named = ", ".join(f"{name} {version}" for name, version in versions.items())
    load = ", ".join(f"{x:.1f}" for x in before["load"]) or "unknown"
    return f"Measured on {before['processor']}, {threads} threads, load before: {load}; {named}."


def _section(name, found, folder, say):
    picture = f"figures/thesis-{name}.{'png' if found.curves else 'jpg'}"
    parts = [f"## {found.title}", found.text]
    if thesis.draw(found, folder / picture):
        parts.append(f"![{found.title}]({picture})")
    elif found.curves:
        say("no plot: matplotlib is missing; pip install 'zraka[bench]'")
    return [*parts, table(found.head, found.rows)]


def _write(folder, parts):
    try:
        (folder / "thesis.md").write_text("\n\n".join(parts) + "\n", encoding="utf-8")
    except OSError as error:
        raise SceneError(f"{folder} cannot be written: {error.strerror or error}") from error
