# SPDX-License-Identifier: GPL-3.0-or-later
"""Path tracing where not every ray sees every object, and not every light reaches every object.

What a ray does not see is not in the tree that it is asked against (`core.compile.visibility`). Light that is sampled
leaves out the lobes that it is hidden from, rough glass where it is hidden from glossy and transmission rays; a path
that meets it later must be of a kind that sees it: both as in Cycles, `kernel/integrator/surface_shader.h` and
`kernel/light/light.h`.

The light of an emitter with blockers of its own is sampled alone, for a path met other things on its way than shadow
rays do; only mirrors and clear glass show it, behind whatever they show.
"""

from __future__ import annotations

import numpy as np

from ..accel import Hits
from ..bsdf.base import Lobe
from ..visibility import Rays
from .blockers import casters, shaded_by
from .pathtrace import PathTrace
from .trails import is_diffuse, is_transmitted, new_trail
from .transparency import pass_through, straight_weight
from .wavefront import gather

_KINDS = tuple(k.value for k in (Rays.DIFFUSE, Rays.GLOSSY, Rays.TRANSMISSION))
_GLASS = Lobe.REFLECTION | Lobe.TRANSMISSION


class VisibilityPathTrace(PathTrace):
    """Path tracing of scenes with `Feature.VISIBILITY`.

    Paths keep a trail, whose last row is the object that they were scattered by.
    """

    def __init__(self, compiled, settings):
        super().__init__(compiled, settings)
        self._tells_rays = True
        visibility = compiled.visibility
        lamps = visibility.rays[: visibility.first_object]
        self._sees_lamps = 0 if (lamps & Rays.CAMERA.value).any() else 1
        self._clear = compiled.clear_prim
        if visibility.holdout_prim is not None:
            self._arrivals = (self._hold_out, *self._arrivals)
            self._clear = self._clear & ~visibility.holdout_prim

    def _start(self, chunk, worker):
        paths, arena = super()._start(chunk, worker), worker.states[0]
        paths.trail = new_trail(paths.keys.size, arena, receivers=True)
        if paths.beta is None and self.scene.visibility.holdout_prim is not None:
            paths.beta = arena.full((3, paths.keys.size), 1.0)
        if self._has_lamps and not self._sees_lamps:
            paths.pdf = arena.full(paths.keys.size, np.inf)
        return paths

    def _trace(self, paths, lanes, o, d, tmax, depth, worker):
        visibility, arena = self.scene.visibility, worker.scratch
        if depth == 0:
            return visibility.camera.intersect(o, d, tmax, arena, clock=worker.clock)
        first, *others = visibility.scattered
        if all(other is first for other in others):
            return first.intersect(o, d, tmax, arena, clock=worker.clock)
        n = o.shape[1]
        hits = Hits(arena.empty(n), arena.empty(n, np.int32), arena.empty(n), arena.empty(n))
        kind = _kinds(paths.trail if lanes is None else paths.trail[:, lanes], transmitted_first=True)
        for value, accel in zip(_KINDS, visibility.scattered, strict=True):
            own = np.flatnonzero(kind == value)
            if own.size:
                rays = (a if a is None else arena.take(a, own) for a in (o, d, tmax))
                for column, part in zip(hits, accel.intersect(*rays, arena, clock=worker.clock), strict=True):
                    column[own] = part
        return hits

    def _casters(self, worker):
        return casters(self.scene, worker)

    def _passages(self, paths, hits, depth, samples, worker):
        def trace(lanes, o, d, tmax):
            return self._trace(paths, lanes, o, d, tmax, depth, worker)

        clear = self._clear if depth <= self._film_depth else None
        limit = self.settings.transparent_depth
        return pass_through(self.scene, paths, hits, depth, limit, samples, worker, trace, clear)

    # -- light that a path meets ---------------------------------------------------------------------------------------

    def _hold_out(self, paths, hits, depth, radiance, worker):
        """Cut holes where the camera sees objects that hold out what is behind, as far as they are opaque.

        The paths carry nothing on; those that passed straight have been counted out before.
        """
        if depth > self._film_depth:
            return
        arena = worker.scratch
        lanes = np.flatnonzero(np.take(self.scene.visibility.holdout_prim, hits.prim, mode="wrap"))
        lanes = lanes[self._before_film(paths, lanes, depth)]
        if self._sees_film and lanes.size:
            part, d = gather(hits, lanes, arena), arena.take(paths.d, lanes)
            surface = self.scene.interact(part, arena.take(paths.o, lanes), d, arena)
            opacity = 1 - straight_weight(self.scene, surface, arena, paths.ray(depth, part.t, arena, lanes))
            where = lanes if paths.lane is None else paths.lane[lanes]
            radiance[3, where] -= (paths.beta[:, lanes] * opacity).mean(axis=0)
        paths.beta[:, lanes] = 0

    def _leaving(self, paths, hits, depth):
        lanes = super()._leaving(paths, hits, depth)
        return lanes[self._gets(paths, lanes, self.scene.visibility.world, depth)]

    def _shining(self, paths, hits, depth):
        lanes = super()._shining(paths, hits, depth)
        prim = hits.prim[lanes]
        emitter = self.scene.visibility.emitter_of_prim(prim)
        gets = self._gets(paths, lanes, emitter, depth)
        if depth > 0:
            sampled = self.scene.lights.sampler.is_sampled(prim)
            gets &= ~(sampled & self._left_to_samples(paths, lanes, emitter))
        return lanes[gets]

    def _crossings(self, paths, part, depth, *rays):
        visibility = self.scene.visibility
        for light, (lanes, radiance, pdf) in self.scene.lights.lamps.numbered_crossings(*rays):
            where = lanes if part is None else part[lanes]
            emitter = visibility.emitter_of_light(light)
            gets = self._gets(paths, where, emitter, depth)
            if depth > 0:
                gets &= ~self._left_to_samples(paths, where, emitter)
            kept = np.flatnonzero(gets)
            if kept.size:
                yield lanes[kept], *(a if a.shape[-1] == 1 else a[..., kept] for a in (radiance, pdf))

    def _gets(self, paths, lanes, emitter, depth):
        """Whether the paths `lanes` (n,) get the light of `emitter`, a number or (n,), that they meet; (n,) bool."""
        visibility = self.scene.visibility
        rays = visibility.rays[emitter]
        if depth == 0:
            return np.broadcast_to((rays & Rays.CAMERA.value) > 0, lanes.shape)
        trail = paths.trail[:, lanes]
        gets = (rays & _kinds(trail)) > 0
        gets &= visibility.reaches(emitter, trail[-1].astype(np.int32))
        gets &= depth - 1 <= visibility.max_bounces[emitter]
        return gets

    def _left_to_samples(self, paths, lanes, emitter):
        """Whether light samples alone carry the light of `emitter` to where the paths `lanes` come from, (n,)."""
        return (self.scene.visibility.blockers[emitter] > 0) & np.isfinite(paths.pdf[lanes])

    # -- light that is sampled -----------------------------------------------------------------------------------------

    def _evaluate(self, mixture, lobes, surface, ray, light, arena, shares):
        visibility = self.scene.visibility
        emitter = None if light.light is None else visibility.emitter_of_light(light.light)
        if emitter is None or not visibility.limited[emitter].any():
            return super()._evaluate(mixture, lobes, surface, ray, light, arena, shares)
        rays = visibility.rays[emitter]
        seen = [(lobe, _seen_color(lobe, color, rays), *rest) for lobe, color, *rest in lobes]
        direct, pdf = mixture.eval_pdf(seen, surface, light.wi, arena, shares)
        gets = visibility.reaches(emitter, surface_objects(self.scene, surface))
        gets = gets & (ray.depth <= visibility.max_bounces[emitter])
        np.multiply(direct, gets, out=direct)
        np.copyto(pdf, 0, where=visibility.blockers[emitter] > 0)  # nothing else finds this light
        return direct, pdf

    def _seen(self, light, lanes, segments, worker, ray):
        if light.light is None:
            return super()._seen(light, lanes, segments, worker, ray)
        emitter = self.scene.visibility.emitter_of_light(worker.scratch.take(light.light, lanes))
        blockers = self.scene.visibility.blockers[emitter]
        if not blockers.any():
            return self.visibility(*segments, worker, ray)
        arena, parts = worker.scratch, []
        for number in np.unique(blockers):
            lanes = np.flatnonzero(blockers == number)
            with shaded_by(self.scene.visibility.casters[number], worker):
                seen = self.visibility(*(arena.take(a, lanes) for a in segments), worker, ray.at(lanes))
            parts.append((lanes, seen))
        out = arena.empty((*parts[0][1].shape[:-1], blockers.size))
        for lanes, part in parts:
            out[..., lanes] = part
        return out

    def _trail_on(self, paths, surface, scattered, lanes, arena, out):
        trail = super()._trail_on(paths, surface, scattered, lanes, arena, out)
        trail[-1] = surface_objects(self.scene, surface)[lanes]
        return trail


def surface_objects(scene, surface):
    """The objects' numbers, (N,) int32."""
    return np.take(scene.geometry.object, surface.prim)


def _kinds(trail, transmitted_first=False):
    """The kind of ray of each path, (n,) uint8, one of `_KINDS`.

    Objects are hidden from what was sent through a surface by TRANSMISSION alone; lights, like lobes, from what was
    scattered diffusely by DIFFUSE.
    """
    diffuse, glossy, transmission = _KINDS
    through, scattered = is_transmitted(trail), is_diffuse(trail)
    if transmitted_first:
        return np.where(through, transmission, np.where(scattered, diffuse, glossy)).astype(np.uint8)
    return np.where(scattered, diffuse, np.where(through, transmission, glossy)).astype(np.uint8)


def _seen_color(lobe, color, rays):
    """A lobe's colour (3, n), black where the lights seen by `rays` (n,) are hidden from it."""
    diffuse, glossy, transmission = _KINDS
    if Lobe.DIFFUSE in lobe.flags:
        kind = diffuse
    elif _GLASS in lobe.flags:
        kind = glossy | transmission
    else:
        kind = transmission if Lobe.TRANSMISSION in lobe.flags else glossy
    return color * ((rays & kind) > 0).astype(np.float32)
