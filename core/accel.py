# SPDX-License-Identifier: GPL-3.0-or-later
"""Which primitive a ray hits: Embree through embreex, and what Embree lacks.

embreex copies triangles one by one and knows no spheres and no curves. So geometry is attached through Embree's
documented C API, on the scene that embreex made and on memory shared with numpy; embreex then traces as usual. Where
that scene cannot be reached safely, `TriangleMesh` and spheres in closed form take over, with the same hits; curves are
then not seen.
"""

from __future__ import annotations

import ctypes
import sys
from functools import cache, partial
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

import embreex
import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore import EmbreeDevice
from embreex.rtcore_scene import EmbreeScene

from .planes import plane_distance, sphere_distance

# Of Embree's rtcore_geometry.h and rtcore_common.h, the same since version 4.0.
_TRIANGLES, _SPHERE_POINTS, _ROUND_CATMULL_ROM = 0, 50, 58
_INDEX, _VERTEX = 0, 1
_DYNAMIC, _LOW_QUALITY = 1, 0
_UINT, _UINT3, _FLOAT3, _FLOAT4 = 0x5001, 0x5003, 0x9003, 0x9004

# How far beyond the inside of a strand a ray goes on: shares of its way there and of its start's coordinates.
_BEYOND, _COORDINATE_BEYOND = 1e-3, np.float32(2.0**-20)
_MOST_EXITS = 16

# So many spheres are cheap enough in closed form where Embree is built to cull their insides.
_FEW = 64

# Where embreex keeps its handles, in bytes from the start of the object.
_SCENE_AT, _DEVICE_OBJECT_AT, _DEVICE_AT = 16, 32, 16


class Hits(NamedTuple):
    """First hits: `t` (N,) in units of |d|, `prim` (N,) int32, -1 for a miss, barycentrics `u`, `v` (N,) of triangles.

    The point hit is ``(1 - u - v) v0 + u v1 + v v2``. A miss has no meaningful `t`.
    """

    t: np.ndarray
    prim: np.ndarray
    u: np.ndarray
    v: np.ndarray


