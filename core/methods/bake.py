# SPDX-License-Identifier: GPL-3.0-or-later
"""Wavefronts that start on surfaces: a lane's first hit is a given point instead of what a camera ray meets.

The point is seen from straight above its shading normal, or from a camera, as in Cycles,
`kernel/integrator/init_from_bake.h`.
"""

from __future__ import annotations

import numpy as np

from ..accel import Hits
from ..bsdf import facets
from ..bsdf.base import Lobe
from ..compile.features import Feature
from ..geometry import NORMAL
from ..interaction import spawn, uv_at
from ..nodes.base import SHADOW_RAY
from ..sampling.sampler import Draw
from ..sampling.warp import square_to_cosine_hemisphere
from ..vecmath import dot, frame, normalize, to_world
from .met import Met
from .pathtrace import PathTrace
from .transparency import pass_through
from .visibility import VisibilityPathTrace
from .wavefront import Wavefront

COLORS = ("diffuse", "glossy", "transmission")
"""Parts of the light by the lobe that reflects it."""

_FLATTEST_VIEW = 0.2  # cosine at which a camera sees the surface at least. Source: Cycles
_ABOVE = 1e-5  # and its geometric normal
_GLASS = Lobe.REFLECTION | Lobe.TRANSMISSION
_STAGES = ("emit", "direct", "indirect")


def bake_method(points, plan):
    """What makes the `Wavefront` of `plan`, a `core.bake.Bake`, for `core.render.render`."""

    def method(compiled, settings):
        if plan.traces_paths:
            kind = _VisibilityLight if Feature.VISIBILITY in compiled.features else _PathLight
        else:
            kind = _Occlusion if plan.kind == "ao" else _Facts
        return kind(compiled, settings, points, plan)

    return method


class _FromPoints:
    """Lanes that start on `points` (`core.bake.BakePoints`); a mixin of wavefronts."""

    def __init__(self, compiled, settings, points, plan):
        super().__init__(compiled, settings)
        self._points, self._plan = points, plan

    def camera_lanes(self, chunk, worker, arena):
        """Keys, slots and rays of a chunk that look at the points, whose hits are left in `worker.first`."""
        pixels, keys, slots = self.numbered_lanes(chunk, arena)
        jitter = self.scene.sampler.draw(Draw.PIXEL.at(0), (0, 1), keys, slots, chunk.samples, arena)
        self.place_samples(jitter, chunk)
        u, v = self._points.at(pixels, jitter)
        hits = Hits(arena.full(pixels.size, 1.0), arena.take(self._points.prim, pixels), u, v)
        n = self._first_normals(hits.prim, arena)
        o, towards = arena.zeros(n.shape), np.negative(n, out=arena.empty(n.shape))
        surface = self.scene.interact(hits, o, towards, arena)
        d = np.negative(self._viewer(surface, arena), out=towards)
        np.subtract(surface.p, d, out=o)
        worker.unseen, worker.first = None, hits
        return keys, slots, o, d, None

    def _first_normals(self, prim, arena):
        n = arena.empty((3, prim.size))
        np.copyto(n, np.take(self.scene.geometry.facets[:, NORMAL], prim, axis=0).T)
        return n

    def _viewer(self, surface, arena):
        """Directions (3, N) from the points to who sees them."""
        n, view = surface.ns, self._plan.view
        if view is None:
            return n
        wo = normalize(view.towards(surface.p), arena)
        cosine = dot(wo, n, arena)
        wo += n * np.maximum(_FLATTEST_VIEW - cosine, 0)
        normalize(wo, arena, out=wo)
        behind = np.clip(-cosine, 0, 1)
        normalize(wo + (n - wo) * behind, arena, out=wo)
        wo += surface.ng * np.maximum(_ABOVE - dot(wo, surface.ng, arena), 0)
        return normalize(wo, arena, out=wo)

    def _trace(self, paths, lanes, o, d, tmax, depth, worker):
        if depth == 0:
            # Beyond a transparent point is nothing: the texel tells of its own surface alone.
            return worker.first if lanes is None else _nowhere(o.shape[1], worker.scratch)
        return super()._trace(paths, lanes, o, d, tmax, depth, worker)


