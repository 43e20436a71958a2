# SPDX-License-Identifier: GPL-3.0-or-later
"""Light from infinity all around.

A constant environment is never chosen by the light sampler: cosine or lobe sampling of the surface draws its
directions already with the best density there is, so a shadow ray towards it would only cost. Its density as a light
is therefore 0, and rays that leave the scene count it in full, which the MIS weight of density 0 does unasked.
"""

from __future__ import annotations

import numpy as np


class ConstantEnvironment:
    """The same `radiance` (3,) from every direction."""

    def __init__(self, radiance):
        self.radiance = np.asarray(radiance, np.float32).reshape(3, 1)
        self._never = np.zeros(1, np.float32)

    def eval(self, d, arena):
        """Radiance that arrives against `d` (3, N), (3, 1)."""
        return self.radiance

    def pdf(self, d, arena):
        """Solid-angle density with which the light sampler would have drawn `d`, choice included, (1,)."""
        return self._never
