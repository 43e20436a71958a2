# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures Cycles' sheen and writes core/bsdf/sheen.npz: ``python -m tests.addon.nodes.measure_sheen``.

Cycles' sheen is a linearly transformed cosine (see `core/bsdf/sheen.py`). Under a sun without extent its value for a
pair of directions is seen without noise, and four suns determine the transform: with z the cosine to the sun,

    sqrt(z/f) = c (a² (x² + y²) + 2ab xz + (b² + 1) z²),   c = sqrt(π/R)/a

is linear in c a², 2c ab and c (b² + 1).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .slope import Slope

TABLE = Path(__file__).resolve().parents[3] / "core" / "bsdf" / "sheen.npz"
SIZE = 32
_LEAST_ROUGHNESS = 1e-3  # Cycles' own limit
_HALF_CELL = 0.5 / (SIZE - 1)
_SUNS = np.array(
    [(0.0, 0.0, 1.0), (0.8, 0.0, 0.6), (-0.8, 0.0, 0.6), (0.0, 0.8, 0.6), (0.3, -0.3, 0.5), (0.6, 0.6, 0.2)]
)


def sheen(roughness):
    """A builder of the Sheen node."""

    def build(tree, plane):
        node = tree.nodes.new("ShaderNodeBsdfSheen")
        node.distribution = "MICROFIBER"
        node.inputs["Color"].default_value = (1, 1, 1, 1)
        node.inputs["Roughness"].default_value = roughness
        return node.outputs[0]

    return build


def measure(cosines, roughnesses):
    """(a, b, R) of the sheen seen at `cosines` (C,), (3, roughnesses, C)."""
    slope = Slope([sheen(r) for r in roughnesses], width=1, rows=4)
    found = np.zeros((3, len(roughnesses), len(cosines)))
    suns = _SUNS / np.linalg.norm(_SUNS, axis=1, keepdims=True)
    x, y, z = suns.T
    system = np.stack((x * x + y * y, x * z, z * z), axis=1)
    for column, cosine in enumerate(cosines):
        slope.tilt(np.degrees(np.arccos(cosine)))
        sine = np.sqrt(1 - cosine * cosine)
        normal, along = np.array((0.0, -sine, cosine)), np.array((0.0, cosine, sine))
        across = np.cross(normal, along)
        f = np.empty((len(suns), len(roughnesses)))
        for row, (u, v, w) in enumerate(suns):
            slope.add_sun(u * along + v * across + w * normal)
            f[row] = slope.render("CYCLES")[:, 0]
        for row in range(len(roughnesses)):
            if (f[:, row] > 0).all():
                found[:, row, column] = _solve(system, np.sqrt(z / f[:, row]))
    return found


def _solve(system, root):
    """(a, b, R) from the values of sqrt(z/f)."""
    (p, q, r), residual, _, _ = np.linalg.lstsq(system / root[:, None], np.ones(len(root)), rcond=None)
    assert residual.size == 0 or residual[0] < 1e-4, residual
    shear = q / (2 * p)
    a = 1 / np.sqrt(r / p - shear * shear)
    c = p / (a * a)
    return a, shear * a, np.pi / (c * a) ** 2


def main():
    """Write the table of a, b and R over (roughness, cosθ), each axis from 0 to 1 in equal steps."""
    steps = np.linspace(0.0, 1.0, SIZE)
    cosines, roughnesses = steps.copy(), steps.copy()
    cosines[0], roughnesses[0] = _HALF_CELL, _LEAST_ROUGHNESS
    table = measure(cosines, roughnesses)
    # What is seen at an angle of less than 90° and above the least roughness lies between two entries of Cycles' table.
    table[:, :, 0] = 2 * table[:, :, 0] - table[:, :, 1]
    share = _LEAST_ROUGHNESS * (SIZE - 1)
    table[:, 0] = (table[:, 0] - share * table[:, 1]) / (1 - share)
    # Where there is next to nothing, Cycles shows none: the transform is the next one's towards the horizon.
    for column in range(1, SIZE):
        empty = table[0, :, column] <= 0
        table[:2, empty, column] = table[:2, empty, column - 1]
    np.savez_compressed(TABLE, ltc=table.astype(np.float32))


if __name__ == "__main__":
    main()
