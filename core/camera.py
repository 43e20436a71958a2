# SPDX-License-Identifier: GPL-3.0-or-later
"""Pixel samples to rays."""

from __future__ import annotations

import numpy as np

from .vecmath import normalize


class CameraRays:
    """A camera made ready for one picture size.

    Parameters
    ----------
    camera : core.scene.Camera
    width, height : int
        Of the whole frame.
    origin : (3,) float64
        What the geometry subtracted from the world.
    """

    def __init__(self, camera, width, height, origin):
        matrix = np.asarray(camera.transform, np.float64)
        axes = matrix[:3, :3] / np.linalg.norm(matrix[:3, :3], axis=0)
        left, right, bottom, top = camera.window
        self._width = width
        self._perspective = camera.projection == "PERSPECTIVE"
        self._clip_start, self._clip_end = float(camera.clip_start), float(camera.clip_end)
        self.has_far = np.isfinite(self._clip_end)
        # A point of the window is corner + x·dx + y·dy, pixels from the lower left; distance 1 in front of the eye.
        dx = axes[:, 0] * (right - left) / width
        dy = axes[:, 1] * (top - bottom) / height
        corner = axes[:, 0] * left + axes[:, 1] * bottom
        eye = matrix[:3, 3] - origin
        if self._perspective:
            corner -= axes[:, 2]
        else:
            corner = eye + corner - axes[:, 2] * self._clip_start
        self._corner, self._dx, self._dy = (_floats(v) for v in (corner, dx, dy))
        self._eye, self._forward = _floats(eye), _floats(-axes[:, 2])

    def rays(self, pixels, jitter, arena):
        """Rays through pixels.

        Parameters
        ----------
        pixels : (N,) int32
            ``y * width + x``, row 0 at the bottom.
        jitter : (2, N) float32
            Position in the pixel.

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
            target = d if self._perspective else o
            t = arena.empty(n)
            for i in range(3):
                np.multiply(x, self._dx[i], out=target[i])
                np.multiply(y, self._dy[i], out=t)
                np.add(target[i], t, out=target[i])
                np.add(target[i], self._corner[i], out=target[i])
        if self._perspective:
            self._start_perspective(o, d, tmax, arena)
        else:
            for i in range(3):
                d[i].fill(self._forward[i])
            if tmax is not None:
                tmax.fill(self._clip_end - self._clip_start)
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

    def _start_perspective(self, o, d, tmax, arena):
        for i in range(3):
            np.multiply(d[i], self._clip_start, out=o[i])
            np.add(o[i], self._eye[i], out=o[i])
        if tmax is not None:
            # d has length 1 along the view axis here, so the far plane is at |d| times the depth.
            with arena.frame():
                t = arena.empty(tmax.size)
                np.multiply(d[0], d[0], out=tmax)
                for i in (1, 2):
                    np.multiply(d[i], d[i], out=t)
                    np.add(tmax, t, out=tmax)
            np.sqrt(tmax, out=tmax)
            np.multiply(tmax, self._clip_end - self._clip_start, out=tmax)
        normalize(d, arena, out=d)


def _floats(v):
    return tuple(float(x) for x in v)
