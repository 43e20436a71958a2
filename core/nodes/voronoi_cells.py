# SPDX-License-Identifier: GPL-3.0-or-later
"""Cells of the Voronoi Texture: a lattice with one random point in each cell.

A cell is told by its lower corner, whole numbers. Blender 5.0 took another hash for cells of two and more dimensions,
so there are two patterns: `PCG` is today's, `LOOKUP3` that of Blender 4.

Sources: Jarzynski and Olano, "Hash Functions for GPU Rendering", JCGT 9(3), 2020 (Blender works with signed numbers
and drops the sign); `hashing` for the other; Blender's release notes 5.0.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from .hashing import hash_to_unit

_UNIT = 2.0**-31
_MULTIPLIER, _INCREMENT = np.int32(1664525), np.int32(1013904223)


def offsets(dimensions, reach):
    """Cells at most `reach` away along each axis, as (count, dimensions) float32 in Blender's order: x runs fastest."""
    steps = range(-reach, reach + 1)
    return np.array([step[::-1] for step in product(steps, repeat=dimensions)], np.float32)


class PCG:
    """Random numbers of cells by permuted congruential generators."""

    @staticmethod
    def point(cell, arena):
        """Numbers in [0, 1] (D, N) of cells (D, N) float32."""
        if cell.shape[0] == 1:
            return LOOKUP3.point(cell, arena)
        return _unit(_pcg(_whole(cell, arena), arena), arena)

    @staticmethod
    def color(cell, arena):
        """Numbers in [0, 1] (3, N) of cells (D, N) float32."""
        dimensions = cell.shape[0]
        if dimensions == 1:
            return LOOKUP3.color(cell, arena)
        keys = _whole(cell, arena, 3 if dimensions == 2 else dimensions)
        return _unit(_pcg(keys, arena), arena)[:3]


class LOOKUP3:
    """Random numbers of cells by Jenkins' lookup3 of the bits of their float32 corners."""

    _POINT = ("x", "x1"), ("xy", "xy1"), ("xyz", "xyz1", "xyz2"), ("xyzw", "wxyz", "zwxy", "yzwx")
    _COLOR = ("x", "x1", "x2"), ("xy", "xy1", "xy2"), ("xyz", "xyz1", "xyz2"), ("xyzw", "zxwy", "wzyx")

    @classmethod
    def point(cls, cell, arena):
        """Numbers in [0, 1] (D, N) of cells (D, N) float32."""
        dimensions = cell.shape[0]
        return _lookups(cell, cls._POINT[dimensions - 1][:dimensions], arena)

    @classmethod
    def color(cls, cell, arena):
        """Numbers in [0, 1] (3, N) of cells (D, N) float32."""
        return _lookups(cell, cls._COLOR[cell.shape[0] - 1], arena)


def _lookups(cell, words, arena):
    """A hash for each of `words`, whose letters are the cell's coordinates and whose digits stand for themselves."""
    named = dict(zip("xyzw", cell, strict=False)) | {"1": np.float32([1]), "2": np.float32([2])}
    out = arena.empty((len(words), cell.shape[-1]))
    for row, word in zip(out, words, strict=True):
        with arena.frame():
            np.copyto(row, hash_to_unit([named[letter] for letter in word], arena))
    return out


def _whole(cell, arena, rows=None):
    """`cell` as (rows, N) int32; rows that it lacks are 0."""
    out = arena.zeros((rows or cell.shape[0], cell.shape[-1]), np.int32)
    np.copyto(out[: cell.shape[0]], cell, casting="unsafe")
    return out


def _pcg(v, arena):
    """Hash (2 to 4, N) int32 in place; negative numbers too."""
    np.multiply(v, _MULTIPLIER, out=v)
    np.add(v, _INCREMENT, out=v)
    _stir(v, arena)
    with arena.frame():
        high = np.right_shift(v, 16, out=arena.empty(v.shape, np.int32))
        np.bitwise_xor(v, high, out=v)
    _stir(v, arena)
    return np.bitwise_and(v, 0x7FFFFFFF, out=v)


# What is added to each row: the product of two others, or in two dimensions a multiple of the other.
_STIRRED = {
    2: ((0, 1, None), (1, 0, None)),
    3: ((0, 1, 2), (1, 2, 0), (2, 0, 1)),
    4: ((0, 1, 3), (1, 2, 0), (2, 0, 1), (3, 1, 2)),
}


def _stir(v, arena):
    with arena.frame():
        t = arena.empty(v.shape[-1], np.int32)
        for row, a, b in _STIRRED[v.shape[0]]:
            np.multiply(v[a], _MULTIPLIER if b is None else v[b], out=t)
            np.add(v[row], t, out=v[row])


def _unit(v, arena):
    """(D, N) int32 in [0, 2³¹) as float32 in [0, 1]."""
    out = arena.empty(v.shape)
    np.copyto(out, v, casting="unsafe")
    return np.multiply(out, _UNIT, out=out)
