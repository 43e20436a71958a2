# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of input nodes that are no plain values."""

from __future__ import annotations

import os

import bpy
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


def ies(node):
    """Properties of an IES Texture node: the file's text, "" where it is missing, and its name."""
    if node.mode == "INTERNAL":
        return {"text": node.ies.as_string(), "name": node.ies.name} if node.ies else {"text": "", "name": ""}
    path = bpy.path.abspath(node.filepath, library=node.id_data.library)
    try:
        with open(path, encoding="latin-1") as file:
            text = file.read()
    except OSError:
        text = ""
    return {"text": text, "name": os.path.basename(path)}