def _nowhere(count, arena):
    """`Hits` of rays that meet nothing."""
    t, u, v = arena.zeros((3, count))
    return Hits(t, arena.full(count, -1, np.int32), u, v)


# -- light -------------------------------------------------------------------------------------------------------------


class _Light(_FromPoints):
    """Light that leaves the points, of the kinds that the plan wants; a mixin of path tracing."""

    def __init__(self, compiled, settings, points, plan):
        super().__init__(compiled, settings, points, plan)
        self._add_any, self._add = self._add, self._add_wanted
        self._whole = plan.kind == "combined"
        self._lobes = frozenset(COLORS) & plan.parts if self._whole else frozenset({plan.kind})

    def _add_wanted(self, radiance, lanes, light, bounces):
        stage = _STAGES[min(bounces, 1) + 1]
        if stage in self._plan.parts and (self._whole or stage != "emit"):
            self._add_any(radiance, lanes, light, bounces)

    def _kept(self, lobes, ray):
        if _is_scattered(ray):
            return lobes
        return [(self._part(lobe), *rest) for lobe, *rest in lobes]

    def _part(self, lobe):
        """What of a lobe belongs to the light that is wanted."""
        reflects, transmits = (kind in self._lobes for kind in ("glossy", "transmission"))
        if Lobe.DIFFUSE in lobe.flags:
            return lobe if "diffuse" in self._lobes else _Part(lobe, 0)
        if _GLASS in lobe.flags:
            return lobe if reflects and transmits else _Part(lobe, int(reflects) - int(transmits))
        kept = transmits if Lobe.TRANSMISSION in lobe.flags else reflects
        return lobe if kept else _Part(lobe, 0)


class _Part:
    """A lobe of which only what goes to one side counts: 1 the viewer's, -1 the other, 0 neither."""

    def __init__(self, lobe, side):
        self._lobe, self._side = lobe, np.float32(side)

    def __getattr__(self, name):
        return getattr(self._lobe, name)

    def sample(self, params, n, wo, uc, u0, u1, arena):
        """As the lobe, whose weight is 0 on the other side."""
        s = self._lobe.sample(params, n, wo, uc, u0, u1, arena)
        return s._replace(weight=s.weight * self._keeps(n, s.wi, arena))

    def eval_pdf(self, params, n, wo, wi, arena):
        """As the lobe, whose value is 0 on the other side."""
        f, pdf = self._lobe.eval_pdf(params, n, wo, wi, arena)
        return f * self._keeps(n, wi, arena), pdf

    def albedo(self, params, n, wo, arena):
        """As the lobe, nothing where no side counts."""
        return self._lobe.albedo(params, n, wo, arena) * abs(self._side)

    def _keeps(self, n, wi, arena):
        return (dot(n, wi, arena) * self._side > 0).astype(np.float32)


class _PathLight(_Light, PathTrace):
    def _passages(self, paths, hits, depth, samples, worker):
        def trace(lanes, o, d, tmax):
            return self._trace(paths, lanes, o, d, tmax, depth, worker)

        return pass_through(self.scene, paths, hits, depth, self.settings.transparent_depth, samples, worker, trace)


class _VisibilityLight(_Light, VisibilityPathTrace):
    pass


def _is_scattered(ray):
    return not np.isscalar(ray.depth) or ray.depth > 0


# -- what needs no light -----------------------------------------------------------------------------------------------


class _AtPoints(_FromPoints, Wavefront):
    """One number or vector of each point."""

    def place_samples(self, jitter, chunk):
        """The first sample is the texel's middle."""
        if chunk.samples[0] == 0:
            jitter[:, :: len(chunk.samples)] = 0.5

    def trace(self, chunk, worker):
        """What the plan names, (channels, lanes); None when stopped."""
        worker.restart()
        if worker.stop.is_set():
            return None
        out = worker.output.full((self.channels, chunk.lanes), 1.0)
        keys, slots, o, d, _ = self.camera_lanes(chunk, worker, worker.states[0])
        with worker.scratch.frame():
            met = Met(self.scene, worker.first, o, d, worker.scratch)
            numbers = keys, slots, chunk.samples
            out[:3] = self._read(met, numbers, worker)
            if self.channels > 3:
                out[3] = self._opacity(met)
        return out

    def _opacity(self, met):
        return met.opacity() if Feature.TRANSPARENCY in self.features else np.float32(1)


