# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures what Cycles believes rough glass to lose, seen from within: ``python -m tests.addon.nodes.measure_glass``.

Cycles divides "Multiscatter GGX" of white glass by a tabulated albedo of its "GGX". From outside that is the albedo;
from within, at grazing angles, it is more than what its GGX returns, so some light stays lost. Both distributions draw
the same samples, so the quotient of two pictures has no noise. Writes ``glass_inside`` of core/bsdf/energy.npz.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .slope import Slope

TABLES = Path(__file__).resolve().parents[3] / "core" / "bsdf" / "energy.npz"
SIZE = 16
_CELL = 1 / (SIZE - 1)


def glass(roughness, ior, distribution):
    """A builder of white glass."""

    def build(tree, plane):
        node = tree.nodes.new("ShaderNodeBsdfGlass")
        node.distribution = distribution
        node.inputs["Color"].default_value = (1, 1, 1, 1)
        node.inputs["Roughness"].default_value, node.inputs["IOR"].default_value = roughness, ior
        return node.outputs[0]

    return build


def measure(index, roughnesses, cosines):
    """Albedo (roughnesses, cosines) from within glass whose index has the coordinate sqrt((η - 1)/(η + 1))."""
    ior = (1 + index**2) / (1 - index**2)
    seen = []
    for distribution in ("GGX", "MULTI_GGX"):
        slope = Slope([glass(r, ior, distribution) for r in roughnesses], width=1, rows=4, below=True)
        columns = []
        for cosine in cosines:
            slope.tilt(np.degrees(np.arccos(cosine)))
            columns.append(slope.render("CYCLES", samples=4)[:, 0])
        seen.append(np.transpose(columns))
    return seen[0] / seen[1]


def extended(measured, axis, share, first):
    """Replace an end of `axis`, measured `share` of a cell within the table, by what lies at the end itself."""
    end, next_ = (0, 1) if first else (-1, -2)
    at, inner = np.take(measured, end, axis), np.take(measured, next_, axis)
    out = np.moveaxis(measured, axis, 0)
    out[end] = (at - share * inner) / (1 - share)


def main():
    """Measure and write the table."""
    steps = np.linspace(0, 1, SIZE)
    indices, roughnesses, cosines = steps.copy(), steps.copy(), steps.copy()
    # Not at the ends: equal and infinite indices, polished glass and the horizon show nothing.
    indices[0], indices[-1] = 0.5 * _CELL, 1 - 0.5 * _CELL
    roughnesses[0], cosines[0] = 0.6 * _CELL, 0.5 * _CELL
    table = np.stack([measure(z, roughnesses, cosines) for z in indices])
    extended(table, 0, 0.5, first=True)
    extended(table, 0, 0.5, first=False)
    extended(table, 1, 0.6, first=True)
    extended(table, 2, 0.5, first=True)
    with np.load(TABLES) as stored:
        tables = {name: stored[name] for name in stored.files}
    tables["glass_inside"] = np.clip(table, 0.01, 1.0).astype(np.float32)
    np.savez_compressed(TABLES, **tables)


if __name__ == "__main__":
    main()
