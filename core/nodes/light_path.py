# SPDX-License-Identifier: GPL-3.0-or-later
"""The Light Path node: what kind of ray asks.

Source: Blender manual, "Light Path Node". The answers are the `Ray` of the context, which the methods supply.
"""

from __future__ import annotations

import numpy as np

from . import spaces
from .base import Operation

_OUTPUTS = {
    "is_camera_ray": "camera",
    "is_shadow_ray": "shadow",
    "is_diffuse_ray": "diffuse",
    "is_glossy_ray": "glossy",
    "is_singular_ray": "singular",
    "is_reflection_ray": "reflection",
    "is_transmission_ray": "transmission",
    "ray_depth": "depth",
    "diffuse_depth": "diffuse_depth",
    "glossy_depth": "glossy_depth",
    "transparent_depth": "transparent_depth",
    "transmission_depth": "transmission_depth",
}
_FARTHEST = np.finfo(np.float32).max
_NEVER = ("is_volume_scatter_ray", "portal_depth")  # there are neither volumes nor portals


def _light_path(context, inputs, properties):
    ray = context.ray
    outputs = {output: _array(getattr(ray, field)) for output, field in _OUTPUTS.items()}
    outputs |= dict.fromkeys(_NEVER, np.zeros(1, np.float32))
    if context.direction is not None:  # which counts as a hit of its own
        outputs["ray_depth"] = outputs["ray_depth"] + np.float32(1)
    return outputs | {"ray_length": ray_length(context)}


def ray_length(context):
    """Distance (N,) that the rays have come; in a world it is the largest number there is."""
    if context.direction is not None:
        return np.full(1, _FARTHEST, np.float32)
    if context.ray.length is not None:
        return _array(context.ray.length)
    return spaces.view_of(context).ray_length(spaces.camera_position(context))


def _array(value):
    return np.atleast_1d(np.asarray(value, np.float32))


OPERATIONS = {"light_path": Operation(_light_path, foldable=False)}
