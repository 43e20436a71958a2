# SPDX-License-Identifier: GPL-3.0-or-later
"""Scratch memory of one worker.

Arrays of a chunk are taken from one block that stays warm in the cache, and given back together. The only place where
uninitialised memory is made.
"""

from __future__ import annotations

from contextlib import contextmanager

import numpy as np

_ALIGN = 64


class Arena:
    """A stack of arrays; `frame` gives back all that was taken inside it.

    It grows by whole blocks when a frame needs more; blocks are kept for the next frame.
    """

    def __init__(self, block_bytes=1 << 25):
        self._block_bytes = block_bytes
        self._blocks = [np.empty(block_bytes, np.uint8)]
        self._block = 0
        self._top = 0

    def empty(self, shape, dtype=np.float32):
        """Uninitialised C-contiguous array, valid until the enclosing `frame` ends."""
        dtype = np.dtype(dtype)
        count = 1
        for s in shape if isinstance(shape, tuple) else (shape,):
            count *= s
        nbytes = count * dtype.itemsize
        if self._top + nbytes > self._blocks[self._block].size:
            self._next_block(nbytes)
        start = self._top
        self._top = start + -(-nbytes // _ALIGN) * _ALIGN
        return self._blocks[self._block][start : start + nbytes].view(dtype).reshape(shape)

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
        return np.take(source, index, axis=-1, out=out, mode="clip")

    def reset(self):
        """Give back everything."""
        self._block = self._top = 0

    @contextmanager
    def frame(self):
        """Arrays taken inside are given back at its end."""
        mark = self._block, self._top
        try:
            yield self
        finally:
            self._block, self._top = mark

    @property
    def nbytes(self):
        """Memory held."""
        return sum(b.size for b in self._blocks)

    def _next_block(self, nbytes):
        self._block += 1
        self._top = 0
        if self._block == len(self._blocks):
            self._blocks.append(np.empty(max(nbytes, self._block_bytes), np.uint8))
        elif self._blocks[self._block].size < nbytes:
            self._blocks[self._block] = np.empty(nbytes, np.uint8)
