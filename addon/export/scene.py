# SPDX-License-Identifier: GPL-3.0-or-later
"""One pass over the dependency graph."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import NamedTuple

import bpy
import numpy as np

from ...core import scene as description
from ...core.compile.needs import needs_of
from .cache import Entry, ExportCache, Kept, is_same_graph
from .camera import export_camera, frame_size, render_border
from .hair import export_curves, export_hair, has_hair
from .image import Images
from .light import export_lamp_shader, export_light
from .material import Materials, keep_shader
from .mesh import export_mesh
from .object_info import ObjectInfos
from .points import export_points
from .updates import address, key_of
from .versions import working_space
from .visibility import Visibilities
from .world import export_world

__all__ = ("export_scene", "frame_size", "render_border")

_NOT_YET = {
    "VOLUME": "volumes are not rendered yet",
    "GREASEPENCIL": "grease pencil is not rendered by Zraka",
    "GPENCIL": "grease pencil is not rendered by Zraka",
}


def export_scene(depsgraph, diagnostics, camera=None, size=None, visible=None, cache=None, still=None):
    """Everything that the dependency graph shows, copied.

    Parameters
    ----------
    depsgraph : bpy.types.Depsgraph
        A render's leaves out what is hidden in renders, a viewport's what is hidden there.
    diagnostics : Diagnostics
    camera : bpy.types.Object, str or core.scene.Camera, optional
        Another camera than the scene's.
    size : (width, height), optional
        Of the whole frame in pixels; the scene's by default.
    visible : callable, optional
        Tells of an entry of `depsgraph.object_instances` whether it is wanted.
    cache : ExportCache, optional
        What the export before left, up to date; it is left what this one used.
    still : Still, optional
        Keeps objects where they were at first.

    Returns
    -------
    core.scene.Scene

    Raises
    ------
    SceneError
        There is no camera.
    """
    scene, layer = depsgraph.scene_eval, depsgraph.view_layer_eval
    if working_space() != "Linear Rec.709":
        diagnostics.warn(f"thin films are coloured as in Linear Rec.709, not as in the working space {working_space()}")
    cache = cache or ExportCache()
    ready = isinstance(camera, description.Camera)
    seen_by = camera if ready else export_camera(depsgraph, diagnostics, camera, size)
    objects = _Objects(depsgraph, diagnostics, cache, still)
    places = _places(depsgraph)
    for instance, place in zip(depsgraph.object_instances, places, strict=True):
        if visible is None or visible(instance):
            objects.take(instance, place.tobytes())
    world = objects.world(getattr(layer, "world_override", None) or scene.world)
    objects.leave(cache)
    return description.Scene(
        camera=seen_by,
        instances=tuple(objects.instances),
        spheres=tuple(objects.spheres),
        curves=tuple(objects.curves),
        planes=tuple(objects.planes),
        lights=tuple(objects.lights),
        world=world,
    )


class _Shown(NamedTuple):
    """What all entries that show one mesh by one object and one instancer have in common."""

    mesh: description.Mesh
    materials: tuple
    needs: object
    visibility: object
    name: str


class _Objects:
    """Collects what the objects become; nothing of an instance outlives `add`, as Blender reuses it."""

    def __init__(self, depsgraph, diagnostics, cache, still):
        self.instances, self.spheres, self.planes, self.lights = [], [], [], []
        self.curves = []
        self._is_render = depsgraph.mode == "RENDER"
        self._images = Images(diagnostics, depsgraph.scene_eval.frame_current, cache.images)
        self._materials = Materials(self._images, diagnostics, cache.materials)
        self._override = depsgraph.view_layer_eval.material_override
        self._depsgraph = depsgraph
        self._diagnostics = diagnostics
        self._known, self._known_worlds, self._known_lamps = cache.meshes, cache.worlds, cache.lamps
        self._meshes, self._worlds, self._lamps = {}, {}, {}
        self._still = still
        self._needs = {}
        self._infos = ObjectInfos(depsgraph, diagnostics)
        self._visibility = Visibilities(depsgraph)
        self._layer = self._visibility.state, address(self._override)
        self._known_entries = cache.entries if cache.layer == self._layer else {}
        self._entries, self._is_fixed = {}, True
        self._seen, self._shared = set(), set()
        self._mesh_keys = {id(kept.value): key for key, kept in cache.meshes.items()}
        self._shown, self._owners, self._staying = {}, {}, set()
        self._doubtful, self._alike = cache.doubtful, {}

    def world(self, world):
        """The world, black where there is none."""
        if world is None:
            return export_world(None, self._images, self._diagnostics)
        key = world.as_pointer(), address(world)
        kept = self._known_worlds.get(key) or keep_shader(world, export_world, self._images, self._diagnostics)
        self._worlds[key] = kept
        return kept.value

    def leave(self, cache):
        """Hand what was used to the next export."""
        cache.meshes, cache.worlds, cache.lamps = self._meshes, self._worlds, self._lamps
        cache.materials, cache.images = self._materials.used, self._images.used
        cache.entries, cache.layer, cache.shared = self._entries, self._layer, self._shared
        cache.doubtful = set()

    def take(self, instance, place):
        """Add all of one entry of the dependency graph, whose matrix has the bytes `place`."""
        obj = instance.object
        key = key_of(obj)
        common = key
        if instance.is_instance:
            common = *key, address(instance.parent)
            self._shared.update((common[0], common[2]))
            key = *common, tuple(instance.persistent_id)
        elif key[0] in self._seen:
            self._shared.add(key[0])
        else:
            self._seen.add(key[0])
        lists = self.instances, self.spheres, self.curves, self.planes
        kept = self._known_entries.get(key)
        if kept is not None and kept.place == place and self._stays(kept) and self._is_alike(kept, instance, common):
            self._entries[key] = kept
            for things, kept_things in zip(lists, kept.things, strict=True):
                things.extend(kept_things)
            return
        counts, self._is_fixed = [len(things) for things in lists], self._still is None and obj.type != "LIGHT"
        if instance.show_self:
            self.add(instance, _matrix(place), common)
        if instance.show_particles:
            self.add_hair(instance, place)
        if self._is_fixed:
            things = tuple(tuple(things[n:]) for things, n in zip(lists, counts, strict=True))
            if common not in self._owners:
                self._owners[common] = frozenset(map(address, (obj, obj.data, instance.parent)))
            self._entries[key] = Entry(things, place, self._owners[common])

    def _stays(self, kept):
        """Whether the meshes and materials of an `Entry` are as they were; they are then used."""
        instances, *others = kept.things
        for instance in instances:
            both = id(instance.mesh), id(instance.materials)
            if both in self._staying:
                continue
            key = self._mesh_keys.get(id(instance.mesh))
            if key is None or not all(map(self._materials.stays, instance.materials)):
                return False
            self._meshes.setdefault(key, self._known[key])
            self._staying.add(both)
        return all(self._materials.stays(thing.material) for things in others for thing in things)

    def _is_alike(self, kept, instance, common):
        """Whether an object's own settings are those of its `Entry`; in doubt, they are not."""
        if kept.owners.isdisjoint(self._doubtful):
            return True
        if common not in self._alike:
            instances, *others = kept.things
            seen = self._visibility(instance)
            self._alike[common] = not any(others) and all(
                thing.visibility == seen and not self._needs_of(thing.materials).objects for thing in instances
            )
        return bool(kept.things[0]) and self._alike[common]

    def add(self, instance, matrix, common):
        """Add one entry of the dependency graph; `common` tells which ones show the same, by the same instancer."""
        obj, data = instance.object, instance.object.data
        # Text, curves and metaballs come twice: as what they are and as the mesh made of them. Only the mesh counts.
        if type(data) is bpy.types.Mesh:
            self._add_mesh(instance, data, matrix, common)
        elif isinstance(data, bpy.types.Light):
            seen = self._visibility(instance)
            if self._still is not None:
                _, matrix = self._still(instance, None, matrix)
            shader = self._lamp_shader(data)
            info = partial(self._info, instance, needs_of((shader,)))
            light = export_light(data, matrix, obj.name, shader, self._diagnostics, seen, info)
            if light is not None:
                self.lights.append(light)
        elif isinstance(data, bpy.types.PointCloud):
            material = self._materials_of(obj, data)[:1]
            needs = self._needs_of(material)
            names = needs.attributes | needs.colors
            spheres = export_points(data, matrix, material[0], obj.name, self._diagnostics, names)
            if spheres is not None:
                info, seen = self._info(instance, needs), self._visibility(instance)
                self.spheres.append(replace(spheres, info=info, visibility=seen))
        elif isinstance(data, bpy.types.Curves):
            material = self._materials_of(obj, data)[:1]
            needs = self._needs_of(material)
            curves = export_curves(data, matrix, material[0], obj.name, needs)
            if curves is not None:
                info, seen = self._info(instance, needs), self._visibility(instance)
                self.curves.append(replace(curves, info=info, visibility=seen))
        elif obj.type == "EMPTY":
            self._add_plane(instance, matrix)
        elif obj.type in _NOT_YET:
            self._diagnostics.warn(_NOT_YET[obj.type], f"object '{obj.name}'")

    def add_hair(self, instance, place):
        """Add the hair of one entry's particle systems."""
        obj = instance.object
        if obj.type != "MESH" or not has_hair(obj, self._is_render):
            return
        self._is_fixed = False
        materials = self._materials_of(obj, obj.data)
        for curves in export_hair(obj, _matrix(place), materials, self._is_render, lambda m: self._needs_of((m,))):
            info = self._info(instance, self._needs_of((curves.material,)))
            self.curves.append(replace(curves, info=info, visibility=self._visibility(instance)))

    def _lamp_shader(self, light):
        """The `core.scene.Material` of a light's nodes, the same as in the export before where nothing changed."""
        key = address(light)
        if key not in self._lamps:
            shader, known = export_lamp_shader(light, self._images, self._diagnostics), self._known_lamps.get(key)
            self._lamps[key] = known if known is not None and is_same_graph(known, shader) else shader
        return self._lamps[key]

    def _add_mesh(self, instance, data, matrix, common):
        if common not in self._shown:
            self._shown[common] = self._show(instance, data)
        mesh, materials, needs, seen, name = self._shown[common]
        if self._still is not None:
            mesh, matrix = self._still(instance, mesh, matrix)
        if mesh is not None:
            info = self._info(instance, needs)
            self.instances.append(description.Instance(mesh, matrix, materials, name, info, seen))

    def _show(self, instance, data):
        obj, materials = instance.object, self._materials_of(instance.object, data)
        needs = self._needs_of(materials)
        # Evaluated meshes live as long as nothing changes them; their places are then used again.
        key = data.as_pointer(), data.session_uid, address(data)
        kept = self._meshes.get(key) or self._known.get(key)
        if kept is None or not needs <= kept.needs:  # other materials on the same mesh may read more of it
            known = needs if kept is None else needs | kept.needs
            owners = frozenset(map(address, (obj, obj.data, instance.parent)))
            kept = Kept(export_mesh(obj, data.name, known), owners, known)
        self._meshes[key] = kept
        return _Shown(kept.value, materials, needs, self._visibility(instance), obj.name)

    def _needs_of(self, materials):
        """What `materials` read, a `Needs`."""
        key = tuple(map(id, materials))
        if key not in self._needs:
            self._needs[key] = needs_of(m for m in materials if m is not None)
        return self._needs[key]

    def _info(self, instance, needs):
        """What nodes can ask of an object, where they do."""
        self._is_fixed &= not needs.object_attributes
        return self._infos(instance, needs.object_attributes) if needs.objects else description.ObjectInfo()

    def _materials_of(self, obj, data):
        """The material of each slot: the object's where the slot says so, else the data's."""
        if self._override is not None:
            return (self._materials(self._override),)
        materials = list(data.materials)
        for index, slot in enumerate(obj.material_slots):
            if slot.link == "OBJECT":
                materials.extend([None] * (index + 1 - len(materials)))
                materials[index] = slot.material
        return tuple(self._materials(material) for material in materials) or (self._materials.default,)

    def _add_plane(self, instance, transform):
        """An empty marked as an infinite plane: its XY plane, the front where its Z axis points."""
        obj = instance.object
        settings = getattr(obj, "zraka", None)
        if not getattr(settings, "plane", False):
            return
        normal = np.cross(transform[:3, 0], transform[:3, 1])
        length = np.linalg.norm(normal)
        if length == 0:
            self._diagnostics.warn("a plane scaled to nothing is not rendered", f"object '{obj.name}'")
            return
        normal *= np.copysign(1 / length, normal @ transform[:3, 2])
        material = getattr(settings, "plane_material", None)
        if material is not None:
            material = material.evaluated_get(self._depsgraph)
        material = self._materials(material)
        info = self._info(instance, self._needs_of((material,)))
        point, normal = tuple(transform[:3, 3].tolist()), tuple(normal.tolist())
        seen = self._visibility(instance)
        self.planes.append(description.Plane(point, normal, material, obj.name, info, seen))


def _places(depsgraph):
    """Matrices (N, 16) of all entries of the dependency graph."""
    entries = depsgraph.object_instances
    places = np.zeros((len(entries), 16), np.float32)
    entries.foreach_get("matrix_world", places.reshape(-1))
    return places


def _matrix(place):
    """Object to world, (4, 4) float64, of the bytes of a matrix in Blender."""
    return np.frombuffer(place, np.float32).reshape(4, 4).T.astype(np.float64, order="C")
