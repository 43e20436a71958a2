# SPDX-License-Identifier: GPL-3.0-or-later
"""A chart as SVG, which a page holds as it is."""

from __future__ import annotations

from html import escape

_COLORS = {
    "text": "#222",
    "faint": "#666",
    "grid": "#ddd",
    "curve": "#d95f02",
    "forecast": "#d95f02",
    "root": "#4878a8",
    "target": "#2a8a3c",
    "before": "#b8a898",
}


def svg(chart):
    """A `chart.Chart` as the text of an ``<svg>`` element."""
    size = f'width="{chart.width}" height="{chart.height}" viewBox="0 0 {chart.width} {chart.height}"'
    parts = [*map(_line, chart.lines), *map(_text, chart.texts)]
    return f'<svg xmlns="http://www.w3.org/2000/svg" class="plot" {size} font-size="13">{"".join(parts)}</svg>'


def _line(line):
    points = line.points if len(line.points) > 1 else line.points.repeat(2, axis=0)
    places = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    dashes = ' stroke-dasharray="6 6"' if line.dashed else ""
    return (
        f'<polyline points="{places}" fill="none" stroke="{_COLORS[line.role]}" stroke-width="{line.width:g}" '
        f'stroke-linecap="round"{dashes}/>'
    )


def _text(text):
    return (
        f'<text x="{text.x:.1f}" y="{text.y:.1f}" dominant-baseline="middle" text-anchor="{text.anchor}" '
        f'fill="{_COLORS[text.role]}">{escape(text.text)}</text>'
    )
