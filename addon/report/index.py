# SPDX-License-Identifier: GPL-3.0-or-later
"""The page before several reports."""

from __future__ import annotations

from html import escape

from ...core.diagnostics import SceneError
from . import page, text
from .converge import PLOT


def write(reports, folder):
    """Write ``index.html`` of reports, name → `measure.Measured`, each in a folder of its name in `folder`.

    Raises
    ------
    SceneError
    """
    rows = []
    for name, measured in reports.items():
        head, found = text.targets_table(measured)
        rows += [[f"{name}, {cells[0]}", *cells[1:]] for cells in found]
    parts = [page.table(["scene, method", *head[1:]], rows)] if rows else []
    parts.append(page.paragraph("An asterisk marks what was extrapolated beyond the samples measured.", "note"))
    for name, measured in reports.items():
        link = escape(f"{name}/report.html", quote=True)
        parts.append(f'<h2><a href="{link}">{escape(name)}</a></h2>')
        parts.append(page.items(text.findings(measured)))
        drawn = folder / name / f"{PLOT}.svg"
        parts.append(page.plot(drawn) if drawn.is_file() else "")
    try:
        (folder / "index.html").write_text(page.page("Error against run time", *parts), encoding="utf-8")
    except OSError as error:
        raise SceneError(f"{folder} cannot be written: {error.strerror or error}") from error
