# SPDX-License-Identifier: GPL-3.0-or-later
"""Monte Carlo path tracing.

The rendering equation, estimated by following one random direction at each hit: emitted light where the path meets
it, a sampled light at every hit, both weighted by the power heuristic, and Russian roulette. Source: Kajiya, "The
Rendering Equation", SIGGRAPH 1986; Veach, "Robust Monte Carlo Methods for Light Transport Simulation", 1997.
"""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from ..compile.features import Feature
from ..interaction import SHADOW_EPSILON, spawn, spawn_to
from ..nodes.base import SHADOW_RAY
from ..sampling.mis import weight as mis_weight
from ..sampling.sampler import Draw
from .bounce_limits import ending
from .holdout import SeesFilm, has_holdouts
from .joining import Joined, in_parts
from .paths import Paths, merged
from .roulette import roulette
from .trails import after_scattering, light_ray, new_trail, shadow_ray
from .transparency import pass_through
from .wavefront import Wavefront, add_at, any_channel, gather, slices, surface_context

_ROULETTE_DEPTH = 2  # hits before the first roulette
_MOST_SHADED = 81920  # lanes of a group, for the memory that its lobes take


class PathTrace(SeesFilm, Wavefront):
    """Path tracing, composed of the stages that the scene needs.

    The waves of a task are traced one after the other until few of their paths are left, which are then followed
    together: a call on a thousand lanes takes as long as one on ten thousand.
    """

    waves = 4

    def __init__(self, compiled, settings):
        super().__init__(compiled, settings)
        features = compiled.features
        self._straight = Feature.TRANSPARENCY in features
        self._tells_rays = bool(features & (Feature.LIGHT_PATH | Feature.BOUNCE_LIMITS))
        self._has_lights = Feature.DIRECT_LIGHT in features
        constant = compiled.lights.environment.is_constant
        self._add_world = self._add_constant_environment if constant else self._add_environment_map
        stages = {
            Feature.ENVIRONMENT: self._add_world,
            Feature.EMISSIVE_SURFACES: self._add_emission,
        }
        self._arrivals = tuple(stage for feature, stage in stages.items() if feature in features)
        self._has_lamps = Feature.LAMPS in features
        self._sees_lamps = 1  # hits before paths see lamps; the camera does not, as in Cycles
        self._sees_film = settings.transparent_film
        self._film_depth = 0  # hits up to which a path may see the film
        if self._sees_film:
            self._arrivals += (self._clear_film,)
            if has_holdouts(compiled):
                self._arrivals += (self._cut_holes,)
        if Feature.BOUNCE_LIMITS in features:
            self._arrivals += (ending(settings),)
        met_by_chance = Feature.ENVIRONMENT | Feature.EMISSIVE_SURFACES | Feature.LAMPS
        self._last_ray_matters = bool(features & met_by_chance)
        # The third number chooses between lobes, or between reflection and refraction; the last row stands in for it.
        chooses = any(len(p.mixture.lobes) > 1 or p.mixture.refracts for p in compiled.materials.programs)
        self._bsdf_dimensions = (0, 1, 2) if chooses else (0, 1)
        self._add = self._add_clamped if Feature.CLAMP in features else self._add_plain

    def trace(self, chunk, worker):
        """Radiance of a chunk, (channels, lanes); None when stopped."""
        worker.restart()
        radiance = worker.output.zeros((self.channels, chunk.lanes))
        if self._sees_film:
            radiance[3].fill(1)
        waves = chunk.waves(max(self.settings.chunk or self.chunk, -(-chunk.lanes // self.waves)))
        few, late, unseen = chunk.lanes // len(waves) ** 2, defaultdict(list), []
        for lane, wave in waves:
            own = radiance[:, lane : lane + wave.lanes]
            paths = self._start(wave, worker)
            if worker.unseen is not None:
                unseen.append(worker.unseen + lane)
            for depth in range(self.settings.depth + 1):
                if depth and len(waves) > 1 and paths.keys.size <= few:
                    late[depth].append(paths.numbered_from(lane))
                    break
                paths = self._step(paths, depth, wave.samples, own, worker)
                if paths is None:
                    break
        if unseen:
            worker.unseen = np.concatenate(unseen)
        paths = None
        for depth in range(min(late, default=self.settings.depth), self.settings.depth + 1):
            paths = merged([*late.pop(depth, ()), paths])
            if paths is not None:
                paths = self._step(paths, depth, chunk.samples, radiance, worker)
        return None if worker.stop.is_set() else radiance

    def _step(self, paths, depth, samples, radiance, worker):
        """`_bounce`; None when no path goes on, or none shall."""
        if worker.stop.is_set():
            return None
        with worker.scratch.frame():
            paths = self._bounce(paths, depth, samples, radiance, worker)
        return None if paths is None or paths.keys.size == 0 else paths

    def _start(self, chunk, worker):
        arena = worker.states[0]
        arena.reset()  # of an earlier wave only copies are left
        paths = Paths(None, *self.camera_lanes(chunk, worker, arena), None)
        if self._straight:
            paths.beta = arena.full(paths.d.shape, 1.0)
            paths.passed = arena.zeros(paths.keys.size)
        if self._tells_rays:
            paths.trail = new_trail(paths.keys.size, arena)
        return paths

    def _bounce(self, paths, depth, samples, radiance, worker):
        """One hit of every path; returns the paths that go on."""
        hits = self._trace(paths, None, paths.o, paths.d, paths.tmax, depth, worker)
        if depth > 0:
            worker.rays["secondary"] += paths.keys.size
        self._cross(paths, None, hits, depth, radiance, worker)
        return self._meet(paths, hits, depth, samples, radiance, worker)

    def _meet(self, paths, hits, depth, samples, radiance, worker):
        """What happens to paths at `hits`; returns those that go on."""
        if self._straight:
            self._pass_through(paths, hits, depth, samples, radiance, worker)
        for arrive in self._arrivals:
            arrive(paths, hits, depth, radiance, worker)
        if depth == self.settings.depth:
            return None
        return self._scatter(paths, hits, depth, samples, radiance, worker)

    def _trace(self, paths, lanes, o, d, tmax, depth, worker):
        """First hits of segments `o`, `d` of the paths `lanes` (None: all)."""
        return self.scene.accel.intersect(o, d, tmax, worker.scratch, clock=worker.clock)

    def _pass_through(self, paths, hits, depth, samples, radiance, worker):
        """Carry paths through surfaces that they pass straight; what is on the way counts."""
        for lanes, further in self._passages(paths, hits, depth, samples, worker):
            self._cross(paths, lanes, further, depth, radiance, worker)

    def _cross(self, paths, part, hits, depth, radiance, worker):
        """What is on the way of the paths `part` (None: all) to `hits`."""
        if self._has_lamps and depth >= self._sees_lamps:
            self._add_lamps(paths, part, hits, depth, radiance, worker)

    def _passages(self, paths, hits, depth, samples, worker):
        """What `pass_through` yields."""
        return pass_through(self.scene, paths, hits, depth, self.settings.transparent_depth, samples, worker)

    # -- light that a path meets ---------------------------------------------------------------------------------------

    def _add_constant_environment(self, paths, hits, depth, radiance, worker):
        missed = self._leaving(paths, hits, depth)
        if missed.size == 0:
            return
        arena = worker.scratch
        light = arena.empty((3, missed.size))
        light[:] = self.scene.lights.environment.eval(None, arena)
        self._arrive(paths, missed, light, depth, radiance, arena)

    def _add_environment_map(self, paths, hits, depth, radiance, worker):
        missed = self._leaving(paths, hits, depth)
        if missed.size == 0:
            return
        arena = worker.scratch
        environment = self.scene.lights.environment
        d = arena.take(paths.d, missed)
        light = arena.empty((3, missed.size))
        with arena.frame():
            light[:] = environment.eval(d, arena, ray=paths.ray(depth, None, arena, missed))
            if paths.pdf is not None:
                pdf = arena.take(paths.pdf, missed)
                np.multiply(light, mis_weight(pdf, environment.pdf(d, arena), arena), out=light)
        self._arrive(paths, missed, light, depth, radiance, arena)

    def _leaving(self, paths, hits, depth):
        """Lanes that leave the scene towards an environment that they see."""
        if depth == 0 and self._sees_film:
            return np.zeros(0, np.intp)
        return np.flatnonzero(hits.prim < 0)

    def _add_emission(self, paths, hits, depth, radiance, worker):
        met = self._shining(paths, hits, depth)
        if met.size == 0:
            return
        arena = worker.scratch
        hits = gather(hits, met, arena)
        d = arena.take(paths.d, met)
        surface = self.scene.interact(hits, arena.take(paths.o, met), d, arena)
        light = self.scene.emitted(surface, arena, paths.ray(depth, hits.t, arena, met))
        if paths.pdf is not None and self._has_lights:
            start, distance = arena.take(paths.o, met), hits.t
            if paths.passed is not None:
                passed = paths.passed[met]
                start, distance = start - d * passed, distance + passed
            light_pdf = self.scene.lights.sampler.pdf_prim(surface.prim, start, d, distance, arena)
            np.multiply(light, mis_weight(paths.pdf[met], light_pdf, arena), out=light)
        self._arrive(paths, met, light, depth, radiance, arena)

    def _shining(self, paths, hits, depth):
        """Lanes that meet a surface whose emission they see."""
        return np.flatnonzero(np.take(self.scene.emissive_prim, hits.prim, mode="wrap"))

    def _add_lamps(self, paths, part, hits, depth, radiance, worker):
        """Lamps crossed by the latest segment of the paths `part` (None: all), which ends at `hits`."""
        arena = worker.scratch
        ends = arena.empty(hits.t.size)
        # As far beyond a surface as shadow rays end before a lamp: both must see a lamp that lies in a surface.
        np.multiply(hits.t, 1.0 + SHADOW_EPSILON, out=ends)
        np.copyto(ends, np.inf, where=hits.prim < 0)
        o, d, passed = (
            a if a is None or part is None else arena.take(a, part) for a in (paths.o, paths.d, paths.passed)
        )
        asking = None
        if self._tells_rays:
            asking = light_ray(paths.trail if part is None else paths.trail[:, part], depth)
        for lanes, emitted, light_pdf in self._crossings(paths, part, depth, o, d, ends, arena, passed, asking):
            where = lanes if part is None else part[lanes]
            light = np.multiply(
                emitted, mis_weight(paths.pdf[where], light_pdf, arena), out=arena.empty((3, lanes.size))
            )
            self._arrive(paths, where, light, depth, radiance, arena)

    def _crossings(self, paths, part, depth, *rays):
        """Lamps that the paths `part` (None: all) see along `rays`, as of `LampHits`."""
        return self.scene.lights.lamps.crossings(*rays)

    def _arrive(self, paths, lanes, light, depth, radiance, arena):
        """Add `light` (3, n) that met the paths `lanes`."""
        if paths.beta is not None:
            np.multiply(light, arena.take(paths.beta, lanes), out=light)
        where = lanes if paths.lane is None else paths.lane[lanes]
        self._add(radiance, where, light, depth - 1)

    # -- scattering ----------------------------------------------------------------------------------------------------

    def _scatter(self, paths, hits, depth, samples, radiance, worker):
        arena = worker.scratch
        order, groups = self.scene.grouped(hits.prim, arena)
        if order.size == 0:
            return None
        if order.size < hits.prim.size or len(groups) > 1:
            if not (self.scene.needs_rays or self._tells_rays):
                hits, paths.o = hits._replace(t=None), None
            paths.tmax = None
            hits, paths = gather(hits, order, arena), paths.at(order, arena)
            if paths.lane is None:
                paths.lane = order
        surface = self.scene.interact(hits, paths.o, paths.d, arena)
        last = depth == self.settings.depth - 1 and not self._last_ray_matters
        light = sampled = chance = None
        spare = worker.states[(depth + 1) & 1]  # empty until paths go on
        spare.reset()
        if self._has_lights:
            u = self._numbers(Draw.LIGHT, (0, 1, 2), paths, depth, samples, spare)
            asking = light_ray(paths.trail, depth) if self._tells_rays else None
            light = self.scene.lights.sampler.sample(surface.p, u[0], u[1], u[2], arena, asking)
        if not last:
            sampled = self._numbers(Draw.BSDF, self._bsdf_dimensions, paths, depth, samples, spare)
            if depth >= _ROULETTE_DEPTH:
                chance = self._numbers(Draw.LIGHT, (3,), paths, depth, samples, spare)[0]
        ray = paths.ray(depth, hits.t, arena)
        with worker.output.frame() as apart:
            direct, scattered = self._shade(surface, groups, ray, light, sampled, arena, apart)
            if direct is not None:
                with arena.frame():  # else most memory would be taken when paths go on
                    self._add_direct(paths, surface, light, direct, depth, radiance, worker)
            if scattered is None:
                return None
            return self._go_on(paths, surface, scattered, chance, depth, worker)

    def _numbers(self, kind, dimensions, paths, depth, samples, arena):
        return self.scene.sampler.draw(kind.at(depth), dimensions, paths.keys, paths.slots, samples, arena)

    def _shade(self, surface, groups, ray, light, sampled, arena, apart):
        """Evaluate every group's materials: (direct (3, N) or None, BSDFSample or None).

        What several groups gave is put together in the arena `apart`.
        """
        if len(groups) == 1:
            program, start, stop = groups[0]
            return self._shade_group(program, surface, ray, light, sampled, start, stop, arena)
        joined = Joined(surface.prim.size, apart)
        for program, start, stop in in_parts(groups, _MOST_SHADED):
            with arena.frame():
                part, seen_by = slices(surface, start, stop), ray.at(slice(start, stop))
                group = self._shade_group(program, part, seen_by, light, sampled, start, stop, arena)
                joined.put(*group, start, stop)
        return joined.direct, joined.scattered

    def _shade_group(self, number, surface, ray, light, sampled, start, stop, arena):
        scene = self.scene
        program = scene.materials.programs[number]
        mixture = self._mixture(program, ray)
        if not mixture.lobes:
            return None, None
        material = arena.take(scene.geometry.material, surface.prim)
        constants = scene.materials.constants(number, "scatter", material, arena)
        lobes = self._kept(program.lobes_over(surface_context(surface, scene.geometry, arena, ray), constants), ray)
        shares = mixture.shares(lobes, surface, arena)
        direct = scattered = None
        if light is not None and mixture.is_smooth:
            part = slices(light, start, stop)
            direct, pdf = self._evaluate(mixture, lobes, surface, ray, part, arena, shares)
            np.multiply(direct, part.weight, out=direct)
            with arena.frame():
                np.multiply(direct, mis_weight(part.pdf, pdf, arena), out=direct)
        if sampled is not None:
            u = sampled[:, start:stop]
            scattered = mixture.sample(lobes, surface, u[-1], u[0], u[1], arena, shares, self._tells_rays)
        return direct, scattered

    def _mixture(self, program, ray):
        """What scatters the rays `ray` at the surfaces of `program`."""
        return program.mixture

    def _kept(self, lobes, ray):
        """The lobes by which `ray` scatters."""
        return lobes

    def _evaluate(self, mixture, lobes, surface, ray, light, arena, shares):
        """What `surface` sends on of the sampled `light` to `ray`, (3, N), and the density of sampling it, (N,)."""
        return mixture.eval_pdf(lobes, surface, light.wi, arena, shares)

    def _add_direct(self, paths, surface, light, direct, depth, radiance, worker):
        """Add the sampled light where nothing stands between."""
        arena = worker.scratch
        if paths.beta is not None:
            np.multiply(direct, paths.beta, out=direct)
        lit = any_channel(direct, arena)
        if lit.size == 0:
            return
        direct = arena.take(direct, lit)
        # What only the segments are made of goes where the next paths will lie: most memory is taken here.
        with arena.frame(), worker.states[(depth + 1) & 1].frame() as spare:
            wi, distance = spare.take(light.wi, lit), spare.take(light.distance, lit)
            p, offset, ng = (spare.take(a, lit) for a in (surface.p, surface.offset, surface.ng))
            ray = shadow_ray(arena.take(paths.trail, lit), depth) if self._tells_rays else SHADOW_RAY
            segments = spawn_to(p, offset, ng, wi, distance, arena)
            np.multiply(direct, self._seen(light, lit, segments, worker, ray), out=direct)
        self._add(radiance, lit if paths.lane is None else arena.take(paths.lane, lit), direct, depth)

    def _seen(self, light, lanes, segments, worker, ray):
        """How much of the samples `lanes` of `light` passes along `segments`."""
        return self.visibility(*segments, worker, ray)

    def _go_on(self, paths, surface, scattered, u, depth, worker):
        """Throughput, roulette, and the surviving paths in the other state arena."""
        arena = worker.scratch
        beta = scattered.weight
        if paths.beta is not None:
            beta = np.multiply(beta, paths.beta, out=arena.empty(paths.beta.shape))
        beta = np.broadcast_to(beta, paths.d.shape)
        alive, survival = roulette(beta, u, arena)
        if alive.size == 0:
            return None
        out = worker.states[(depth + 1) & 1]
        out.reset()
        d = out.take(scattered.wi, alive)
        kept = Paths(
            lane=alive if paths.lane is None else out.take(paths.lane, alive),
            keys=out.take(paths.keys, alive),
            slots=None if paths.slots is None else out.take(paths.slots, alive),
            o=out.take(spawn(surface.p, surface.offset, surface.ng, scattered.wi, arena), alive),
            d=d,
            tmax=None,
            beta=out.take(beta, alive),
            pdf=out.take(scattered.pdf, alive),
            passed=out.zeros(alive.size) if self._straight else None,
        )
        if self._tells_rays:
            kept.trail = self._trail_on(paths, surface, scattered, alive, arena, out)
        if survival is not None:
            np.divide(kept.beta, arena.take(survival, alive), out=kept.beta)
        return kept

    def _trail_on(self, paths, surface, scattered, lanes, arena, out):
        """The trail of the paths `lanes` after they scattered at `surface`, in the arena `out`."""
        return after_scattering(paths.trail, scattered, surface.ng, lanes, arena, out)

    # -- film ----------------------------------------------------------------------------------------------------------

    def _add_plain(self, radiance, lanes, light, bounces):
        """Add `light` to `lanes`, which are unique."""
        for row, values in zip(radiance, light, strict=False):
            add_at(row, lanes, values)

    def _add_clamped(self, radiance, lanes, light, bounces):
        """The same with each contribution's sum of channels limited; its hue stays."""
        limit = self.settings.clamp_direct if bounces <= 0 else self.settings.clamp_indirect
        if limit > 0:
            total = np.abs(light).sum(axis=0)
            light *= np.minimum(1, limit / np.maximum(total, limit))
        self._add_plain(radiance, lanes, light, bounces)
