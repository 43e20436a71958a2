# SPDX-License-Identifier: GPL-3.0-or-later
"""Pixel samples to rays."""

from __future__ import annotations

import math

import numpy as np

from .camera_lens import LEAST_FOCUS, aperture_points
from .camera_panorama import DIRECTIONS, ROUND
from .diagnostics import SceneError
from .vecmath import dot, normalize

_FLATTEST = 1e-9  # volume that a camera's axes span, brought to length 1


class CameraRays:
    """A camera made ready for one picture size.

    Parameters
    ----------
    camera : core.scene.Camera
    width, height : int
        Of the whole frame.
    origin : (3,) float64
        What the geometry subtracted from the world.

    Attributes
    ----------
    dimensions : tuple of int
        Which numbers of `Draw.PIXEL` a ray needs: the place in the pixel, and that in the lens if there is one.
    has_far : bool
        Whether `rays` returns limits.
    is_round : bool
        Whether there are parts of the picture that show nothing: rays with a limit of 0.
    """

    def __init__(self, camera, width, height, origin):
        matrix = np.asarray(camera.transform, np.float64)
        self._width = width
        axes = matrix[:3, :3] / np.linalg.norm(matrix[:3, :3], axis=0)
        self._right, self._up, self._forward = (_floats(v) for v in (axes[:, 0], axes[:, 1], -axes[:, 2]))
        eye = matrix[:3, 3] - origin
        self._eye = _floats(eye)
        self._clip_start, self._clip_end = float(camera.clip_start), float(camera.clip_end)
        self._lens = camera.lens if camera.lens is not None and camera.lens.radius > 0 else None
        self.dimensions = (0, 1) if self._lens is None else (0, 1, 2, 3)
        self._panorama = camera.panorama
        self.is_round = camera.projection == "PANORAMIC" and camera.panorama.kind in ROUND
        self.has_far = math.isfinite(self._clip_end) or self.is_round
        self._start = {
            "PERSPECTIVE": self._start_perspective,
            "ORTHOGRAPHIC": self._start_orthographic,
            "PANORAMIC": self._start_panoramic,
        }[camera.projection]
        left, right, bottom, top = camera.window
        self._step = (right - left) / width, (top - bottom) / height
        self._lower_left = left, bottom
        # A point of the window is corner + x·dx + y·dy, pixels from the lower left; distance 1 in front of the eye.
        dx, dy = axes[:, 0] * self._step[0], axes[:, 1] * self._step[1]
        corner = axes[:, 0] * left + axes[:, 1] * bottom
        if camera.projection == "PERSPECTIVE":
            corner -= axes[:, 2]
        else:
            corner = eye + corner - axes[:, 2] * self._clip_start
        self._corner, self._dx, self._dy = (_floats(v) for v in (corner, dx, dy))

    def rays(self, pixels, jitter, arena):
        """Rays through pixels.

        Parameters
        ----------
        pixels : (N,) int32
            ``y * width + x``, row 0 at the bottom.
        jitter : (D, N) float32
            Position in the pixel, or beside it; then numbers in [0, 1) for the lens, as `dimensions` says.

        Returns
        -------
        o, d : (3, N) float32
            Origins on the near clipping plane, unit directions.
        tmax : (N,) float32 or None
            Distance to the far clipping plane.
        """
        n = pixels.size
        o, d = arena.empty((3, n)), arena.empty((3, n))
        tmax = arena.empty(n) if self.has_far else None
        with arena.frame():
            x, y = self._raster(pixels, jitter, arena)
            aperture = None if self._lens is None else aperture_points(self._lens, jitter[2:4], arena)
            self._start(x, y, aperture, o, d, tmax, arena)
        return o, d, tmax

    def _raster(self, pixels, jitter, arena):
        x, y = arena.empty(pixels.size), arena.empty(pixels.size)
        row = arena.empty(pixels.size, np.int32)
        np.floor_divide(pixels, np.int32(self._width), out=row)
        np.copyto(y, row, casting="unsafe")
        np.add(y, jitter[1], out=y)
        np.multiply(row, np.int32(self._width), out=row)
        np.subtract(pixels, row, out=row)
        np.copyto(x, row, casting="unsafe")
        np.add(x, jitter[0], out=x)
        return x, y

    def _on_window(self, x, y, out, arena):
        """Points (3, N) of the window."""
        t = arena.empty(x.size)
        for i in range(3):
            np.multiply(x, self._dx[i], out=out[i])
            np.multiply(y, self._dy[i], out=t)
            np.add(out[i], t, out=out[i])
            np.add(out[i], self._corner[i], out=out[i])

    def _start_perspective(self, x, y, aperture, o, d, tmax, arena):
        self._on_window(x, y, d, arena)
        if aperture is not None:
            self._through_lens(aperture, o, d, tmax, arena)
            return
        for i in range(3):
            np.multiply(d[i], self._clip_start, out=o[i])
            np.add(o[i], self._eye[i], out=o[i])
        if tmax is not None:
            # d has length 1 along the view axis here, so the far plane is at |d| times the depth.
            _length(d, tmax, arena)
            np.divide(d, tmax, out=d)
            np.multiply(tmax, self._clip_end - self._clip_start, out=tmax)
        else:
            normalize(d, arena, out=d)

    def _through_lens(self, aperture, o, d, tmax, arena):
        """Rays from the aperture to where the ray from its middle, `d`, is in focus."""
        stretch, t = arena.empty(d.shape[1]), arena.empty(d.shape[1])
        _length(d, stretch, arena)
        focus = max(self._lens.focus_distance, LEAST_FOCUS)
        for i in range(3):
            self._across(aperture, i, o[i], t)
            np.multiply(o[i], 1 / focus, out=t)
            np.subtract(d[i], t, out=d[i])
            np.add(o[i], self._eye[i], out=o[i])
        normalize(d, arena, out=d)
        # As in Cycles, the clipping planes are where the ray from the middle of the lens meets them.
        for i in range(3):
            np.multiply(d[i], stretch, out=t)
            np.multiply(t, self._clip_start, out=t)
            np.add(o[i], t, out=o[i])
        if tmax is not None:
            np.multiply(stretch, self._clip_end - self._clip_start, out=tmax)

    def _start_orthographic(self, x, y, aperture, o, d, tmax, arena):
        self._on_window(x, y, o, arena)
        for i in range(3):
            d[i].fill(self._forward[i])
        if tmax is not None:
            tmax.fill(self._clip_end - self._clip_start)
        if aperture is None:
            return
        focus = max(self._lens.focus_distance, LEAST_FOCUS)
        across, t = arena.empty(x.size), arena.empty(x.size)
        for i in range(3):
            self._across(aperture, i, across, t)
            np.multiply(across, 1 / focus, out=t)
            np.subtract(d[i], t, out=d[i])
            # The aperture stands at the eye; the rays start at the near plane.
            np.multiply(across, 1 - self._clip_start / focus, out=t)
            np.add(o[i], t, out=o[i])
        normalize(d, arena, out=d)

    def _across(self, aperture, i, out, t):
        """Component `i` of the points of the aperture, from its middle."""
        np.multiply(aperture[0], self._right[i], out=out)
        np.multiply(aperture[1], self._up[i], out=t)
        np.add(out, t, out=out)

    def _start_panoramic(self, x, y, aperture, o, d, tmax, arena):
        u, v = arena.empty(x.size), arena.empty(x.size)
        for out, raster, step, low in zip((u, v), (x, y), self._step, self._lower_left, strict=True):
            np.multiply(raster, step, out=out)
            np.add(out, low, out=out)
        right, up, forward, seen = DIRECTIONS[self._panorama.kind](self._panorama, u, v)
        for i in range(3):
            np.multiply(right, self._right[i], out=d[i])
            for part, axis in ((up, self._up), (forward, self._forward)):
                np.multiply(part, axis[i], out=u)
                np.add(d[i], u, out=d[i])
        normalize(d, arena, out=d)
        for i in range(3):
            o[i].fill(self._eye[i])
        if aperture is not None:
            self._through_moving_lens(aperture, o, d, arena)
        for i in range(3):
            np.multiply(d[i], self._clip_start, out=u)
            np.add(o[i], u, out=o[i])
        if tmax is not None:
            tmax.fill(self._clip_end - self._clip_start)
        if seen is not None:
            np.copyto(tmax, 0, where=~seen)

    def _through_moving_lens(self, aperture, o, d, arena):
        """Rays of a panorama, whose lens faces each direction `d` in turn: Cycles, kernel/camera/camera.h."""
        axis = self._right if self._panorama.kind == "MIRRORBALL" else self._forward
        axis = np.array(axis, np.float32).reshape(3, 1)
        across = normalize(axis - (axis * d).sum(axis=0) * d, arena)
        upwards = np.cross(d, across, axis=0)
        focus = np.float32(max(self._lens.focus_distance, LEAST_FOCUS))
        point = across * aperture[0] + upwards * aperture[1]
        np.add(o, point, out=o)
        np.subtract(d, point / focus, out=d)
        normalize(d, arena, out=d)


def check_camera(camera):
    """Refuse a camera that looks nowhere.

    Raises
    ------
    SceneError
    """
    matrix, numbers = np.asarray(camera.transform, np.float64), [*camera.window, camera.clip_start]
    if matrix.shape != (4, 4) or not (np.isfinite(matrix).all() and np.isfinite(numbers).all()):
        raise SceneError("the camera's place or lens has numbers that are not finite; clear its transform")
    lengths = np.linalg.norm(matrix[:3, :3], axis=0)
    if not lengths.all() or abs(np.linalg.det(matrix[:3, :3] / lengths)) < _FLATTEST:
        raise SceneError("the camera is scaled to nothing along an axis; clear its scale")


def _length(v, out, arena):
    """Lengths (N,) of `v` (3, N)."""
    np.sqrt(dot(v, v, arena, out=out), out=out)


def _floats(v):
    return tuple(float(x) for x in v)
