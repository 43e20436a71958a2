# SPDX-License-Identifier: GPL-3.0-or-later
"""Instances grouped by mesh, with their arrays checked."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..diagnostics import SceneError
from ..scene import Mesh

# So many points have their extent faster at once than column by column.
_FEW = 1000
_MOST_ASKED = 64


class Placed(NamedTuple):
    """I instances of one mesh; of them, `flipped` ones mirror it and so turn its winding round."""

    mesh: Mesh
    numbers: np.ndarray  # (I,) of the objects
    matrix: np.ndarray  # (I, 4, 4) float64, object to world
    normal_matrix: np.ndarray  # (I, 3, 3) float64, takes object normals to the world, up to length
    flipped: np.ndarray  # (I,) bool
    vertices: np.ndarray  # (V, 3), object space
    triangles: np.ndarray  # (T, 3) uint32
    corners: np.ndarray | None  # (T, 3) uint32, None is the plain order
    rows: slice  # of the facets
    first_vertex: int  # in the table of all vertices
    is_shared: bool  # whether the mesh has other instances


def place(instances):
    """Instances grouped by mesh, a list of `Placed`; and the number of their triangles."""
    members: dict[int, list[int]] = {}
    for i, instance in enumerate(instances):
        members.setdefault(id(instance.mesh), []).append(i)
    groups, count, vertex_count = [], 0, 0
    matrices = np.array([_matrix(i) for i in instances]).reshape(-1, 4, 4)
    normal_matrix, flipped = _normal_matrices(matrices[:, :3, :3])
    for numbers in members.values():
        mesh = instances[numbers[0]].mesh
        vertices, triangles, corners = _checked(mesh)
        if not len(triangles):
            continue
        numbers = np.array(numbers, np.int32)
        rows = slice(count, count + len(numbers) * len(triangles))
        tables = vertices, triangles, corners, rows, vertex_count, len(numbers) > 1
        groups.append(Placed(mesh, numbers, matrices[numbers], normal_matrix[numbers], flipped[numbers], *tables))
        count = rows.stop
        vertex_count += len(numbers) * len(vertices)
    return groups, count


def _normal_matrices(linear):
    """Cofactors (I, 3, 3) with the sign of the determinant, and whether that is negative (I,).

    They are the inverse transpose times the determinant's size, and finite where a scale is zero.
    """
    a, b, c = linear[:, 0], linear[:, 1], linear[:, 2]
    cofactors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
    flipped = (a * cofactors[:, 0]).sum(1) < 0
    return np.where(flipped[:, None, None], -cofactors, cofactors), flipped


def _matrix(instance):
    matrix = np.asarray(instance.transform, np.float64)
    if matrix.shape != (4, 4):
        raise SceneError(f"transform of object '{instance.name}' has shape {matrix.shape}; make it a 4 by 4 matrix")
    return matrix


def _checked(mesh):
    """Vertices (V, 3), triangles (T, 3) uint32 and corners (T, 3) uint32 or None of a mesh whose indices fit."""
    vertices = np.asarray(mesh.vertices)
    if vertices.dtype.kind != "f":
        vertices = vertices.astype(np.float64)
    if vertices.ndim != 2 or vertices.shape[1] != 3:
        raise SceneError(f"vertices of mesh '{mesh.name}' have shape {vertices.shape}; make it (V, 3)")
    triangles = _indices(mesh, "triangles", mesh.triangles, len(vertices))
    if mesh.material_index is not None and np.shape(mesh.material_index) != (len(triangles),):
        raise SceneError(
            f"material_index of mesh '{mesh.name}' needs one number for each of {len(triangles)} triangles"
        )
    if mesh.corners is None:
        return vertices, triangles, None
    corners = _indices(mesh, "corners", mesh.corners, None)
    if corners.shape != triangles.shape:
        raise SceneError(f"corners of mesh '{mesh.name}' need one row for each of {len(triangles)} triangles")
    return vertices, triangles, corners


def _indices(mesh, what, values, limit):
    values = np.asarray(values)
    if values.size == 0:
        return np.zeros((0, 3), np.uint32)
    if values.ndim != 2 or values.shape[1] != 3 or values.dtype.kind not in "iu":
        raise SceneError(f"{what} of mesh '{mesh.name}' are {values.dtype} {values.shape}; make them integers (T, 3)")
    # Without its sign a negative number is a large one, so one look finds both.
    numbers = values.view(np.uint32) if values.dtype == np.int32 else values
    if numbers.dtype != np.uint32:
        numbers = values.astype(np.uint64)
    if int(numbers.max()) >= (1 << 31 if limit is None else limit):
        raise SceneError(
            f"{what} of mesh '{mesh.name}' reach from {int(values.min())} to {int(values.max())}; only 0 to "
            f"{'the last' if limit is None else limit - 1} exist"
        )
    return numbers.astype(np.uint32, copy=False)


def corner_index(group):
    """Where the corners of a group's triangles stand in per-corner arrays, (T, 3)."""
    if group.corners is not None:
        return group.corners
    return np.arange(group.triangles.size, dtype=np.uint32).reshape(-1, 3)