class Accel:
    """Answers rays against a `Geometry`. The tree is built here; afterwards any number of threads may ask.

    Parameters
    ----------
    geometry : Geometry
    native : bool
        False keeps to embreex's own interface, as where Embree's C API cannot be reached.
    parts : sequence of int, optional
        First triangles, ascending from 0, of parts that get a tree each, which `rebuild` can build again.

    Attributes
    ----------
    parts : (P,) int or None
        None where there is one tree.

    Notes
    -----
    Both queries take `o` (3, N), `d` (3, N) or (3, 1) of any length, and `tmax` (N,) in units of |d| or None, all
    float32; none is modified. A surface at distance 0 counts as hit, so origins must clear it first
    (`core.interaction`). Rays with NaN or without a direction miss. `clock.seconds` grows by the time spent in Embree.

    Blender's own Embree, which embreex is bound to inside Blender on Linux, does not show a sphere to rays from its
    inside. There up to 64 spheres are met in closed form; more of them are Embree's, and `insides_missed` is True.
    Where curves cannot be attached, `strands_missed` is True. `u` runs along a curve's segment.
    """

    def __init__(self, geometry, native=True, parts=None):
        first_plane = geometry.count - geometry.plane_count
        self._analytic = [
            (first_plane + k, partial(plane_distance, geometry.plane_points[:, k], geometry.plane_normals[:, k]))
            for k in range(geometry.plane_count)
        ]
        device = EmbreeDevice()
        self._scene = EmbreeScene(device, robust=True)
        api = _Api.reach(self._scene, device) if native else None
        self._buffers = []
        self.parts, self._api = (np.asarray(parts), api) if api and parts is not None else (None, None)
        if self._api:
            api.expect_changes()
        if geometry.triangle_count and not (api and self._attach_triangles(api, geometry.vertices, geometry.index)):
            TriangleMesh(self._scene, np.ascontiguousarray(geometry.corners.T).reshape(-1, 3, 3))
        self._spheres_attached = bool(
            api
            and geometry.sphere_count
            and (_sees_inside() or geometry.sphere_count > _FEW)
            and self._attach_spheres(api, _sphere_table(geometry))
        )
        self.insides_missed = self._spheres_attached and not _sees_inside()
        if not self._spheres_attached:
            self._analytic += [
                (geometry.triangle_count + s, partial(sphere_distance, geometry.centers[:, s], geometry.radii[s]))
                for s in range(geometry.sphere_count)
            ]
        self._strands_attached = bool(api and geometry.segment_count and self._attach_strands(api, geometry.strands))
        self.strands_missed = geometry.segment_count > 0 and not self._strands_attached
        self._first_numbers, self._first_number_of = self._numbers_by_attachment(geometry), None
        if self._api:
            self._first_numbers, self._first_number_of = (), _table(self._first_numbers)
        self.native = api is not None
        # The tree is built here, not in a worker; embreex would hold all of Python meanwhile, Blender's window too.
        if api:
            api.commit()
        self._scene.run(np.zeros((1, 3), np.float32), np.ones((1, 3), np.float32), query="OCCLUDED")

    def intersect(self, o, d, tmax, arena, clock=None):
        """First hit of every ray, as `Hits` that are valid until the arena's frame ends."""
        # embreex writes the distances into the array it was given.
        tmax = None if tmax is None else _copy(tmax, arena)
        found = self._outside(o, d, tmax, arena, clock) if self._strands_attached else self._nearest(o, d, tmax, clock)
        t, prim = found["tfar"], found["primID"]
        for attachment, first in self._first_numbers:
            with arena.frame():
                on_it = np.equal(found["geomID"], attachment, out=arena.empty(prim.shape, bool))
                np.add(prim, first, out=prim, where=on_it)
        if self._first_number_of is not None:
            with arena.frame():
                first = arena.empty(prim.shape, np.int32)
                np.add(prim, np.take(self._first_number_of, found["geomID"], out=first, mode="wrap"), out=prim)
        for number, distance in self._analytic:
            with arena.frame():
                s = distance(o, d, arena)
                nearer = np.less(s, t, out=arena.empty(t.shape, bool))
                np.copyto(t, s, where=nearer)
                np.copyto(prim, np.int32(number), where=nearer)
        return Hits(t, prim, found["u"], found["v"])

    def occluded(self, o, d, tmax, arena, clock=None):
        """True where something lies within `tmax`, (N,) bool."""
        blocked = arena.empty(o.shape[1], bool)
        # Without `output`, with which embreex would hand out uninitialised memory.
        np.equal(self._run(o, d, tmax, clock, query="OCCLUDED"), 0, out=blocked)
        if self._strands_attached:
            lanes = np.flatnonzero(blocked)
            met = self._outside(o[:, lanes], _of(d, lanes), None if tmax is None else tmax[lanes], arena, clock)
            blocked[lanes] = met["primID"] >= 0
        for _, distance in self._analytic:
            with arena.frame():
                s = distance(o, d, arena)
                nearer = np.less(s, np.float32(np.inf) if tmax is None else tmax, out=arena.empty(s.shape, bool))
                np.logical_or(blocked, nearer, out=blocked)
        return blocked

    def rebuild(self, triangles):
        """Build the trees of the `parts` with these triangles again, whose vertices were changed where they stand.

        Nothing may be traced meanwhile.
        """
        self._api.rebuild(np.unique(np.searchsorted(self.parts, triangles, side="right") - 1).tolist())

    def _nearest(self, o, d, tmax, clock):
        return self._run(o, d, tmax, clock, query="INTERSECT", output=True)

    def _outside(self, o, d, tmax, arena, clock):
        """`_nearest`, but rays leave strands from inside as if nothing were there; Cycles' do."""
        limit = None if tmax is None else tmax.copy()
        found = self._nearest(o, d, tmax, clock)
        lanes = self._leaving(found, o, d, arena)
        for _ in range(_MOST_EXITS):
            if not lanes.size:
                break
            start, way = o[:, lanes], _of(d, lanes)
            t = found["tfar"][lanes] * np.float32(1 + _BEYOND)
            t += _COORDINATE_BEYOND * np.abs(start).max(axis=0) / np.abs(way).max(axis=0)
            start, left = start + way * t, None if limit is None else np.maximum(limit[lanes] - t, 0)
            further = self._nearest(start, way, left, clock)
            still = self._leaving(further, start, way, arena)
            further["tfar"] += t
            for name, values in further.items():
                found[name][lanes] = values
            lanes = lanes[still]
        return found

    def _leaving(self, found, o, d, arena):
        """Lanes whose rays met a strand from inside, which they had not entered by its open end."""
        lanes = np.flatnonzero(found["geomID"] == self._strands_number)
        lanes = lanes[np.einsum("ni,in->n", found["Ng"][lanes], _of(d, lanes)) > 0]
        segment, t = found["primID"][lanes], found["tfar"][lanes]
        return lanes[~self._strands.entered(segment, o[:, lanes], _of(d, lanes), t, arena)] if lanes.size else lanes

    def _run(self, o, d, tmax, clock, **query):
        # embreex does not compare lengths, and would read past the end of the shorter array.
        if d.shape not in (o.shape, (3, 1)) or (tmax is not None and tmax.shape != o.shape[1:]):
            raise ValueError(f"rays do not fit: o {o.shape}, d {d.shape}, tmax {None if tmax is None else tmax.shape}")
        if self._strands_attached:
            o, d = _finite_rays(o, d)
        if clock is None:
            return self._scene.run(o.T, d.T, dists=tmax, **query)
        start = perf_counter()
        found = self._scene.run(o.T, d.T, dists=tmax, **query)
        clock.seconds += perf_counter() - start
        return found

    def _attach_triangles(self, api, vertices, index):
        self._buffers += [vertices, index]
        parts = [index] if self.parts is None else np.split(index, self.parts[1:])
        attached = [
            api.attach(_TRIANGLES, [(_VERTEX, _FLOAT3, vertices, 16, len(vertices)), (_INDEX, _UINT3, i, 12, len(i))])
            for i in parts
        ]
        if any(attached) and not all(attached):
            raise MemoryError("Embree takes only some of the triangles")
        return all(attached)

    def _attach_spheres(self, api, spheres):
        self._buffers.append(spheres)
        return api.attach_spheres(spheres)

    def _attach_strands(self, api, strands):
        vertices, index, self._strands = strands.vertices, strands.index, strands
        self._buffers += [vertices, index]
        return api.attach(
            _ROUND_CATMULL_ROM,
            [(_VERTEX, _FLOAT4, vertices, 16, len(vertices)), (_INDEX, _UINT, index, 4, len(index))],
        )

    def _numbers_by_attachment(self, geometry):
        """[(Embree's number of a geometry, number of its first primitive)], those left out that start at 0."""
        attached = [0] if geometry.triangle_count else []
        attached = attached if self.parts is None else self.parts.tolist()
        attached += [geometry.triangle_count] if self._spheres_attached else []
        self._strands_number = len(attached)  # they come last
        attached += [geometry.first_segment] if self._strands_attached else []
        return [(number, first) for number, first in enumerate(attached) if first]


