# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that moved, and nothing else: the rest of the scene is not even looked at."""

from __future__ import annotations

from dataclasses import replace

import bpy
import numpy as np

from .updates import is_camera, key_of


def export_moved(scene, depsgraph, cache):
    """The scene after meshes were moved.

    Parameters
    ----------
    scene : core.scene.Scene
        Exported last.
    depsgraph : bpy.types.Depsgraph
    cache : ExportCache
        What that export left; brought up to date where a scene is returned, else as it was.

    Returns
    -------
    core.scene.Scene or None
        None where the updates name more than objects that moved, or an object of which there may be several entries.
    """
    if not (cache.is_of(depsgraph) and len(depsgraph.updates)) or cache.has_passing:
        return None
    entries, moved = {}, {}
    for update in depsgraph.updates:
        obj = update.id
        if is_camera(obj):  # the viewer's
            continue
        key = _key_of_moved(update)
        entry = cache.entries.get(key)
        if entry is None or key[0] in cache.shared:
            return None
        matrix = np.array(obj.matrix_world, np.float64)
        place = matrix.T.astype(np.float32).tobytes()
        instances = tuple(replace(instance, transform=matrix) for instance in entry.things[0])
        moved |= {id(before): after for before, after in zip(entry.things[0], instances, strict=True)}
        entries[key] = entry._replace(things=(instances, *entry.things[1:]), place=place)
    cache.entries.update(entries)
    return replace(scene, instances=tuple(moved.get(id(i), i) for i in scene.instances)) if moved else scene


def _key_of_moved(update):
    """Key of the entry of a mesh that moved; None where an update tells of something else."""
    obj = update.id
    is_moved = update.is_updated_transform and not (update.is_updated_geometry or update.is_updated_shading)
    if not (is_moved and isinstance(obj, bpy.types.Object) and type(obj.data) is bpy.types.Mesh):
        return None
    return key_of(obj)
