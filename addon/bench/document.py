# SPDX-License-Identifier: GPL-3.0-or-later
"""A bench's results as Markdown and as plots."""

from __future__ import annotations

from ...core.report.plot import Curve, plot
from ...core.report.table import number, percent, table
from . import full_size
from .convergence import TARGETS

NAMES = {"zraka": "Zraka", "cycles": "Cycles", "again": "Zraka again"}


def markdown(result):
    """The whole text."""
    parts = [_head(result), _scenes(result), _errors(result), _zraka(result)]
    parts += [write(result) for key, write in _STUDIES.items() if key in result["studies"]]
    return "\n\n".join(part for part in parts if part) + "\n"


def summary(result):
    """What is printed: the scenes and the mean."""
    return "\n\n".join(part for part in (_scenes(result), _mean(result)) if part)


# -- scenes ------------------------------------------------------------------------------------------------------------


def _head(result):
    machine = result["machine"]
    load = ", ".join(f"{x:.1f}" for x in machine["load"]) or "unknown"
    state = ["", "**Interrupted: what follows is not whole.**"] if result["interrupted"] else []
    lines = [
        f"# Zraka beside {NAMES[result['other']]}",
        *state,
        "",
        f"Suite `{result['suite']}`, {result['threads']} threads, {result['date']}, {result['seconds']:.0f} s in all. "
        f"{machine['processor']}, {machine['processors']} processors, {machine['system']}; load before and after: "
        f"{load}. " + ", ".join(f"{name} {version}" for name, version in result["versions"].items()) + ".",
        "",
        "Seconds are medians of the wall time of Blender's whole render operator, both engines by turns in one "
        "process, warm, set alike: plain path tracing, box filter of one pixel, no denoising, no clamps, nothing "
        "adaptive. Errors are relative RMSE: |I - R|² / (|R|² + (0.1 mean)²) by pixel, without the thousandth that err "
        "most, against the other engine's reference, less the noise of that reference. An asterisk marks what was "
        "extrapolated along the slope beyond the samples measured; a dagger a scene with a note below.",
    ]
    return "\n".join(lines)


def _scenes(result):
    if not result["scenes"]:
        return ""
    other = NAMES[result["other"]]
    head = ["scene", f"samples/s, Zraka / {other}"]
    for target in TARGETS:
        head += [f"s to {target}, Zraka", other, "ratio"]
    rows = []
    for name, scene in result["scenes"].items():
        row = [name + (" †" if scene["flags"] else ""), scene["ratios"]["samples_per_second"]]
        for target in TARGETS:
            row += [_seconds(scene["zraka"], target), _seconds(scene[result["other"]], target), scene["ratios"][target]]
        rows.append(row)
    notes = [f"† {name}: {flag}" for name, scene in result["scenes"].items() for flag in scene["flags"]]
    return "\n\n".join([table(head, rows), *notes])


def _mean(result):
    means = ", ".join(f"{number(mean)} to {target}" for target, mean in result["geometric_means"].items())
    return f"Time to equal error, {NAMES[result['other']]} / Zraka, geometric mean: {means}."


def _seconds(side, target):
    reach = side["seconds_to"].get(target)
    return None if reach is None else number(reach["seconds"]) + ("*" if reach["extrapolated"] else "")


def _errors(result):
    rows = []
    for name, scene in result["scenes"].items():
        for side in ("zraka", result["other"]):
            found = scene[side]
            last = found["rungs"][-1]
            rows.append(
                [
                    f"{name}, {NAMES[side]}",
                    " ".join(str(r["samples"]) for r in found["rungs"]),
                    " ".join(number(100 * r["error"], 2) for r in found["rungs"]),
                    100 * last["error_with_fireflies"],
                    found["slope"],
                    last["seconds"],
                    found["fixed_seconds"],
                    found["peak_mb"],
                    found["render_mb"],
                ]
            )
    if not rows:
        return ""
    head = "scene, engine|samples|error %|last with fireflies|slope|last s|fixed s|peak MB|of it render".split("|")
    refs = []
    for name, scene in result["scenes"].items():
        (width, height), found = scene["size"], scene["references"]
        shares = percent(found["agreement"]), percent(found["telling"])
        refs.append([name, f"{width} × {height}", *shares, found["brightness"]])
    judged = table(["references", "pixels", "blocks agree", "would tell 5%", "brightness ratio"], refs)
    return f"{_mean(result)}\n\n## Errors\n\n{table(head, rows)}\n\n{judged}"


def _zraka(result):
    rows = [
        [
            name,
            ours["samples_per_second"] / 1e6,
            ours["rays_per_second"] / 1e6,
            percent(ours["embree_share"]),
            ours["trace_seconds"] / ours["rungs"][-1]["seconds"],
            ours["export_seconds"],
            ours["compile_seconds"],
            ours["build_seconds"],
        ]
        for name, ours in ((name, scene["zraka"]) for name, scene in result["scenes"].items())
    ]
    head = "scene|M samples/s|M rays/s|Embree of wall|tracing of wall|export s|compile s|build s".split("|")
    return "## Zraka itself\n\n" + table(head, rows) if rows else ""


# -- studies -----------------------------------------------------------------------------------------------------------


