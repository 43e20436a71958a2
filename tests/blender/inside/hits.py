# SPDX-License-Identifier: GPL-3.0-or-later
"""Which Embree answers inside Blender, and what it says: ``blender -b --python hits.py -- FILE.json``."""

from __future__ import annotations

import importlib
import json
import sys
from pathlib import Path

import numpy as np

CORE = "bl_ext.user_default.zraka.core"

accel = importlib.import_module(f"{CORE}.accel")
Arena = importlib.import_module(f"{CORE}.arena").Arena
Geometry = importlib.import_module(f"{CORE}.geometry").Geometry
compile_geometry = importlib.import_module(f"{CORE}.compile.geometry").compile_geometry
description = importlib.import_module(f"{CORE}.scene")


def answers(native):
    """First hits of random rays on random triangles and spheres, and whether the C API was used."""
    rng = np.random.default_rng(1)
    corners = rng.uniform(-1, 1, (500, 1, 3)) + rng.uniform(-0.2, 0.2, (500, 3, 3))
    geometry = Geometry.from_arrays(
        triangles=np.float32(corners),
        centers=np.float32(rng.uniform(-1, 1, (20, 3))),
        radii=np.float32(rng.uniform(0.05, 0.2, 20)),
    )
    tree = accel.Accel(geometry, native=native)
    o, d = np.float32(rng.uniform(-2, 2, (3, 20000))), np.float32(rng.normal(size=(3, 20000)))
    arena = Arena()
    hits = tree.intersect(o, d, None, arena)
    blocked = tree.occluded(o, d, None, arena)
    return tree.native, hits.t.copy(), hits.prim.copy(), blocked.copy()


def tube():
    """Distances at which a ray meets a strand of radius 0.1 from 1 m above its middle, and from its middle."""
    strand = description.Curves([(x, 0, 0) for x in range(5)], np.full(5, 0.1), [5])
    geometry = compile_geometry(description.Scene(description.Camera(np.eye(4)), curves=(strand,)))
    o = np.float32([[0.2, 0, 1], [0.2, 0, 0]]).T.copy()
    hits = accel.Accel(geometry).intersect(o, np.float32([[0], [0], [-1]]), None, Arena())
    return [float(t) if prim >= 0 else None for t, prim in zip(hits.t, hits.prim, strict=True)]


native, t, prim, blocked = answers(native=True)
_, plain_t, plain_prim, plain_blocked = answers(native=False)
same = prim == plain_prim
maps = Path("/proc/self/maps").read_text(encoding="utf-8").split()
facts = {
    "native": native,
    "hit": float((prim >= 0).mean()),
    "same_prim": float(same.mean()),
    "same_blocked": float((blocked == plain_blocked).mean()),
    "blocked_agrees": float((blocked == (prim >= 0)).mean()),
    "largest_difference": float(np.max(np.abs(t - plain_t)[same & (prim >= 0)])),
    "tube": tube(),
    "global_scope": accel._loaded_library()._name is None,
    "embree": sorted({Path(name).name for name in maps if "libembree" in name}),
    "embreex": accel.embreex.__file__,
    "numpy": np.__file__,
}
Path(sys.argv[-1]).write_text(json.dumps(facts), encoding="utf-8")
