# SPDX-License-Identifier: GPL-3.0-or-later
"""What the groups of materials gave, side by side."""

from __future__ import annotations

from itertools import pairwise

from ..bsdf.base import BSDFSample


def in_parts(groups, most):
    """Yield the groups (program, first lane, end), large ones as equal parts of at most `most` lanes."""
    for program, start, stop in groups:
        lanes = stop - start
        number = -(-lanes // most)
        edges = [start + lanes * k // number for k in range(number + 1)]
        yield from ((program, a, b) for a, b in pairwise(edges))


class Joined:
    """Directs and BSDF samples of all groups, taken over one after the other: a group's own memory is free then.

    Lanes of a group without get 0; both are None until some group has any.

    Parameters
    ----------
    count : int
        Lanes of all groups.
    arena : Arena
        Not the one that the groups use.
    """

    def __init__(self, count, arena):
        self._count, self._arena = count, arena
        self.direct = self.scattered = None

    def put(self, direct, scattered, start, stop):
        """Take over what the lanes from `start` to `stop` gave, which follow those before."""
        if self.direct is None and direct is not None:
            self.direct = self._begun(direct, start)
        if self.direct is not None:
            self.direct[..., start:stop] = 0 if direct is None else direct
        if self.scattered is None and scattered is not None:
            self.scattered = self._samples_begun(scattered, start)
        if self.scattered is not None:
            parts = [0] * len(self.scattered) if scattered is None else scattered
            for own, part in zip(self.scattered, parts, strict=True):
                if own is not None:
                    own[..., start:stop] = part

    def _samples_begun(self, sample, start):
        wi, weight = (self._begun(sample.wi, start) for _ in range(2))
        pdf, flags, diffuse = (
            None if a is None else self._begun(a, start) for a in (sample.pdf, sample.flags, sample.diffuse)
        )
        return BSDFSample(wi, weight, pdf, flags=flags, diffuse=diffuse)

    def _begun(self, part, start):
        """An array for all lanes, of which the first `start` had nothing to give."""
        out = self._arena.empty((*part.shape[:-1], self._count), part.dtype)
        out[..., :start] = 0
        return out
