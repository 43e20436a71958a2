# SPDX-License-Identifier: GPL-3.0-or-later
"""Instances, spheres and planes to the tables of `core.geometry`.

World positions are computed in float64 and recentred before the cast to float32. All instances of a mesh are placed at
once, so neither many small objects nor one large one costs a loop.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..diagnostics import SceneError
from ..geometry import CORNERS, NORMAL, NORMAL_ROW, Geometry, columns_of, empty_facets, finish_facets
from ..scene import Material, Mesh
from .corners import corner_tables
from .needs import Needs
from .objects import compile_objects

# Corner normals this near to the face's are the face's: the shading of a flat triangle.
_FLAT = 1e-4


class _Placed(NamedTuple):
    """I instances of one mesh; of them, `flipped` ones mirror it and so turn its winding round."""

    mesh: Mesh
    numbers: np.ndarray  # (I,) of the objects
    normal_matrix: np.ndarray  # (I, 3, 3) float64, takes object normals to the world, up to length
    flipped: np.ndarray  # (I,) bool
    vertices: np.ndarray  # (I, V, 3) float64, world
    triangles: np.ndarray  # (T, 3) intp
    corners: np.ndarray | None  # (T, 3) intp, None is the plain order
    rows: slice  # of the facets


def compile_geometry(scene, uv_names=(), diagnostics=None, needs=None):
    """Tables of all that rays can hit in `scene`.

    Parameters
    ----------
    scene : Scene
    uv_names : iterable of str
        The UV maps that materials read; "" is each mesh's active map.
    diagnostics : Diagnostics, optional
        Told how many triangles and spheres were left out because they have no area or are not finite.
    needs : Needs, optional
        What else materials read.

    Returns
    -------
    Geometry
        Fronts stay fronts under mirroring transforms, as in Blender. A material slot out of range takes the last slot.

    Raises
    ------
    SceneError
        Arrays of a mesh, of spheres or a transform whose shape or indices do not fit.
    """
    numbering = _Materials()
    centers, radii = _spheres(scene.spheres)
    needs = needs or Needs()
    # What is not finite comes out as NaN and is left out below.
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        groups, count = _place(scene.instances)
        origin = _centre(groups, centers, radii, scene.planes)
        facets = empty_facets(count)
        for group in groups:
            _write_corners(group, origin, facets)
        good = finish_facets(facets)
        normals = _write_normals(groups, facets)
    names = [x.name for x in (*scene.instances, *scene.spheres, *scene.planes)]
    material, objects = _triangle_numbers(groups, scene.instances, count, numbering)
    uvs = {name: _uvs(groups, name, count) for name in uv_names}
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        corner_values = corner_tables(groups, count, needs)
    if not good.all():
        _tell_dropped(
            "triangles without area or with coordinates that are not finite were left out",
            objects[~good],
            names,
            diagnostics,
        )
        facets, material, objects = facets[good], material[good], objects[good]
        uvs = {name: table[good] for name, table in uvs.items()}
        corner_values = {key: table[good] for key, table in corner_values.items()}

    round_material, round_objects = _owners(
        scene.spheres, [len(s.radii) for s in scene.spheres], len(scene.instances), numbering
    )
    centers -= origin
    with np.errstate(invalid="ignore", over="ignore"):
        good = (radii.astype(np.float32) > 0) & np.isfinite(radii) & np.isfinite(centers).all(1)
    if not good.all():
        _tell_dropped(
            "spheres whose radius is not positive or whose place is not finite were left out",
            round_objects[~good],
            names,
            diagnostics,
        )
    flat_material, flat_objects = _owners(
        scene.planes, [1] * len(scene.planes), len(scene.instances) + len(scene.spheres), numbering
    )
    points, directions = _planes(scene.planes, origin)
    return Geometry(
        origin=origin,
        facets=facets,
        centers=columns_of(centers[good]),
        radii=radii[good].astype(np.float32),
        plane_points=points,
        plane_normals=directions,
        material=np.concatenate([material, round_material[good], flat_material]),
        object=np.concatenate([objects, round_objects[good], flat_objects]),
        materials=tuple(numbering.materials),
        normals=normals,
        uvs=uvs,
        corner_values=corner_values,
        objects=compile_objects(scene, origin, numbering.materials) if needs.objects else None,
    )


class _Materials:
    """Numbers materials in the order in which they are met; None is the default grey."""

    def __init__(self):
        self.materials = []
        self._number = {}

    def number(self, material):
        key = id(material)
        if key not in self._number:
            self._number[key] = len(self.materials)
            self.materials.append(Material.diffuse(name="default") if material is None else material)
        return self._number[key]

    def slots(self, materials):
        return [self.number(m) for m in materials or (None,)]


# -- placing -----------------------------------------------------------------------------------------------------------


def _place(instances):
    """Instances grouped by mesh, in world space; and the number of their triangles."""
    members: dict[int, list[int]] = {}
    for i, instance in enumerate(instances):
        members.setdefault(id(instance.mesh), []).append(i)
    groups, count = [], 0
    matrices = np.array([_matrix(i) for i in instances]).reshape(-1, 4, 4)
    normal_matrix, flipped = _normal_matrices(matrices[:, :3, :3])
    for numbers in members.values():
        mesh = instances[numbers[0]].mesh
        vertices, triangles, corners = _checked(mesh)
        if not len(triangles):
            continue
        numbers = np.array(numbers, np.int32)
        placed = matrices[numbers]
        world = vertices @ placed[:, :3, :3].transpose(0, 2, 1) + placed[:, None, :3, 3]
        rows = slice(count, count + len(numbers) * len(triangles))
        groups.append(_Placed(mesh, numbers, normal_matrix[numbers], flipped[numbers], world, triangles, corners, rows))
        count = rows.stop
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
    """Vertices (V, 3) float64, triangles (T, 3) intp and corners (T, 3) intp or None of a mesh whose indices fit."""
    vertices = np.asarray(mesh.vertices, np.float64)
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
        return np.zeros((0, 3), np.intp)
    if values.ndim != 2 or values.shape[1] != 3 or values.dtype.kind not in "iu":
        raise SceneError(f"{what} of mesh '{mesh.name}' are {values.dtype} {values.shape}; make them integers (T, 3)")
    _within(mesh, what, values, limit)
    return values.astype(np.intp)


def _within(mesh, what, values, limit):
    if values.size and (int(values.min()) < 0 or (limit is not None and int(values.max()) >= limit)):
        raise SceneError(
            f"{what} of mesh '{mesh.name}' reach from {values.min()} to {values.max()}; only 0 to "
            f"{'the last' if limit is None else limit - 1} exist"
        )


def _centre(groups, centers, radii, planes):
    """Middle of the bounding box of all that is finite."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    ends = [g.vertices.reshape(-1, 3) for g in groups] + [centers - radii[:, None], centers + radii[:, None]]
    for points in ends:
        if not len(points):
            continue
        if not (np.isfinite(points.min()) and np.isfinite(points.max())):
            points = points[np.isfinite(points).all(1)]
        low = np.minimum(low, points.min(0, initial=np.inf))
        high = np.maximum(high, points.max(0, initial=-np.inf))
    if (low <= high).all():
        return 0.5 * low + 0.5 * high
    return np.mean([p.point for p in planes], axis=0, dtype=np.float64) if planes else np.zeros(3)


