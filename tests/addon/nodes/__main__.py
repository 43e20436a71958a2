# SPDX-License-Identifier: GPL-3.0-or-later
"""Compare every node with Cycles and write docs/nodes.md: ``python -m tests.addon.nodes``."""

from __future__ import annotations

import importlib
from pathlib import Path

import bpy

from . import test_probe
from .harness import SIZE, difference

HERE = Path(__file__).resolve().parent
PAGE = HERE.parents[2] / "docs" / "nodes.md"


def cases_by_family():
    """Title of each family to its cases, from the ``CASES`` of this folder's tests."""
    found = {}
    for path in sorted(HERE.glob("test_*.py")):
        module = importlib.import_module(f".{path.stem}", __package__)
        if isinstance(getattr(module, "CASES", None), list):  # those of nodes that cast rays have noise
            found[path.stem.removeprefix("test_").replace("_", " ").capitalize()] = module.CASES
    return found


def rows(cases):
    """Lines of a table: node, number of modes, largest difference, largest share beyond the tolerance."""
    nodes = {}
    for case in cases:
        try:
            nodes.setdefault(case.node, []).append((*difference(case), case))
        except AssertionError as error:
            print(f"FAILED {error}", flush=True)
            nodes.setdefault(case.node, []).append((float("nan"), 1.0, case))
    for node, measured in nodes.items():
        worst = max(measured, key=lambda m: (m[1] > m[2].share, m[1], m[0]))
        share = f"{worst[1]:.2%}" if worst[1] else "none"
        mode = worst[2].name.partition(":")[2].strip()
        yield f"| {node} | {len(measured)} | {worst[0]:.1e} | {mode} | {share} | {worst[2].tolerance:g} |"
        print(node, f"{worst[0]:.1e}", share, flush=True)


def probed():
    """Lines on the nodes that cast rays, whose noise is averaged out over blocks."""
    block, samples = test_probe.BLOCK, test_probe.SAMPLES
    yield "## Nodes that cast rays"
    yield ""
    yield f"Ambient Occlusion and Bevel have noise: means of blocks of {block} × {block} pixels of {samples} samples,"
    yield "from 0 to 1 (`pytest tests/addon/nodes/test_probe.py`)."
    yield ""
    yield "| mode | largest difference | mean | tolerance of the largest |"
    yield "| --- | ---: | ---: | ---: |"
    for name, (build, other, tolerance) in test_probe.CASES.items():
        apart, _ = test_probe.apart(test_probe.scene_of(build, other))
        yield f"| {name} | {apart.max():.1e} | {apart.mean():.1e} | {3 * tolerance:g} |"


def main():
    """Write the page."""
    lines = [
        "# Nodes beside Cycles",
        "",
        f"Each mode of a node is shown by a plane that emits its output, {SIZE} × {SIZE} pixels without noise, in",
        f"Zraka and in Cycles of Blender {bpy.app.version_string}. The difference is the largest of any channel of any",
        "pixel in the node's worst mode; beside it the share of pixels beyond the tolerance.",
        "",
        "`python -m tests.addon.nodes` writes this page; `pytest tests/addon/nodes` tests the same cases.",
        "",
        "A ray exactly through the side that two triangles share may meet either of them, so parametric coordinates",
        "are compared beside such sides. Without a UV map Blender maps a sphere, whose tangents cancel at the poles.",
        "What Cycles takes there is rounding noise, seen in the triangles around: as a ball's mesh was turned about",
        "its axis by 0°, 15°, 30° and 45°, the tangent at its pole pointed to 148°, 87°, 135° and -83°.",
    ]
    for title, cases in cases_by_family().items():
        lines += ["", f"## {title}", ""]
        lines += ["| node | modes | largest difference | in mode | pixels beyond | tolerance |"]
        lines += ["| --- | ---: | ---: | --- | ---: | ---: |", *rows(cases)]
    lines += ["", *probed()]
    PAGE.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
