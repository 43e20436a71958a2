# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes `energy.npz`: ``python -m zraka.core.bsdf.energy_tables``, about a minute."""

from __future__ import annotations

import os

import numpy as np

from ..arena import Arena
from . import dielectric, glass, glossy

_POINTS = 1 << 13
_LEAST_COSINE = 1e-3


def _points(count):
    """Points of the unit cube with low discrepancy, (3, count). Source: Roberts' R3 sequence."""
    root = 1.2207440846057596
    steps = np.array([root**-1, root**-2, root**-3])[:, None]
    return ((0.5 + steps * np.arange(count)) % 1.0).astype(np.float32)


def directional_albedo(lobe, params, cosine, arena, points=_POINTS):
    """Mean sample weight of `lobe` seen at `cosine`, (3,)."""
    with arena.frame():
        return _weights(lobe, params, cosine, arena, points).mean(axis=1, dtype=np.float64)


def _weights(lobe, params, cosine, arena, points=_POINTS):
    """Sample weights, (3, points)."""
    u0, u1, uc = _points(points)
    up = np.zeros((3, points), np.float32)
    up[2] = 1.0
    wo = np.zeros((3, points), np.float32)
    wo[0], wo[2] = np.sqrt(1.0 - cosine * cosine), cosine
    return np.broadcast_to(lobe.sample(params, up, wo, uc, u0, u1, arena).weight, (3, points))


def _table(size, entry):
    """Table over (roughness, cosθ) of `entry(alpha, cosine)`."""
    axis = np.linspace(0.0, 1.0, size)
    return [[entry(np.float32([r * r]), max(float(mu), _LEAST_COSINE)) for mu in axis] for r in axis]


def make():
    """The tables by name, see `energy`; all but ``glass_inside``."""
    arena = Arena()

    def ior(z):
        return np.float32([(1.0 + z * z) / max(1.0 - z * z, 1e-3)])

    def reflection(alpha, cosine):
        return directional_albedo(glossy.Rough, {"alpha": alpha}, cosine, arena)[0]

    def transmission(eta):
        return lambda alpha, cosine: directional_albedo(glass.Rough, {"alpha": alpha, "eta": eta}, cosine, arena)[0]

    def interpolation(eta):
        f0 = np.float32([[0.0], [1.0], [1.0]])  # channel 0 is s alone, channel 1 the lobe without Fresnel

        def entry(alpha, cosine):
            params = {"alpha": alpha, "eta": eta, "f0": f0}
            with arena.frame():
                s, full, _ = _weights(dielectric.Rough, params, cosine, arena)
                return np.divide(s, full, out=np.zeros_like(s), where=full > 0.0).mean(dtype=np.float64)

        return entry

    axis = np.linspace(0.0, 1.0, 16)
    axis[0] = 1e-3
    return {
        "reflection": np.float32(_table(32, reflection)),
        "glass": np.float32([_table(16, transmission(ior(z))) for z in axis]),
        "schlick": np.float32([_table(16, interpolation(ior(z))) for z in axis]),
    }


def main():
    """Write the tables beside those that are not made here."""
    path = os.path.join(os.path.dirname(__file__), "energy.npz")
    with np.load(path) as stored:
        kept = {name: stored[name] for name in stored.files}
    np.savez_compressed(path, **(kept | make()))


if __name__ == "__main__":
    main()
