# SPDX-License-Identifier: GPL-3.0-or-later
"""The local model of the classic methods, and Whitted's rays beyond it.

At a hit: emitted light + ambient · diffuse + for each light E V (diffuse cosθ/π + specular (m + 2)/2π cosᵐα cosθ). E is
the light's irradiance (core.lights.classic), V its visibility, α the angle to the mirror direction. The lobe is the
energy-conserving form of Phong's: Lafortune and Willems, "Using the Modified Phong Reflectance Model for Physically
Based Rendering", 1994. Down to the depth, k_s · (mirror ray) + k_t · (refracted ray) is added: Whitted, "An Improved
Illumination Model for Shaded Display", CACM 23(6), 1980.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..bsdf.phong import PhongParameters, phong_parameters
from ..compile.features import Feature
from ..interaction import spawn, spawn_to
from ..limits import at_least
from ..nodes.base import CAMERA_RAY, SCATTERED_RAY, SHADOW_RAY
from ..vecmath import dot, reflect
from .phong_table import phong_table
from .wavefront import Wavefront, any_channel, gather, slices, surface_context

_INV_PI = 1 / np.pi
_LEAST_LOG = -80.0  # of a highlight's strength
_PRUNE = 1 / 1024  # rays that carry less than this are not traced


class Rays(NamedTuple):
    """Rays of one level: origins and directions (3, N), distance limits, weights (3, N) and the lanes they add to.

    trail (2, N): whether the ray is refracted, and how often it was; None of camera rays and where no shader asks.
    """

    o: np.ndarray
    d: np.ndarray
    tmax: np.ndarray | None
    weight: np.ndarray | None
    lane: np.ndarray | None
    trail: np.ndarray | None = None

    def told(self, level, t):
        """The `Ray` that shaders are told of, `t` (N,) from the rays' origins."""
        if level == 0:
            return CAMERA_RAY
        if self.trail is None:
            return SCATTERED_RAY
        refracted, refractions = self.trail
        return SCATTERED_RAY._replace(
            glossy=1.0,
            singular=1.0,
            reflection=1 - refracted,
            transmission=refracted,
            length=t,
            depth=level,
            glossy_depth=level - refractions,
            transmission_depth=refractions,
        )


