# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Normal node: a direction set by hand, and its cosine to another.

Source: Blender manual, "Normal Node"; Cycles, `kernel/svm/normal.h`.
"""

from __future__ import annotations

import numpy as np

from ..vecmath import dot, normalize
from .base import Operation, as_vector


def _normal(context, inputs, properties):
    arena = context.arena
    with np.errstate(all="ignore"):
        direction = normalize(as_vector(properties.get("direction", (0.0, 0.0, 1.0))), arena)
        return {"normal": direction, "dot": dot(direction, normalize(inputs["normal"], arena), arena)}


OPERATIONS = {"normal": Operation(_normal, {"normal": (0.0, 0.0, 1.0)})}
