# SPDX-License-Identifier: GPL-3.0-or-later
"""Directions that the points of a panoramic picture show, and where it shows a direction.

A function of `DIRECTIONS` takes the description and the place in the picture, `x` and `y` (N,) in [0, 1] from the lower
left, and returns (right, up, forward), each (N,), not always of unit length, and where the picture shows anything: (N,)
bool, or None for everywhere. One of `PLACES` takes the description and right, up and forward, and returns x and y, also
of directions beyond the picture.

Sources: Blender's manual, "Cameras: Panoramic"; Cycles, kernel/camera/projection.h; Google, "Bringing pixels front and
center in VR video", 2017, for the cubemap's face.
"""

from __future__ import annotations

import numpy as np


def equirectangular(panorama, x, y):
    """Longitude to the right, latitude upwards."""
    longitude, latitude = _between(panorama.longitude, x), _between(panorama.latitude, y)
    flat = np.cos(latitude)
    return flat * np.sin(longitude), np.sin(latitude), flat * np.cos(longitude), None


def equiangular_cubemap_face(panorama, x, y):
    """The front face of a cube, its angles evenly spread."""
    right, up = (np.tan((a - np.float32(0.5)) * np.float32(0.5 * np.pi)) for a in (x, y))
    return right, up, np.ones_like(x), None


def central_cylindrical(panorama, x, y):
    """A cylinder around the camera, seen from its middle."""
    longitude, height = _between(panorama.longitude, x), _between(panorama.height, y)
    return np.sin(longitude), height, np.cos(longitude), None


def mirror_ball(panorama, x, y):
    """What a mirroring ball shows that fills the picture, seen from far away."""
    a, b = 2 * x - 1, 2 * y - 1
    square = a * a + b * b
    # The normal's cosine to the view axis; the mirrored view axis is 2 (n·v) n - v.
    cosine = np.sqrt(np.maximum(1 - square, 0))
    return 2 * cosine * a, 2 * cosine * b, 2 * cosine * cosine - 1, square <= 1


def fisheye_equidistant(panorama, x, y):
    """The angle from the axis grows in proportion to the distance from the middle."""
    a, b = 2 * x - 1, 2 * y - 1
    r = np.hypot(a, b)
    return *_around_axis(a, b, r, r * np.float32(0.5 * panorama.fov)), r <= 1


def fisheye_equisolid(panorama, x, y):
    """Equal areas of the picture show equal solid angles."""
    a, b, r = _on_sensor(panorama, x, y)
    reach = abs(2 * panorama.lens * np.sin(0.25 * panorama.fov))
    sine = np.clip(r / np.float32(2 * max(panorama.lens, 1e-6)), -1, 1)
    return *_around_axis(a, b, r, 2 * np.arcsin(sine)), r <= np.float32(reach)


def fisheye_lens_polynomial(panorama, x, y):
    """The angle from the axis is a polynomial of the distance from the middle."""
    a, b, r = _on_sensor(panorama, x, y)
    angle = np.zeros_like(r)
    for k in reversed(panorama.polynomial):
        angle = angle * r + np.float32(k)
    return *_around_axis(a, b, r, -angle), np.abs(angle) <= np.float32(0.5 * panorama.fov)


DIRECTIONS = {
    "EQUIRECTANGULAR": equirectangular,
    "EQUIANGULAR_CUBEMAP_FACE": equiangular_cubemap_face,
    "MIRRORBALL": mirror_ball,
    "FISHEYE_EQUIDISTANT": fisheye_equidistant,
    "FISHEYE_EQUISOLID": fisheye_equisolid,
    "FISHEYE_LENS_POLYNOMIAL": fisheye_lens_polynomial,
    "CENTRAL_CYLINDRICAL": central_cylindrical,
}
# Kinds that leave parts of the picture black.
ROUND = {"MIRRORBALL", "FISHEYE_EQUIDISTANT", "FISHEYE_EQUISOLID", "FISHEYE_LENS_POLYNOMIAL"}