def _table(first_numbers):
    """The numbers of first primitives by attachment, 0 where none is named and at the end, for misses (-1)."""
    table = np.zeros(2 + max((number for number, _ in first_numbers), default=0), np.int32)
    for number, first in first_numbers:
        table[number] = first
    return table


def _sphere_table(geometry):
    return np.ascontiguousarray(np.vstack([geometry.centers, geometry.radii]).T)


@cache
def _sees_inside():
    """Whether this Embree reports a sphere's far side to a ray from inside; Blender's is built to cull it."""
    device = EmbreeDevice()
    scene = EmbreeScene(device, robust=True)
    api, spheres = _Api.reach(scene, device), np.array([[0, 0, 0, 1]], np.float32)
    ray = np.zeros((1, 3), np.float32), np.ones((1, 3), np.float32)
    return api.attach_spheres(spheres) and int(scene.run(*ray, query="OCCLUDED")[0]) == 0


def _finite_rays(o, d):
    """The rays, with direction 0 where they are no numbers, so that they miss: among curves Embree crashes on those."""
    with np.errstate(over="ignore", invalid="ignore"):
        if np.isfinite(o.sum()) and np.isfinite(d.sum()):
            return o, d
    lost = ~(np.isfinite(o).all(axis=0) & np.isfinite(d).all(axis=0))
    return np.where(lost, np.float32(0), o), np.where(lost, np.float32(0), d)


def _of(d, lanes):
    """Directions of some lanes; one direction serves all."""
    return d if d.shape[1] == 1 else d[:, lanes]


def _copy(array, arena):
    out = arena.empty(array.shape)
    np.copyto(out, array)
    return out


# -- Embree's C API ----------------------------------------------------------------------------------------------------


