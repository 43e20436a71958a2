# SPDX-License-Identifier: GPL-3.0-or-later
"""How time grows: with samples, triangles and lights; and what leaving stages out gives."""

from __future__ import annotations

from time import perf_counter

import numpy as np

from ...core.report.error import line, noise, weights
from . import scenes
from .engines import Interrupted, median, open_blend

SAMPLES = 8
AMONG_LIGHTS = 0.05  # error whose time the lights are compared by
_FIRST_RAYS = 3  # of a run of the plan; each takes a quarter of a second for a million triangles


def samples(bench, plan, folder):
    """Time of Zraka's path tracing over samples, `cornell`: the line of the thesis' figure 4.6."""
    scene = open_blend(scenes.find("cornell", folder), plan.percentage)
    cases = {n: {"side": "zraka", "samples": n} for n in plan.samples}
    runs = bench.alternate(scene, cases, plan.runs)
    seconds = [median(runs[n]) for n in plan.samples]
    return {"samples": list(plan.samples), "seconds": seconds, "line": line(plan.samples, seconds)._asdict()}


def features(bench, plan, folder):
    """Time of Zraka with every stage over that with those the scene needs, `cornell`."""
    from ...core.compile.features import Feature

    scene = open_blend(scenes.find("cornell", folder), plan.percentage)
    cases = {
        "own": {"side": "zraka", "samples": SAMPLES},
        "all": {"side": "zraka", "samples": SAMPLES, "force_features": Feature.all()},
    }
    runs = bench.alternate(scene, cases, plan.runs)
    own, every = median(runs["own"]), median(runs["all"])
    return {"own_seconds": own, "all_seconds": every, "gain": every / own}


def triangles(bench, plan, folder):
    """Time of both engines over triangles, hills under a sun; Zraka's building beside it."""
    rows = []
    for count in plan.triangles:
        bench.say(f"{count} triangles")
        scene = _prepared(scenes.terrain(count), plan)
        runs = bench.alternate(scene, {side: {"side": side, "samples": SAMPLES} for side in bench.sides}, plan.runs)
        rows.append({"triangles": count} | {side: _times(runs[side]) for side in bench.sides})
    return rows


def first_ray(bench, plan, folder):
    """Seconds from Blender's mesh to the first ray, hills with smooth and flat shading, over Embree's tree alone."""
    import bpy

    rows = []
    for count in plan.triangles:
        for shading in ("smooth", "flat"):
            bench.say(f"{count} triangles, {shading}")
            scenes.terrain(count)
            if shading == "flat":
                bpy.data.objects["Hills"].data.shade_flat()
            depsgraph = bpy.context.evaluated_depsgraph_get()
            runs = [_to_first_ray(depsgraph) for _ in range(_FIRST_RAYS * plan.runs + 1)][1:]
            if bench.interrupted():
                raise Interrupted
            seconds = dict(zip(("export", "compile", "tree"), np.median(runs, axis=0).tolist(), strict=True))
            over = float(np.median(np.sum(runs, axis=1) / np.array(runs)[:, 2]))
            rows.append({"triangles": count, "shading": shading, "seconds": seconds, "over_tree": over})
    return rows


def _to_first_ray(depsgraph):
    """Seconds of exporting, of the tables, and of Embree's tree, which ends with a ray."""
    from ...core.accel import Accel
    from ...core.compile.geometry import compile_geometry
    from ...core.diagnostics import Diagnostics
    from ..export.scene import export_scene

    times = [perf_counter()]
    scene = export_scene(depsgraph, Diagnostics())
    times.append(perf_counter())
    geometry = compile_geometry(scene)
    times.append(perf_counter())
    tree = Accel(geometry)
    times.append(perf_counter())
    del tree
    return np.diff(times)


def lights(bench, plan, folder):
    """Time of both engines to 5% of error over point lights.

    The error here is the spread of the timed runs, which are independent, and goes with the root of the samples.
    """
    rows = []
    for count in plan.lights:
        bench.say(f"{count} lights")
        scene = _prepared(scenes.lamps(count), plan)
        runs = bench.alternate(scene, {side: {"side": side, "samples": SAMPLES} for side in bench.sides}, plan.runs)
        pictures = {side: np.stack([run.picture for run in runs[side]]) for side in bench.sides}
        weight = weights(np.mean([p.mean(axis=0) for p in pictures.values()], axis=0))
        row = {"lights": count}
        for side in bench.sides:
            spread = float(np.sqrt(noise(pictures[side], weight)))
            times = _times(runs[side])
            to_error = times["seconds"] * (spread / AMONG_LIGHTS) ** 2
            row[side] = times | {"error": spread, "seconds_to_5%": to_error}
        rows.append(row)
    return rows


def _prepared(scene, plan):
    scene.render.resolution_percentage = plan.percentage
    return scene


def _times(runs):
    """Median seconds, and those of Zraka's export and compilation."""
    found = {"seconds": median(runs)}
    if runs[-1].seen.stats:
        build = [run.seen.export_seconds + run.seen.compile_seconds for run in runs]
        found["build_seconds"] = float(np.median(build))
    return found


STUDIES = {
    "samples": samples,
    "leaving_out": features,
    "triangles": triangles,
    "first_ray": first_ray,
    "lights": lights,
}
