# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's camera parameters to the window that a `core.scene.Camera` looks through."""

from __future__ import annotations


def blender_window(
    lens=50.0,
    sensor_width=36.0,
    sensor_height=24.0,
    sensor_fit="AUTO",
    shift_x=0.0,
    shift_y=0.0,
    width=1920,
    height=1080,
    pixel_aspect_x=1.0,
    pixel_aspect_y=1.0,
    ortho_scale=6.0,
    projection="PERSPECTIVE",
):
    """Edges of the whole frame, as `core.scene.Camera.window` wants them.

    The *fitted side* of the picture is the width or the height, by `sensor_fit`; AUTO takes the longer one and always
    the sensor's width. The sensor (or `ortho_scale`) spans the fitted side, and both shifts are parts of it.

    Parameters
    ----------
    lens, sensor_width, sensor_height : float
        Millimetres.
    sensor_fit : {"AUTO", "HORIZONTAL", "VERTICAL"}
    shift_x, shift_y : float
        In fitted sides.
    width, height : int
        Pixels of the whole frame.
    pixel_aspect_x, pixel_aspect_y : float
        Width and height of a pixel, in any unit.
    ortho_scale : float
        World units that the fitted side spans; for ORTHOGRAPHIC only.
    projection : {"PERSPECTIVE", "ORTHOGRAPHIC", "PANORAMIC"}

    Returns
    -------
    left, right, bottom, top : float
        On the plane at distance 1 for PERSPECTIVE, in world units for ORTHOGRAPHIC, in whole panoramas for PANORAMIC.
    """
    if projection == "PANORAMIC":  # its shifts are parts of the frame's own sides
        return shift_x, 1 + shift_x, shift_y, 1 + shift_y
    w, h = width * pixel_aspect_x, height * pixel_aspect_y
    horizontal = sensor_fit == "HORIZONTAL" or (sensor_fit == "AUTO" and w >= h)
    fitted = w if horizontal else h
    if projection == "ORTHOGRAPHIC":
        span = ortho_scale
    else:
        span = (sensor_height if sensor_fit == "VERTICAL" else sensor_width) / lens
    x, y = 0.5 * span * w / fitted, 0.5 * span * h / fitted
    dx, dy = shift_x * span, shift_y * span
    return dx - x, dx + x, dy - y, dy + y