class _Api:
    """Embree's C API on the device and scene of embreex's objects."""

    def __init__(self, library, device, scene):
        self._library, self._device, self._scene = library, device, scene

    @classmethod
    def reach(cls, scene, device):
        """The API for an `EmbreeScene`, or None where the layout of embreex's objects is not the one known."""
        library = _library()
        if library is None or sys.implementation.name != "cpython":
            return None
        if EmbreeScene.__basicsize__ < _DEVICE_OBJECT_AT + 8 or EmbreeDevice.__basicsize__ < _DEVICE_AT + 8:
            return None
        # That the scene's object refers to the device's object proves the layout before any pointer is followed.
        if _word(scene, _DEVICE_OBJECT_AT) != id(device):
            return None
        handle = _word(device, _DEVICE_AT)
        if not handle or not _word(scene, _SCENE_AT):
            return None
        owner = library.rtcGetSceneDevice(_word(scene, _SCENE_AT))
        if owner != handle:
            return None
        library.rtcReleaseDevice(owner)
        return cls(library, handle, _word(scene, _SCENE_AT))

    def attach(self, kind, buffers):
        """Add a geometry over shared memory; False where Embree refuses.

        `buffers` are (type, format, array, stride in bytes, number of items); the caller keeps the arrays alive.
        """
        lib = self._library
        lib.rtcGetDeviceError(self._device)
        geometry = lib.rtcNewGeometry(self._device, kind)
        if not geometry:
            return False
        for buffer, form, array, stride, count in buffers:
            lib.rtcSetSharedGeometryBuffer(geometry, buffer, 0, form, array.ctypes.data, 0, stride, count)
        lib.rtcCommitGeometry(geometry)
        accepted = lib.rtcGetDeviceError(self._device) == 0
        if accepted:
            lib.rtcAttachGeometry(self._scene, geometry)
        lib.rtcReleaseGeometry(geometry)
        return accepted

    def commit(self):
        """Build the tree; other Python threads go on."""
        self._library.rtcCommitScene(self._scene)

    def expect_changes(self):
        """Have Embree build a tree for each geometry, and one over them, so that one can be built again alone."""
        flags = self._library.rtcGetSceneFlags(self._scene)
        self._library.rtcSetSceneFlags(self._scene, flags | _DYNAMIC)
        self._library.rtcSetSceneBuildQuality(self._scene, _LOW_QUALITY)

    def rebuild(self, numbers):
        """Build the trees of geometries again, by their numbers, whose vertices were changed."""
        lib = self._library
        for number in numbers:
            geometry = lib.rtcGetGeometry(self._scene, number)
            lib.rtcUpdateGeometryBuffer(geometry, _VERTEX, 0)
            lib.rtcCommitGeometry(geometry)
        lib.rtcCommitScene(self._scene)

    def attach_spheres(self, spheres):
        """Add spheres, rows of centre and radius (S, 4) float32."""
        return self.attach(_SPHERE_POINTS, [(_VERTEX, _FLOAT4, spheres, 16, len(spheres))])


def _word(thing, offset):
    return ctypes.c_size_t.from_address(id(thing) + offset).value


@cache
def _library():
    """The Embree that embreex is bound to, with its functions' types declared; None where it is not found."""
    library = _loaded_library()
    if library is None:
        return None
    pointer, size, number = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_uint
    for name, result, arguments in (
        ("rtcGetSceneDevice", pointer, (pointer,)),
        ("rtcReleaseDevice", None, (pointer,)),
        ("rtcGetDeviceError", ctypes.c_int, (pointer,)),
        ("rtcNewGeometry", pointer, (pointer, ctypes.c_int)),
        ("rtcSetSharedGeometryBuffer", None, (pointer, ctypes.c_int, number, ctypes.c_int, pointer, size, size, size)),
        ("rtcCommitGeometry", None, (pointer,)),
        ("rtcAttachGeometry", number, (pointer, pointer)),
        ("rtcReleaseGeometry", None, (pointer,)),
        ("rtcCommitScene", None, (pointer,)),
        ("rtcGetSceneFlags", ctypes.c_int, (pointer,)),
        ("rtcSetSceneFlags", None, (pointer, ctypes.c_int)),
        ("rtcSetSceneBuildQuality", None, (pointer, ctypes.c_int)),
        ("rtcGetGeometry", pointer, (pointer, number)),
        ("rtcUpdateGeometryBuffer", None, (pointer, ctypes.c_int, number)),
    ):
        function = getattr(library, name, None)
        if function is None:
            return None
        function.restype, function.argtypes = result, arguments
    return library


def _loaded_library():
    # Blender's own Embree may stand in the process's global scope; embreex's calls are then bound to that one.
    if sys.platform != "win32":
        program = ctypes.CDLL(None)
        if hasattr(program, "rtcNewDevice"):
            return program
    package = Path(embreex.__file__).parent
    for folder in (package.parent / "embreex.libs", package / ".dylibs", package):
        for path in sorted(folder.glob("*embree4*")):
            return ctypes.CDLL(str(path))
    return None