class _Facts(_AtPoints):
    """What the surface is there."""

    def _read(self, met, numbers, worker):
        if self._plan.kind == "environment":
            return self._environment(worker.scratch, met.surface.p)
        return _FACTS[self._plan.kind](self.scene, met, worker.scratch)

    def _environment(self, arena, p):
        if Feature.ENVIRONMENT not in self.features:
            return np.float32(0)
        world = p + self.scene.geometry.origin.astype(np.float32).reshape(3, 1)
        return self.scene.lights.environment.eval(normalize(world, arena), arena)


class _Occlusion(_AtPoints):
    """How much of the hemisphere is free within a distance: 1 is all."""

    def _read(self, met, numbers, worker):
        arena = worker.scratch
        n = _diffuse_normal(met, arena)
        u = self.scene.sampler.draw(Draw.BSDF.at(0), (1, 2), *numbers, arena)
        s, t = frame(n, arena)
        w = to_world(square_to_cosine_hemisphere(u[0], u[1], arena), s, t, n, arena)
        surface = met.surface
        start = spawn(surface.p, surface.offset, surface.ng, w, arena)
        free = self.visibility(start, w, arena.full(w.shape[1], self._plan.distance), worker, SHADOW_RAY)
        return free * self._opacity(met)


def _diffuse_normal(met, arena):
    """Mean of the diffuse lobes' normals by their weights, (3, n); the shading normal where there are none."""
    out = met.surface.ns.copy()
    for lanes, surface, _, entries in met.parts:
        total = np.zeros((3, lanes.size), np.float32)
        for lobe, weight, _, n in entries:
            if Lobe.DIFFUSE in lobe.flags:
                total += (surface.ns if n is None else n) * np.abs(weight.mean(axis=0))
        total = np.where(total.any(axis=0), total, surface.ns)
        out[:, lanes] = normalize(total, arena)
    return out


def _roughness(scene, met, arena):
    """Mean of the lobes' by their weights; plain diffuse ones do not count beside others, as in Cycles 5.0."""
    out = np.ones(met.lane.size, np.float32)
    for lanes, _, _, entries in met.parts:
        total, of_all = np.zeros((2, lanes.size), np.float32)
        for lobe, weight, params, _ in entries:
            roughness = _roughness_of(lobe, params)
            if roughness is not None:
                share = np.abs(weight.mean(axis=0))
                of_all += share
                total += share * roughness
        out[lanes] = np.divide(total, of_all, out=np.ones_like(total), where=of_all > 0)
    return out


def _roughness_of(lobe, params):
    """0 of mirrors; None of what is plainly diffuse."""
    if Lobe.DELTA in lobe.flags:
        return np.float32(0)
    if Lobe.DIFFUSE in lobe.flags:
        return params.get("roughness")
    if "alpha" not in params or "size" in params:  # toon's size is no width of facets
        return np.float32(1)
    return np.sqrt(facets.mean_alpha(params))


def _position(scene, met, arena):
    return met.surface.p + scene.geometry.origin.astype(np.float32).reshape(3, 1)


def _uv(scene, met, arena):
    out = np.ones((3, met.lane.size), np.float32)
    surface = met.surface
    out[:2] = uv_at(scene.geometry, "", surface.prim, surface.u, surface.v, arena)
    return out


def _color(number):
    return lambda scene, met, arena: met.colors()[number]


_FACTS = {
    "normal": lambda scene, met, arena: met.normal(),
    "emit": lambda scene, met, arena: met.emitted(),
    "position": _position,
    "uv": _uv,
    "roughness": _roughness,
} | {name: _color(number) for number, name in enumerate(COLORS)}
