# SPDX-License-Identifier: GPL-3.0-or-later
"""The camera, the frame and its border."""

from __future__ import annotations

import bpy
import numpy as np

from ...core import scene as description
from ...core.camera_window import blender_window
from ...core.diagnostics import SceneError


def frame_size(scene):
    """Width and height of the whole picture in pixels, the percentage included."""
    render = scene.render
    return tuple(
        max(1, resolution * render.resolution_percentage // 100)
        for resolution in (render.resolution_x, render.resolution_y)
    )


def render_border(scene, width, height):
    """Pixels inside the render border as (x0, y0, x1, y1), y upward, half open; None without a border.

    Rounded down in single precision, as Blender does, so that the result fits the one Blender allocates.
    """
    render = scene.render
    if not render.use_border:
        return None
    edges = (
        (render.border_min_x, width),
        (render.border_min_y, height),
        (render.border_max_x, width),
        (render.border_max_y, height),
    )
    return tuple(int(np.float32(fraction) * np.float32(size)) for fraction, size in edges)


def export_camera(depsgraph, diagnostics, camera=None, size=None):
    """The camera as `core.scene.Camera`.

    Parameters
    ----------
    depsgraph : bpy.types.Depsgraph
    diagnostics : Diagnostics
    camera : bpy.types.Object or str, optional
        Another camera than the scene's.
    size : (width, height), optional
        Of the whole frame in pixels; the scene's by default.

    Raises
    ------
    SceneError
        There is no camera, or the object named is none.
    """
    scene = depsgraph.scene_eval
    obj = _camera_object(scene, camera).evaluated_get(depsgraph)
    data = obj.data
    place = f"camera '{obj.name}'"
    if data.type not in ("PERSP", "ORTHO"):
        diagnostics.warn(f"{data.type.lower()} cameras are not supported; a perspective one is used", place)
    if data.dof.use_dof:
        diagnostics.warn("depth of field is not rendered yet; everything is in focus", place)
    projection = "ORTHOGRAPHIC" if data.type == "ORTHO" else "PERSPECTIVE"
    width, height = size or frame_size(scene)
    return description.Camera(
        transform=_without_scale(np.array(obj.matrix_world, np.float64)),
        window=blender_window(
            data.lens,
            data.sensor_width,
            data.sensor_height,
            data.sensor_fit,
            data.shift_x,
            data.shift_y,
            width,
            height,
            scene.render.pixel_aspect_x,
            scene.render.pixel_aspect_y,
            data.ortho_scale,
            projection,
        ),
        projection=projection,
        clip_start=data.clip_start,
        clip_end=data.clip_end,
    )


def _camera_object(scene, camera):
    if isinstance(camera, str):
        obj = scene.objects.get(camera)
        if obj is None:
            names = ", ".join(f"'{o.name}'" for o in scene.objects if o.type == "CAMERA") or "none"
            raise SceneError(f"there is no camera '{camera}' in the scene; it has {names}")
    else:
        obj = camera or scene.camera
    if obj is None:
        raise SceneError("the scene has no camera; add one or pass --camera NAME")
    if not isinstance(obj.data, bpy.types.Camera):
        raise SceneError(f"object '{obj.name}' is not a camera; choose one that is")
    return obj


def _without_scale(matrix):
    """`matrix` with axes of length 1; a mirrored camera stays mirrored, as in Blender."""
    lengths = np.linalg.norm(matrix[:3, :3], axis=0)
    matrix[:3, :3] /= np.where(lengths > 0, lengths, 1)
    return matrix
