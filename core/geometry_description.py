# SPDX-License-Identifier: GPL-3.0-or-later
"""What objects, meshes and hair carry beside their shape; part of `core.scene`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True, eq=False)
class Attribute:
    """Values that shader nodes read by name.

    Parameters
    ----------
    values : (n, C) float32
        C is 1 for a number, 2 or 3 for a vector, 4 for a linear colour with alpha; n by `domain`.
    domain : {"vertex", "corner", "triangle", "strand", "mesh"}
    """

    values: np.ndarray
    domain: str = "vertex"


@dataclass(frozen=True, eq=False)
class TextureSpace:
    """The box of a mesh that generated coordinates span from 0 to 1: centre `location`, half sides `size`.

    `undeformed` (V, 3) are the vertices that are measured in it; None takes the mesh's own.
    """

    location: tuple[float, float, float] = (0.0, 0.0, 0.0)
    size: tuple[float, float, float] = (1.0, 1.0, 1.0)
    undeformed: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class ObjectInfo:
    """What shader nodes can ask of an object.

    color: with alpha; random: in [0, 1], different for each object and instance; generated, uv: coordinates of the
    point of the instancer where an instance stands; attributes: colours with alpha by (type, name), where the type is
    ``"OBJECT"``, ``"INSTANCER"`` or ``"VIEW_LAYER"``.
    """

    color: tuple[float, float, float, float] = (1.0, 1.0, 1.0, 1.0)
    index: int = 0
    random: float = 0.0
    generated: tuple[float, float, float] = (0.0, 0.0, 0.0)
    uv: tuple[float, float] = (0.0, 0.0)
    attributes: Mapping[tuple[str, str], tuple] = field(default_factory=dict)
