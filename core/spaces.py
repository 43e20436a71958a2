# SPDX-License-Identifier: GPL-3.0-or-later
"""What shader nodes know of objects and of the camera, as read-only tables.

Positions are relative to the geometry's `origin`, as everywhere behind the compiler; the matrices here take that into
account, so that nothing is lost far from the world's zero.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .camera_panorama import PLACES


@dataclass(frozen=True, eq=False)
class Objects:
    """Tables of the K objects that `Geometry.object` numbers, and of the M materials.

    Parameters
    ----------
    to_object, to_world : (12, K) float32
        Rows of 3 x 4 matrices.
    location, generated, uv : (3, K) float32
        Origin in the world; coordinates where an instance stands on its instancer.
    color : (4, K) float32
        With alpha.
    index, random : (1, K) float32
    mirrored : (1, K) bool
        Whether the second and third corner of its triangles have changed places.
    attributes : mapping of (type, name) to (4, K) float32
    material_index : (1, M) float32
    """

    to_object: np.ndarray
    to_world: np.ndarray
    location: np.ndarray
    generated: np.ndarray
    uv: np.ndarray
    color: np.ndarray
    index: np.ndarray
    random: np.ndarray
    mirrored: np.ndarray
    attributes: dict
    material_index: np.ndarray


class View:
    """The camera as shader nodes see it.

    Parameters
    ----------
    camera : core.scene.Camera
    width, height : int
        Of the whole frame in pixels.
    origin : (3,) float64
        What the geometry subtracted from the world.

    Attributes
    ----------
    to_camera, to_world : (12, 1) float32
        Rows of 3 x 4 matrices; camera space has Y up and looks along +Z.
    origin : (3, 1) float32
    is_perspective, is_parallel : bool
        Which projection it has; neither is true of panoramas.
    pixel : (float, float)
        Width and height of a pixel as shares of the frame's.
    """

    def __init__(self, camera, width, height, origin):
        with np.errstate(over="ignore"):
            self.origin = np.array(origin, np.float32).reshape(3, 1)
        self._offset = np.array(origin, np.float64)
        self.look_through(camera, width, height)

    def look_through(self, camera, width, height):
        """Replace the camera and the frame."""
        matrix = np.array(camera.transform, np.float64)
        matrix[:3, :3] /= np.linalg.norm(matrix[:3, :3], axis=0)
        matrix[:3, 3] -= self._offset
        matrix[:3, 2] *= -1
        self.to_camera, self.to_world = rows_of(np.linalg.inv(matrix)), rows_of(matrix)
        self.is_perspective = camera.projection == "PERSPECTIVE"
        self.is_parallel = camera.projection == "ORTHOGRAPHIC"
        self._panorama = camera.panorama if camera.projection == "PANORAMIC" else None
        self._clip_start = float(camera.clip_start)
        self._window = tuple(float(x) for x in camera.window)
        left, right, bottom, top = self._window
        self.pixel = 1.0 / width, 1.0 / height
        self._pixel = (right - left) / width, (top - bottom) / height

    def raster(self, p, arena):
        """Where points `p` (3, N) of camera space are seen, (3, N): x and y from 0 to 1 over the frame, z 0."""
        left, right, bottom, top = self._window
        out = arena.zeros((3, p.shape[-1]))
        with arena.frame():
            depth = _away_from_zero(p[2], arena) if self.is_perspective else np.float32(1)
            x, y = p[:2] if self._panorama is None else PLACES[self._panorama.kind](self._panorama, *p)
            for row, coordinate, low, high in ((out[0], x, left, right), (out[1], y, bottom, top)):
                np.divide(coordinate, depth, out=row)
                np.subtract(row, low, out=row)
                np.divide(row, high - low, out=row)
        return out

    def ray_length(self, p):
        """Distance (N,) of points `p` (3, N) of camera space from where the camera's rays start."""
        depth = np.maximum(p[2] - np.float32(self._clip_start), 0)
        if not self.is_perspective:
            return depth
        return np.sqrt(np.einsum("in,in->n", p, p)) * depth / np.maximum(p[2], np.float32(1e-20))

    def footprint(self, p, prim, arena):
        """Radius (N,) of a pixel at points `p` (3, N) of camera space, on primitives `prim` (N,).

        It is the mean of the half axes' lengths, and the same on all primitives.

        Notes
        -----
        For a perspective camera a pixel's step at distance 1 is projected onto the plane across the ray. Source:
        Igehy, "Tracing Ray Differentials", 1999, for a ray that comes straight from the camera.
        """
        x, y = self._pixel
        out = arena.full(p.shape[-1], 0.5 * (x + y))
        if not self.is_perspective:
            return out
        with arena.frame():
            square = np.maximum(np.einsum("in,in->n", p, p), np.float32(1e-30))
            across = [np.sqrt(np.maximum(1 - row * row / square, 0)) for row in p[:2]]
            np.multiply(across[0] * np.float32(0.5 * x) + across[1] * np.float32(0.5 * y), np.abs(p[2]), out=out)
        return out


def rows_of(matrix):
    """The upper three rows of a (4, 4) matrix, or of K of them, as (12, K) float32."""
    matrix = np.asarray(matrix, np.float64).reshape(-1, 4, 4)
    with np.errstate(over="ignore"):
        matrix = matrix.astype(np.float32)
    return np.ascontiguousarray(matrix[:, :3].reshape(-1, 12).T)


def transform_point(rows, p, arena, out=None):
    """3 x 4 matrices `rows` (12, K) times points (3, N); K is N or 1."""
    return _transform(rows, p, arena, out, translate=True)


def transform_direction(rows, d, arena, out=None):
    """3 x 4 matrices `rows` (12, K), without their last column, times directions (3, N); K is N or 1."""
    return _transform(rows, d, arena, out, translate=False)


def transform_normal(inverse, n, arena, out=None):
    """Normals (3, N), not of unit length, under the transform whose `inverse` has the rows (12, K)."""
    turned = inverse.reshape(3, 4, -1).transpose(1, 0, 2)[:3]
    out = arena.empty((3, max(inverse.shape[-1], n.shape[-1]))) if out is None else out
    _multiply(turned, n, arena, out)
    return out


def _transform(rows, v, arena, out, translate):
    out = arena.empty((3, max(rows.shape[-1], v.shape[-1]))) if out is None else out
    matrix = rows.reshape(3, 4, -1)
    _multiply(matrix[:, :3], v, arena, out)
    if translate:
        np.add(out, matrix[:, 3], out=out)
    return out


def _multiply(matrix, v, arena, out):
    """(3, 3, K) matrices times (3, N) vectors."""
    with arena.frame():
        t = arena.empty(out.shape[-1])
        for total, row in zip(out, matrix, strict=True):
            np.multiply(row[0], v[0], out=total)
            for factor, component in zip(row[1:], v[1:], strict=True):
                np.multiply(factor, component, out=t)
                np.add(total, t, out=total)


def _away_from_zero(x, arena):
    """`x` (N,), at least 1e-20 in size, its sign kept."""
    out = np.abs(x, out=arena.empty(x.shape))
    np.maximum(out, 1e-20, out=out)
    return np.copysign(out, x, out=out)
