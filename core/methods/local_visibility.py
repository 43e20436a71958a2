# SPDX-License-Identifier: GPL-3.0-or-later
"""The classic methods where not every ray sees every object, and not every light reaches every object.

Mirror rays are glossy rays and refracted ones transmission rays. A light hidden from diffuse rays has no diffuse term
and one hidden from glossy rays no specular term; a world hidden from diffuse rays gives no ambient light. Objects that
hold out what is behind are rendered as any other.
"""

from __future__ import annotations

import numpy as np

from ..accel import Hits
from ..visibility import Rays
from .blockers import casters, shaded_by
from .local import LocalModel
from .phong import Phong
from .raycast import RayCast
from .raytrace import RayTrace


class VisibilityLocalModel(LocalModel):
    """What the classic methods change in scenes with `Feature.VISIBILITY`."""

    def _casters(self, worker):
        return casters(self.scene, worker)

    def _trace(self, rays, level, worker):
        visibility, arena = self.scene.visibility, worker.scratch
        if level == 0:
            return visibility.camera.intersect(rays.o, rays.d, rays.tmax, arena, clock=worker.clock)
        n = rays.o.shape[1]
        hits = Hits(arena.empty(n), arena.empty(n, np.int32), arena.empty(n), arena.empty(n))
        for refracted, accel in enumerate(visibility.scattered[1:]):
            own = np.flatnonzero(rays.trail[0] == refracted)
            o, d = arena.take(rays.o, own), arena.take(rays.d, own)
            for column, part in zip(hits, accel.intersect(o, d, None, arena, clock=worker.clock), strict=True):
                column[own] = part
        return hits

    def _leaving(self, rays, hits, level):
        lanes = super()._leaving(rays, hits, level)
        if level == 0 and self.settings.transparent_film:
            return lanes
        kind = Rays.CAMERA if level == 0 else np.where(rays.trail[0, lanes], Rays.TRANSMISSION, Rays.GLOSSY)
        return lanes[np.broadcast_to((self.scene.visibility.rays[-1] & kind) > 0, lanes.shape)]

    def _reflected(self, k, level, surface, phong, twice, wi, irradiance, arena):
        visibility, emitter = self.scene.visibility, self.scene.lights.classic.emitter(k)
        if visibility.limited[emitter]:
            rays = Rays(int(visibility.rays[emitter]))
            black = np.zeros((3, 1), np.float32)
            phong = phong._replace(
                diffuse=phong.diffuse if Rays.DIFFUSE in rays else black,
                specular=phong.specular if Rays.GLOSSY in rays else black,
            )
            gets = visibility.reaches(emitter, np.take(self.scene.geometry.object, surface.prim))
            irradiance = irradiance * (gets & (level <= visibility.max_bounces[emitter]))
        return super()._reflected(k, level, surface, phong, twice, wi, irradiance, arena)

    def _seen(self, k, surface, value, wi, distance, ray, worker):
        visibility = self.scene.visibility
        blockers = visibility.blockers[self.scene.lights.classic.emitter(k)]
        with shaded_by(visibility.casters[blockers], worker):
            return super()._seen(k, surface, value, wi, distance, ray, worker)


class VisibilityPhong(VisibilityLocalModel, Phong):
    """`Phong` of such scenes."""


class VisibilityRayCast(VisibilityLocalModel, RayCast):
    """`RayCast` of such scenes."""


class VisibilityRayTrace(VisibilityLocalModel, RayTrace):
    """`RayTrace` of such scenes."""
