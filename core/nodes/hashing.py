# SPDX-License-Identifier: GPL-3.0-or-later
"""Jenkins' lookup3 hash of one to four words, over lanes.

Blender's procedural textures take all their random numbers from it, from the bits of floats or from cell numbers.
Source: B. Jenkins, lookup3.c (2006); Blender, intern/cycles/util/hash.h (the words' order, which words are constant).
"""

from __future__ import annotations

import numpy as np

_MIX = (4, 6, 8, 16, 19, 4)
_FINAL = (14, 11, 25, 16, 4, 14, 24)


def hash_words(words, arena):
    """Hash of one to four uint32 arrays that broadcast together, an array of their common shape.

    Steps that depend on fewer words are done in fewer lanes: the corners of a cell share most of their words.
    """
    shape = np.broadcast_shapes(*(w.shape for w in words))
    out = arena.empty(shape, np.uint32)
    start = (0xDEADBEEF + 13 + 4 * len(words)) & 0xFFFFFFFF
    with arena.frame():
        a, b, c = (_sum(word, start, arena) for word in (*words[:3], *(np.zeros(1, np.uint32),) * (3 - len(words))))
        if len(words) == 4:
            a, b, c = (np.add(x, 0, out=arena.empty(shape, np.uint32)) for x in (a, b, c))
            _mix(a, b, c, arena)
            np.add(a, words[3], out=a)
        _final(a, b, c, out, arena)
    return out


def hash_to_unit(words, arena):
    """Hash of one to four arrays of uint32 words or float32 bits, as a float32 from 0 to 1."""
    bits = [w.view(np.uint32) for w in words]
    out = arena.empty(np.broadcast_shapes(*(w.shape for w in bits)))
    with arena.frame():
        np.copyto(out, hash_words(bits, arena), casting="unsafe")
        np.multiply(out, 2.0**-32, out=out)
    return out


def _sum(word, start, arena):
    return np.add(word, start, out=arena.empty(word.shape, np.uint32))


def _mix(a, b, c, arena):
    """lookup3's mix in place; after each of its six steps the words change their parts."""
    with arena.frame():
        t = arena.empty(a.shape, np.uint32)
        for k in _MIX:
            np.subtract(a, c, out=a)
            _rotated(np.bitwise_xor, a, c, k, t)
            np.add(c, b, out=c)
            a, b, c = b, c, a


def _final(a, b, c, out, arena):
    """lookup3's final, whose result is left in `out`; words that do not fill its shape are replaced as they grow."""
    for step, k in enumerate(_FINAL):
        shape = np.broadcast_shapes(b.shape, c.shape)
        grown = out if step == 3 else c if c.shape == shape else arena.empty(shape, np.uint32)
        c = np.bitwise_xor(c, b, out=grown)
        with arena.frame():
            _rotated(np.subtract, c, b, k, arena.empty(b.shape, np.uint32))
        a, b, c = b, c, a


def _rotated(operation, x, y, k, t):
    """`operation` of x and of y rotated left by k bits, in place; halves of a rotation have no bit in common."""
    np.left_shift(y, k, out=t)
    operation(x, t, out=x)
    np.right_shift(y, 32 - k, out=t)
    operation(x, t, out=x)
