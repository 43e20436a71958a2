# SPDX-License-Identifier: GPL-3.0-or-later
"""The thesis' own table: what ray tracing costs over ray casting; and what ray casting costs over Embree."""

from __future__ import annotations

import time
from concurrent.futures import ThreadPoolExecutor
from threading import local

import numpy as np

from ...core.arena import Arena
from . import scenes
from .engines import median, open_blend, operate, set_threads, watched

SAMPLES = 4
CASES = {  # scene, depth, Najev 2024, table 4.1: time over that of ray casting
    "depth 1": ("room_open", 1, 1.09),
    "depth 2": ("room_open", 2, 1.62),
    "depth 5, open": ("room_open", 5, 1.79),
    "depth 5, closed": ("room_closed", 5, 3.31),
}
FULL_HD = (1920, 1080)
TURNS = 9  # of what takes a quarter of a second, at least


def raytracing_over_raycasting(bench, plan, folder):
    """Time and rays of ray tracing over those of ray casting of the same scene, at the thesis' 500 × 500."""
    rows = []
    for name, (which, depth, thesis) in CASES.items():
        bench.say(f"ray tracing, {name}")
        scene = open_blend(scenes.find(which, folder))
        runs = {"RAYCAST": [], "RAYTRACE": []}
        for turn in range(plan.runs + 1):
            for method in runs if turn % 2 else reversed(runs):
                scene.zraka.method, scene.zraka.depth = method, depth
                done = bench.run(scene, "zraka", SAMPLES, matched=False)
                if turn:
                    runs[method].append(done)
        cast, traced = runs["RAYCAST"], runs["RAYTRACE"]
        rows.append(
            {
                "case": name,
                "scene": which,
                "depth": depth,
                "raycast_seconds": median(cast),
                "raytrace_seconds": median(traced),
                "time": median(traced) / median(cast),
                "rays": _rays(traced) / _rays(cast),
                "thesis": thesis,
            }
        )
    return rows


def _rays(runs):
    return sum(runs[-1].seen.stats["rays"].values())


# -- ray casting over Embree -------------------------------------------------------------------------------------------


class _Recorder:
    """Stands in for an `Accel` and keeps every query."""

    def __init__(self, accel):
        self._accel = accel
        self.queries = []

    def intersect(self, o, d, tmax, arena, clock=None):
        self._keep("intersect", o, d, tmax)
        return self._accel.intersect(o, d, tmax, arena, clock)

    def occluded(self, o, d, tmax, arena, clock=None):
        self._keep("occluded", o, d, tmax)
        return self._accel.occluded(o, d, tmax, arena, clock)

    def _keep(self, kind, o, d, tmax):
        self.queries.append((kind, o.copy(), d.copy(), None if tmax is None else tmax.copy()))

    @property
    def rays(self):
        return sum(o.shape[1] for _, o, _, _ in self.queries)


def raycasting_over_embree(bench, plan, folder):
    """All of ray casting `thesis` at 1920 × 1080 after its compilation, over the same rays asked of Embree alone.

    The rays are those of one render, kept and asked again by as many threads, in the same pieces, with nothing between
    them. Both are repeated by turns.
    """
    from ...core.render import render

    scene = open_blend(scenes.find("thesis", folder))
    scene.render.resolution_x, scene.render.resolution_y = FULL_HD
    scene.zraka.method, scene.zraka.samples = "RAYCAST", 1
    set_threads(scene, bench.threads)
    with watched(interrupted=bench.interrupted) as seen:
        operate(scene, "ZRAKA")
    compiled, settings = seen.compiled, seen.settings
    accel = compiled.accel
    compiled.accel = recorder = _Recorder(accel)
    try:
        render(compiled, settings)
    finally:
        compiled.accel = accel
    whole, alone, inside = [], [], []
    for turn in range(max(plan.runs, TURNS) + 1):
        started = time.perf_counter()
        film = render(compiled, settings)
        seconds = time.perf_counter() - started
        asked = _ask(accel, recorder.queries, bench.threads)
        if turn:
            whole.append(seconds)
            alone.append(asked)
            inside.append(film.stats["embree_seconds"])
    seconds, embree = float(np.median(whole)), float(np.median(alone))
    return {
        "rays": recorder.rays,
        "seconds": seconds,
        "embree_alone_seconds": embree,
        "embree_inside_seconds": float(np.median(inside)),
        "over_embree": seconds / embree,
    }


def _ask(accel, queries, threads):
    """Seconds that `threads` threads take to ask all queries."""
    own = local()

    def ask(query):
        kind, *rays = query
        if not hasattr(own, "arena"):
            own.arena = Arena()
        with own.arena.frame():
            getattr(accel, kind)(*rays, own.arena)

    with ThreadPoolExecutor(threads) as pool:
        started = time.perf_counter()
        for _ in pool.map(ask, queries):
            pass
        return time.perf_counter() - started


STUDIES = {"thesis": raytracing_over_raycasting, "raycast_over_embree": raycasting_over_embree}