class LocalModel(Wavefront):
    """A classic method: `shadows` and `levels` tell which."""

    shadows = True
    chunk = 98304  # fewer arrays are alive than in path tracing; these stay in the cache

    def __init__(self, compiled, settings):
        super().__init__(compiled, settings)
        self._table = phong_table(compiled)

    @property
    def levels(self):
        """Hits in a row that are shaded."""
        return 1

    def trace(self, chunk, worker):
        """Radiance of a chunk, (channels, lanes); None when stopped."""
        worker.restart()
        radiance = worker.output.zeros((self.channels, chunk.lanes))
        if self.channels == 4:
            radiance[3].fill(1)
        _, _, o, d, tmax = self.camera_lanes(chunk, worker, worker.states[0])
        rays = Rays(o, d, tmax, None, None)
        for level in range(self.levels):
            if worker.stop.is_set():
                return None
            with worker.scratch.frame():
                rays = self._level(rays, level, radiance, worker)
            if rays is None:
                break
        return radiance

    def camera_lanes(self, chunk, worker, arena):
        """Where there are first samples alone, nothing is drawn by chance, and they have no keys."""
        if chunk.samples != (0,) or len(self.scene.camera.dimensions) > 2:
            return super().camera_lanes(chunk, worker, arena)
        return None, None, *self.camera_rays(chunk.pixels, arena.full((2, 1), 0.5), worker, arena)

    def place_samples(self, jitter, chunk):
        """The first sample is in the pixel's centre, as in the thesis; further ones smooth the edges."""
        if 0 in chunk.samples:
            jitter[:, chunk.samples.index(0) :: len(chunk.samples)] = 0.5

    def _level(self, rays, level, radiance, worker):
        arena = worker.scratch
        hits = self._trace(rays, level, worker)
        if level:
            worker.rays["secondary"] += rays.o.shape[1]
        order, groups = self.scene.grouped(hits.prim, arena)
        if order.size < hits.prim.size:
            self._add_environment(rays, hits, level, radiance, arena)
        if Feature.EMISSIVE_SURFACES in self.features:
            self._add_emission(rays, hits, level, radiance, arena)
        if order.size == 0:
            return None
        if order.size < hits.prim.size or len(groups) > 1:
            hits, rays = gather(hits, order, arena), gather(rays, order, arena)
            if rays.lane is None:
                rays = rays._replace(lane=order)
        surface = self.scene.interact(hits, rays.o, rays.d, arena)
        goes_on = level < self.levels - 1
        phong = self._parameters(surface, groups, rays.told(level, hits.t), goes_on, arena)
        if phong.normal is not None:
            surface = surface._replace(ns=phong.normal)
        light = self._illuminated(surface, phong, level, worker)
        self._add(radiance, rays, light)
        return self._further(rays, surface, phong, level, worker) if goes_on else None

    def _trace(self, rays, level, worker):
        """First hits of the rays of a level."""
        return self.scene.accel.intersect(rays.o, rays.d, rays.tmax, worker.scratch, clock=worker.clock)

    def _add_environment(self, rays, hits, level, radiance, arena):
        missed = self._leaving(rays, hits, level)
        if missed.size == 0:
            return
        if level == 0 and self.settings.transparent_film:
            radiance[3, missed] = 0
        elif Feature.ENVIRONMENT in self.features:
            environment = self.scene.lights.environment
            d = None if environment.is_constant else rays.d
            rays = gather(rays._replace(o=None, d=d, tmax=None), missed, arena)
            seen = environment.eval(rays.d, arena, ray=rays.told(level, None))
            self._add(radiance, rays, np.broadcast_to(seen, (3, missed.size)), missed)

    def _leaving(self, rays, hits, level):
        """Lanes that leave the scene and see where they go."""
        return np.flatnonzero(hits.prim < 0)

    def _add_emission(self, rays, hits, level, radiance, arena):
        met = np.flatnonzero(np.take(self.scene.emissive_prim, hits.prim, mode="wrap"))
        if met.size:
            hits, rays = gather(hits, met, arena), gather(rays, met, arena)
            surface = self.scene.interact(hits, rays.o, rays.d, arena)
            light = self.scene.emitted(surface, arena, rays.told(level, hits.t))
            self._add(radiance, rays, light, met)

    def _add(self, radiance, rays, light, lanes=None):
        """Add weighted light; several rays of a level may belong to one lane."""
        if rays.weight is not None:
            light = light * rays.weight
        lane = rays.lane if rays.lane is not None else lanes
        for row, values in zip(radiance, light, strict=False):
            if lane is None:
                row += values
            elif rays.weight is None:
                row[lane] += values
            else:
                np.add.at(row, lane, values)

    # -- shading -------------------------------------------------------------------------------------------------------

    def _parameters(self, surface, groups, ray, goes_on, arena):
        """Phong parameters of every group of lanes, side by side."""
        if self._table is not None:
            return self._overridden(self._table.at(surface.prim, goes_on, arena), surface)
        parts = [
            self._group_parameters(n, slices(surface, a, b), ray.at(slice(a, b)), goes_on, arena) for n, a, b in groups
        ]
        if len(parts) == 1:
            return self._overridden(parts[0], surface)
        *columns, normals = zip(*parts, strict=True)
        normal = None
        if any(n is not None for n in normals):
            whole = [surface.ns[:, a:b] if n is None else n for n, (_, a, b) in zip(normals, groups, strict=True)]
            normal = _stacked(whole, arena)
        columns = (None if column[0] is None else _stacked(column, arena) for column in columns)
        return self._overridden(PhongParameters(*columns, normal), surface)

    def _group_parameters(self, number, surface, ray, goes_on, arena):
        scene = self.scene
        material = arena.take(scene.geometry.material, surface.prim)
        constants = scene.materials.constants(number, "scatter", material, arena)
        context = surface_context(surface, scene.geometry, arena, ray)
        lobes = scene.materials.programs[number].lobes_over(context, constants)
        transparency = None
        if goes_on and scene.materials.programs[number].transparency is not None:
            constants = scene.materials.constants(number, "transparency", material, arena)
            transparency = scene.materials.programs[number].transparency.run(context, constants)["T"]
        return phong_parameters(lobes, surface.ns, surface.wo, transparency, arena, goes_on)

    def _overridden(self, phong, surface):
        """The scene-wide overrides of the settings."""
        s = self.settings
        if s.exponent is not None:
            phong.exponent.fill(s.exponent)
        if phong.eta is None:
            return phong
        if s.reflectivity is not None:
            phong.k_s.fill(s.reflectivity)
        if s.transparency is not None:
            phong.k_t.fill(s.transparency)
        if s.ior is not None:
            phong.eta[:] = np.where(surface.front, s.ior, 1 / s.ior)
        return phong

    def _illuminated(self, surface, phong, level, worker):
        """Ambient light and the local terms of every light, (3, N)."""
        arena = worker.scratch
        ambient = self.settings.ambient
        if ambient is None:
            ambient = self.scene.lights.classic.ambient_radiance.reshape(3, 1)
        light = np.multiply(phong.diffuse, ambient, out=arena.empty(surface.p.shape))
        twice = dot(surface.wo, surface.ns, arena)
        np.add(twice, twice, out=twice)
        ray = SHADOW_RAY._replace(depth=level + 1, length=0.0) if Feature.LIGHT_PATH in self.features else SHADOW_RAY
        lights = self.scene.lights.classic
        for k in range(lights.count):
            with arena.frame():
                wi, distance, irradiance = lights.illuminate(k, surface.p, arena, surface.ns)
                value = self._reflected(k, level, surface, phong, twice, wi, irradiance, arena)
                if self.shadows:
                    np.multiply(value, self._seen(k, surface, value, wi, distance, ray, worker), out=value)
                np.add(light, value, out=light)
        return light

    def _reflected(self, k, level, surface, phong, twice, wi, irradiance, arena):
        """What the surface sends of light number `k` to the viewer when nothing stands between, over `irradiance`.

        `twice` (N,) is 2 wo·n.
        """
        with arena.frame():
            value = arena.empty(wi.shape)
            cosine = dot(surface.ns, wi, arena)
            at_least(cosine, 0, cosine)
            # The mirror direction 2 (wo·n) n - wo, times wi.
            along = np.multiply(twice, cosine, out=arena.empty(cosine.shape))
            np.subtract(along, dot(surface.wo, wi, arena), out=along)
            if surface.ns is not surface.ng:
                # A light behind the true surface is in its shadow, whatever the smooth normal says.
                behind = dot(surface.ng, wi, arena)
                np.copyto(cosine, 0, where=np.less_equal(behind, 0, out=arena.empty(behind.shape, bool)))
            np.multiply(cosine, _INV_PI, out=cosine)
            np.multiply(phong.specular, _lobe(phong.exponent, along, arena), out=value)
            np.add(value, phong.diffuse, out=value)
            np.multiply(value, cosine, out=value)
            return np.multiply(value, irradiance, out=irradiance)

    def _seen(self, k, surface, value, wi, distance, ray, worker):
        """Share of light `k` that reaches the surface, (N,) or (3, N); only where `value` (3, N) depends on it."""
        arena = worker.scratch
        lanes = any_channel(value, arena)
        if lanes.size == 0:
            return np.float32(0)
        o, ng, wi = (arena.take(a, lanes) for a in (surface.p, surface.ng, wi))
        offset, distance = arena.take(surface.offset, lanes), arena.take(distance, lanes)
        distance = self.scene.lights.classic.shadow_distance(k, distance, arena)
        # Where they depend on it, the light is in front of the surface (`_reflected`).
        seen = self.visibility(*spawn_to(o, offset, ng, wi, distance, arena, in_front=True), worker, ray)
        out = arena.zeros((*seen.shape[:-1], surface.prim.size))
        for row, values in zip(out.reshape(-1, out.shape[-1]), seen.reshape(-1, lanes.size), strict=True):
            row[lanes] = values  # twice as fast as all rows by one index
        return out

    # -- rays beyond ---------------------------------------------------------------------------------------------------

    def _further(self, rays, surface, phong, level, worker):
        """Mirror and refracted rays of a level, one after the other; None when none carries enough."""
        arena = worker.scratch
        out = worker.states[(level + 1) & 1]
        out.reset()
        lane = np.arange(surface.prim.size) if rays.lane is None else rays.lane
        bent, total = _refracted(surface, phong.eta, arena)
        # Where light cannot leave, the mirror ray carries the refracted one's share too.
        mirrored, passed = arena.empty(bent.shape), arena.empty(bent.shape)
        np.multiply(phong.k_t, total, out=mirrored)
        np.subtract(phong.k_t, mirrored, out=passed)
        np.add(mirrored, phong.k_s, out=mirrored)
        if Feature.BOUNCE_LIMITS in self.features:
            self._end_spent(rays, level, mirrored, passed)
        parts = []
        for refracted, (wi, weight) in enumerate(((reflect(surface.wo, surface.ns, arena), mirrored), (bent, passed))):
            if rays.weight is not None:
                np.multiply(weight, rays.weight, out=weight)
            with arena.frame():
                kept = np.flatnonzero(np.max(weight, axis=0, out=arena.empty(total.shape)) > _PRUNE)
            if kept.size:
                d, p, offset, ng = (arena.take(a, kept) for a in (wi, surface.p, surface.offset, surface.ng))
                parts.append((spawn(p, offset, ng, d, arena), d, arena.take(weight, kept), arena.take(lane, kept)))
                if self.features & (Feature.LIGHT_PATH | Feature.VISIBILITY | Feature.BOUNCE_LIMITS):
                    parts[-1] += (_trail(rays, kept, refracted, arena),)
        if not parts:
            return None
        o, d, *rest = (_stacked(column, out) for column in zip(*parts, strict=True))
        return Rays(o, d, None, *rest)

    def _end_spent(self, rays, level, mirrored, passed):
        """Set weights (3, N) of mirror and of refracted rays to 0 where a path has as many as it may."""
        refractions = np.float32(0) if rays.trail is None else rays.trail[1]
        np.copyto(mirrored, 0, where=level - refractions >= self.settings.glossy_bounces)
        np.copyto(passed, 0, where=refractions >= self.settings.transmission_bounces)


