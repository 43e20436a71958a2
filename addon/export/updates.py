# SPDX-License-Identifier: GPL-3.0-or-later
"""What the dependency graph's updates say of what is exported."""

from __future__ import annotations

import bpy


def is_camera(thing):
    """Whether an ID is a camera, or an object that is one."""
    return isinstance(thing, bpy.types.Camera) or isinstance(getattr(thing, "data", None), bpy.types.Camera)


def is_touched(update):
    """Whether an update tells of a change; objects and scenes are also named where something else of them changed."""
    return update.is_updated_geometry or update.is_updated_transform or update.is_updated_shading


def key_of(obj):
    """What tells an evaluated object of `depsgraph.object_instances` from others, with the data that it shows."""
    data = obj.data
    return obj.original.as_pointer(), data.as_pointer() if data else 0


def address(thing):
    """What tells an ID of the file from others, whichever evaluated copy of it is given; 0 is none."""
    return 0 if thing is None else (thing.original or thing).as_pointer()
