# SPDX-License-Identifier: GPL-3.0-or-later
"""Fractal sums and products of Perlin noise.

Source: F. K. Musgrave in Ebert et al., "Texturing and Modeling" (2003), chapter 16; how octaves are weighted and where
the series ends is Blender's (intern/cycles/kernel/svm/fractal_noise.h). A detail that is no whole number blends the
last octave in, except for the ridged kind, which leaves it out.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..vecmath import lanes
from .perlin import BLOCK, signed_noise

_MOST_DETAIL = 15.0


@dataclass
class Fractal:
    """What a fractal is made of; numbers are float32 (1,) or (N,).

    Parameters
    ----------
    kind : str
        Blender's name, e.g. ``"FBM"``.
    detail : array
        Octaves after the first, up to 15.
    roughness, lacunarity : array
        Factors of amplitude and of frequency from one octave to the next.
    offset, gain : array
        Of the kinds after Musgrave.
    normalize : bool
        Whether FBM is mapped to [0, 1].
    """

    kind: str
    detail: np.ndarray
    roughness: np.ndarray
    lacunarity: np.ndarray
    offset: np.ndarray = None
    gain: np.ndarray = None
    normalize: bool = True

    def __post_init__(self):
        self.detail = np.fmin(np.fmax(self.detail, np.float32(0)), np.float32(_MOST_DETAIL))
        self.roughness = np.fmax(self.roughness, np.float32(0))

    @property
    def numbers(self):
        """The numbers by name."""
        return {name: v for name, v in vars(self).items() if isinstance(v, np.ndarray)}

    def at(self, chosen):
        """The same of a slice of the lanes."""
        return replace(self, **{name: v[chosen] for name, v in self.numbers.items() if v.size > 1})

    def octaves(self):
        """Share of each octave: 1, and the fraction that is left of the last."""
        least, most = float(self.detail.min()), float(self.detail.max())
        for number in range(int(np.ceil(most)) + 1):
            yield np.float32(1) if number <= least else np.clip(self.detail - (number - 1), 0, 1)


def evaluate(fractal, p, arena):
    """The fractal at points `p` (D, N), (N,), block by block."""
    n = lanes(p, *fractal.numbers.values())
    p = np.broadcast_to(p, (p.shape[0], n))
    out = arena.empty(n)
    with np.errstate(over="ignore", invalid="ignore"):
        for start in range(0, n, BLOCK):
            block = slice(start, min(start + BLOCK, n))
            with arena.frame():
                # Each octave scales its own copy of the points in place.
                q = arena.empty((p.shape[0], block.stop - start))
                np.copyto(q, p[:, block])
                _KINDS[fractal.kind](fractal.at(block), q, out[block], arena)
    return out


def _fbm(fractal, p, out, arena):
    """Sum of octaves; normalised, by the sum of their amplitudes."""
    out.fill(0)
    total, q, scaled = arena.zeros(out.size), arena.empty(p.shape), arena.empty(out.size)
    frequency = amplitude = np.ones(1, np.float32)
    reach = np.zeros(1, np.float32)
    for share in fractal.octaves():
        with arena.frame():
            noise = signed_noise(np.multiply(p, frequency, out=q), arena)
            np.add(total, np.multiply(noise, amplitude, out=noise), out=total)
        reach = reach + amplitude
        np.multiply(total, np.float32(0.5) / reach if fractal.normalize else np.float32(1), out=scaled)
        if fractal.normalize:
            np.add(scaled, 0.5, out=scaled)
        _blend(out, scaled, share)
        frequency, amplitude = frequency * fractal.lacunarity, amplitude * fractal.roughness


def _multifractal(fractal, p, out, arena):
    """Product of octaves about 1."""
    out.fill(1)
    power = np.ones(1, np.float32)
    for share in fractal.octaves():
        with arena.frame():
            noise = signed_noise(p, arena)
            np.multiply(noise, power * share, out=noise)
            np.add(noise, 1, out=noise)
            np.multiply(out, noise, out=out)
        power = power * fractal.roughness
        np.multiply(p, fractal.lacunarity, out=p)


def _hetero_terrain(fractal, p, out, arena):
    """Octaves as large as the height they are added to."""
    power = np.ones(1, np.float32)
    for number, share in enumerate(fractal.octaves()):
        with arena.frame():
            noise = signed_noise(p, arena)
            np.add(noise, fractal.offset, out=noise)
            if number == 0:
                np.copyto(out, noise)
            else:
                np.multiply(noise, power * share, out=noise)
                np.multiply(noise, out, out=noise)
                np.add(out, noise, out=out)
        power = power * fractal.roughness
        np.multiply(p, fractal.lacunarity, out=p)


def _hybrid_multifractal(fractal, p, out, arena):
    """Octaves weighted by the ones before; a lane ends where its weight falls to 0.001."""
    out.fill(0)
    weight, goes_on = arena.full(out.size, 1), arena.empty(out.size, np.bool_)
    power = np.ones(1, np.float32)
    for share in fractal.octaves():
        with arena.frame():
            signal = signed_noise(p, arena)
            np.add(signal, fractal.offset, out=signal)
            np.multiply(signal, power, out=signal)
            np.multiply(signal, weight, out=signal)
            np.multiply(signal, fractal.gain, out=weight)
            np.multiply(weight, np.greater(weight, 0.001, out=goes_on), out=weight)
            np.minimum(weight, 1, out=weight)
            np.add(out, np.multiply(signal, share, out=signal), out=out)
        power = power * fractal.roughness
        np.multiply(p, fractal.lacunarity, out=p)


def _ridged_multifractal(fractal, p, out, arena):
    """Octaves of squared ridges, each weighted by the one before."""
    out.fill(0)
    signal = arena.full(out.size, 1)
    power = np.ones(1, np.float32)
    for number, share in enumerate(fractal.octaves()):
        with arena.frame():
            ridge = signed_noise(p, arena)
            np.abs(ridge, out=ridge)
            np.subtract(fractal.offset, ridge, out=ridge)
            np.multiply(ridge, ridge, out=ridge)
            if number:
                np.multiply(signal, fractal.gain, out=signal)
                np.clip(signal, 0, 1, out=signal)
            np.multiply(signal, ridge, out=signal)
            np.add(out, np.multiply(signal, power * np.floor(share), out=ridge), out=out)
        power = power * fractal.roughness
        np.multiply(p, fractal.lacunarity, out=p)


_KINDS = {
    "FBM": _fbm,
    "MULTIFRACTAL": _multifractal,
    "HETERO_TERRAIN": _hetero_terrain,
    "HYBRID_MULTIFRACTAL": _hybrid_multifractal,
    "RIDGED_MULTIFRACTAL": _ridged_multifractal,
}


def _blend(a, b, share):
    """`a` moved towards `b` by `share`, in place."""
    np.subtract(b, a, out=b)
    np.multiply(b, share, out=b)
    np.add(a, b, out=a)
