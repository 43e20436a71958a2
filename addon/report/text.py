# SPDX-License-Identifier: GPL-3.0-or-later
"""What was measured, as tables, sentences and curves."""

from __future__ import annotations

import csv
from dataclasses import astuple, fields

import numpy as np

from ...core.report.plot import Curve
from ...core.report.table import number, percent
from .measure import NAMES, RANDOM, Rung

TARGETS = (0.10, 0.05, 0.02, 0.01)
_PERCENT = ("error", "error_with_fireflies", "noise", "bias", "estimate")
_HEAD = {
    "method": "method",
    "samples": "samples",
    "seconds": "seconds",
    "error": "relative RMSE %",
    "error_with_fireflies": "with fireflies %",
    "noise": "of it noise %",
    "bias": "of it bias %",
    "relative_mse": "relMSE",
    "psnr": "PSNR dB",
    "flip": "FLIP",
    "estimate": "own estimate %",
    "rays": "rays",
}


def all_rungs(measured):
    """Every `Rung`, method by method."""
    return [rung for rungs in measured.rungs.values() for rung in rungs]


def rung_text(rung):
    """Samples, seconds and error in a few words."""
    return f"{rung.samples} samples, {number(rung.seconds)} s, error {percent(rung.error)}"


# -- tables ------------------------------------------------------------------------------------------------------------


def write_csv(measured, path):
    """Write every rung with all its digits; errors are shares, not percents."""
    with path.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow([field.name for field in fields(Rung)])
        rows.writerows(["" if value is None else value for value in astuple(rung)] for rung in all_rungs(measured))


def rungs_table(measured):
    """Head and rows of all rungs; columns nobody measured are left out."""
    rungs = all_rungs(measured)
    names = [name for name in _HEAD if any(getattr(rung, name) is not None for rung in rungs)]
    return [_HEAD[name] for name in names], [[_cell(rung, name) for name in names] for rung in rungs]


def _cell(rung, name):
    value = getattr(rung, name)
    if name == "method":
        return NAMES[value]
    return 100 * value if name in _PERCENT and value is not None else value


def targets_table(measured):
    """Head and rows of seconds to errors; an asterisk marks what lies beyond what was measured."""
    head = ["method", *(f"s to {target:.0%}" for target in TARGETS), "slope over samples", "s a sample", "start s"]
    rows = []
    for method in measured.rungs:
        curve = measured.convergence(method)
        if curve:
            reaches = [curve.reach(target) for target in TARGETS]
            cells = [number(reach.seconds) + ("*" if reach.extrapolated else "") for reach in reaches]
            rows.append([NAMES[method], *cells, f"-{curve.slope:.2f}", curve.time.each, curve.time.start])
    return head, rows


# -- sentences ---------------------------------------------------------------------------------------------------------


def findings(measured):
    """Sentences of what the figures say."""
    found = [_crossing(measured, method) for method in measured.rungs if method not in RANDOM]
    curve, rungs = measured.convergence("pathtrace"), measured.rungs.get("pathtrace")
    if curve:
        last = rungs[-1]
        found.append(
            f"Path tracing: error falls as samples to the power of -{curve.slope:.2f}; after {number(last.seconds)} s "
            f"({last.samples} samples) it is {percent(last.error)}, {_biased(last)}."
        )
    share = measured.agreement()
    if share is not None:
        found.append(f"The references of both engines agree in {percent(share)} of the blocks of 8 × 8 pixels.")
    return [sentence for sentence in found if sentence]


def _biased(rung):
    return "and no bias can be told from the noise" if rung.bias < 0.2 * rung.noise else f"bias {percent(rung.bias)}"


def _crossing(measured, method):
    """Where path tracing passes below a method whose error stays."""
    last, curve = measured.rungs[method][-1], measured.convergence("pathtrace")
    name = NAMES[method]
    flat = f"{name} stays at {percent(last.error)} of error: its bias, which more samples do not take away"
    if curve is None or last.error <= 0:
        return flat + "."
    first = measured.rungs["pathtrace"][0]
    if first.error <= last.error:
        return f"{flat}; path tracing is below it from its first sample on ({number(first.seconds)} s)."
    reach = curve.reach(last.error)
    where = "would pass" if reach.extrapolated else "passes"
    return f"{flat}; path tracing {where} below it after {number(reach.seconds)} s ({reach.samples:.0f} samples)."


# -- curves ------------------------------------------------------------------------------------------------------------


def curves(measured):
    """`Curve` of each method in percent; how far those reach whose error stays, the fitted slope, and that of -1/2."""
    rungs = {method: [r for r in rows if r.error > 0] for method, rows in measured.rungs.items()}
    rungs = {method: rows for method, rows in rungs.items() if rows}
    drawn = [
        Curve(NAMES[method], [r.seconds for r in rows], [100 * r.error for r in rows]) for method, rows in rungs.items()
    ]
    longest = max((r.seconds for rows in rungs.values() for r in rows), default=1.0)
    for method, rows in rungs.items():
        if method not in RANDOM:
            drawn.append(Curve(f"_{method}", [rows[-1].seconds, longest], [100 * rows[-1].error] * 2, "k--"))
    for method in RANDOM:
        curve = measured.convergence(method)
        if curve:
            drawn += _slopes(method, rungs[method], curve)
    return drawn


def _slopes(method, rows, curve):
    """The power law of the last rungs, by the samples, and the root law through the first rung, by the time."""
    counts = np.geomspace(max(1, rows[-1].samples / 8), 2 * rows[-1].samples, 9)
    fitted = 100 * rows[-1].error * (counts / rows[-1].samples) ** -curve.slope
    lines = [
        Curve(
            f"{NAMES[method]}: samples^-{curve.slope:.2f}", [curve.time.at(n) for n in counts], fitted.tolist(), "k-."
        )
    ]
    if method == "pathtrace":
        x = np.geomspace(rows[0].seconds, rows[-1].seconds, 2)
        lines.append(Curve("seconds^-1/2", x.tolist(), (100 * rows[0].error * (x / x[0]) ** -0.5).tolist(), "k:"))
    return lines
