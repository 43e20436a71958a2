# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers as nobody would choose them."""

from __future__ import annotations

import math

import numpy as np

BAD = (math.nan, math.inf, -math.inf, 1e30, -1e30, 1e38, 1e-38, 1e-45, 3.5e38)


class Numbers:
    """Draws from wide distributions.

    Parameters
    ----------
    seed : int
    tame : bool
        Finite numbers of moderate size alone.
    """

    def __init__(self, seed, tame=False):
        self.rng = np.random.default_rng(seed)
        self.tame = tame

    def chance(self, probability):
        """True with that probability."""
        return bool(self.rng.random() < probability)

    def choice(self, values):
        """One of `values`."""
        return values[int(self.rng.integers(len(values)))]

    def count(self, most):
        """A whole number from 0 to `most`, small ones more often."""
        return int((most + 1) * self.rng.random() ** 2)

    def unit(self):
        """A number from 0 to 1, often one of the ends."""
        return float(self.choice((0.0, 1.0, 0.5, 1e-4))) if self.chance(0.3) else float(self.rng.random())

    def size(self):
        """A positive number of any magnitude; 0 at times."""
        if self.chance(0.06):
            return 0.0
        decades = 3 if self.tame else 12 if self.chance(0.2) else 4
        return float(10 ** self.rng.uniform(-decades, decades)) if self.chance(0.5) else float(self.rng.uniform(0, 2))

    def number(self):
        """Any number."""
        if not self.tame and self.chance(0.04):
            return self.choice(BAD)
        if self.chance(0.6):
            return self.unit()
        return math.copysign(self.size(), self.rng.random() - 0.3)

    def vector(self, count=3):
        """A tuple of any numbers, at times all the same."""
        if self.chance(0.2):
            return (self.number(),) * count
        return tuple(self.number() for _ in range(count))

    def color(self):
        """Three numbers from 0 to 1; beyond and bad at times unless tame."""
        if self.tame or self.chance(0.7):
            return tuple(self.unit() for _ in range(3))
        return self.vector()

    def array(self, shape, dtype=np.float32):
        """An array of normal numbers, with some of any kind strewn in."""
        out = self.rng.normal(size=shape).astype(dtype)
        if out.size and self.chance(0.3):
            for _ in range(self.count(3) + 1):
                with np.errstate(over="ignore"):
                    out.reshape(-1)[int(self.rng.integers(out.size))] = self.number()
        return out

    def matrix(self):
        """A (4, 4) transform: rigid, scaled, sheared, mirrored, flat or broken."""
        out = np.eye(4)
        kind = self.rng.random()
        if kind < 0.2:
            return out
        turn, _ = np.linalg.qr(self.rng.normal(size=(3, 3)))
        scale = np.diag([self.size() or 0.0 for _ in range(3)]) if kind < 0.5 else np.eye(3) * (self.size() or 1.0)
        out[:3, :3] = turn @ scale if kind < 0.8 else turn
        if kind > 0.95:
            out[:3, :3] = self.rng.normal(size=(3, 3))
        out[:3, 3] = self.rng.normal(size=3) * (self.size() if self.chance(0.3) else 1.0)
        if not self.tame and self.chance(0.06):
            out[int(self.rng.integers(3)), int(self.rng.integers(4))] = self.choice(BAD)
        return out
