# SPDX-License-Identifier: GPL-3.0-or-later
"""The experiments of the thesis, anew: a picture, a table and a sentence of each.

Davor Najev, "Postupak praćenja zrake i praćenja puta" (FER, Zagreb, 2024), figures 4.1 to 4.6 and table 4.1.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ...core.diagnostics import SceneError
from ...core.report.error import line, relative_rmse, weights
from ...core.report.plot import Curve, plot
from ...core.report.table import number, percent
from ..bench import scenes, thesis
from ..bench.engines import open_blend
from . import display
from .measure import NAMES, REFERENCE_RUNS
from .sheet import contact_sheet

RUNS = 2
_WIDTH = 400  # of a picture on a sheet
_THEIRS = {  # Najev 2024, table 4.1: milliseconds of a picture by depth and scene
    "ray casting": 2547,
    "depth 1": 2779,
    "depth 2": 4114,
    "depth 5, open": 4557,
    "depth 5, closed": 8443,
}


@dataclass
class Found:
    """What an experiment showed."""

    title: str
    text: str
    head: list
    rows: list
    figure: np.ndarray | None = None  # (H, W, 4)
    curves: list = field(default_factory=list)  # in place of a picture


class Lab:
    """Renders what the experiments ask for.

    Parameters
    ----------
    bench : addon.bench.engines.Bench
    size : (width, height), optional
        In place of the thesis' 500 × 500.
    """

    def __init__(self, bench, size=None):
        self.bench, self._size = bench, size

    def open(self, name):
        """Open a sample scene."""
        scene = open_blend(scenes.find(name, None))
        if self._size:
            scene.render.resolution_x, scene.render.resolution_y = self._size
        return scene

    def render(self, scene, method, samples=1, **settings):
        """`RUNS` renders of a scene, after one of a single sample that is not counted."""
        scene.zraka.method = method.upper()
        for name, value in settings.items():
            setattr(scene.zraka, name, value)
        return [self.bench.run(scene, "zraka", n, matched=False) for n in (1, *[samples] * RUNS)][1:]


def _milliseconds(runs):
    """Of the quickest run: what else the machine does only adds."""
    return 1000 * min(run.seconds for run in runs)


def _rays(runs):
    return sum(runs[-1].seen.stats["rays"].values())


def _sheet(scene, runs, captions):
    pictures = [display.shrunk(display.shown(scene, run[-1].picture), _WIDTH) for run in runs]
    return contact_sheet(pictures, captions, columns=len(pictures))


def _apart(picture, other):
    """Relative RMSE between two pictures of no noise."""
    weight = weights(other)
    return float(np.sqrt(np.mean(((picture - other) ** 2).sum(axis=-1) * weight)))


# -- the figures -------------------------------------------------------------------------------------------------------


def shadows(lab):
    """Figure 4.1: Phong beside ray casting."""
    scene = lab.open("thesis")
    runs = {method: lab.render(scene, method) for method in ("phong", "raycast")}
    rows = [
        [NAMES[m], _milliseconds(r), _milliseconds(r) / _milliseconds(runs["phong"]), _rays(r)] for m, r in runs.items()
    ]
    dark = np.mean(_luminance(runs["raycast"]) < 0.999 * _luminance(runs["phong"]))
    text = (
        f"Where the shadow ray meets something, {percent(dark)} of the picture, the light goes out. The picture takes "
        f"{number(_rays(runs['raycast']) / _rays(runs['phong']))} times the rays of Phong's model alone."
    )
    figure = _sheet(scene, runs.values(), [NAMES[method] for method in runs])
    return Found("Figure 4.1: Phong beside ray casting", text, ["method", "ms", "relative", "rays"], rows, figure)


def _luminance(runs):
    return runs[-1].picture @ np.array((0.2126, 0.7152, 0.0722), np.float32)


def depths(lab):
    """Figure 4.2: ray tracing to depth 1, 2 and 10."""
    scene = lab.open("thesis")
    runs = {depth: lab.render(scene, "raytrace", depth=depth) for depth in (1, 2, 10)}
    last = runs[10][-1].picture
    rows = [[f"{d}", _milliseconds(r), _rays(r), percent(_apart(r[-1].picture, last))] for d, r in runs.items()]
    text = (
        f"The second hit is what mirrors show: without it the picture differs from that of depth 10 by {rows[0][3]}; "
        f"with it by {rows[1][3]}, and the further eight take {number(rows[2][2] / rows[1][2])} times its rays."
    )
    head = ["depth", "ms", "rays", "differs from depth 10"]
    figure = _sheet(scene, runs.values(), [f"Depth {depth}" for depth in runs])
    return Found("Figure 4.2: ray tracing, depth 1, 2 and 10", text, head, rows, figure)


def reflectivities(lab):
    """Figure 4.3: reflectivity 0, 0.5 and 1."""
    scene = lab.open("thesis")
    shares = (0.0, 0.5, 1.0)
    runs = {s: lab.render(scene, "raytrace", depth=5, use_reflectivity=True, reflectivity=s) for s in shares}
    rows = [[f"{share:g}", _milliseconds(r), _rays(r), float(r[-1].picture.mean())] for share, r in runs.items()]
    text = (
        "The share of the mirror ray is one number for all materials. At 0 no mirror ray carries anything and none is "
        f"traced; at 1 the same depth of 5 takes {number(rows[2][2] / rows[0][2])} times the rays."
    )
    head = ["reflectivity", "ms", "rays", "mean radiance"]
    figure = _sheet(scene, runs.values(), [f"Reflectivity {share:g}" for share in runs])
    return Found("Figure 4.3: ray tracing, reflectivity 0, 0.5 and 1", text, head, rows, figure)


def iterations(lab):
    """Figure 4.4: path tracing after 1, 5 and 30 iterations."""
    scene = lab.open("thesis")
    runs = {n: lab.render(scene, "pathtrace", n) for n in (1, 5, 30)}
    truth = _reference(lab, scene, 16)
    weight = weights(truth.mean(axis=0))

    def error(runs, trim):
        return float(np.mean([relative_rmse(run.picture, truth, weight, trim) for run in runs]))

    kept, all_of_them = ({n: error(r, trim) for n, r in runs.items()} for trim in (0.01, 0.0))
    rows = [[f"{n}", _milliseconds(r), percent(kept[n]), percent(all_of_them[n])] for n, r in runs.items()]
    text = (
        "An iteration adds a sample to every pixel. From 1 to 30 the error of all pixels falls by a factor of "
        f"{number(all_of_them[1] / all_of_them[30])}; independent samples give the root of 30, {number(30**0.5)}. "
        f"Without the hundredth that err most it is a factor of {number(kept[1] / kept[30])}: the light hangs a tenth "
        "under the ceiling, and the bright, rare paths that end beside it reach more pixels with each iteration."
    )
    figure = _sheet(scene, runs.values(), [f"{n} iteration{'s' * (n > 1)}" for n in runs])
    head = ["iterations", "ms", "relative RMSE, 99% of the pixels", "of all"]
    return Found("Figure 4.4: path tracing, 1, 5 and 30 iterations", text, head, rows, figure)


def _reference(lab, scene, samples):
    """Independent path-traced runs, (R, H, W, 3)."""
    scene.zraka.method = "PATHTRACE"
    return np.stack([lab.bench.run(scene, "zraka", samples, matched=False).picture for _ in range(REFERENCE_RUNS)])


def edges(lab):
    """Figure 4.5: an edge by ray tracing and by path tracing, enlarged."""
    scene = lab.open("thesis")
    runs = {"raytrace": lab.render(scene, "raytrace"), "pathtrace": lab.render(scene, "pathtrace", 16)}
    shown = {method: display.shown(scene, r[-1].picture) for method, r in runs.items()}
    height, width = shown["raytrace"].shape[:2]
    side = max(2, min(height, width) // 16)
    y, x = int(_EDGE[1] * height), int(_EDGE[0] * width)
    cut = {method: picture[y : y + side, x : x + side] for method, picture in shown.items()}
    rows = [[NAMES[m], r[-1].seen.settings.samples, _milliseconds(r)] for m, r in runs.items()]
    text = (
        "Ray tracing looks through the middle of each pixel once, and edges are stairs. Path tracing's "
        f"{rows[1][1]} rays go through random points of the pixel, and edges come out smooth without a further step."
    )
    factor = max(1, _WIDTH // side)
    captions = [f"{NAMES[method]}\n{side} × {side} pixels, {factor} times" for method in cut]
    figure = contact_sheet([display.enlarged(c, factor) for c in cut.values()], captions, columns=2)
    head = ["method", "rays through a pixel", "ms"]
    return Found("Figure 4.5: an edge, ray tracing beside path tracing", text, head, rows, figure)


_EDGE = (0.79, 0.43)  # upper left corner of the cut-out, as shares of the picture's sides


def times(lab):
    """Figure 4.6: path tracing's time over its iterations."""
    scene = lab.open("thesis")
    counts = (1, 5, 10, 20, 30)
    milliseconds = [_milliseconds(lab.render(scene, "pathtrace", n)) for n in counts]
    fit = line(counts, milliseconds)
    fitted = [fit.at(n) for n in counts]
    rows = [[f"{n}", t, f] for n, t, f in zip(counts, milliseconds, fitted, strict=True)]
    text = f"Time is a line: {number(fit.start)} ms to begin with, {number(fit.each)} ms an iteration, R² {fit.r2:.4f}."
    drawn = [Curve("measured", list(counts), milliseconds), Curve("line", list(counts), fitted, "k--")]
    head = ["iterations", "ms", "line, ms"]
    return Found("Figure 4.6: path tracing's time over iterations", text, head, rows, curves=drawn)


