# SPDX-License-Identifier: GPL-3.0-or-later
"""Instances, spheres and planes to the tables of `core.geometry`.

The triangles themselves are written by `core.compile.triangles`; here all is numbered, and what cannot be hit left out.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from ..arena import uninitialised
from ..diagnostics import SceneError
from ..geometry import BLOCK, INDEX_PADDING, Geometry, columns_of, in_reading_order
from ..scene import Material
from .corners import corner_tables
from .memory import check_memory
from .needs import Needs
from .objects import compile_objects
from .placing import boxes, check_length, corner_index, place, share_of_most, turn
from .round_tables import append_rows
from .strands import place_curves, write_segments
from .triangles import write_triangles

# Things smaller than this share of the scene lose digits that count where they are far from the tables' zero.
_FINE = 1e-4
_FARTHEST = 1e18  # m; squares of larger numbers are not finite in float32


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
        Arrays of a mesh, of spheres or a transform whose shape or indices do not fit, or tables that memory does not.
    """
    numbering, needs, uv_names = _Materials(), needs or Needs(), tuple(uv_names)
    told = partial(_tell_dropped, names=[x.name for x in scene.objects], diagnostics=diagnostics)
    centers, radii = _spheres(scene.spheres)
    placed = place_curves(scene.curves)
    check_memory(scene.instances, len(uv_names), needs.corner_columns)
    # What is not finite comes out as NaN and is left out below.
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        groups, count = place(scene.instances)
        reached = np.concatenate([centers, placed.points]), np.concatenate([radii, placed.radii])
        origin = centre(groups, *reached, scene)[0]
        own, material, objects, uvs, corner_values = _triangles(
            groups, count, origin, scene.instances, numbering, uv_names, needs, told
        )
    good, centers, radii, round_material, round_objects = _balls(scene, centers - origin, radii, numbering, told)
    segments, hair_material, hair_objects = _hair(scene, placed, origin, numbering, told)
    if segments is not None or scene.spheres:
        uvs = {name: append_rows(table, ("uv", name), scene, good, segments) for name, table in uvs.items()}
        corner_values = {key: append_rows(t, key, scene, good, segments) for key, t in corner_values.items()}
    uvs, corner_values = ({key: in_reading_order(t) for key, t in some.items()} for some in (uvs, corner_values))
    first = len(scene.objects) - len(scene.planes)
    flat_material, flat_objects = _owners(scene.planes, [1] * len(scene.planes), first, numbering)
    points, directions = _planes(scene.planes, origin)
    return Geometry(
        **own,
        origin=origin,
        centers=columns_of(centers),
        radii=radii,
        plane_points=points,
        plane_normals=directions,
        material=_joined(material, round_material, hair_material, flat_material),
        object=_joined(objects, round_objects, hair_objects, flat_objects),
        materials=tuple(numbering.materials),
        uvs=uvs,
        corner_values=corner_values,
        objects=compile_objects(scene, origin, numbering.materials) if needs.objects else None,
        strands=None if segments is None else segments.strands,
    )


DEFAULT = Material.diffuse(name="default")


class _Materials:
    """Numbers materials in the order in which they are met; None is the default grey."""

    def __init__(self):
        self.materials = []
        self._number = {}

    def number(self, material):
        key = id(material)
        if key not in self._number:
            self._number[key] = len(self.materials)
            self.materials.append(DEFAULT if material is None else material)
        return self._number[key]

    def slots(self, materials):
        return [self.number(m) for m in materials or (None,)]


def _joined(first, *others):
    """Arrays one after the other, without a copy where there is but the first."""
    return np.concatenate([first, *others]) if any(map(len, others)) else first


# -- triangles ---------------------------------------------------------------------------------------------------------


def _triangles(groups, count, origin, instances, numbering, uv_names, needs, told):
    """Of all triangles that can be hit: their own tables by name, materials, objects, UV maps and other values."""
    vertices, index, facets, normals, good = write_triangles(groups, count, origin)
    material, objects = _triangle_numbers(groups, instances, count, numbering)
    uvs = {name: _uvs(groups, name, count) for name in uv_names}
    corner_values = corner_tables(groups, count, needs)
    own_number = None
    if not good.all():
        own_number = _own_numbers(groups, count)[good]
        told("triangles without area or with coordinates that are not finite were left out", objects[~good])
        facets, material, objects = facets[good], material[good], objects[good]
        index = np.append(index[good], np.zeros((INDEX_PADDING, 3), np.uint32), axis=0)[: len(facets)]
        uvs = {name: table[good] for name, table in uvs.items()}
        corner_values = {key: table[good] for key, table in corner_values.items()}
    own = {"vertices": vertices, "index": index, "facets": facets, "normals": normals, "own_number": own_number}
    return own, material, objects, uvs, corner_values


