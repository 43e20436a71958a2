# SPDX-License-Identifier: GPL-3.0-or-later
"""A report as Markdown, as JSON and as a page."""

from __future__ import annotations

import html
import math

from ..report.table import table
from . import items
from .axis import holds, widest
from .stiff import CRITICAL_T, SEEDS

_STYLE = (
    "body{font:15px/1.5 sans-serif;max-width:75em;margin:2em auto;padding:0 1em}"
    "table{border-collapse:collapse}td,th{border-bottom:1px solid #ccc;padding:.2em .7em;text-align:right}"
    "td:first-child,th:first-child{text-align:left}.fail{background:#fbb}.range{background:#fed}"
)
_RANGES = ("axis", "scene and closed form", "widest range that passes", "tried", "must hold")
_ITEMS = ("what is driven to its extremes", "where", "cases")
_CASES = ("case", "reference", "value", "error", "not finite", "s", "verdict", "why")
_STIFF = (
    "scene",
    "closed form",
    "truth",
    "mean",
    "t",
    "t, other route and stages",
    "by sampled lights",
    "clamp removes",
    "error over time",
    "verdict",
)


def markdown(report):
    """The whole text."""
    parts = [_head(report), "## What is covered", _table(_ITEMS, items.rows(report))]
    parts += ["## Widest ranges", _table(_RANGES, _range_rows(report))]
    if report.findings:
        words = (
            f"Means over {SEEDS} seeds against the truth: a right mean has |t| above {CRITICAL_T} once in a thousand "
            "runs. The clamp is set to ten times the picture's mean."
        )
        parts += ["## Stiff scenes", words, _table(_STIFF, _stiff_rows(report))]
    return "\n\n".join([*parts, "## Cases", _table(_CASES, _case_rows(report))]) + "\n"


def _table(head, rows):
    """Cells of many lengths would be padded to lines of hundreds of characters."""
    return table(head, rows, padded=False)


def page(report):
    """The same as HTML."""
    body = [f"<h1>Numerical stability</h1><p>{html.escape(_state(report))}</p>"]
    covered = ("What is covered", _ITEMS, items.rows)
    sections = (covered, ("Widest ranges", _RANGES, _range_rows), ("Stiff scenes", _STIFF, _stiff_rows))
    for title, head, rows in (*sections, ("Cases", _CASES, _case_rows)):
        body.append(f"<h2>{title}</h2><table>{_row(head, 'th')}{''.join(_row(r) for r in rows(report))}</table>")
    title = "<title>Numerical stability</title>"
    head = f'<!DOCTYPE html><html lang="en"><meta charset="utf-8">{title}<style>{_STYLE}</style>'
    return head + "".join(body) + "</html>\n"


def data(report):
    """The same as what JSON can hold; numbers that are not finite become null."""
    return {
        "quick": report.quick,
        "interrupted": report.interrupted,
        "seconds": report.seconds,
        "processor": report.processor,
        "failures": report.failures,
        "ranges": {name: found and list(found) for name, found in report.ranges.items()},
        "cases": [
            {"axis": r.axis.name, "case": r.value, "reference": _finite(r.case.truth)}
            | {key: _finite(value) for key, value in outcome._asdict().items()}
            for r in report.results
            for outcome in r.outcomes
        ],
        "stiff": [
            {"scene": f.stiff.name, "truth": f.stiff.case.truth, "verdict": f.verdict}
            | {key: value for key, value in f._asdict().items() if key != "stiff"}
            for f in report.findings
        ],
    }


def _head(report):
    return f"# Numerical stability\n\n{_state(report)}"


def _state(report):
    count = sum(len(r.outcomes) for r in report.results)
    failures = "; ".join(report.failures) or "none"
    whole = "Interrupted: what follows is not whole. " if report.interrupted else ""
    command = "zraka stability" + (" --quick" if report.quick else "")
    took = f"{report.seconds:.0f} s, {report.processor:.0f} s of the processor"
    return f"{whole}Written by `{command}`: {count} renders in {took}. Failing: {failures}."


def _range_rows(report):
    for axis in dict.fromkeys(result.axis for result in report.results):
        if axis.usual is None:
            passed = sum(r.verdict == "pass" for r in report.results if r.axis is axis)
            yield axis.name, axis.truth, f"{passed} of {len(axis.chosen(report.quick))} cases", "", ""
            continue
        found, tried = widest(axis, report.results), axis.chosen(report.quick)
        text = "none" if found is None else _span(*found)
        text += "" if holds(axis, found, tried) else " (too narrow)"
        yield axis.name, axis.truth, text, _span(tried[0], tried[-1]), _span(*axis.must) if axis.must else ""


def _case_rows(report):
    """One line for each case; of renders that differ in verdict, one each."""
    for r in report.results:
        groups = {}
        for outcome in r.outcomes:
            groups.setdefault(outcome.verdict, []).append(outcome)
        for verdict, outcomes in groups.items():
            first = outcomes[0]
            name = f"{r.axis.name}: {_text(r.value)}"
            if len(groups) > 1:
                name += f" ({', '.join(f'{o.method}, {o.route}, {o.features}' for o in outcomes)})"
            off = None
            if r.case.truth and first.value is not None and first.method in r.case.methods:
                off = f"{first.value / r.case.truth - 1:+.2%}"
            lost, seconds = sum(o.nonfinite for o in outcomes), sum(o.seconds for o in outcomes)
            truth = "finite" if r.case.truth is None else _text(r.case.truth)
            yield name, truth, _text(first.value), off or "–", str(lost), f"{seconds:.2f}", verdict, first.note


def _stiff_rows(report):
    for f in report.findings:
        ladder = ", ".join(f"{error:.2%} in {seconds:.2f} s" for _, seconds, error in f.ladder)
        numbers = (
            _text(f.stiff.case.truth),
            _text(f.mean),
            f"{f.t:+.2f}",
            f"{f.others:+.2f}",
            f"{f.lights:.1%}",
            f"{f.clamped:.1%}",
        )
        yield f.stiff.name, f.stiff.truth, *numbers, ladder, f.verdict


def _row(cells, tag="td"):
    kind = "fail" if "fail" in cells else "range" if "out of range" in cells else ""
    return f'<tr class="{kind}">' + "".join(f"<{tag}>{html.escape(str(c))}</{tag}>" for c in cells) + "</tr>"


def _span(low, high):
    return f"{_text(low)} to {_text(high)}"


def _text(value):
    if value is None:
        return "–"
    return value if isinstance(value, str) else f"{value:.6g}"


def _finite(value):
    return None if isinstance(value, float) and not math.isfinite(value) else value
