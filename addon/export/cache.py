# SPDX-License-Identifier: GPL-3.0-or-later
"""What one export hands to the next: the meshes, materials, images and the world that did not change.

What became of an object is kept until an update names it, its data or its instancer, or it stands elsewhere. Lamps, and
what materials read of an object's properties, are read anew each time. The same Python objects come out for the same
things, by which the compiler knows what it may use again.
"""

from __future__ import annotations

from typing import NamedTuple

import bpy
import numpy as np

from .updates import address

_SOURCES = bpy.types.Image | bpy.types.Texture | bpy.types.ShaderNodeTree


class Kept(NamedTuple):
    """Something exported, and the addresses of the IDs that it was made of.

    needs: of a mesh, what was read of it, a `Needs`; passing: whether no update tells of all that it shows.
    """

    value: object
    owners: frozenset = frozenset()
    needs: object = None
    passing: bool = False


class Entry(NamedTuple):
    """What became of an entry of `depsgraph.object_instances`.

    things: its instances, spheres, curves and planes, four tuples; place: its matrix, as bytes; owners: as of `Kept`.
    """

    things: tuple
    place: bytes
    owners: frozenset


class ExportCache:
    """Things exported, by where Blender has them.

    Each export leaves only what it used itself. Before each, and after every step in time, `follow` is to be called.

    Attributes
    ----------
    meshes, materials, images, worlds : dict
        `Kept` by key. A key alone does not tell that a thing is still the same: Blender uses its memory again.
    lamps : dict
        Shaders of lamps by the lamp's address. They are read anew and compared.
    entries : dict
        `Entry` by key.
    layer : object
        What else they depend on, equal where it is the same.
    shared : set of int
        Addresses of the objects that are instanced, that instance others, or come more than once.
    doubtful : set of int
        Addresses of the objects whose own settings may have changed since the last export, though nothing else of them:
        when one object is hidden Blender names all of them so.
    """

    def __init__(self):
        self._graph = None
        self.clear()

    def clear(self):
        """Forget everything."""
        self.meshes, self.materials, self.images, self.worlds, self.lamps = {}, {}, {}, {}, {}
        self.entries, self.layer, self.shared, self.doubtful = {}, None, set(), set()

    def follow(self, depsgraph, shading=True):
        """Forget what the updates of `depsgraph` (bpy.types.Depsgraph) name.

        Parameters
        ----------
        shading : bool
            Whether materials and the world follow too; those of a frame stay while its shutter is open, as in Cycles.
        """
        if not self.is_of(depsgraph):
            self.clear()
        self._graph = _name(depsgraph)
        named, shapes, shaders, sources = set(), set(), set(), False
        for update in depsgraph.updates:
            thing = update.id
            own = isinstance(thing, bpy.types.Object) and not (
                update.is_updated_geometry or update.is_updated_transform
            )
            if own and update.is_updated_shading:
                self.doubtful.add(address(thing))
                continue
            named.add(address(thing))
            if update.is_updated_geometry:
                shapes.add(address(thing))
            if isinstance(thing, bpy.types.Material | bpy.types.World):
                shaders.add(address(thing))
            elif isinstance(thing, _SOURCES):
                sources |= not thing.is_embedded_data
        self.meshes, self.entries = _without(self.meshes, shapes), _without(self.entries, named)
        if not shading:
            return
        if sources:
            self.materials, self.images, self.worlds, self.entries = {}, {}, {}, {}
        self.materials, self.worlds = (
            {key: kept for key, kept in _without(things, shaders).items() if not kept.passing}
            for things in (self.materials, self.worlds)
        )

    def is_of(self, depsgraph):
        """Whether what is kept was exported of this scene and view layer."""
        return self._graph == _name(depsgraph)

    @property
    def has_passing(self):
        """Whether some of it may change without being named."""
        return any(kept.passing for things in (self.materials, self.worlds) for kept in things.values())


def _name(depsgraph):
    return depsgraph.scene.name_full, depsgraph.view_layer.name


def is_same_graph(one, other):
    """Whether two `core.scene.Material`s have the same nodes, of the same constants and images."""
    return (one.name, one.surface, len(one.nodes)) == (other.name, other.surface, len(other.nodes)) and all(
        a.op == b.op and a.inputs == b.inputs and _is_same(a.properties, b.properties)
        for a, b in zip(one.nodes, other.nodes, strict=True)
    )


def _is_same(some, others):
    """Whether two mappings to plain values, arrays and things compared by identity are equal."""
    return some.keys() == others.keys() and all(
        np.array_equal(v, others[k]) if isinstance(v, np.ndarray) else v is others[k] or v == others[k]
        for k, v in some.items()
    )


def _without(kept, owners):
    if not owners:
        return kept
    return {key: thing for key, thing in kept.items() if thing.owners.isdisjoint(owners)}
