# SPDX-License-Identifier: GPL-3.0-or-later
"""Who sees an object, a light or the world, and what a light is linked to.

As in Cycles, an instance is hidden from what its instancer is hidden from, collections that are indirect only hide
from the camera, and an object that is in no set of a kind is found by its instancer.
"""

from __future__ import annotations

from ...core.visibility import ALL_RAYS, UNLIMITED, ObjectSet, Rays, Visibility

_KINDS = ("camera", "diffuse", "glossy", "transmission", "shadow")
_BOUNCES = 1024  # the most that Blender's settings can say, which stands for no limit


class Visibilities:
    """Makes `Visibility` of entries of the dependency graph.

    Parameters
    ----------
    depsgraph : bpy.types.Depsgraph

    Attributes
    ----------
    state : object
        What it knows beside each object's own settings, equal where it is the same.
    """

    def __init__(self, depsgraph):
        self._layer = depsgraph.view_layer_eval
        self._sets = {"receiver": {}, "blocker": {}}
        self._linked = {"receiver": set(), "blocker": set()}
        self._made = {}
        for obj in depsgraph.objects:
            linking = getattr(obj, "light_linking", None)
            for role, sets in self._sets.items():
                collection = linking and getattr(linking, f"{role}_collection")
                if collection:
                    found = _object_set(collection)
                    sets[obj.name_full] = found
                    self._linked[role] |= found.names
        self.state = self._sets, layer_state(self._layer)

    def __call__(self, instance):
        """The visibility of one entry."""
        obj, parent = instance.object, instance.parent
        key = obj.name_full, parent and parent.name_full
        if key not in self._made:
            self._made[key] = self._visibility(obj, parent)
        return self._made[key]

    def _visibility(self, obj, parent):
        rays = _rays(obj)
        if parent is not None and obj.type != "LIGHT":
            rays &= _rays(parent)
        if obj.type != "LIGHT" and obj.indirect_only_get(view_layer=self._layer):
            rays &= ~Rays.CAMERA
        name = obj.name_full
        return Visibility(
            rays=rays,
            catcher=obj.is_shadow_catcher or (parent is not None and parent.is_shadow_catcher),
            holdout=obj.type != "LIGHT" and obj.holdout_get(view_layer=self._layer),
            receivers=self._sets["receiver"].get(name),
            blockers=self._sets["blocker"].get(name),
            receives_as=self._found_as(obj, parent, "receiver"),
            blocks_as=self._found_as(obj, parent, "blocker"),
            max_bounces=_max_bounces(obj.data) if obj.type == "LIGHT" else UNLIMITED,
        )

    def _found_as(self, obj, parent, role):
        """The name by which sets find an object: its instancer's where that is in one."""
        if parent is not None and parent.name_full in self._linked[role]:
            return parent.name_full
        return obj.name_full


def layer_state(layer):
    """What the collections of a `bpy.types.ViewLayer` hide, as a tuple."""

    def flags(collection):
        yield collection.name, collection.exclude, collection.holdout, collection.indirect_only
        for child in collection.children:
            yield from flags(child)

    return tuple(flags(layer.layer_collection))


def world_visibility(world):
    """The visibility of a `bpy.types.World`; where it stands is Cycles' own."""
    settings = getattr(world, "cycles_visibility", None)
    rays = ALL_RAYS
    for kind in _KINDS[:-1]:
        if not getattr(settings, kind, True):
            rays &= ~Rays[kind.upper()]
    return Visibility(rays, max_bounces=_max_bounces(world))


def _rays(obj):
    rays = ALL_RAYS
    for kind in _KINDS:
        if not getattr(obj, f"visible_{kind}"):
            rays &= ~Rays[kind.upper()]
    return rays


def _max_bounces(data):
    """Of a light or world, from the settings of Cycles."""
    bounces = getattr(getattr(data, "cycles", None), "max_bounces", _BOUNCES)
    return UNLIMITED if bounces >= _BOUNCES else bounces


def _object_set(collection):
    """The `ObjectSet` of a linking collection: what it includes, or else all but what it excludes."""
    states = {"INCLUDE": set(), "EXCLUDE": set()}
    for entry, obj in zip(collection.collection_objects, collection.objects, strict=True):
        states[entry.light_linking.link_state].add(obj.name_full)
    for entry, child in zip(collection.collection_children, collection.children, strict=True):
        states[entry.light_linking.link_state] |= {obj.name_full for obj in child.all_objects}
    included, excluded = states["INCLUDE"], states["EXCLUDE"]
    if included:
        return ObjectSet(frozenset(included - excluded))
    return ObjectSet(frozenset(excluded), excluded=True)
