# SPDX-License-Identifier: GPL-3.0-or-later
"""HTML pages in one file: what they show is embedded in them."""

from __future__ import annotations

import base64
from html import escape

from ...core.report.table import number
from .display import encoded

_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; margin: 2em auto; max-width: 72em; padding: 0 1em; color: #222; }
h1 { font-size: 1.6em; } h2 { font-size: 1.2em; margin-top: 2em; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { padding: .2em .7em; text-align: right; border-bottom: 1px solid #ddd; }
th:first-child, td:first-child { text-align: left; }
.wide { overflow-x: auto; } .plot { max-width: 100%; }
.pictures { display: grid; grid-template-columns: repeat(auto-fill, minmax(17em, 1fr)); gap: 1em; }
figure { margin: 0; } figure img { width: 100%; } figcaption { font-size: .9em; color: #555; }
dt { font-weight: bold; } dd { margin: 0 0 .4em 1.5em; } .note { color: #555; font-size: .9em; }
"""


def page(title, *parts):
    """A whole page of parts that are HTML."""
    head = f'<meta charset="utf-8"><title>{escape(title)}</title><style>{_STYLE}</style>'
    body = "\n".join([heading(title, 1), *(part for part in parts if part)])
    return f'<!DOCTYPE html>\n<html lang="en"><head>{head}</head>\n<body>\n{body}\n</body></html>\n'


def heading(text, level=2):
    """A heading."""
    return f"<h{level}>{escape(text)}</h{level}>"


def paragraph(text, kind=""):
    """A paragraph of text, of a class of the style."""
    return f"<p{_classed(kind)}>{escape(text)}</p>"


def items(texts):
    """A list of texts; nothing of none."""
    rows = "".join(f"<li>{escape(text)}</li>" for text in texts)
    return f"<ul>{rows}</ul>" if rows else ""


def terms(pairs):
    """Names and what they stand for."""
    rows = "".join(f"<dt>{escape(name)}</dt><dd>{escape(str(value))}</dd>" for name, value in pairs)
    return f"<dl>{rows}</dl>"


def table(head, rows):
    """A table of texts and numbers, which are written as `core.report.table.number` does."""

    def line(tag, cells):
        return "<tr>" + "".join(f"<{tag}>{escape(number(cell))}</{tag}>" for cell in cells) + "</tr>"

    body = "".join(line("td", row) for row in rows)
    return f'<div class="wide"><table><thead>{line("th", head)}</thead><tbody>{body}</tbody></table></div>'


def pictures(shown):
    """Pictures (H, W, 3) uint8 side by side: (picture, caption) each."""
    return figures([("image/jpeg", encoded(picture), caption) for picture, caption in shown])


def figures(shown):
    """Pictures in files side by side: (media type, bytes, caption) each."""
    parts = "".join(
        f'<figure><img alt="{escape(caption)}" src="{_uri(media, content)}">'
        f"<figcaption>{escape(caption)}</figcaption></figure>"
        for media, content, caption in shown
    )
    return f'<div class="pictures">{parts}</div>'


def plot(path):
    """An SVG file, embedded."""
    return f'<img class="plot" alt="{escape(path.stem)}" src="{_uri("image/svg+xml", path.read_bytes())}">'


def _classed(kind):
    return f' class="{kind}"' if kind else ""


def _uri(media, content):
    return f"data:{media};base64,{base64.b64encode(content).decode('ascii')}"