def _place_equirectangular(panorama, right, up, forward):
    latitude = np.arctan2(up, np.hypot(right, forward))
    return _share(panorama.longitude, np.arctan2(right, forward)), _share(panorama.latitude, latitude)


def _place_cubemap(panorama, right, up, forward):
    return [np.arctan2(a, forward) * np.float32(2 / np.pi) + np.float32(0.5) for a in (right, up)]


def _place_cylindrical(panorama, right, up, forward):
    height = up / np.maximum(np.hypot(right, forward), _LEAST)
    return _share(panorama.longitude, np.arctan2(right, forward)), _share(panorama.height, height)


def _place_mirror_ball(panorama, right, up, forward):
    length = np.sqrt(right * right + up * up + forward * forward)
    # The normal is half way between the direction and the view axis.
    scale = np.float32(0.5) / np.maximum(np.hypot(np.hypot(right, up), forward + length), _LEAST)
    return right * scale + np.float32(0.5), up * scale + np.float32(0.5)


def _place_equidistant(panorama, right, up, forward):
    across, angle = _from_axis(right, up, forward)
    scale = angle / (np.float32(panorama.fov) * across)
    return right * scale + np.float32(0.5), up * scale + np.float32(0.5)


def _place_equisolid(panorama, right, up, forward):
    across, angle = _from_axis(right, up, forward)
    return _off_sensor(panorama, right, up, np.float32(2 * panorama.lens) * np.sin(0.5 * angle) / across)


def _place_polynomial(panorama, right, up, forward):
    """The polynomial is undone as far as it grows, to three times the sensor's corner."""
    across, angle = _from_axis(right, up, forward)
    r = np.linspace(0, 1.5 * np.hypot(*panorama.sensor), 1 << 12)
    angles = np.maximum.accumulate(-np.polynomial.polynomial.polyval(r, panorama.polynomial))
    return _off_sensor(panorama, right, up, np.interp(angle, angles, r).astype(np.float32) / across)


PLACES = {
    "EQUIRECTANGULAR": _place_equirectangular,
    "EQUIANGULAR_CUBEMAP_FACE": _place_cubemap,
    "MIRRORBALL": _place_mirror_ball,
    "FISHEYE_EQUIDISTANT": _place_equidistant,
    "FISHEYE_EQUISOLID": _place_equisolid,
    "FISHEYE_LENS_POLYNOMIAL": _place_polynomial,
    "CENTRAL_CYLINDRICAL": _place_cylindrical,
}
_LEAST = np.float32(1e-20)


def _between(limits, t):
    low, high = limits
    return np.float32(low) + np.float32(high - low) * t


def _share(limits, value):
    """Undoes `_between`."""
    low, high = limits
    return (value - np.float32(low)) / np.float32(high - low or 1.0)


def _from_axis(right, up, forward):
    """Distance from the view axis and angle to it."""
    across = np.maximum(np.hypot(right, up), _LEAST)
    return across, np.arctan2(across, forward)


def _off_sensor(panorama, right, up, scale):
    """Undoes `_on_sensor`."""
    return [
        a * scale / np.float32(size or 1.0) + np.float32(0.5)
        for a, size in zip((right, up), panorama.sensor, strict=True)
    ]


def _on_sensor(panorama, x, y):
    """Millimetres from the middle of the sensor: right, up, distance."""
    width, height = panorama.sensor
    a, b = (x - np.float32(0.5)) * np.float32(width), (y - np.float32(0.5)) * np.float32(height)
    return a, b, np.hypot(a, b)


def _around_axis(a, b, r, angle):
    """Direction at `angle` from the axis, turned to where (a, b), of length r, points."""
    scale = np.sin(angle) / np.maximum(r, np.float32(1e-20))
    return a * scale, b * scale, np.cos(angle)
