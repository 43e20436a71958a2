# SPDX-License-Identifier: GPL-3.0-or-later
"""Guides: pictures of what the camera sees first, beside the picture itself.

A few camera rays of each pixel find them; light is not traced. Meanings are Cycles': depth, position and indices are
those of one ray through the pixel's centre, everything else is the mean over the rays.

========================  ====  =====================================================================================
depth                     1     along the view axis; 1e10 where nothing is
position                  3     in the world
normal                    3     in the world, turned to the viewer, textures and bumps included
uv                        3     the active map; the third is 1 where there is one
vector                    4     pixels to the place a frame before, from that a frame after (`vectors`)
object_index              1     and material_index
mist                      1     0 near, 1 far and where nothing is
diffuse_color             3     and glossy_color, transmission_color: of the lobes, without light
emission, environment     3     what is seen of them directly
denoising_albedo          3     what mirrors and glass show, not they themselves
denoising_normal          3     likewise, in camera space
denoising_depth           1     likewise, length of the way
denoising_specular        3     colour of the mirrors and glass themselves
denoising_roughness       1     of the first surface: 0 mirrors, 1 is diffuse
aov_value:NAME            1     and aov_color:NAME, of 4: what materials and the world tell under that name (`aovs`)
crypto_object             4 L   and crypto_material, crypto_asset: ranked ids and coverages (`cryptomatte`)
========================  ====  =====================================================================================
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import replace
from threading import Event, local

import numpy as np

from ..compile.features import Feature
from ..interaction import spawn, uv_at
from ..nodes.base import CAMERA_RAY, SCATTERED_RAY
from ..sampling.sampler import Draw
from ..spaces import transform_direction, transform_point
from . import aovs
from .cryptomatte import matte_names, name_id, ranked
from .light_passes import summed
from .met import Met, features, shown
from .paths import Paths
from .transparency import pass_through, straight_weight
from .vectors import Vectors, mean
from .wavefront import Chunk, Wavefront, Worker, gather

NOTHING = 1e10  # the depth of what is not there

_OF_CENTRE = {"depth": 1, "position": 3, "object_index": 1, "material_index": 1}
_OF_SOLID = {"normal": 3, "uv": 3, "vector": 4}
_COLORS = ("diffuse_color", "glossy_color", "transmission_color")
_DENOISING = {
    "denoising_albedo": 3,
    "denoising_normal": 3,
    "denoising_depth": 1,
    "denoising_specular": 3,
    "denoising_roughness": 1,
}
_MATTES = ("crypto_object", "crypto_material", "crypto_asset")
_BLENDED = dict.fromkeys(_COLORS, 3) | {"emission": 3, "environment": 3, "mist": 1}
CHANNELS = _OF_CENTRE | _OF_SOLID | _BLENDED | _DENOISING

_FALLOFFS = {"QUADRATIC": np.square, "LINEAR": lambda x: x, "INVERSE_QUADRATIC": np.sqrt}
_MIRRORED = 8  # surfaces in a row that show others
_POLL = 0.05  # seconds between two looks at `cancelled`


def render_guides(compiled, scene, settings, cancelled=lambda: False, around=()):
    """Render the guides that `settings.guides` names.

    Parameters
    ----------
    compiled : CompiledScene
    scene : core.scene.Scene
        That was compiled.
    settings : Settings
    cancelled : callable, optional
        Polled on the calling thread; True stops.
    around : pair of core.scene.Scene, optional
        A frame before and a frame after; without them there is no "vector".

    Returns
    -------
    dict of str to (C, H·W) float32
        By name, row 0 at the bottom; empty where nothing was asked for or the work was stopped.
    """
    names = {n for n in settings.guides.names if n in CHANNELS or n in _MATTES or aovs.is_aov(n)} - {*summed(settings)}
    names -= set() if around else {"vector"}
    if not names:
        return {}
    settings = replace(settings, guides=replace(settings.guides, names=frozenset(names)))
    tracer = _Guides(compiled, scene, settings, around)
    x0, y0, x1, y1 = settings.region
    rows = np.arange(y0, y1, dtype=np.int32)[:, None] * np.int32(settings.width)
    pixels = (rows + np.arange(x0, x1, dtype=np.int32)).ravel()
    threads = settings.threads or os.cpu_count() or 1
    parts = np.array_split(np.arange(pixels.size), max(threads, -(-pixels.size // (settings.chunk or Wavefront.chunk))))
    out = tracer.pictures(pixels.size)
    stop, own = Event(), local()

    def work(places):
        if not hasattr(own, "worker"):
            own.worker = Worker(stop=stop)
        with np.errstate(all="ignore"):  # as in `Wavefront.radiance`
            tracer.trace_part(pixels[places], places, out, own.worker)

    with ThreadPoolExecutor(threads) as pool:
        waiting = {pool.submit(work, places) for places in parts if places.size}
        try:
            while waiting:
                done, waiting = wait(waiting, timeout=_POLL)
                for future in done:
                    future.result()
                if waiting and cancelled():
                    stop.set()
        finally:
            if waiting:
                stop.set()
    return {} if stop.is_set() else out


class _Guides(Wavefront):
    def __init__(self, compiled, scene, settings, around=()):
        super().__init__(compiled, settings)
        self._vectors = Vectors(compiled, scene, around, settings) if around else None
        options = settings.guides
        self._names, self._options = options.names, options
        self._samples = min(options.samples, settings.samples)
        if not self._names - set(_OF_CENTRE):
            self._samples = 1
        self._transparent = Feature.TRANSPARENCY in self.features
        self._accel = compiled.visibility.camera
        objects = scene.objects
        self._object_index = _floats([options.indices.get(x.name, x.info.index) for x in objects])
        self._material_index = _floats([m.index for m in compiled.geometry.materials])
        self._has_uv = _floats(
            [bool(x.mesh.uvs) for x in scene.instances] + [0] * (len(objects) - len(scene.instances))
        )
        self._aovs = {name for name in self._names if aovs.is_aov(name)}
        self._shader_values = aovs.ShaderValues(compiled, sorted(self._aovs), settings.transparent_film)
        self._mattes = {}
        names = matte_names(compiled, scene, options)
        for matte in _MATTES:
            if matte in self._names:
                known = {name: name_id(name) for name in set(names[matte])}
                self._mattes[matte] = np.array([known[name] for name in names[matte]] or [0], np.uint32)

    def pictures(self, count):
        """Black pictures of `count` pixels."""
        channels = CHANNELS | dict.fromkeys(_MATTES, 4 * -(-self._options.levels // 2))
        channels |= {name: aovs.channels(name) for name in self._aovs}
        return {name: np.zeros((channels[name], count), np.float32) for name in sorted(self._names)}

    def place_samples(self, jitter, chunk):
        """The first ray goes through the pixel's centre."""
        if chunk.samples == (0,):
            jitter[:] = 0.5

    def trace_part(self, pixels, places, out, worker):
        """Write pixels of the pictures `out`; left as they are when stopped."""
        sums = {name: np.zeros((len(out[name]), pixels.size), np.float32) for name in self._names - set(_MATTES)}
        if "vector" in sums:
            sums["vector"] = np.zeros((5, pixels.size), np.float32)
        met = {name: np.zeros((self._samples, pixels.size), np.int32) for name in self._mattes}
        weight = np.zeros((self._samples, pixels.size), np.float32)
        for sample in range(self._samples):
            if worker.stop.is_set():
                return
            worker.restart()
            self._trace_sample(
                Chunk(pixels, (sample,)), sums, {n: m[sample] for n, m in met.items()}, weight[sample], worker
            )
        if "vector" in sums:
            out["vector"][:, places] = mean(sums.pop("vector"))
        for name, total in sums.items():
            out[name][:, places] = total if name in _OF_CENTRE else total / np.float32(self._samples)
        if "mist" in out:
            out["mist"][:, places] = 1 - out["mist"][:, places]
        for name, numbers in met.items():
            out[name][:, places] = ranked(numbers, weight, self._mattes[name], len(out[name]) // 4)

    def _trace_sample(self, chunk, sums, met, weight, worker):
        """Add one ray of each pixel."""
        arena = worker.scratch
        keys, slots, o, d, tmax = self.camera_lanes(chunk, worker, worker.states[0])
        hits = self._accel.intersect(o, d, tmax, arena, clock=worker.clock)
        seen = np.ones(keys.size, bool)
        if worker.unseen is not None:
            seen[worker.unseen] = False
            hits.prim[worker.unseen] = -1
        wanted = set(_OF_SOLID) | (set(_OF_CENTRE) if chunk.samples == (0,) else set())
        solid, surfaces = self._names & wanted, None
        blended = self._names - set(_OF_CENTRE) - set(_OF_SOLID) - self._aovs
        if solid:
            surfaces = (
                self._solid(hits, o, d, tmax, worker) if self._transparent else Met(self.scene, hits, o, d, arena)
            )
            self._add_solid(surfaces, solid, sums, arena)
            if "vector" in solid and self._options.moves_background:
                self._vectors.add_background(seen, surfaces.lane, d, sums["vector"], arena)
        if self._aovs:
            limits = self._options.alpha_threshold, self.settings.transparent_depth
            self._shader_values.add(hits, o, d, tmax, *limits, sums, self._accel, worker)
        if not blended:
            return
        beta = arena.full((3, keys.size), 1.0)
        lanes = Paths(None, keys, slots, o, d, tmax, beta, passed=arena.zeros(keys.size))
        if self._transparent:
            limit = self.settings.transparent_depth

            def trace(_, o, d, tmax):
                return self._accel.intersect(o, d, tmax, arena, clock=worker.clock)

            for _ in pass_through(self.scene, lanes, hits, 0, limit, chunk.samples, worker, trace):
                pass
        if surfaces is None or self._transparent:
            surfaces = Met(self.scene, hits, lanes.o, lanes.d, arena)
        lanes.beta *= seen
        self._add_blended(surfaces, lanes, sums, arena)
        if self._mattes and surfaces.lane.size:
            self._add_mattes(surfaces, lanes, met, weight)
        if self._names & set(_DENOISING):
            self._add_features(surfaces, lanes, chunk.samples, sums, worker)

    # -- what has no blend ---------------------------------------------------------------------------------------------

    def _solid(self, hits, o, d, tmax, worker):
        """The first surfaces that are opaque enough; the rays stay as they are."""
        arena = worker.scratch
        hits = type(hits)(*(a.copy() for a in hits))
        o, tmax = o.copy(), None if tmax is None else tmax.copy()
        lane = self._clear_lanes(hits)
        for _ in range(self.settings.transparent_depth + 1):
            part, further = gather(hits, lane, arena), arena.take(d, lane)
            surface = self.scene.interact(part, arena.take(o, lane), further, arena)
            opacity = 1 - straight_weight(self.scene, surface, arena, CAMERA_RAY).mean(axis=0)
            goes = np.flatnonzero(opacity < self._options.alpha_threshold)
            lane = lane[goes]
            if lane.size == 0:
                break
            further = further[:, goes]
            o[:, lane] = spawn(surface.p[:, goes], surface.offset[goes], surface.ng[:, goes], further, arena)
            if tmax is not None:
                tmax[lane] -= part.t[goes]
            left = None if tmax is None else tmax[lane]
            found = self._accel.intersect(arena.take(o, lane), further, left, arena, clock=worker.clock)
            for column, values in zip(hits, found, strict=True):
                column[lane] = values
            lane = lane[np.take(self.scene.transparent_prim, found.prim, mode="wrap")]
        hits.prim[lane] = -1
        return Met(self.scene, hits, o, d, arena)

    def _clear_lanes(self, hits):
        return np.flatnonzero(np.take(self.scene.transparent_prim, hits.prim, mode="wrap"))

    def _add_solid(self, met, names, sums, arena):
        surface, lane, geometry = met.surface, met.lane, self.scene.geometry
        if "depth" in names:
            sums["depth"].fill(NOTHING)
        if lane.size == 0:
            return
        number = arena.take(geometry.object, surface.prim)
        if "depth" in names:
            sums["depth"][0, lane] = transform_point(geometry.view.to_camera, surface.p, arena)[2]
        if "position" in names:
            sums["position"][:, lane] = surface.p + geometry.origin.astype(np.float32).reshape(3, 1)
        if "object_index" in names:
            sums["object_index"][0, lane] = self._object_index[number]
        if "material_index" in names:
            sums["material_index"][0, lane] = self._material_index[met.material]
        if "normal" in names:
            sums["normal"][:, lane] += met.normal()
        if "uv" in names:
            sums["uv"][:2, lane] += uv_at(geometry, "", surface.prim, surface.u, surface.v, arena)
            sums["uv"][2, lane] += self._has_uv[number]
        if "vector" in names:
            self._vectors.add(met, sums["vector"], arena)

    # -- what is blended -----------------------------------------------------------------------------------------------

    def _add_blended(self, met, lanes, sums, arena):
        if "environment" in self._names:
            self._add_environment(_missing(met.lane, lanes), lanes.d, lanes.beta, sums["environment"], arena)
        if met.lane.size == 0:
            return
        beta = arena.take(lanes.beta, met.lane)
        if self._names & set(_COLORS):
            for name, color in zip(_COLORS, met.colors(), strict=True):
                if name in self._names:
                    sums[name][:, met.lane] += color * beta
        if "emission" in self._names:
            sums["emission"][:, met.lane] += met.emitted() * beta
        if "mist" in self._names:
            sums["mist"][0, met.lane] += (1 - self._mist(met.surface.p, arena)) * self._coverage(met, lanes)

    def _add_environment(self, lane, d, beta, out, arena, to=None):
        """Add what the rays `lane` see of the environment to the pixels `to`, which are the lanes by default."""
        if lane.size and Feature.ENVIRONMENT in self.features:
            light = self.scene.lights.environment.eval(arena.take(d, lane), arena)
            out[:, lane if to is None else to[lane]] += light * beta[:, lane]

    def _mist(self, p, arena):
        view, options = self.scene.geometry.view, self._options
        p = transform_point(view.to_camera, p, arena)
        distance = np.sqrt((p * p).sum(axis=0)) if view.is_perspective else np.abs(p[2])
        share = (distance - np.float32(options.mist_start)) / np.float32(max(options.mist_depth, 1e-20))
        return _FALLOFFS[options.mist_falloff](np.clip(share, 0, 1))

    def _coverage(self, met, lanes):
        """Share of the pixel's ray that ends at the surface, (n,)."""
        beta = lanes.beta[:, met.lane].mean(axis=0)
        return beta * met.opacity() if self._transparent else beta

    def _add_mattes(self, met, lanes, numbers, weight):
        objects = self.scene.geometry.object[met.surface.prim]
        for name, row in numbers.items():
            row[met.lane] = met.material if name == "crypto_material" else objects
        weight[met.lane] = self._coverage(met, lanes)

    # -- what a denoiser is told ---------------------------------------------------------------------------------------

    def _add_features(self, met, lanes, samples, sums, worker):
        """Follow mirrors and glass to what they show."""
        arena = worker.scratch
        pixel = np.arange(lanes.keys.size)
        out = {name: sums.get(name) for name in _DENOISING}
        for depth in range(_MIRRORED):
            albedo, way = out["denoising_albedo"], out["denoising_depth"]
            if albedo is not None:
                self._add_environment(_missing(met.lane, lanes), lanes.d, lanes.beta, albedo, arena, pixel)
            if met.lane.size == 0:
                return
            if albedo is not None:
                albedo[:, pixel[met.lane]] += met.emitted() * lanes.beta[:, met.lane]
            if way is not None:
                step = met.surface.p - lanes.o[:, met.lane]
                way[0, pixel[met.lane]] += np.sqrt((step * step).sum(axis=0)) + lanes.passed[met.lane]
            further = self._show(met, lanes, pixel, depth, samples, out, arena)
            if not further:
                return
            pixel, keys, o, d, beta = (np.concatenate(column, axis=-1) for column in zip(*further, strict=True))
            lanes = Paths(None, keys, None, o, d, None, beta, passed=np.zeros(pixel.size, np.float32))
            worker.rays["secondary"] += pixel.size
            met = Met(
                self.scene,
                self.scene.accel.intersect(o, d, None, arena, clock=worker.clock),
                o,
                d,
                arena,
                SCATTERED_RAY,
            )

    def _show(self, met, lanes, pixel, depth, samples, out, arena):
        """Add the surfaces that show themselves; the rays on from the others, [(pixel, keys, o, d, beta)]."""
        further = []
        for part in met.parts:
            blends = self._options.blends
            told, lane = features(part, arena, blends), met.lane[part[0]]
            beta = lanes.beta[:, lane]
            last = depth == _MIRRORED - 1
            shows = np.ones(lane.size, np.float32) if last else shown(told.share, blends)
            turned = transform_direction(self.scene.geometry.view.to_camera, told.normal, arena)
            added = {
                "denoising_albedo": (told.albedo + told.specular if last else told.albedo) * beta * shows,
                "denoising_normal": turned * shows * (beta.mean(axis=0) if blends else 1),
            }
            if depth == 0:
                added["denoising_specular"] = told.specular * beta * (1 if blends else 1 - shows)
                added["denoising_roughness"] = told.roughness * beta.mean(axis=0)
            for name, values in added.items():
                if out[name] is not None:
                    out[name][:, pixel[lane]] += values
            on = np.flatnonzero(shows < 1)
            if on.size:
                rays = self._onwards(part, told.specular * (1 - shows), lanes, lane, on, depth, samples, arena)
                further.append((pixel[lane[on]], *rays))
        return further

    def _onwards(self, part, specular, lanes, lane, on, depth, samples, arena):
        """Rays that leave the places `on` of a part, whose lanes are `lane`: (keys, o, d, beta)."""
        _, surface, mixture, entries = part
        keys = arena.take(lanes.keys, lane)
        u = self.scene.sampler.draw(Draw.BSDF.at(depth), (0, 1, 2), keys, None, samples, arena)
        d = mixture.sample(entries, surface, u[2], u[0], u[1], arena).wi[:, on]
        o = spawn(surface.p[:, on], surface.offset[on], surface.ng[:, on], d, arena)
        return keys[on], o, d, lanes.beta[:, lane[on]] * specular[:, on]


def _missing(lane, lanes):
    """The lanes that are not in `lane`."""
    missed = np.ones(lanes.keys.size, bool)
    missed[lane] = False
    return np.flatnonzero(missed)


def _floats(values):
    return np.asarray(values, np.float32).reshape(-1)
