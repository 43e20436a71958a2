# SPDX-License-Identifier: GPL-3.0-or-later
"""What of a compiled scene serves another description too: the next frame's, or a moment later in the same one."""

from __future__ import annotations

from dataclasses import fields, is_dataclass

import numpy as np

from ..scene import Instance, Link, Material, Mesh
from .geometry import DEFAULT

_ASK_FOR_CAMERA = frozenset(["camera_data", "light_path", "vector_transform", "bump", "displacement"])
_CAMERA_OUTPUTS = frozenset(["camera", "window"])


def same_shapes(one, other):
    """Whether two `core.scene.Scene`s have the same things to hit, of the same materials, in the same places."""
    return all(_same(getattr(one, name), getattr(other, name)) for name in ("instances", "spheres", "curves", "planes"))


def exchanged(one, other, materials):
    """`materials` of one `core.scene.Scene` as they are in another of the same things in the same places.

    Parameters
    ----------
    one, other : Scene
    materials : sequence of Material
        Some of those of `one`, or the default.

    Returns
    -------
    tuple of Material or None
        None where the scenes differ by more than that each material has become another one.
    """
    if not all(
        _same(getattr(one, name), getattr(other, name), but=("material", "materials"))
        for name in ("instances", "spheres", "curves", "planes")
    ):
        return None
    new, old = {}, {}
    for a, b in zip(one.objects, other.objects, strict=True):
        before, after = _slots(a), _slots(b)
        if len(before) != len(after):
            return None
        for m, n in zip(before, after, strict=True):
            if new.setdefault(m, n) is not n or old.setdefault(n, m) is not m:
                return None
    return tuple(new[m] for m in materials)


def moved(one, other):
    """Numbers of the instances that stand elsewhere in another `core.scene.Scene`, of the same things else.

    Returns
    -------
    list of int or None
        None where the scenes differ by more than where meshes stand.
    """
    if not _same(one.instances, other.instances, but=("transform",)):
        return None
    if not all(_same(getattr(one, name), getattr(other, name)) for name in ("spheres", "curves", "planes")):
        return None
    pairs = enumerate(zip(one.instances, other.instances, strict=True))
    return [n for n, (a, b) in pairs if a is not b and not _same(a.transform, b.transform)]


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


def _slots(thing):
    """Materials of what can be hit."""
    materials = thing.materials if isinstance(thing, Instance) else (thing.material,)
    return [DEFAULT if m is None else m for m in materials or (None,)]


def _same(a, b, but=()):
    """Equality of descriptions; meshes and materials, which are shared, are the same only as the same object.

    Fields of the names `but` are not compared.
    """
    if a is b:
        return True
    if isinstance(a, Mesh | Material) or type(a) is not type(b):
        return False
    if isinstance(a, np.ndarray):
        return np.array_equal(a, b)
    if isinstance(a, tuple | list):
        return len(a) == len(b) and all(_same(x, y, but) for x, y in zip(a, b, strict=True))
    if is_dataclass(a):
        return all(_same(getattr(a, f.name), getattr(b, f.name), but) for f in fields(a) if f.name not in but)
    return a == b
