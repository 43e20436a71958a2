# SPDX-License-Identifier: GPL-3.0-or-later
"""Which of the dependency graph's updates change what is exported."""

from __future__ import annotations

import bpy

from ..export.updates import is_camera, is_touched
from ..export.visibility import layer_state
from ..properties import settings_of


def changes_scene(depsgraph):
    """Whether an update tells that something but the viewer changed.

    A camera is the viewer's: looking through one that moves changes the view, which is compared for every picture. A
    scene that is updated in no respect stands for many things, a selection among them: see `fingerprint`.
    """
    return any(_matters(update) for update in depsgraph.updates)


def _matters(update):
    thing = update.id
    if is_camera(thing):
        return False
    if isinstance(thing, bpy.types.Object | bpy.types.Scene | bpy.types.Collection):
        return is_touched(update)
    return True


def fingerprint(depsgraph, visible):
    """What a scene can change by without naming it: its settings, its frame, its world, and which objects it shows.

    And how: by collections that are holdouts, or indirect only.
    """
    scene = depsgraph.scene_eval
    shown = [entry.object.name_full for entry in depsgraph.object_instances if entry.show_self and visible(entry)]
    world = scene.world.name_full if scene.world else None
    layer = layer_state(depsgraph.view_layer_eval)
    return settings_of(scene), scene.zraka.viewport_samples, scene.frame_current_final, world, tuple(shown), layer