# -- triangles ---------------------------------------------------------------------------------------------------------


def _write_corners(group, origin, facets):
    instances, count = len(group.numbers), len(group.triangles)
    vertices = (group.vertices - origin).astype(np.float32)
    rows = facets[group.rows].reshape(instances, count, -1)
    for k, columns in enumerate(CORNERS):
        rows[..., columns] = np.take(vertices, group.triangles[:, k], axis=1)
    _turn(rows, CORNERS[1], CORNERS[2], group.flipped)


def _turn(rows, second, third, flipped):
    """Exchange the second and third corner in the rows of mirrored instances."""
    if flipped.any():
        kept = rows[flipped][..., second]
        rows[flipped, :, second] = rows[flipped][..., third]
        rows[flipped, :, third] = kept


def _write_normals(groups, facets):
    """Shading normals of the smooth triangles, (R, 9); their row numbers go into the facets."""
    groups = [g for g in groups if g.mesh.normals is not None]
    if not groups:
        return np.zeros((0, 9), np.float32)
    table = np.concatenate([_corner_normals(g) for g in groups])
    triangle = np.concatenate([np.arange(g.rows.start, g.rows.stop) for g in groups])
    faces = np.take(facets[:, NORMAL], triangle, axis=0)[:, None, :]
    # A corner without a usable normal takes the face's.
    table = np.where(np.isfinite(table).all(-1, keepdims=True), table, faces)
    smooth = (np.abs(table - faces) > _FLAT).any((1, 2))
    facets.view(np.int32)[triangle[smooth], NORMAL_ROW] = np.arange(np.count_nonzero(smooth))
    return table[smooth].reshape(-1, 9)


