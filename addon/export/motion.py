# SPDX-License-Identifier: GPL-3.0-or-later
"""What is seen while the shutter is open: the scene in the middle of each of some slices of that time."""

from __future__ import annotations

import math
from dataclasses import replace

import bpy
import numpy as np

from ...core.diagnostics import Diagnostics
from .camera import export_camera
from .scene import export_scene
from .updates import is_camera, is_touched

_CURVE_STEPS = 256


def shutter_times(render, count):
    """When, in frames from the frame that is rendered, equal shares of the light are let in, ascending.

    The shutter's curve tells how much light comes in when; each share's time is that by which half of it has come.
    Source: Cycles, whose shutter table is the same inverse of the curve's integral.

    Parameters
    ----------
    render : bpy.types.RenderSettings
    count : int
    """
    mapping = render.motion_blur_shutter_curve
    mapping.initialize()
    places = np.linspace(0, 1, _CURVE_STEPS + 1)
    height = np.maximum([mapping.evaluate(mapping.curves[0], place) for place in places], 0)
    passed = np.concatenate([[0], np.cumsum((height[1:] + height[:-1]) / 2)])
    shares = (np.arange(count) + 0.5) / count
    if passed[-1] > 0:
        shares = np.interp(shares, passed / passed[-1], places)
    opened = {"START": 0.0, "CENTER": -0.5, "END": -1.0}[render.motion_blur_position]
    return [float(time) for time in (shares + opened) * render.motion_blur_shutter]


class Still:
    """Keeps what is not to be blurred as it was when it was first exported: Cycles' switches of each object."""

    def __init__(self):
        self._first = {}

    def __call__(self, instance, mesh, matrix):
        """Mesh and matrix of an entry of `depsgraph.object_instances`, its own or those it is to keep."""
        moves = deforms = True
        for obj in (instance.object, instance.parent):
            moves &= _switch(obj, "use_motion_blur")
            deforms &= _switch(obj, "use_deform_motion")
        if moves and deforms:
            return mesh, matrix
        parent = instance.parent.name_full if instance.parent else ""
        key = instance.object.name_full, parent, tuple(instance.persistent_id)
        first = self._first.setdefault(key, (mesh, matrix))
        return first[0], matrix if moves else first[1]


def _switch(obj, name):
    return bool(getattr(getattr(obj, "cycles", None), name, True))


def export_slices(depsgraph, frame_set, first, times, camera, size, cache, still):
    """The scene at some times, a list of `core.scene.Scene`: the same object where nothing changed.

    Materials and the world stay as they are at the frame.

    Parameters
    ----------
    depsgraph : bpy.types.Depsgraph
    frame_set : callable
        ``frame_set(frame, subframe)`` of the engine that renders.
    first : core.scene.Scene
        At the frame itself, where the dependency graph stands before and after.
    times : sequence of float
        In frames from there, ascending.
    camera, size, cache, still
        As of `export_scene`; `first` was exported with them. Without `still`, switches of motion blur mean nothing.
    """
    scene = depsgraph.scene_eval
    unheard = Diagnostics()  # all of it was said of the frame itself
    camera = camera or scene.camera
    blurs_camera = still is None or _switch(camera, "use_motion_blur")
    frame, subframe, slices, latest = scene.frame_current, scene.frame_subframe, [], first
    try:
        for time in times:
            _set_time(frame_set, frame + subframe + time)
            cache.follow(depsgraph, shading=False)
            objects, cameras = _moved(depsgraph)
            if objects:
                latest = export_scene(depsgraph, unheard, camera, size, cache=cache, still=still)
                latest = latest if blurs_camera else replace(latest, camera=first.camera)
            elif cameras and blurs_camera:
                latest = replace(latest, camera=export_camera(depsgraph, unheard, camera, size))
            slices.append(latest)
    finally:
        frame_set(frame, subframe)
        cache.follow(depsgraph, shading=False)
    return slices


def export_around(depsgraph, frame_set, first, camera, size, cache, diagnostics):
    """The scene a frame before and a frame after, for the pass of motion vectors; () where they cannot be told.

    Parameters
    ----------
    depsgraph, frame_set, first, camera, size, cache
        As of `export_slices`; without `frame_set` no other frame is reached.
    diagnostics : Diagnostics
    """
    if depsgraph.scene_eval.render.use_motion_blur:
        reason = "with motion blur, as in Cycles"
    elif frame_set is None:
        reason = "in stereo views"
    else:
        return tuple(export_slices(depsgraph, frame_set, first, (-1.0, 1.0), camera, size, cache, None))
    diagnostics.warn(f"the pass 'Vector' stays empty {reason}")
    return ()


def _set_time(frame_set, time):
    frame = math.floor(time)
    frame_set(frame, min(time - frame, 1 - 1e-6))


def _moved(depsgraph):
    """Whether updates tell of objects, and whether of cameras; of the data of cameras and lamps no flag is set."""
    objects = cameras = False
    for update in depsgraph.updates:
        thing = update.id
        if is_camera(thing):
            cameras = True
        elif isinstance(thing, bpy.types.Light):
            objects = True
        elif isinstance(thing, bpy.types.Object | bpy.types.Collection):
            objects |= is_touched(update)
    return objects, cameras