def _lobe(exponent, along, arena):
    """Phong's lobe times π, (m + 2)/2 · cosᵐα, (N,); `along` (N,) is cosα and is overwritten."""
    # exp(m log) is five times as fast as power; its result stays above the subnormal numbers, which are slow.
    np.log(at_least(along, 1e-30, along), out=along)
    np.multiply(along, exponent, out=along)
    np.exp(at_least(along, _LEAST_LOG, along), out=along)
    half = np.multiply(exponent, 0.5, out=arena.empty(exponent.shape))
    return np.multiply(np.add(half, 1, out=half), along, out=along)


def _trail(rays, lanes, refracted, arena):
    """`Rays.trail` of the rays that go on from `lanes`, all of them `refracted` (1) or mirrored (0)."""
    trail = arena.full((2, lanes.size), refracted)
    if rays.trail is not None:
        trail[1] += rays.trail[1][lanes]
    return trail


def _refracted(surface, eta, arena):
    """Snell's direction (3, N), and whether there is none (total reflection), (N,) float32 1 or 0."""
    wi, total = arena.empty(surface.wo.shape), arena.empty(eta.shape)
    with arena.frame():
        ratio, root, t = arena.empty(eta.shape), arena.empty(eta.shape), arena.empty(wi.shape)
        cosine = dot(surface.wo, surface.ns, arena)
        np.divide(1, eta, out=ratio)
        # 1 - (1 - cos²) / eta²
        np.multiply(cosine, cosine, out=root)
        np.subtract(root, 1, out=root)
        np.multiply(root, ratio, out=root)
        np.multiply(root, ratio, out=root)
        np.add(root, 1, out=root)
        np.less(root, 0, out=total, casting="unsafe")
        np.sqrt(at_least(root, 0, root), out=root)
        np.multiply(cosine, ratio, out=cosine)
        np.subtract(cosine, root, out=cosine)
        np.multiply(surface.ns, cosine, out=wi)
        np.subtract(wi, np.multiply(surface.wo, ratio, out=t), out=wi)
    return wi, total


def _stacked(parts, arena):
    """Arrays side by side, in `arena`."""
    out = arena.empty((*parts[0].shape[:-1], sum(p.shape[-1] for p in parts)), parts[0].dtype)
    return np.concatenate(parts, axis=-1, out=out)