def _full_size(result):
    other = result["other"]
    rows = [
        [row["scene"], row["seconds"]["zraka"], row["seconds"][other], row["faster"], percent(row["embree_share"])]
        for row in result["studies"]["full_size"]
    ]
    head = ["scene", "Zraka s", f"{NAMES[other]} s", f"samples/s, Zraka / {NAMES[other]}", "Embree of wall"]
    return f"## {full_size.SAMPLES} samples at full size\n\n" + table(head, rows)


def _threads(result):
    found = result["studies"]["threads"]
    rows = [
        [NAMES[side], *times["seconds"].values(), times["gain"], times["gain_after_another"]]
        for side, times in found.items()
    ]
    head = ["engine", "1 thread s", "2 threads s", "gain", "gain, each after a render of another kind"]
    return "## Threads, `cornell` at full size\n\n" + table(head, rows)


def _samples(result):
    found = result["studies"]["samples"]
    rows = list(zip(found["samples"], found["seconds"], strict=True))
    start, each, r2 = found["line"].values()
    text = f"Line: {start:.3g} s + {each:.3g} s a sample, R² {r2:.5f}."
    return f"## Samples\n\n{table(['samples', 's'], rows)}\n\n{text}"


def _leaving_out(result):
    found = result["studies"]["leaving_out"]
    rows = [["cornell", found["own_seconds"], found["all_seconds"], found["gain"]]]
    return "## Leaving out\n\n" + table(["scene", "own stages s", "all stages s", "gain"], rows)


def _growth(key, title, figure, extra):
    def write(result):
        other, rows = result["other"], []
        for row in result["studies"][key]:
            ours, theirs = row["zraka"][figure], row[other][figure]
            rows.append([row[key], ours, theirs, theirs / ours, row["zraka"][extra[0]]])
        return f"## {title}\n\n" + table([key, "Zraka s", f"{NAMES[other]} s", "ratio", extra[1]], rows)

    return write


def _first_ray(result):
    rows = [
        [row["triangles"], row["shading"], *row["seconds"].values(), row["over_tree"]]
        for row in result["studies"]["first_ray"]
    ]
    head = ["triangles", "shading", "export s", "tables s", "Embree's tree s", "all over tree"]
    return "## From Blender's mesh to the first ray\n\n" + table(head, rows)


def _materials(result):
    found = result["studies"]["materials"]
    rows = [[kind, seconds, found["over_diffuse"][kind]] for kind, seconds in found["seconds"].items()]
    return "## Materials of a tiled floor\n\n" + table(["material", "s", "over diffuse"], rows)


def _thesis(result):
    rows = [[r["case"], r["time"], r["rays"], r["thesis"]] for r in result["studies"]["thesis"]]
    head = ["ray tracing over ray casting", "time", "rays", "time, the thesis"]
    return "## The thesis' table\n\n" + table(head, rows)


def _embree(result):
    found = result["studies"]["raycast_over_embree"]
    head = ["ray casting `thesis`", "rays", "all s", "Embree alone s", "Embree inside s", "all over alone"]
    row = ["1920 × 1080", found["rays"], found["seconds"]]
    row += [found["embree_alone_seconds"], found["embree_inside_seconds"], found["over_embree"]]
    return "## Ray casting over Embree\n\n" + table(head, [row])


def _memory(result):
    rows = [[NAMES[s], m["peak_mb"], m["render_mb"]] for s, m in result["studies"]["memory"].items()]
    return "## Memory, `cornell` at 1920 × 1080\n\n" + table(["engine", "peak MB", "of it render"], rows)


_STUDIES = {
    "memory": _memory,
    "full_size": _full_size,
    "threads": _threads,
    "samples": _samples,
    "leaving_out": _leaving_out,
    "triangles": _growth("triangles", "Triangles", "seconds", ("build_seconds", "Zraka's building s")),
    "first_ray": _first_ray,
    "lights": _growth("lights", "Lights, time to 5%", "seconds_to_5%", ("error", "Zraka's error at 8 samples")),
    "thesis": _thesis,
    "raycast_over_embree": _embree,
    "materials": _materials,
}


# -- plots -------------------------------------------------------------------------------------------------------------


def plots(result, folder):
    """Draw what there is into PNG files in `folder`.

    Returns
    -------
    list of str
        Names of the files.

    Raises
    ------
    ImportError
        Where matplotlib is not installed.
    """
    return [_draw(folder, *job) for job in _jobs(result)]


def _draw(folder, name, *job):
    plot(folder / name, *job)
    return name


def _jobs(result):
    sides = ("zraka", result["other"])
    for name, scene in result["scenes"].items():
        curves = [
            Curve(NAMES[s], *([r[key] for r in scene[s]["rungs"]] for key in ("seconds", "error"))) for s in sides
        ]
        yield f"error-{name}.png", curves, f"{name}: error over time", "seconds", "relative RMSE"
    studies = result["studies"]
    for key, figure in (("triangles", "seconds"), ("lights", "seconds_to_5%")):
        if key in studies:
            rows = studies[key]
            curves = [Curve(NAMES[s], [r[key] for r in rows], [r[s][figure] for r in rows]) for s in sides]
            yield f"{key}.png", curves, f"Time over {key}", key, figure.replace("_", " ")
    if "samples" in studies:
        found = studies["samples"]
        fit = [found["line"]["start"] + found["line"]["each"] * n for n in found["samples"]]
        curves = [Curve("measured", found["samples"], found["seconds"]), Curve("line", found["samples"], fit)]
        yield "samples.png", curves, "Time over samples", "samples", "seconds", False
