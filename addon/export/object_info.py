# SPDX-License-Identifier: GPL-3.0-or-later
"""What shader nodes can ask of objects and instances."""

from __future__ import annotations

import numpy as np

from ...core import scene as description
from ...core.arena import Arena
from ...core.compile.corners import as_colors
from ...core.nodes.hashing import hash_words
from .hair import curve_attribute

_HASH_MAX = 0xFFFFFFFF
_NONE = 0x7FFFFFFF  # where an instance's id has no further level


class ObjectInfos:
    """Makes `core.scene.ObjectInfo`s of one export.

    Parameters
    ----------
    depsgraph : bpy.types.Depsgraph
    diagnostics : Diagnostics
    """

    def __init__(self, depsgraph, diagnostics):
        self._diagnostics = diagnostics
        self._of_instances = {}
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
        obj = shown_as = instance.object
        generated, uv = (0.0, 0.0, 0.0), (0.0, 0.0)
        if instance.is_instance:
            # An instance has its instancer's colour; `object` tells it only while Python knows the true object not.
            shown_as = instance.parent
            generated = tuple(0.5 * x - 0.5 for x in instance.orco)
            uv = tuple(instance.uv)
        return description.ObjectInfo(
            color=tuple(shown_as.color),
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
                value = None if system else self._of_nodes(instance, name)
                if value is not None:
                    return value
                owners = (*([system.settings] if system else []), instance.parent, *owners)
        return next((v for v in (_property(o, name) for o in owners if o is not None) if v), (0.0,) * 4)

    def _of_nodes(self, instance, name):
        """Colour and alpha of an attribute of what geometry nodes instance; None where there is no such."""
        parent, (_, index, outer, *_) = instance.parent, instance.persistent_id
        if parent is None or outer != _NONE or index == _NONE or all(m.type != "NODES" for m in parent.modifiers):
            return None
        if not hasattr(parent, "evaluated_geometry"):
            message = "attributes of instances of geometry nodes cannot be read before Blender 4.5; properties are"
            self._diagnostics.warn(message, f"object '{parent.name}'")
            return None
        key = parent.name_full, name
        if key not in self._of_instances:
            geometry = parent.evaluated_geometry()  # it owns the cloud
            cloud = geometry.instances_pointcloud()
            found = curve_attribute(cloud.attributes.get(name)) if cloud else None
            self._of_instances[key] = None if found is None else as_colors(found.values)[:, :4]
        values = self._of_instances[key]
        return None if values is None or index >= len(values) else tuple(values[index].tolist())


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
