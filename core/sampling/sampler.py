# SPDX-License-Identifier: GPL-3.0-or-later
"""Random numbers keyed by (seed, pixel, sample, dimension).

The same key gives the same number whatever the tile, chunk or thread. Early dimensions are Owen-scrambled Sobol points:
shuffle and scramble are hashes of the dimension alone, so the point is one scalar for all lanes that share a sample,
and a lane only shifts it by digits (exclusive or), at a fifth of the cost of a scramble of its own and with the same
error. Deeper dimensions are independent numbers.

Sources: Burley, "Practical Hash-based Owen Scrambling", JCGT 9(4), 2020; Laine and Karras, "Stratified Sampling for
Stochastic Transparency", EGSR 2011; Kollig and Keller, "Efficient Multidimensional Sampling", CGF 21(3), 2002, for the
digital shift; direction numbers of Joe and Kuo, "Constructing Sobol sequences with better
two-dimensional projections", 2008; integer hash of Wellons, "Prospecting for Hash Functions", 2018.
"""

from __future__ import annotations

import enum
from functools import lru_cache

import numpy as np

_MASK = 0xFFFFFFFF
_TO_UNIT = 2.0**-24  # 24 bits fill a float32's mantissa; 32 could round to 1
_JOE_KUO = ((1, 0, (1,)), (2, 1, (1, 3)), (3, 1, (1, 3, 1)))  # degree, coefficients, first directions


class Draw(enum.IntEnum):
    """Groups of four numbers that a path uses; a bounce's groups follow one another."""

    PIXEL = 0  # x, y in the pixel, u, v in the lens
    LIGHT = 1  # choice, u0, u1, roulette
    BSDF = 2  # lobe, u0, u1
    STRAIGHT = 3  # choice at transparent surfaces

    def at(self, depth):
        """Number of this group at bounce `depth`."""
        return int(self) + 4 * depth


_SHUTTER = 0x3A57C1B5  # in the hash of the moments at which samples are taken


class Sampler:
    """Numbers of one render.

    Parameters
    ----------
    seed : int
    sobol_depth : int
        Bounces whose numbers are Sobol points; deeper ones are independent.
    """

    def __init__(self, seed, sobol_depth=8):
        self.seed = int(seed) & _MASK
        self._sobol_groups = 4 * sobol_depth

    def keys(self, pixels, arena):
        """The key (P,) uint32 of each pixel number (P,) int32."""
        out = arena.empty(pixels.size, np.uint32)
        np.multiply(pixels.view(np.uint32), np.uint32(0x9E3779B1), out=out)
        np.bitwise_xor(out, np.uint32(hash_int(self.seed + 0x51ED27)), out=out)
        return _mix(out, arena)

    def draw(self, group, dimensions, keys, slots, samples, arena):
        """Numbers of `group`: those asked for, each the same whichever others are.

        Parameters
        ----------
        group : int
            From `Draw.at`.
        dimensions : sequence of int
            Which of the group's four.
        keys : (N,) uint32
            Of the lane's pixel.
        slots : (N,) uint8 or None
            Which of `samples` the lane carries; None when there is one.
        samples : tuple of int
            Sample numbers in the chunk.

        Returns
        -------
        (len(dimensions), N) float32 in [0, 1)
        """
        out = arena.empty((len(dimensions), keys.size))
        number, numbers = self._shifted, _points
        if group >= self._sobol_groups:
            number, numbers = self._independent, _hashes
        with arena.frame():
            of_samples = numbers(group, dimensions, samples, self.seed)
            of_lanes = of_samples if slots is None else arena.take(of_samples, slots)
            bits = arena.empty(keys.size, np.uint32)
            for row, dimension, own in zip(out, dimensions, of_lanes, strict=True):
                number(group, dimension, keys, own, bits, arena)
                np.right_shift(bits, np.uint32(8), out=bits)
                np.copyto(row, bits.view(np.int32), casting="unsafe")
                np.multiply(row, _TO_UNIT, out=row)
        return out

    def moment(self, sample):
        """When, while the shutter is open, a sample is taken: in [0, 1), the same for all pixels.

        In which 2^k-th it falls depends on the last k bits of its number alone: 2^k samples in a row fall into
        different ones, and of two in the same one that follow each other, each is in another half of a film.
        """
        return _owen_int(reverse_int(sample), hash_int(self.seed * 0x9E3779B1 + _SHUTTER)) / 2**32

    def _shifted(self, group, dimension, keys, points, out, arena):
        """Write points, shifted by digits that follow from the lane's pixel."""
        np.multiply(keys, np.uint32(hash_int(group * 4 + dimension + 1) | 1), out=out)
        np.bitwise_xor(out, points, out=out)

    def _independent(self, group, dimension, keys, hashes, out, arena):
        """Write hashes of the lane's pixel and those of its sample."""
        np.add(keys, hashes, out=out)
        _mix(out, arena)


