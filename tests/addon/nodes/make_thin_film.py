# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes core/bsdf/thin_film.npz, what the eye makes of interference: ``python -m tests.addon.nodes.make_thin_film``.

For each of red, green and blue (Rec.709) the Fourier transform of its matching function over wave numbers,
∫ m(λ) exp(-2πi D/λ) dλ, over its value for D = 0, at optical path differences D in equal steps: real and imaginary
parts, (2, 3, 512). Steps are as long as Cycles', whose linear interpolation is seen: its table spans 60 µm of angular
frequency.

Source: Belcour and Barla, "A Practical Extension to Microfacet Theory for the Modeling of Varying Iridescence",
SIGGRAPH 2017; the CIE's 1931 matching functions as in `core/nodes/wavelength.py`.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

from zraka.core.nodes import wavelength

TABLE = Path(__file__).resolve().parents[3] / "core" / "bsdf" / "thin_film.npz"
SIZE = 512
STEP = 60_000 / (2 * np.pi * (SIZE - 1))  # nm
_FINE = 0.25  # nm


def transforms():
    """(2, 3, SIZE) float64."""
    match = np.asarray(wavelength._MATCH, np.float64)
    nodes = wavelength._FIRST + wavelength._STEP * np.arange(len(match))
    fine = np.arange(nodes[0], nodes[-1], _FINE)
    colors = wavelength._XYZ_TO_RGB @ CubicSpline(nodes, match)(fine).T
    difference = STEP * np.arange(SIZE)
    waves = np.exp(-2j * np.pi * difference[:, None] / fine)
    found = (waves @ colors.T).T
    found /= found[:, :1].real
    return np.stack((found.real, found.imag))


if __name__ == "__main__":
    np.savez_compressed(TABLE, sensitivity=transforms().astype(np.float32), step=np.float32(STEP))
