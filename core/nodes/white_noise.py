# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's White Noise Texture: a hash of the coordinates' bits.

Source: Blender, intern/cycles/kernel/svm/white_noise.h and intern/cycles/util/hash.h.
"""

from __future__ import annotations

import numpy as np

from .base import Operation, Outputs
from .hashing import hash_to_unit

# Words of the colour's second and third hash: coordinates by letter, constants by value.
_OTHERS = {
    "1D": (("w", 1.0), ("w", 2.0)),
    "2D": (("x", "y", 1.0), ("x", "y", 2.0)),
    "3D": (("x", "y", "z", 1.0), ("x", "y", "z", 2.0)),
    "4D": (("z", "x", "w", "y"), ("w", "z", "y", "x")),
}
_WORDS = {"1D": "w", "2D": "xy", "3D": "xyz", "4D": "xyzw"}


def _white_noise(context, inputs, properties):
    arena, dimensions = context.arena, properties.get("noise_dimensions", "3D")
    words = dict(zip("xyz", inputs["vector"], strict=True)) | {"w": inputs["w"]}

    def hashed(names):
        return hash_to_unit([words[n] if isinstance(n, str) else np.float32([n]) for n in names], arena)

    def color():
        rows = [outputs["value"], *(hashed(names) for names in _OTHERS[dimensions])]
        return np.stack(rows, out=arena.empty((3, rows[0].size)))

    outputs = Outputs({"value": lambda: hashed(_WORDS[dimensions]), "color": color})
    return outputs


OPERATIONS = {"white_noise": Operation(_white_noise, {"vector": (0.0,) * 3, "w": 0.0})}
