# SPDX-License-Identifier: GPL-3.0-or-later
"""Paths on their way from bounce to bounce."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..nodes.base import CAMERA_RAY, SCATTERED_RAY
from .trails import ray_of


@dataclass
class Paths:
    """Lanes on their way; columns that a scene does not need are None.

    lane: where the path's radiance is summed (None: in order); pdf: density with which `d` was sampled (None: infinite,
    a camera ray); passed: distance through transparent surfaces; trail: what shaders ask of the ray (`trails`).
    """

    lane: np.ndarray | None
    keys: np.ndarray
    slots: np.ndarray | None
    o: np.ndarray
    d: np.ndarray
    tmax: np.ndarray | None
    beta: np.ndarray | None
    pdf: np.ndarray | None = None
    passed: np.ndarray | None = None
    trail: np.ndarray | None = None

    def ray(self, depth, t, arena, lanes=None):
        """The `Ray` of the paths `lanes` (None: all) at their hit number `depth`, `t` (n,) from `o`."""
        if self.trail is None:
            return CAMERA_RAY if depth == 0 else SCATTERED_RAY
        trail, passed = (a if a is None or lanes is None else arena.take(a, lanes) for a in (self.trail, self.passed))
        return ray_of(trail, depth, t if passed is None or t is None else t + passed)

    def at(self, lanes, arena):
        """The lanes `lanes`, dense."""
        return Paths(*(None if a is None else arena.take(a, lanes) for a in vars(self).values()))

    def numbered_from(self, lane):
        """A copy in memory of its own, as paths of a chunk in which their wave begins at `lane`."""
        kept = Paths(*(None if a is None else a.copy() for a in vars(self).values()))
        kept.lane += lane
        return kept


def merged(parts):
    """The `Paths` of a list as one, as of `together`; each column is let go as soon as it is copied."""
    parts = [part for part in parts if part is not None]
    if len(parts) < 2:
        return parts[0] if parts else None
    columns = {}
    for name in vars(parts[0]):
        some = [getattr(part, name) for part in parts]
        for part in parts:
            setattr(part, name, None)
        columns[name] = None if some[0] is None else np.concatenate(some, axis=-1)
    return Paths(**columns)


def together(parts):
    """All `Paths` of a list, or all `Hits`, as one; None are left out, and None is what is made of none."""
    parts = [part for part in parts if part is not None]
    if len(parts) < 2:
        return parts[0] if parts else None
    rows = parts if isinstance(parts[0], tuple) else [vars(part).values() for part in parts]
    columns = zip(*rows, strict=True)
    return type(parts[0])(*(None if some[0] is None else np.concatenate(some, axis=-1) for some in columns))
