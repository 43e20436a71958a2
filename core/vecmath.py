# SPDX-License-Identifier: GPL-3.0-or-later
"""3-vectors over lanes: arrays (3, N) float32, results in the arena.

Written out by component, which is faster than linalg.norm or cross for vectors of three; dot products by einsum, whose
one call in place of five lets other threads run.
"""

from __future__ import annotations

import numpy as np

from .limits import at_least

_SIGN = np.uint32(1 << 31)  # the bit of a float32's sign


def lanes(*arrays):
    """Number of lanes of arrays that broadcast together."""
    counts = [a.shape[-1] for a in arrays]
    return max(counts) if all(counts) else 0


def dot(a, b, arena, out=None):
    """Dot product, (N,)."""
    if out is None:
        out = arena.empty(lanes(a, b))
    return np.einsum("i...,i...->...", a, b, out=out)


def with_sign(magnitude, sign):
    """±`magnitude`, a number or (N,), none below 0, by the signs of `sign` (N,), which it is written to.

    By bits: `numpy.copysign` takes three times as long.
    """
    bits = sign.view(np.uint32)
    np.bitwise_and(bits, _SIGN, out=bits)
    np.bitwise_or(bits, np.asarray(magnitude, np.float32).view(np.uint32), out=bits)
    return sign


def turned(matrix, v):
    """`matrix` (3, 3) times vectors or colours (3, N), a new array; last digits of matmul depend on N."""
    return np.einsum("ij,j...->i...", matrix, v)


def cross(a, b, arena):
    """Cross product, (3, N)."""
    n = lanes(a, b)
    out = arena.empty((3, n))
    with arena.frame():
        t = arena.empty(n)
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            np.multiply(a[j], b[k], out=out[i])
            np.multiply(a[k], b[j], out=t)
            np.subtract(out[i], t, out=out[i])
    return out


def normalize(v, arena, out=None):
    """Unit vectors of `v`; the zero vector stays zero. `out` may be `v`."""
    if out is None:
        out = arena.empty(v.shape)
    with arena.frame():
        s = dot(v, v, arena)
        np.sqrt(s, out=s)
        at_least(s, 1e-30, s)
        np.divide(v, s, out=out)
    return out


def reflect(w, n, arena):
    """`w` mirrored about `n`: 2 (w·n) n - w, both pointing away from the surface."""
    out = arena.empty((3, lanes(w, n)))
    with arena.frame():
        s = dot(w, n, arena)
        np.add(s, s, out=s)
        np.multiply(n, s, out=out)
        np.subtract(out, w, out=out)
    return out


def frame(n, arena):
    """Two unit vectors that make a right-handed basis with the unit vectors `n`.

    Branchless, without a pole. Source: Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017.
    """
    count = n.shape[-1]
    s, t = arena.empty((3, count)), arena.empty((3, count))
    with arena.frame():
        sign, a, b = arena.empty(count), arena.empty(count), arena.empty(count)
        np.copyto(sign, n[2])
        with_sign(1.0, sign)
        np.add(sign, n[2], out=a)
        np.divide(-1.0, a, out=a)
        np.multiply(n[0], n[1], out=b)
        np.multiply(b, a, out=b)
        np.multiply(n[0], n[0], out=s[0])
        np.multiply(s[0], a, out=s[0])
        np.multiply(s[0], sign, out=s[0])
        np.add(s[0], 1.0, out=s[0])
        np.multiply(sign, b, out=s[1])
        np.multiply(sign, n[0], out=s[2])
        np.negative(s[2], out=s[2])
        np.multiply(n[1], n[1], out=t[1])
        np.multiply(t[1], a, out=t[1])
        np.add(t[1], sign, out=t[1])
        np.copyto(t[0], b)
        np.negative(n[1], out=t[2])
    return s, t


def to_world(local, s, t, n, arena):
    """`local` (3, N) in the basis `s`, `t`, `n`, in world coordinates."""
    out = arena.empty(local.shape)
    with arena.frame():
        tmp = arena.empty(local.shape[-1])
        for i in range(3):
            np.multiply(local[0], s[i], out=out[i])
            np.multiply(local[1], t[i], out=tmp)
            np.add(out[i], tmp, out=out[i])
            np.multiply(local[2], n[i], out=tmp)
            np.add(out[i], tmp, out=out[i])
    return out


def to_local(v, s, t, n, arena):
    """`v` (3, N) in coordinates of the basis `s`, `t`, `n`."""
    out = arena.empty((3, lanes(v, n)))
    dot(v, s, arena, out=out[0])
    dot(v, t, arena, out=out[1])
    dot(v, n, arena, out=out[2])
    return out
