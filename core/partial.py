# SPDX-License-Identifier: GPL-3.0-or-later
"""Embree over some of the primitives, for rays that do not see the others.

embreex has no ray masks. A tree of its own costs memory, but a ray costs no more than any other, however many things it
does not see lie on its way.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .accel import Accel
from .geometry import INDEX_PADDING


class PartialAccel:
    """Answers rays as `Accel` does, against the primitives `kept` (P,) bool of a geometry, numbered as in the whole.

    `native` is as for `Accel`.
    """

    def __init__(self, geometry, kept, native=True):
        ends = np.cumsum([geometry.triangle_count, geometry.sphere_count, geometry.segment_count])
        triangles, spheres, segments, planes = np.split(kept, ends)
        index = geometry.index[triangles]
        part = replace(
            geometry,
            facets=geometry.facets[triangles],
            index=np.append(index, np.zeros((INDEX_PADDING, 3), np.uint32), axis=0)[: len(index)],
            centers=np.ascontiguousarray(geometry.centers[:, spheres]),
            radii=geometry.radii[spheres],
            strands=None if geometry.strands is None else geometry.strands.part(segments),
            plane_points=np.ascontiguousarray(geometry.plane_points[:, planes]),
            plane_normals=np.ascontiguousarray(geometry.plane_normals[:, planes]),
            material=geometry.material[kept],
        )
        self._accel = Accel(part, native)
        self.native = self._accel.native
        self._numbers = np.append(np.flatnonzero(kept), -1).astype(np.int32)  # the last stands for a miss

    def intersect(self, o, d, tmax, arena, clock=None):
        """First hit of every ray, as `Hits`."""
        hits = self._accel.intersect(o, d, tmax, arena, clock)
        return hits._replace(prim=np.take(self._numbers, hits.prim, mode="wrap"))

    def occluded(self, o, d, tmax, arena, clock=None):
        """True where something lies within `tmax`, (N,) bool."""
        return self._accel.occluded(o, d, tmax, arena, clock)
