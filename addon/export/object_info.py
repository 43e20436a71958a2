# SPDX-License-Identifier: GPL-3.0-or-later
"""What shader nodes can ask of objects and instances."""

from __future__ import annotations

import numpy as np

from ...core import scene as description
from ...core.arena import Arena
from ...core.nodes.hashing import hash_words

_HASH_MAX = 0xFFFFFFFF


class ObjectInfos:
    """Makes `core.scene.ObjectInfo`s of one export.

    Parameters
    ----------
    depsgraph : bpy.types.Depsgraph
    """

    def __init__(self, depsgraph):
        self._layer = depsgraph.view_layer_eval, depsgraph.scene_eval
        self._arena = Arena(4096)

    def __call__(self, instance, attributes):
        """Of an entry of the dependency graph.

        Parameters
        ----------
        instance : bpy.types.DepsgraphObjectInstance
        attributes : set of (type, name)
            That its materials read.
        """
        obj = instance.object
        generated, uv = (0.0, 0.0, 0.0), (0.0, 0.0)
        if instance.is_instance:
            generated = tuple(0.5 * x - 0.5 for x in instance.orco)
            uv = tuple(instance.uv)
        return description.ObjectInfo(
            color=tuple(obj.color),
            index=obj.pass_index,
            random=(instance.random_id & _HASH_MAX) / _HASH_MAX if instance.is_instance else self._random_of(obj.name),
            generated=generated,
            uv=uv,
            attributes={key: self._attribute(instance, *key) for key in attributes},
        )

    def _random_of(self, name):
        """The number in [0, 1] that Blender draws for a name: a hash of its hash."""
        number = 0
        for byte in name.encode():
            number = (number * 37 + (byte if byte < 128 else byte - 256)) & _HASH_MAX
        with self._arena.frame():
            words = [np.array([word], np.uint32) for word in (number, 0)]
            return int(hash_words(words, self._arena)[0]) / _HASH_MAX

    def _attribute(self, instance, kind, name):
        """Colour and alpha of a property; all 0 where there is none."""
        if kind == "VIEW_LAYER":
            owners = self._layer
        else:
            owners = instance.object, instance.object.data
            if kind == "INSTANCER" and instance.is_instance:
                system = instance.particle_system
                owners = (*([system.settings] if system else []), instance.parent, *owners)
        return next((v for v in (_property(o, name) for o in owners if o is not None) if v), (0.0,) * 4)


def _property(owner, name):
    """A custom property or one of Blender's own as a colour with alpha, None where it is no number or vector."""
    value = owner.get(name)
    if value is None:
        try:
            value = owner.path_resolve(name)
        except ValueError:
            return None
    if isinstance(value, bool | int | float):
        return (float(value),) * 3 + (1.0,)
    try:
        numbers = [float(v) for v in value]
    except (TypeError, ValueError):
        return None
    return tuple((numbers + [0.0, 0.0, 0.0, 1.0][len(numbers) :])[:4]) if 0 < len(numbers) <= 4 else None