def _corner_normals(group):
    """Unit normals (I * T, 3, 3) of the corners in world space; NaN where there is none."""
    mesh = group.mesh
    values = np.asarray(mesh.normals, np.float64)
    index = group.triangles if mesh.normals_domain == "vertex" else _corner_index(group)
    _check_length(mesh, "normals", values, index, 3)
    world = values @ group.normal_matrix.transpose(0, 2, 1)
    world /= np.sqrt((world * world).sum(-1, keepdims=True))
    rows = np.take(world.astype(np.float32), index.reshape(-1), axis=1).reshape(len(group.numbers), -1, 9)
    _turn(rows, slice(3, 6), slice(6, 9), group.flipped)
    return rows.reshape(-1, 3, 3)


def _corner_index(group):
    if group.corners is not None:
        return group.corners
    return np.arange(group.triangles.size).reshape(-1, 3)


def _check_length(mesh, what, values, index, width):
    if values.ndim != 2 or values.shape[1] != width:
        raise SceneError(f"{what} of mesh '{mesh.name}' have shape {values.shape}; make it (C, {width})")
    if index.size and int(index.max()) >= len(values):
        raise SceneError(f"{what} of mesh '{mesh.name}' need {int(index.max()) + 1} rows; there are {len(values)}")


def _triangle_numbers(groups, instances, count, numbering):
    """Material and object of each triangle."""
    material, objects = np.zeros(count, np.int32), np.zeros(count, np.int32)
    for group in groups:
        shape = len(group.numbers), len(group.triangles)
        objects[group.rows].reshape(shape)[...] = group.numbers[:, None]
        slots = [numbering.slots(instances[i].materials) for i in group.numbers]
        most = max(map(len, slots))
        table = np.array([s + s[-1:] * (most - len(s)) for s in slots], np.int32)
        chosen = group.mesh.material_index
        if chosen is None:
            material[group.rows].reshape(shape)[...] = table[:, :1]
        else:
            # Unsigned, a negative slot is out of range too.
            chosen = np.minimum(np.asarray(chosen).astype(np.uint32), most - 1)
            material[group.rows].reshape(shape)[...] = table[:, chosen]
    return material, objects


def _uvs(groups, name, count):
    """(T, 6) coordinates of the UV map `name`."""
    table = np.zeros((count, 6), np.float32)
    for group in groups:
        maps = group.mesh.uvs
        key = name or group.mesh.active_uv or next(iter(maps), "")
        if key not in maps:
            continue
        values, index = np.asarray(maps[key], np.float32), _corner_index(group)
        _check_length(group.mesh, f"UV map '{key}'", values, index, 2)
        rows = table[group.rows].reshape(len(group.numbers), -1, 6)
        rows[...] = values[index].reshape(1, -1, 6)
        _turn(rows, slice(2, 4), slice(4, 6), group.flipped)
    return table


# -- spheres and planes ------------------------------------------------------------------------------------------------


def _spheres(groups):
    """Centres (S, 3) and radii (S,) of all spheres, float64."""
    centers, radii = [np.zeros((0, 3))], [np.zeros(0)]
    for spheres in groups:
        centers.append(np.asarray(spheres.centers, np.float64))
        radii.append(np.asarray(spheres.radii, np.float64))
        if radii[-1].ndim != 1 or centers[-1].shape != (len(radii[-1]), 3):
            raise SceneError(
                f"spheres '{spheres.name}' have centers {centers[-1].shape} and radii {radii[-1].shape}; "
                "make them (N, 3) and (N,)"
            )
    return np.concatenate(centers), np.concatenate(radii)


def _planes(planes, origin):
    """Point nearest to the origin, relative to it, and unit normal of each plane, both (3, K)."""
    points, normals = np.zeros((len(planes), 3)), np.zeros((len(planes), 3))
    for i, plane in enumerate(planes):
        normal, point = np.asarray(plane.normal, np.float64), np.asarray(plane.point, np.float64)
        length = float(np.sqrt(normal @ normal)) if normal.shape == point.shape == (3,) else 0.0
        if not (0.0 < length < np.inf and np.isfinite(point).all()):
            raise SceneError(f"plane '{plane.name}' needs a finite point and a normal that is not zero")
        normals[i] = normal / length
        points[i] = normals[i] * (normals[i] @ (point - origin))
    return columns_of(points), columns_of(normals)


def _owners(things, counts, first, numbering):
    """Material and object number of every primitive of Spheres or Planes."""
    material = np.array([numbering.number(t.material) for t in things], np.int32)
    objects = np.arange(first, first + len(things), dtype=np.int32)
    return np.repeat(material, counts), np.repeat(objects, counts)


def _tell_dropped(message, objects, names, diagnostics):
    if diagnostics is None:
        return
    numbers, counts = np.unique(objects, return_counts=True)
    for number, count in zip(numbers.tolist(), counts.tolist(), strict=True):
        diagnostics.warn(message, names[number], count)