def relative_times(lab):
    """Table 4.1: what ray tracing takes over ray casting."""
    plan = scenes.PLANS["quick"]._replace(runs=RUNS + 1)
    found = thesis.raytracing_over_raycasting(lab.bench, plan, None)
    cast = 1000 * found[0]["raycast_seconds"]
    rows = [["ray casting", _THEIRS["ray casting"], 1.0, cast, 1.0, 1.0]]
    rows += [
        [
            f"ray tracing, {r['case']}",
            _THEIRS.get(r["case"]),
            r["thesis"],
            1000 * r["raytrace_seconds"],
            r["time"],
            r["rays"],
        ]
        for r in found
    ]
    text = (
        f"Set against ray casting of the same scene; ours are {thesis.SAMPLES} samples of a pixel at 500 × 500, on "
        "as many threads as the machine has processors. The rays are what must be done; where time grows slower than "
        "they do, there is a part that does not depend on them."
    )
    head = ["method", "thesis ms", "thesis relative", "Zraka ms", "Zraka relative", "Zraka rays relative"]
    return Found("Table 4.1: relative times", text, head, rows)


EXPERIMENTS = {
    "4.1": shadows,
    "4.2": depths,
    "4.3": reflectivities,
    "4.4": iterations,
    "4.5": edges,
    "4.6": times,
    "table-4.1": relative_times,
}


def draw(found, path):
    """Write the figure of an experiment; tell whether there is one, which a curve without matplotlib is not."""
    if found.curves:
        try:
            plot(path, found.curves, found.title, "iterations", "ms", log=False)
        except ImportError:
            return False
        return True
    if found.figure is None:
        return False
    try:
        display.write(display.as_uint8(found.figure), path, quality=85)
    except OSError as error:
        raise SceneError(f"{path} cannot be written: {error.strerror or error}") from error
    return True
