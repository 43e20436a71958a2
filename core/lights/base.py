# SPDX-License-Identifier: GPL-3.0-or-later
"""What all lights share. Their contract is in docs/design.md, "A light"."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class LightSample(NamedTuple):
    """A direction towards a light.

    wi (3, N) unit; distance (N,), inf for lights at infinity; weight (3, N) = Le/pdf, 0 where nothing arrives;
    pdf (N,) per solid angle, inf for delta lights.
    """

    wi: np.ndarray
    distance: np.ndarray
    weight: np.ndarray
    pdf: np.ndarray
