# SPDX-License-Identifier: GPL-3.0-or-later
"""A table beside an animation's frames: how long each took, and how large its error was when it stopped."""

from __future__ import annotations

import csv
import math
import os
from pathlib import Path

from ..core.diagnostics import SceneError

FIELDS = ("frame", "layer", "seconds", "samples", "error", "stopped")


def table_path(render):
    """The file that belongs to the frames of a scene, by where Blender writes them.

    Parameters
    ----------
    render : bpy.types.RenderSettings

    Returns
    -------
    Path
        ``shot_error.csv`` for ``shot_0001.png`` and all others; ``error.csv`` where their names are numbers alone.
    """
    first, second = (Path(render.frame_path(frame=frame)) for frame in (0, 1))
    name = first.stem
    # Both names differ in the last digit of the frame alone; a film's do not.
    place = next((i for i, (a, b) in enumerate(zip(name, second.stem, strict=False)) if a != b), None)
    if place is not None:
        name = name[: place + 1].rstrip("0") + name[place + 1 :]
    name = name.strip("_-. ")
    return first.with_name(f"{name}_error.csv" if name else "error.csv")


def write_row(path, frame, layer, film):
    """Put a frame into the table, in place of what stood there of it.

    Parameters
    ----------
    path : Path
    frame : int
    layer : str
    film : core.film.Film
        Or a `monitor.Record`.

    Raises
    ------
    SceneError
        If the file cannot be written, or is another's.
    """
    error = film.stats["error"]
    row = {
        "frame": str(frame),
        "layer": layer,
        "seconds": f"{film.stats['seconds']:.3f}",
        "samples": str(film.samples),
        "error": f"{error:.6g}" if math.isfinite(error) else "",
        "stopped": film.stats["stopped"],
    }
    try:
        rows = {(found["frame"], found["layer"]): found for found in _rows(path)} | {(row["frame"], layer): row}
        path.parent.mkdir(parents=True, exist_ok=True)
        partial = path.with_name(path.name + ".part")
        with partial.open("w", newline="", encoding="utf-8") as file:
            table = csv.DictWriter(file, FIELDS)
            table.writeheader()
            table.writerows(rows[key] for key in sorted(rows, key=lambda key: (int(key[0]), key[1])))
        os.replace(partial, path)
    except OSError as problem:
        raise SceneError(f"{path} cannot be written: {problem.strerror or problem}") from problem


def _rows(path):
    """Those that stand there, of other frames and of other runs."""
    if not path.exists() or not path.stat().st_size:
        return []
    with path.open(newline="", encoding="utf-8", errors="replace") as file:
        table = csv.DictReader(file)
        if tuple(table.fieldnames or ()) != FIELDS:
            raise SceneError(f"{path} holds something else and was left as it is")
        return [row for row in table if _is_whole(row)]


def _is_whole(row):
    return None not in row and None not in row.values() and row["frame"].removeprefix("-").isdigit()
