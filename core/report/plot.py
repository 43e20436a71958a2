# SPDX-License-Identifier: GPL-3.0-or-later
"""Curves in a picture.

Matplotlib is imported when something is drawn; only ``pip install 'zraka[bench]'`` brings it.
"""

from __future__ import annotations

from typing import NamedTuple

MARKS = ("o-", "s--", "^:", "d-.")


class Curve(NamedTuple):
    """A named line of points."""

    name: str
    x: list
    y: list


def plot(path, curves, title, x_label, y_label, log=True):
    """Draw curves into a PNG.

    Parameters
    ----------
    path : Path
    curves : sequence of Curve
    log : bool
        Both axes logarithmic.

    Raises
    ------
    ImportError
        Where matplotlib is not installed.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot(title=title, xlabel=x_label, ylabel=y_label)
    if log:
        axes.set_xscale("log")
        axes.set_yscale("log")
    for number, curve in enumerate(curves):
        axes.plot(curve.x, curve.y, MARKS[number % len(MARKS)], label=curve.name)
    if not log:
        axes.set_ylim(bottom=0)
    axes.grid(True, which="both", alpha=0.3)
    axes.legend()
    figure.savefig(path, dpi=110)