def check_length(mesh, what, values, index, width):
    """Refuse per-corner or per-vertex arrays that are too short for `index`."""
    if values.ndim != 2 or values.shape[1] != width:
        raise SceneError(f"{what} of mesh '{mesh.name}' have shape {values.shape}; make it (C, {width})")
    if index.size and int(index.max()) >= len(values):
        raise SceneError(f"{what} of mesh '{mesh.name}' need {int(index.max()) + 1} rows; there are {len(values)}")


def turn(rows, second, third, flipped):
    """Exchange the second and third corner in the rows of mirrored instances."""
    if flipped.any():
        kept = rows[flipped][..., second]
        rows[flipped, :, second] = rows[flipped][..., third]
        rows[flipped, :, third] = kept


def boxes(groups):
    """Lower and upper ends (I, 3) of boxes around all instances; of the vertices that are finite."""
    ends = np.array([_extent(g.vertices) for g in groups]).reshape(-1, 2, 3)
    low, high = np.repeat(ends, [len(g.numbers) for g in groups], axis=0).transpose(1, 0, 2)
    matrix = np.concatenate([np.zeros((0, 4, 4)), *(g.matrix for g in groups)])
    middle, half = 0.5 * low + 0.5 * high, 0.5 * high - 0.5 * low
    center = (matrix[:, :3, :3] @ middle[..., None])[..., 0] + matrix[:, :3, 3]
    reach = (np.abs(matrix[:, :3, :3]) @ half[..., None])[..., 0]
    return center - reach, center + reach


def _extent(points):
    """Least and greatest coordinates [(3,), (3,)] of the points that are finite."""
    ends = _ends(points)
    return ends if np.isfinite(ends).all() else _ends(points[np.isfinite(points).all(1)])


def _ends(points):
    if len(points) < _FEW:
        return [points.min(0, initial=np.inf), points.max(0, initial=-np.inf)]
    # numpy is slow along the first of two axes, but for long rows.
    many = len(points) // _FEW * _FEW
    rows, rest = points[:many].reshape(-1, 3 * _FEW), points[many:]
    return [f(np.concatenate([f(rows, axis=0).reshape(-1, 3), rest]), axis=0) for f in (np.min, np.max)]


def share_of_most(points):
    """How wide the middle half of some of the points stands, over the width of all that are finite; 1 if unknown."""
    low, high = _extent(points)
    some = np.sort(points[:: -(-len(points) // _MOST_ASKED)].astype(np.float64), axis=0)
    wide, half = np.max(np.subtract(high, low)), np.max(some[3 * len(some) // 4] - some[len(some) // 4])
    return float(half / wide) if 0 < half < wide else 1.0
