# SPDX-License-Identifier: GPL-3.0-or-later
"""What materials cost: many of one structure, and a texture."""

from __future__ import annotations

import numpy as np

from . import scenes
from .engines import median

SAMPLES = 16
_SIDE = 20  # tiles along each side of the floor
_KINDS = ("diffuse", "one principled", "200 principled", "textured principled")


def materials(bench, plan, folder):
    """Time of Zraka's path tracing of a tiled floor over its materials, each over that of a diffuse one."""
    cases = {kind: {"side": "zraka", "samples": SAMPLES} for kind in _KINDS}
    seconds = {kind: [] for kind in _KINDS}
    for _ in range(plan.runs):
        for kind, case in cases.items():
            scene = _floor(kind)
            scene.render.resolution_percentage = plan.percentage
            seconds[kind].append(median(bench.alternate(scene, {kind: case}, 1)[kind]))
    best = {kind: float(np.median(times)) for kind, times in seconds.items()}
    return {"seconds": best, "over_diffuse": {kind: best[kind] / best["diffuse"] for kind in _KINDS}}


def _floor(kind):
    """Tiles under a lamp that fill the picture."""
    parts = scenes.sample_parts()
    scene = parts.new_file(1024, 1024, samples=SAMPLES, depth=3)
    made = _materials(parts, kind)
    at = np.arange(_SIDE) - _SIDE / 2
    for number, (x, y) in enumerate((x, y) for x in at for y in at):
        corners = ((x, y, 0), (x + 1, y, 0), (x + 1, y + 1, 0), (x, y + 1, 0))
        parts.quad(f"Tile {number}", corners, made[number % len(made)], (1, 1))
    parts.light("Lamp", "AREA", 2000.0, (0, 0, 12), (0, 0, 0), size=3.0)
    parts.world((0.2, 0.2, 0.2))
    parts.camera((0, 0, 18), (0, 0.001, 0), fov=50)
    return scene


def _materials(parts, kind):
    rng = np.random.default_rng(1)
    if kind == "diffuse":
        return [parts.diffuse("Diffuse", (0.6, 0.5, 0.4))]
    if kind == "textured principled":
        return [parts.principled("Picture", parts.image("noise", rng.random((64, 64, 3))), roughness=0.4)]
    count = 200 if kind == "200 principled" else 1
    looks = zip(rng.random((count, 3)), rng.uniform(0.1, 1.0, count), strict=True)
    return [parts.principled(f"Look {k}", tuple(c), roughness=float(r)) for k, (c, r) in enumerate(looks)]
