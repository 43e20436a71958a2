# SPDX-License-Identifier: GPL-3.0-or-later
"""Russian roulette."""

from __future__ import annotations

import numpy as np

from ..limits import at_most
from .wavefront import nonzero


def roulette(beta, u, arena):
    """Lanes that survive by `u` (N,) in [0, 1), and each lane's chance to; without `u` all that carry something."""
    chance = arena.empty(beta.shape[1])
    with arena.frame():
        t = arena.empty(beta.shape[1])
        np.abs(beta[0], out=chance)
        for row in beta[1:]:
            np.abs(row, out=t)
            np.maximum(chance, t, out=chance)
    if u is None:
        return nonzero(chance, arena), None
    # A path that carries little still finds light that others miss: the fourth root takes the least time to a given
    # error in docs/performance.md.
    np.sqrt(np.sqrt(at_most(chance, 1, chance), out=chance), out=chance)
    return (u < chance).nonzero()[0], chance
