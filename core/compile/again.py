# SPDX-License-Identifier: GPL-3.0-or-later
"""What of a compiled scene serves another description too: the next frame's, or a moment later in the same one."""

from __future__ import annotations

from dataclasses import fields, is_dataclass

import numpy as np

from ..scene import Link, Material, Mesh

_ASK_FOR_CAMERA = frozenset(["camera_data", "light_path", "vector_transform", "bump", "displacement"])
_CAMERA_OUTPUTS = frozenset(["camera", "window"])


def same_shapes(one, other):
    """Whether two `core.scene.Scene`s have the same things to hit, of the same materials, in the same places."""
    return all(_same(getattr(one, name), getattr(other, name)) for name in ("instances", "spheres", "curves", "planes"))


def same_lights(one, other):
    """Whether two `core.scene.Scene`s have the same lamps and the same world."""
    a, b = one.world, other.world
    constant = a.surface is None and b.surface is None and a.radiance == b.radiance
    return (a is b or constant) and _same(one.lights, other.lights)


def same_cameras(one, other):
    """Whether two `core.scene.Camera`s see the same."""
    return _same(one, other)


def asks_for_camera(described):
    """Whether the nodes of a `Material` or `World` may read where the camera is; in doubt, they do."""
    return any(
        node.op in _ASK_FOR_CAMERA
        or any(isinstance(v, Link) and v.output in _CAMERA_OUTPUTS for v in node.inputs.values())
        for node in described.nodes
    )


def _same(a, b):
    """Equality of descriptions; meshes and materials, which are shared, are the same only as the same object."""
    if a is b:
        return True
    if isinstance(a, Mesh | Material) or type(a) is not type(b):
        return False
    if isinstance(a, np.ndarray):
        return np.array_equal(a, b)
    if isinstance(a, tuple | list):
        return len(a) == len(b) and all(map(_same, a, b))
    if is_dataclass(a):
        return all(_same(getattr(a, f.name), getattr(b, f.name)) for f in fields(a))
    return a == b
