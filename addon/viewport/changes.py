# SPDX-License-Identifier: GPL-3.0-or-later
"""Which of the dependency graph's updates change what is exported."""

from __future__ import annotations

import bpy

from ..properties import settings_of


def changes_scene(depsgraph):
    """Whether an update tells that something but the viewer changed.

    A camera is the viewer's: looking through one that moves changes the view, which is compared for every picture. A
    scene that is updated in no respect stands for many things, a selection among them: see `fingerprint`.
    """
    return any(_matters(update) for update in depsgraph.updates)


def _matters(update):
    thing = update.id
    if isinstance(thing, bpy.types.Camera) or isinstance(getattr(thing, "data", None), bpy.types.Camera):
        return False
    if isinstance(thing, bpy.types.Object | bpy.types.Scene | bpy.types.Collection):
        return update.is_updated_geometry or update.is_updated_transform or update.is_updated_shading
    return True


def fingerprint(depsgraph, visible):
    """What a scene can change by without naming it: its settings, its frame, its world, and which objects it shows."""
    scene = depsgraph.scene_eval
    shown = [entry.object.name_full for entry in depsgraph.object_instances if entry.show_self and visible(entry)]
    world = scene.world.name_full if scene.world else None
    return settings_of(scene), scene.zraka.viewport_samples, scene.frame_current_final, world, tuple(shown)