def hash_int(x):
    """Well-mixed 32 bits of the Python int `x`."""
    x &= _MASK
    x ^= x >> 16
    x = x * 0x7FEB352D & _MASK
    x ^= x >> 15
    x = x * 0x846CA68B & _MASK
    return x ^ x >> 16


@lru_cache(maxsize=1 << 10)
def _points(group, dimensions, samples, seed):
    """Numbers `dimensions` of `scrambled_sobol` of `samples`, both tuples: (len(dimensions), len(samples)) uint32."""
    return np.array([[scrambled_sobol(group, s, seed)[d] for s in samples] for d in dimensions], np.uint32)


@lru_cache(maxsize=1 << 10)
def _hashes(group, dimensions, samples, seed):
    """The same of independent numbers: hashes, which `_independent` mixes with the pixel's."""
    numbers = [[hash_int(seed ^ hash_int(s * 0x3C6EF372 + group * 4 + d)) for s in samples] for d in dimensions]
    return np.array(numbers, np.uint32)


@lru_cache(maxsize=1 << 16)
def scrambled_sobol(group, sample, seed):
    """Four Sobol integers of `sample` shuffled for `group`, scrambled each by itself."""
    hashed = hash_int(seed * 0x9E3779B1 + group + 0x2545F491)
    index = _owen_int(sample, hashed)
    points = (_sobol_int(index, directions) for directions in _directions())
    return tuple(_owen_int(point, hash_int(hashed + 1 + d)) for d, point in enumerate(points))


def reverse_int(x):
    """The 32 bits of `x` in reversed order."""
    return int(f"{x:032b}"[::-1], 2)


def _owen_int(x, seed):
    """Owen scramble of the 32 bits of `x`: in reversed order, each step lets a bit change only the bits above it."""
    x = (reverse_int(x) + seed) & _MASK
    for factor in (0x6C50B47C, 0xB82F1E52, 0xC7AFE638, 0x8D22F6E6):
        x ^= x * factor & _MASK
    return reverse_int(x)


def _sobol_int(index, directions):
    x, bit = 0, 0
    while index:
        if index & 1:
            x ^= directions[bit]
        index >>= 1
        bit += 1
    return x


@lru_cache(maxsize=1)
def _directions():
    """Direction integers of the first four Sobol dimensions; the first is van der Corput's."""
    dimensions = [tuple(1 << (31 - i) for i in range(32))]
    for degree, coefficients, first in _JOE_KUO:
        v = [m << (31 - i) for i, m in enumerate(first)]
        for i in range(degree, 32):
            x = v[i - degree] ^ (v[i - degree] >> degree)
            for k in range(1, degree):
                if coefficients >> (degree - 1 - k) & 1:
                    x ^= v[i - k]
            v.append(x)
        dimensions.append(tuple(v))
    return tuple(dimensions)


def _mix(x, arena):
    """Hash each of `x` (N,) uint32 in place."""
    with arena.frame():
        t = arena.empty(x.size, np.uint32)
        for shift, factor in ((16, 0x7FEB352D), (15, 0x846CA68B), (16, None)):
            np.right_shift(x, np.uint32(shift), out=t)
            np.bitwise_xor(x, t, out=x)
            if factor is not None:
                np.multiply(x, np.uint32(factor), out=x)
    return x