def centre(groups, centers, radii, scene):
    """Middle of a box around all that is finite, or the camera's place; and how far one may be from it.

    What is small and far from the tables' zero loses its form in float32. Where it would do so about the middle, for
    which one outlier is enough, the camera's place is taken: from there, what looks large is precise.
    """
    ends = boxes(groups), (centers - radii[:, None], centers + radii[:, None])
    low, high = (np.concatenate(e) for e in zip(*ends, strict=True))
    finite = (np.isfinite(low) & np.isfinite(high)).all(1)
    if not finite.any():
        points = [p.point for p in scene.planes] or [(0, 0, 0)]
        return np.mean(points, axis=0, dtype=np.float64), 0.0
    bottom, top = low[finite].min(0), high[finite].max(0)
    middle, reach = 0.5 * bottom + 0.5 * top, float((0.5 * top - 0.5 * bottom).max())
    eye = np.asarray(scene.camera.transform, np.float64)[:3, 3]
    if not np.abs(eye - middle).max() <= 2 * reach:  # nor where it is not finite
        return middle, reach
    sizes = np.where(finite, (high - low).max(1), np.inf)
    return (eye, 0.0) if _finest(groups, sizes, reach) < _FINE * reach else (middle, reach)


def _finest(groups, sizes, reach):
    """The least of the things' `sizes` but 0; that of one as wide as the scene as most of its vertices tell."""
    start = 0
    for group in groups:
        own = sizes[start : start + len(group.numbers)]
        start += len(own)
        if own.max() >= reach:
            own *= share_of_most(group.vertices)
    return sizes[sizes > 0].min(initial=np.inf)


def _triangle_numbers(groups, instances, count, numbering):
    """Material and object of each triangle."""
    material, objects = uninitialised(count, np.int32), uninitialised(count, np.int32)
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


def _own_numbers(groups, count):
    """Number of each triangle in its mesh, (T,)."""
    numbers = uninitialised(count, np.int32)
    for group in groups:
        numbers[group.rows].reshape(-1, len(group.triangles))[...] = np.arange(len(group.triangles))
    return numbers


def _uvs(groups, name, count):
    """(T, 6) coordinates of the UV map `name`."""
    table = np.zeros((count, 6), np.float32)
    for group in groups:
        maps = group.mesh.uvs
        key = name or group.mesh.active_uv or next(iter(maps), "")
        if key not in maps:
            continue
        values, index = np.asarray(maps[key], np.float32), corner_index(group)
        check_length(group.mesh, f"UV map '{key}'", values, index, 2)
        rows = table[group.rows].reshape(len(group.numbers), -1, 6)
        for start in range(0, len(index), BLOCK):
            part = slice(start, start + BLOCK)
            np.take(values, index[part].reshape(-1), axis=0, out=rows[0, part].reshape(-1, 2), mode="clip")
        rows[1:] = rows[:1]
        turn(rows, slice(2, 4), slice(4, 6), group.flipped)
    return table


# -- strands, spheres and planes ---------------------------------------------------------------------------------------


def _balls(scene, centers, radii, numbering, told):
    """Of all spheres, those that can be hit, their centres and radii (float32), and the material and object of each."""
    counts = [len(s.radii) for s in scene.spheres]
    material, objects = _owners(scene.spheres, counts, len(scene.instances), numbering)
    with np.errstate(invalid="ignore", over="ignore"):
        single = radii.astype(np.float32)
        good = (single > 0) & np.isfinite(single) & np.isfinite(centers.astype(np.float32)).all(1)
    if not good.all():
        told("spheres whose radius is not positive or whose place is not finite were left out", objects[~good])
    return np.flatnonzero(good), centers[good], single[good], material[good], objects[good]


def _hair(scene, placed, origin, numbering, told):
    """Segments of all curves or None, and the material and object of each."""
    with np.errstate(invalid="ignore", over="ignore"):
        segments = write_segments(placed, origin)
    first = len(scene.instances) + len(scene.spheres)
    if segments.lost.size:
        message = "pieces of strands without radius or with coordinates that are not finite were left out"
        told(message, first + segments.lost)
    if segments.strands is None:
        return None, *_owners((), (), first, numbering)
    if segments.slim.size:
        message = "pieces of strands that are too long for their radius are not met exactly; add points to them"
        told(message, first + segments.slim)
    material = np.array([numbering.number(c.material) for c in scene.curves], np.int32)
    return segments, material[segments.owner], (first + segments.owner).astype(np.int32)


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
        if not (0.0 < length < np.inf and np.isfinite(point).all() and np.all(np.abs(point - origin) < _FARTHEST)):
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
