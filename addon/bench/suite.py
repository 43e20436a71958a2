# SPDX-License-Identifier: GPL-3.0-or-later
"""A whole bench: all scenes, all studies, and the files they end up in."""

from __future__ import annotations

import datetime
import json
import time

from ...core.diagnostics import SceneError
from .. import headless
from ..machine import finite, load, machine, make_folder, versions
from . import convergence, document, full_size, materials, scaling, scenes, thesis
from .engines import Bench, Interrupted
from .memory import peak_memory

THREADS = 2
AGAINST = {"CYCLES": "cycles", "ZRAKA": "again"}


def run(suite, against, folder, interrupted=lambda: False, say=lambda text: None):
    """Measure a suite and write ``bench.json``, ``bench.md`` and plots.

    Parameters
    ----------
    suite : str
        Of `scenes.PLANS`.
    against : str
        Blender's name of the other engine. Zraka against itself tells how steady the machine is.
    folder : Path
        Of the results; made if it is missing.
    interrupted : callable
        Asked after every render; what was measured until then is written.
    say : callable
        Takes a line about how far the run is.

    Returns
    -------
    dict
        As in ``bench.json``.

    Raises
    ------
    SceneError
    """
    make_folder(folder)
    bpy = headless.load_blender()
    plan, started = scenes.PLANS[suite], time.perf_counter()
    bench = Bench({"zraka": "ZRAKA", AGAINST[against]: against}, THREADS, interrupted, say)
    result = _header(bpy, suite, bench.other)
    made = folder / "scenes"
    try:
        for name in plan.scenes:
            say(f"scene {name}")
            result["scenes"][name] = convergence.compare(bench, scenes.find(name, made), plan)
            say(f"scene {name}: time to 5%, ratio {document.number(result['scenes'][name]['ratios']['5%'])}")
            _write(result, folder, started)
        result["studies"]["memory"] = _memory(bench, made)
        studies = full_size.STUDIES | thesis.STUDIES | scaling.STUDIES | {"materials": materials.materials}
        for name, study in studies.items():
            say(f"study {name}")
            result["studies"][name] = study(bench, plan, made)
            _write(result, folder, started)
        result["interrupted"] = False
    except Interrupted:
        say("interrupted; what was measured is written")
    _write(result, folder, started)
    try:
        _append_plots(folder, document.plots(result, folder))
    except ImportError:
        say("no plots: matplotlib is missing; pip install 'zraka[bench]'")
    return result


def _memory(bench, made):
    path = scenes.find("cornell", made)
    return {side: peak_memory(path, name, 100, bench.threads, thesis.FULL_HD) for side, name in bench.sides.items()}


def _header(bpy, suite, other):
    return {
        "geometric_mean": None,
        "geometric_means": {},
        "suite": suite,
        "other": other,
        "threads": THREADS,
        "date": datetime.datetime.now().astimezone().isoformat(timespec="minutes"),
        "seconds": 0.0,
        "interrupted": True,  # until it is whole
        "machine": machine(),
        "versions": versions(bpy),
        "scenes": {},
        "studies": {},
    }


def _write(result, folder, started):
    """Write what there is; after every step, since hours may have gone into it."""
    result["seconds"] = time.perf_counter() - started
    result["geometric_means"] = {t: convergence.overall(result["scenes"], t) for t in convergence.TARGETS}
    result["geometric_mean"] = result["geometric_means"]["5%"]
    result["machine"]["load"][1:] = load()[:1]
    try:
        (folder / "bench.json").write_text(json.dumps(finite(result), indent=2) + "\n", encoding="utf-8")
        (folder / "bench.md").write_text(document.markdown(result), encoding="utf-8")
    except OSError as error:
        raise SceneError(f"{folder} cannot be written: {error.strerror or error}") from error


def _append_plots(folder, names):
    with (folder / "bench.md").open("a", encoding="utf-8") as file:
        file.writelines(f"\n![{name.removesuffix('.png')}]({name})\n" for name in names)
