# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of input nodes that are no plain values."""

from __future__ import annotations

import numpy as np


def texture_coordinate(node):
    """Properties of a Texture Coordinate node: `matrix` is from the world into the space of another object."""
    if node.object is None:
        return {}
    matrix = np.array(node.object.matrix_world, np.float64)
    try:
        inverse = np.linalg.inv(matrix)
    except np.linalg.LinAlgError:
        inverse = np.linalg.pinv(matrix)
    return {"matrix": tuple(inverse.ravel().tolist())}
