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
        """Take over what the lanes from `start` to `stop` gave."""
        if direct is not None:
            if self.direct is None:
                self.direct = self._zeros_like(direct)
            self.direct[..., start:stop] = direct
        if scattered is not None:
            if self.scattered is None:
                self.scattered = self._samples_like(scattered)
            for own, part in zip(self.scattered, scattered, strict=True):
                if own is not None:
                    own[..., start:stop] = part

    def _samples_like(self, sample):
        wi, weight = (self._arena.zeros((3, self._count)) for _ in range(2))
        pdf, flags, diffuse = (
            None if a is None else self._zeros_like(a) for a in (sample.pdf, sample.flags, sample.diffuse)
        )
        return BSDFSample(wi, weight, pdf, flags=flags, diffuse=diffuse)

    def _zeros_like(self, part):
        return self._arena.zeros((*part.shape[:-1], self._count), part.dtype)
