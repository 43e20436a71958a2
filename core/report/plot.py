# SPDX-License-Identifier: GPL-3.0-or-later
"""Curves in a picture.

Matplotlib is imported when something is drawn; only ``pip install 'zraka[bench]'`` brings it.
"""

from __future__ import annotations

from typing import NamedTuple

MARKS = ("o-", "s--", "^:", "d-.", "v-")


class Curve(NamedTuple):
    """A named line of points.

    Parameters
    ----------
    name : str
    x, y : list
    style : str, optional
        Matplotlib's format in place of the next of `MARKS`, of a line that was not measured; it is drawn faintly. Where
        its name begins with an underscore it stands in no legend.
    """

    name: str
    x: list
    y: list
    style: str | None = None


def plot(path, curves, title, x_label, y_label, log=True, own_range=True):
    """Draw curves into a PNG or, as `path` ends, an SVG.

    Parameters
    ----------
    path : Path
    curves : sequence of Curve
    log : bool
        Both axes logarithmic.
    own_range : bool
        Whether lines in a `style` of their own widen the axes.

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
        _make_logarithmic(axes)
    marked = [curve for curve in curves if curve.style is None]
    for number, curve in enumerate(marked):
        axes.plot(curve.x, curve.y, MARKS[number % len(MARKS)], label=curve.name)
    if not own_range:
        axes.set_xlim(axes.get_xlim())
        axes.set_ylim(axes.get_ylim())
    for curve in curves:
        if curve.style is not None:
            axes.plot(curve.x, curve.y, curve.style, label=curve.name, alpha=0.6, linewidth=1)
    if not log:
        axes.set_ylim(bottom=0)
    axes.grid(True, which="both", alpha=0.3)
    axes.legend()
    figure.savefig(path, dpi=110)


def _make_logarithmic(axes):
    """Logarithmic axes with plain numbers at 1, 2 and 5."""
    from matplotlib.ticker import LogLocator, StrMethodFormatter

    axes.set_xscale("log")
    axes.set_yscale("log")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.set_major_formatter(StrMethodFormatter("{x:g}"))
        axis.set_minor_formatter("")
