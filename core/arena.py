# SPDX-License-Identifier: GPL-3.0-or-later
"""Scratch memory of one worker.

Arrays of a chunk are taken from one block that stays warm in the cache, and given back together. The only place where
uninitialised memory is made.
"""

from __future__ import annotations

import math
import mmap
from contextlib import suppress
from functools import cache

import numpy as np

_ALIGN = 64
_GAP = 2 * _ALIGN - 1  # arrays that touch are slower to add
_HUGE_PAGE = 1 << 21  # bytes
_LARGE = 1 << 22  # bytes; less is not worth a mapping of its own


class Arena:
    """A stack of arrays; `frame` gives back all that was taken inside it.

    It grows by whole blocks when a frame needs more; blocks are kept for the next frame.
    """

    def __init__(self, block_bytes=1 << 23):
        self._block_bytes = block_bytes
        self._blocks = [_block(block_bytes)]
        self._block = 0
        self._top = 0

    def empty(self, shape, dtype=np.float32):
        """Uninitialised C-contiguous array, valid until the enclosing `frame` ends."""
        nbytes = _itemsize(dtype) * (math.prod(shape) if shape.__class__ is tuple else shape)
        start = self._top
        block = self._blocks[self._block]
        if start + nbytes > block.size:
            block, start = self._next_block(nbytes), 0
        self._top = start + (nbytes + _GAP) // _ALIGN * _ALIGN
        return np.ndarray(shape, dtype, block, start)

    def zeros(self, shape, dtype=np.float32):
        """Like `empty`, filled with zero."""
        out = self.empty(shape, dtype)
        out.fill(0)
        return out

    def full(self, shape, value, dtype=np.float32):
        """Like `empty`, filled with `value`."""
        out = self.empty(shape, dtype)
        out.fill(value)
        return out

    def take(self, source, index):
        """Columns `index` of `source` ((N,) or (C, N)), dense; ids were validated at compile, so nothing is checked."""
        out = self.empty((*source.shape[:-1], index.size), source.dtype)
        return source.take(index, axis=-1, out=out, mode="wrap")

    def reset(self):
        """Give back everything."""
        self._block = self._top = 0

    def frame(self):
        """Context in which arrays are taken that are given back at its end."""
        return _Frame(self)

    @property
    def nbytes(self):
        """Memory held."""
        return sum(b.size for b in self._blocks)

    def _next_block(self, nbytes):
        self._block += 1
        self._top = 0
        if self._block == len(self._blocks):
            self._blocks.append(_block(max(nbytes, self._block_bytes)))
        elif self._blocks[self._block].size < nbytes:
            self._blocks[self._block] = _block(nbytes)
        return self._blocks[self._block]


class _Frame:
    """What is left of `contextlib.contextmanager` when each of its microseconds counts."""

    __slots__ = ("_arena", "_mark")

    def __init__(self, arena):
        self._arena = arena

    def __enter__(self):
        arena = self._arena
        self._mark = arena._block, arena._top
        return arena

    def __exit__(self, *error):
        self._arena._block, self._arena._top = self._mark


def _block(nbytes):
    """Memory of an arena, in whole huge pages: malloc's begins and ends among small ones, touched one by one."""
    if nbytes < _LARGE:
        return np.empty(nbytes, np.uint8)
    return zeros_on_demand((-(-nbytes // _HUGE_PAGE) * _HUGE_PAGE,), np.uint8)


def uninitialised(shape, dtype=np.float32):
    """An array of its own, for large tables that are written whole; unlike zeros, numpy asks huge pages for it."""
    return np.empty(shape, dtype)


def zeros_on_demand(shape, dtype, shared=False):
    """Zeros that take memory, by huge pages where the system has them, and time only where they are touched.

    `numpy.zeros` would get small pages, and what is filled is touched. What is `shared` is the same in forks.
    """
    nbytes = math.prod(shape) * _itemsize(dtype)
    if not shared and nbytes < _LARGE:
        return np.zeros(shape, dtype)
    private = not shared and hasattr(mmap, "MAP_PRIVATE")
    private = {"flags": mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS} if private else {}
    try:
        memory = mmap.mmap(-1, nbytes, **private)
    except OSError as error:
        raise MemoryError(f"{nbytes >> 20} MB are not there") from error
    if hasattr(mmap, "MADV_HUGEPAGE"):
        with suppress(OSError):
            memory.madvise(mmap.MADV_HUGEPAGE)
    return np.frombuffer(memory, dtype).reshape(shape)


@cache
def _itemsize(dtype):
    return np.dtype(dtype).itemsize
