# SPDX-License-Identifier: GPL-3.0-or-later
"""Time to equal error: two engines on one scene.

Every engine renders a reference of its own, from seeds that no timed render has, with at least 16 times the samples of
the ladder's last rung. The two references must agree (`core.report.error.agreement`), else the scene is flagged. The
error of an engine is then measured against the *other* engine's reference: so no picture is compared with one that its
own engine made, and where the two differ by more than noise the difference counts against both alike. The noise of the
reference is subtracted. Its own runs, each against the other engine's reference, are one rung more.
"""

from __future__ import annotations

import numpy as np

from ...core.report.error import Convergence, agreement, geometric_mean, noise, power, relative_rmse, weights
from .engines import median, open_blend, size_of
from .memory import peak_memory

TARGETS = {"5%": 0.05, "2%": 0.02}
AGREE = 0.99


def compare(bench, path, plan):
    """Measure both engines on a scene.

    Returns
    -------
    dict
        As it stands in ``bench.json`` under the scene's name.
    """
    scene = open_blend(path, plan.percentage)
    bench.run(scene, bench.other)
    warm = bench.run(scene, "zraka")
    result = {"size": size_of(scene), "depth": scene.zraka.depth, "flags": list(warm.seen.messages)}

    ladder = _ladder(bench, scene, plan)
    references = _references(bench, scene, plan)
    runs = {side: np.stack([run.picture for run in references[side]]) for side in bench.sides}
    result["references"] = _judge(runs, bench.other)
    if result["references"]["agreement"] < AGREE:
        if warm.seen.messages:  # a diagnostic alone, of a triangle without area, makes no other picture
            result["not_supported"] = warm.seen.messages
            result["flags"].append("not supported yet, and left out of the mean")
        result["flags"].append(f"references differ: {result['references']['agreement']:.1%} of the blocks agree")

    weight = weights(np.mean([r.mean(axis=0) for r in runs.values()], axis=0))
    pairs = ("zraka", bench.other), (bench.other, "zraka")
    for side, judge in pairs:
        rungs = {n: ladder[side, n] for n in plan.ladder} | {plan.reference // plan.reference_runs: references[side]}
        result[side] = _side(rungs, runs[judge], weight, scene)
        result[side] |= peak_memory(path, bench.sides[side], plan.percentage, bench.threads)
    result["ratios"] = _ratios(result["zraka"], result[bench.other])
    return result


def _ladder(bench, scene, plan):
    cases = {(side, n): {"side": side, "samples": n} for n in plan.ladder for side in bench.sides}
    return bench.alternate(scene, cases, plan.runs, warm=False)


def _references(bench, scene, plan):
    cases = {side: {"side": side, "samples": plan.reference // plan.reference_runs} for side in bench.sides}
    return bench.alternate(scene, cases, plan.reference_runs, warm=False)


def _judge(runs, other):
    ours, theirs = runs["zraka"], runs[other]
    return {
        "agreement": agreement(ours, theirs),
        "telling": power(ours, theirs),  # share of the blocks in which a shift of 5% would show
        "brightness": float(ours.mean() / theirs.mean()) if theirs.any() else None,
    }


def _side(rungs, reference, weight, scene):
    """Errors, times and rates of one engine; `rungs` maps samples to runs."""
    rows = [_rung(n, runs, reference, weight) for n, runs in rungs.items()]
    longest, pixels = list(rungs.values())[-1], float(np.prod(size_of(scene)))
    seconds = rows[-1]["seconds"]
    result = {"rungs": rows, "samples_per_second": pixels * rows[-1]["samples"] / seconds}
    result |= _own(longest, seconds)
    usable = [row for row in rows if row["error"] > 0]
    if len(usable) < 2:  # noise-free to within the reference's noise
        return result | {"slope": None, "fixed_seconds": None, "seconds_to": {}}
    curve = Convergence(*([row[key] for row in usable] for key in ("samples", "error", "seconds")))
    return result | {
        "slope": curve.slope,
        "fixed_seconds": curve.time.start,
        "seconds_to": {name: curve.reach(error)._asdict() for name, error in TARGETS.items()},
    }


def _rung(samples, runs, reference, weight):
    def error(**kwargs):
        squares = [relative_rmse(run.picture, reference, weight, **kwargs) ** 2 for run in runs]
        return float(np.sqrt(np.mean(squares)))

    return {
        "samples": samples,
        "runs": [run.seconds for run in runs],
        "seconds": median(runs),
        "error": error(),
        "error_with_fireflies": error(trim=0.0),
        "reference_noise": float(np.sqrt(noise(reference, weight) / len(reference))),
    }


def _own(runs, seconds):
    """What Zraka says of itself; nothing of another engine."""
    stats = runs[-1].seen.stats
    if not stats:
        return {}
    seen = [run.seen for run in runs]
    export, compiling = (float(np.median([getattr(s, f"{p}_seconds") for s in seen])) for p in ("export", "compile"))
    return {
        "rays_per_second": sum(stats["rays"].values()) / seconds,
        "rays": dict(stats["rays"]),
        "embree_share": float(np.median([s.stats["embree_seconds"] for s in seen])) / seconds,
        "trace_seconds": float(np.median([s.stats["seconds"] for s in seen])),
        "export_seconds": export,
        "compile_seconds": compiling,
        "build_seconds": export + compiling,
    }


def _ratios(ours, theirs):
    """The other engine's seconds over Zraka's, so that above 1 is Zraka's favour; of the rates the other way."""
    ratios = {"samples_per_second": ours["samples_per_second"] / theirs["samples_per_second"]}
    for name in TARGETS:
        a, b = (side["seconds_to"].get(name, {}).get("seconds") for side in (ours, theirs))
        finite = a and b and np.isfinite([a, b]).all()
        ratios[name] = b / a if finite else None
    return ratios


def overall(scenes, target):
    """Geometric mean of the ratios of those scenes that Zraka supports."""
    return geometric_mean([s["ratios"][target] for s in scenes.values() if "not_supported" not in s])
