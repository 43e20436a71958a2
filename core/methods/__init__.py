# SPDX-License-Identifier: GPL-3.0-or-later
"""The four methods, by name."""

from .pathtrace import PathTrace
from .phong import Phong
from .raycast import RayCast
from .raytrace import RayTrace

METHODS = {"phong": Phong, "raycast": RayCast, "raytrace": RayTrace, "pathtrace": PathTrace}
