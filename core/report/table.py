# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers as text: tables in Markdown that read well on a terminal, too."""

from __future__ import annotations

import math


def number(value, digits=3):
    """A number with `digits` digits that count; a dash for None and what is not finite; texts as they are."""
    if isinstance(value, str):
        return value
    if value is None or not math.isfinite(value):
        return "–"
    if isinstance(value, int):
        return str(value)
    if value == 0:
        return "0"
    places = max(0, digits - 1 - math.floor(math.log10(abs(value))))
    return f"{value:.{places}f}"


def percent(share):
    """A share in percent."""
    return "–" if share is None else f"{share:.1%}"


def table(head, rows, padded=True):
    """A Markdown table, the first column to the left, numbers to the right; `padded` where cells are short."""
    cells = [list(map(number, row)) for row in (head, *rows)]
    if not padded:
        rule = "|---|" + "---:|" * (len(head) - 1)
        return "\n".join([_line(cells[0]), rule, *map(_line, cells[1:])])
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]

    def joined(first, *others):
        numbers = [text.rjust(width) for text, width in zip(others, widths[1:], strict=True)]
        return _line([first.ljust(widths[0]), *numbers])

    rule = "|".join(["|" + "-" * (widths[0] + 2), *("-" * (width + 1) + ":" for width in widths[1:])]) + "|"
    return "\n".join([joined(*cells[0]), rule, *(joined(*row) for row in cells[1:])])


def _line(cells):
    """One line of a table."""
    return "| " + " | ".join(cells) + " |"
