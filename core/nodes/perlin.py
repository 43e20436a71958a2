# SPDX-License-Identifier: GPL-3.0-or-later
"""Perlin's gradient noise in one to four dimensions.

Source: K. Perlin, "Improving Noise" (2002); the gradients, the hash and the scale to about [-1, 1] are those of Open
Shading Language and Blender (intern/cycles/kernel/svm/noise.h).
"""

from __future__ import annotations

import numpy as np

from .hashing import hash_words

# Lanes of a block: enough that calls cost little, few enough that the corners of their cells stay in the cache.
BLOCK = 32768

_SCALE = (0.25, 0.6616, 0.982, 0.8344)
_PERIOD = 1e5
_PERIOD_BITS = int(np.float32(_PERIOD).view(np.uint32))


def signed_noise(p, arena):
    """Noise in about [-1, 1] at points `p` (D, N), D from 1 to 4; the result is (N,).

    Corners of cells stand in D leading axes of length 2, in the order of the coordinates. Interpolation takes away one
    axis after the other. numpy takes arrays that touch in memory for overlapping and then adds one by one, so results
    are not written next to what they are computed from.
    """
    dimension, n = p.shape
    out = arena.empty(n)
    with arena.frame():
        cell, offset = _split(p, arena)
        weight = _fade(offset, arena)
        sides = []
        for axis, row in enumerate(offset):
            side = arena.empty((2, n))
            np.copyto(side[0], row)
            np.subtract(row, 1, out=side[1])
            sides.append(side.view(np.uint32).reshape(_along(axis, dimension, n)))
        value = _GRADIENT[dimension - 1](_corner_hashes(cell, arena), *sides, arena)
        for t in weight:
            low, high = value
            rise = np.subtract(high, low, out=arena.empty(low.shape))
            np.multiply(rise, t, out=rise)
            value = np.add(low, rise, out=low)
        np.multiply(value, _SCALE[dimension - 1], out=out)
    return out


def _along(axis, dimension, n):
    """Shape of what differs between corners along one axis only."""
    return (*(1,) * axis, 2, *(1,) * (dimension - 1 - axis), n)


def _corner_hashes(cell, arena):
    """Hashes of the corners of `cell` (D, N), (2, ..., 2, N) uint32.

    Where the lanes lie in few cells, as they do unless the noise is fine, each corner is hashed once and looked up.
    """
    dimension, n = cell.shape
    if n:
        low = cell.min(axis=1)
        size = cell.max(axis=1).astype(np.float64) - low + 2
        if size.prod() <= n << (dimension - 1):
            return _looked_up(cell, low, size.astype(np.intp), arena)
    words = []
    for axis, row in enumerate(cell):
        word = arena.empty((2, n), np.uint32)
        np.copyto(word[0].view(np.int32), row, casting="unsafe")
        np.add(word[0], 1, out=word[1])
        words.append(word.reshape(_along(axis, dimension, n)))
    return hash_words(words, arena)


def _looked_up(cell, low, size, arena):
    """The same from a table of all corners of the box of `size` (D,) that starts at `low` (D,)."""
    dimension, n = cell.shape
    out = arena.empty((2,) * dimension + (n,), np.uint32)
    with arena.frame():
        axes = [int(start) + np.arange(count, dtype=np.int32) for start, count in zip(low, size, strict=True)]
        table = hash_words([a.view(np.uint32) for a in np.ix_(*axes)], arena)
        strides = np.array(table.strides) // table.itemsize
        place, index, t = arena.zeros(n), arena.empty(n, np.intp), arena.empty(n)
        for row, start, stride in zip(cell, low, strides, strict=True):
            # Whole numbers below 2**24 are exact in float32.
            np.subtract(row, start, out=t)
            np.multiply(t, np.float32(stride), out=t)
            np.add(place, t, out=place)
        np.copyto(index, place, casting="unsafe")
        flat = table.reshape(-1)
        for corner in np.ndindex(out.shape[:-1]):
            np.take(flat[int(np.dot(corner, strides)) :], index, out=out[corner], mode="clip")
    return out


def _split(p, arena):
    """Whole and fractional parts of `p`; beyond 100,000 the noise repeats, and what is no number counts as zero."""
    offset, cell = arena.empty(p.shape), arena.empty(p.shape)
    with arena.frame():
        bits = np.bitwise_and(p.view(np.uint32), 0x7FFFFFFF, out=arena.empty(p.shape, np.uint32))
        if bits.size and bits.max() >= _PERIOD_BITS:
            p = _wrapped(p)
        np.floor(p, out=cell)
        np.subtract(p, cell, out=offset)
    return cell, offset


def _wrapped(p):
    """`p` within ±100,000. Floats beyond a million have no fraction left: half a cell is added, as Blender does."""
    p = np.where(np.isfinite(p), p, np.float32(0))
    return np.fmod(p, np.float32(_PERIOD)) + np.float32(0.5) * (np.abs(p) >= 1e6)


