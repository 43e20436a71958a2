# SPDX-License-Identifier: GPL-3.0-or-later
"""The camera, the frame and its border."""

from __future__ import annotations

import bpy
import numpy as np

from ...core import scene as description
from ...core.camera_description import PANORAMAS
from ...core.camera_window import blender_window
from ...core.diagnostics import SceneError

PROJECTIONS = {"PERSP": "PERSPECTIVE", "ORTHO": "ORTHOGRAPHIC", "PANO": "PANORAMIC"}


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


def export_camera(depsgraph, diagnostics, camera=None, size=None, eye=None):
    """The camera as `core.scene.Camera`.

    Parameters
    ----------
    depsgraph : bpy.types.Depsgraph
    diagnostics : Diagnostics
    camera : bpy.types.Object or str, optional
        Another camera than the scene's.
    size : (width, height), optional
        Of the whole frame in pixels; the scene's by default.
    eye : (matrix, shift), optional
        Of one view of a stereo render: where it is, object to world, and its horizontal shift; the camera's by default.

    Raises
    ------
    SceneError
        There is no camera, or the object named is none.
    """
    scene = depsgraph.scene_eval
    obj = _camera_object(scene, camera).evaluated_get(depsgraph)
    data = obj.data
    place = f"camera '{obj.name}'"
    if data.type not in PROJECTIONS:
        diagnostics.warn(f"{data.type.lower()} cameras are not supported; a perspective one is used", place)
    projection = PROJECTIONS.get(data.type, "PERSPECTIVE")
    width, height = size or frame_size(scene)
    aspect = width * scene.render.pixel_aspect_x / (height * scene.render.pixel_aspect_y)
    matrix, shift_x = eye or (obj.matrix_world, data.shift_x)
    transform = _without_scale(np.array(matrix, np.float64))
    return description.Camera(
        transform=transform,
        window=camera_window(data, scene.render, projection, (width, height), shift_x),
        projection=projection,
        clip_start=data.clip_start,
        clip_end=data.clip_end,
        lens=_thin_lens(data, projection, transform) if data.dof.use_dof else None,
        panorama=_panorama(data, aspect, diagnostics, place) if projection == "PANORAMIC" else description.Panorama(),
    )


def camera_window(data, render, projection, size, shift_x):
    """What a frame of `size` pixels spans, as `core.scene.Camera.window`, seen in any `projection`."""
    return blender_window(
        data.lens,
        data.sensor_width,
        data.sensor_height,
        data.sensor_fit,
        shift_x,
        data.shift_y,
        *size,
        render.pixel_aspect_x,
        render.pixel_aspect_y,
        data.ortho_scale,
        projection,
    )


def _thin_lens(data, projection, transform):
    """Depth of field; an orthographic camera has a focal length of one unit. Source: Cycles, blender/camera.cpp."""
    dof = data.dof
    focal_length = 1.0 if projection == "ORTHOGRAPHIC" else data.lens * 1e-3
    return description.ThinLens(
        radius=focal_length / (2 * max(dof.aperture_fstop, 1e-5)),
        focus_distance=_focus_distance(dof, transform),
        blades=dof.aperture_blades,
        rotation=dof.aperture_rotation,
        ratio=dof.aperture_ratio,
    )


def _focus_distance(dof, transform):
    """Distance along the view axis to the object, or the bone, that is to be sharp; else the number given."""
    target = dof.focus_object
    if target is None:
        return dof.focus_distance
    matrix = np.array(target.matrix_world, np.float64)
    bone = target.pose.bones.get(dof.focus_subtarget) if target.pose and dof.focus_subtarget else None
    if bone is not None:
        matrix = matrix @ np.array(bone.matrix, np.float64)
    return abs(float(transform[:3, 2] @ (transform[:3, 3] - matrix[:3, 3])))


def _panorama(data, aspect, diagnostics, place):
    """Which panorama it is, with the limits that its kind reads."""
    kind = data.panorama_type
    if kind not in PANORAMAS:
        diagnostics.warn(f"panorama {kind} is not known; an equirectangular one is rendered", place)
        kind = "EQUIRECTANGULAR"
    longitude, height = (data.longitude_min, data.longitude_max), (-1.0, 1.0)
    if kind == "CENTRAL_CYLINDRICAL":
        longitude = data.central_cylindrical_range_u_min, data.central_cylindrical_range_u_max
        low, high = data.central_cylindrical_range_v_min, data.central_cylindrical_range_v_max
        height = low / data.central_cylindrical_radius, high / data.central_cylindrical_radius
    return description.Panorama(
        kind=kind,
        longitude=longitude,
        latitude=(data.latitude_min, data.latitude_max),
        height=height,
        fov=data.fisheye_fov,
        lens=data.fisheye_lens,
        sensor=_sensor(data, aspect),
        polynomial=tuple(getattr(data, f"fisheye_polynomial_k{i}") for i in range(5)),
    )


def _sensor(data, aspect):
    """Millimetres that the whole frame spans: the sensor's size along the fitted side."""
    if data.sensor_fit == "HORIZONTAL" or (data.sensor_fit == "AUTO" and aspect >= 1):
        return data.sensor_width, data.sensor_width / aspect
    size = data.sensor_height if data.sensor_fit == "VERTICAL" else data.sensor_width
    return size * aspect, size


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
