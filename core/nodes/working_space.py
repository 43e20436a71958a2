# SPDX-License-Identifier: GPL-3.0-or-later
"""Colours of Linear Rec.709 in the space that a file's colours are in, where that is another."""

from __future__ import annotations

import numpy as np

from ..vecmath import turned
from .base import Operation


def matrix_of(properties):
    """The matrix (3, 3) from Rec.709 to the working space, None where they are the same."""
    rows = properties.get("working_space")
    return None if rows is None else np.float32(rows).reshape(3, 3)


def _to_working_space(context, inputs, properties):
    """`matrix_of` times the colour; without it the colour as it is."""
    color, matrix = inputs["color"], matrix_of(properties)
    return {"color": color if matrix is None else turned(matrix, color)}


OPERATIONS = {"to_working_space": Operation(_to_working_space, {"color": (0.0, 0.0, 0.0)})}