def _fade(t, arena):
    """6 t⁵ - 15 t⁴ + 10 t³."""
    out = arena.empty(t.shape)
    np.multiply(t, 6, out=out)
    np.subtract(out, 15, out=out)
    np.multiply(out, t, out=out)
    np.add(out, 10, out=out)
    for _ in range(3):
        np.multiply(out, t, out=out)
    return out


# -- gradients ---------------------------------------------------------------------------------------------------------
#
# Products of a gradient and an offset. A gradient's components are 0, 1 and -1 (2 in two dimensions), so a few bits of
# the hash choose coordinates and their signs. Coordinates come as bits: choosing is then two bitwise operations.


def _gradient_1d(h, x, arena):
    out = arena.empty(h.shape)
    with arena.frame():
        t = np.bitwise_and(h, 7, out=arena.empty(h.shape, np.uint32))
        np.add(t, 1, out=t)
        np.copyto(out, t.view(np.int32), casting="unsafe")
        np.multiply(out, x.view(np.float32), out=out)
        _negate(out.view(np.uint32), h, 3, t)
    return out


def _gradient_2d(h, x, y, arena):
    u = arena.empty(h.shape, np.uint32)
    with arena.frame():
        t, v = arena.empty(h.shape, np.uint32), arena.empty(h.shape, np.uint32)
        both = _difference(x, y, arena)
        _choose(_mask(h, 2, t), x, both, u)
        np.bitwise_xor(u, both, out=v)
        np.multiply(v.view(np.float32), 2, out=v.view(np.float32))
        _negate(u, h, 0, t)
        _negate(v, h, 1, t)
        return np.add(u.view(np.float32), v.view(np.float32), out=u.view(np.float32))


def _gradient_3d(h, x, y, z, arena):
    """Of h < 8 x, else y; with it of h < 4 or h in (12, 14) the other of the two, else z."""
    u = arena.empty(h.shape, np.uint32)
    with arena.frame():
        t, v = arena.empty(h.shape, np.uint32), arena.empty(h.shape, np.uint32)
        both = _difference(x, y, arena)
        _choose(_mask(h, 3, t), x, both, u)
        # z where bits 3 and 2 differ, or bits 3 and 0 are set.
        np.left_shift(h, 3, out=t)
        np.bitwise_and(t, h, out=t)
        np.left_shift(h, 1, out=v)
        np.bitwise_xor(v, h, out=v)
        np.bitwise_or(t, v, out=t)
        _mask(t, 3, t)
        np.bitwise_xor(u, both, out=v)
        w = np.bitwise_xor(v, z, out=arena.empty(h.shape, np.uint32))
        np.bitwise_and(t, w, out=t)
        np.bitwise_xor(v, t, out=v)
        _negate(u, h, 0, t)
        _negate(v, h, 1, t)
        return np.add(u.view(np.float32), v.view(np.float32), out=u.view(np.float32))


def _gradient_4d(h, x, y, z, w, arena):
    """Of h < 24 x, else y; with it of h < 16 y, else z; and of h < 8 z, else w."""
    u = arena.empty(h.shape, np.uint32)
    with arena.frame():
        s, t, v = (arena.empty(h.shape, np.uint32) for _ in range(3))
        np.left_shift(h, 1, out=s)
        _choose(_mask(np.bitwise_and(s, h, out=t), 4, t), x, _difference(x, y, arena), u)
        _negate(u, h, 0, t)
        _choose(_mask(h, 4, t), y, _difference(y, z, arena), v)
        _negate(v, h, 1, t)
        np.add(u.view(np.float32), v.view(np.float32), out=u.view(np.float32))
        _choose(_mask(np.bitwise_or(s, h, out=t), 4, t), z, _difference(z, w, arena), v)
        _negate(v, h, 2, t)
        return np.add(u.view(np.float32), v.view(np.float32), out=u.view(np.float32))


_GRADIENT = (_gradient_1d, _gradient_2d, _gradient_3d, _gradient_4d)


def _mask(h, bit, out):
    """All ones where `bit` of h is set, else zero."""
    np.left_shift(h, 31 - bit, out=out)
    np.right_shift(out.view(np.int32), 31, out=out.view(np.int32))
    return out


def _difference(x, y, arena):
    """Bits in which x and y differ."""
    return np.bitwise_xor(x, y, out=arena.empty(np.broadcast_shapes(x.shape, y.shape), np.uint32))


def _choose(mask, x, difference, out):
    """x, and where `mask` is set what differs from x by `difference`."""
    np.bitwise_and(mask, difference, out=out)
    return np.bitwise_xor(out, x, out=out)


def _negate(value, h, bit, t):
    """Turn the sign of floats `value` where `bit` of h is set, in place."""
    np.right_shift(h, bit, out=t)
    np.left_shift(t, 31, out=t)
    np.bitwise_xor(value, t, out=value)
