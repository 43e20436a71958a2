# SPDX-License-Identifier: GPL-3.0-or-later
"""What all methods share: a worker's memory and counters, camera rays, visibility.

A chunk is a set of lanes (pixel samples) that one worker carries from the camera to the film.
"""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import dataclass, field
from threading import Event

import numpy as np

from ..arena import Arena
from ..compile.features import Feature
from ..interaction import SHORTEST
from ..nodes.base import CAMERA_RAY, SHADOW_RAY, Context
from ..sampling.pixel_filter import pixel_filter
from ..sampling.sampler import Draw
from ..tile_order import ranges
from .transparency import transmittance

RAY_KINDS = ("camera", "shadow", "secondary")
"""What rays are counted by."""

# What numpy does about overflows and NaN in a chunk: what is not finite goes through, the film leaves it out and counts
# it.
_FLOATING_POINT = "ignore"


@contextmanager
def watched_arithmetic(watched=True):
    """Let numpy warn of overflows and NaN while rendering, or not, as it does by default; for tests."""
    global _FLOATING_POINT
    before, _FLOATING_POINT = _FLOATING_POINT, "warn" if watched else "ignore"
    try:
        yield
    finally:
        _FLOATING_POINT = before


@dataclass
class Clock:
    """Seconds spent inside Embree."""

    seconds: float = 0.0


@dataclass
class Worker:
    """Memory and counters of one thread.

    `output` holds a chunk's radiance, `scratch` what one bounce needs, `states` the lanes that go on: one arena for
    even and one for odd bounces. Once `stop` is set, a chunk is given up between two bounces.
    """

    output: Arena = field(default_factory=Arena)
    scratch: Arena = field(default_factory=Arena)
    states: tuple[Arena, Arena] = field(default_factory=lambda: (Arena(), Arena()))
    clock: Clock = field(default_factory=Clock)
    rays: dict = field(default_factory=lambda: dict.fromkeys(RAY_KINDS, 0))
    nonfinite: int = 0
    unseen: np.ndarray | None = None  # lanes of the chunk that fall beside a round picture
    first: object = None  # `Hits` of the chunk where they are known before (`bake`)
    casters: object = None  # what casts the shadows that are asked for now; None is what all lights share
    stop: Event = field(default_factory=Event)
    rows: np.ndarray | None = None  # the chunk's radiance, where it is split into passes
    caught: object = None  # `Caught` of the chunk (`catchers`)

    @property
    def nbytes(self):
        """Memory held."""
        return sum(arena.nbytes for arena in (self.output, self.scratch, *self.states))

    def restart(self):
        """Give back the memory of the chunk before."""
        for arena in (self.output, self.scratch, *self.states):
            arena.reset()


@dataclass(frozen=True)
class Chunk:
    """Pixels and samples of a chunk; lane ``p * S + s`` is sample number s of pixel p, of S.

    A pixel's samples follow one another, as they see nearly the same: what one touched is in the cache for the next.

    pixels : (P,) int32, ``y * width + x`` of the whole frame; samples : tuple of int.
    """

    pixels: np.ndarray
    samples: tuple

    @property
    def lanes(self):
        """Number of lanes."""
        return self.pixels.size * len(self.samples)

    def waves(self, lanes):
        """Chunks of some of the pixels, of about so many lanes: [(first lane, Chunk)]."""
        parts = ranges(self.pixels.size, max(-(-self.lanes // lanes), 1))
        return [(a * len(self.samples), Chunk(self.pixels[a:b], self.samples)) for a, b in parts]


class Wavefront:
    """Base of the methods; one object serves all workers.

    Parameters
    ----------
    compiled : CompiledScene
    settings : Settings

    Attributes
    ----------
    chunk : int
        Lanes that are best traced together: many, so that calls cost little beside their work.
    waves : int
        As many times that is a task for `trace`, where there are so many.
    behind, compose : int, callable
        Channels of `radiance` after the picture's of which, and of the picture's, ``compose(means)`` makes the picture
        that is shown, both of as many channels; None where it is there already.
    extra : int
        Channels of `radiance` beyond, which are no part of the picture.
    """

    chunk = 131072
    waves = 1
    behind, compose = 0, None
    extra = 0

    def __init__(self, compiled, settings):
        self.scene = compiled
        self.features = compiled.features
        self.settings = settings
        self.channels = 4 if settings.transparent_film else 3
        self._filter = pixel_filter(settings.pixel_filter, settings.filter_width)
        self.visibility = self._through_surfaces if Feature.TRANSPARENCY in compiled.features else self._unblocked
        if compiled.lights.sampler.has_shadowless:
            self._cast, self.visibility = self.visibility, self._cast_some

    def trace(self, chunk, worker):
        """Radiance of a chunk, (channels, lanes) float32 in `worker.output`; None when `worker.stop` was set."""
        raise NotImplementedError

    def radiance(self, chunk, worker):
        """What `trace` gives, black where the camera shows nothing."""
        with np.errstate(over=_FLOATING_POINT, divide=_FLOATING_POINT, invalid=_FLOATING_POINT):
            radiance = self.trace(chunk, worker)
        if radiance is not None and worker.unseen is not None:
            radiance[:3, worker.unseen] = 0
            radiance[3:, worker.unseen] = 1
        return radiance

    def camera_lanes(self, chunk, worker, arena):
        """Keys, slots and rays of a chunk: (keys, slots, o, d, tmax); `arena` is not the worker's `scratch`."""
        pixels, keys, slots = self.numbered_lanes(chunk, arena)
        dimensions = self.scene.camera.dimensions
        with worker.scratch.frame() as scratch:
            jitter = self.scene.sampler.draw(Draw.PIXEL.at(0), dimensions, keys, slots, chunk.samples, scratch)
            self.place_samples(jitter, chunk)
            return keys, slots, *self.camera_rays(pixels, jitter, worker, arena)

    def numbered_lanes(self, chunk, arena):
        """Pixel, key and slot of each lane of a chunk; without slots where there is one sample."""
        count, keys = len(chunk.samples), self.scene.sampler.keys(chunk.pixels, arena)
        if count == 1:
            return chunk.pixels, keys, None
        slots = np.tile(np.arange(count, dtype=np.uint8), chunk.pixels.size)
        return np.repeat(chunk.pixels, count), np.repeat(keys, count), slots

    def camera_rays(self, pixels, jitter, worker, arena):
        """Rays (o, d, tmax) through `pixels` (N,), at even numbers `jitter` (2 or 4, N) in them; (2, 1) is for all."""
        if self._filter is not None:
            self._filter.place(jitter[:2], arena)
        o, d, tmax = self.scene.camera.rays(pixels, jitter, arena)
        worker.unseen = np.flatnonzero(tmax <= 0) if self.scene.camera.is_round else None
        worker.rays["camera"] += pixels.size
        return o, d, tmax

    def place_samples(self, jitter, chunk):
        """Where in their pixels, and in the lens, (2 or 4, N) the samples fall; the default leaves them at random."""

    def _unblocked(self, o, d, tmax, worker, ray=SHADOW_RAY):
        """How much light passes along shadow rays: (N,) float32, 0 or 1."""
        arena = worker.scratch
        worker.rays["shadow"] += o.shape[1]
        blocked = self._casters(worker).occluded(o, d, tmax, arena, clock=worker.clock)
        clear = arena.empty(o.shape[1])
        np.copyto(clear, np.logical_not(blocked, out=blocked))
        return clear

    def _through_surfaces(self, o, d, tmax, worker, ray=SHADOW_RAY):
        """The same where surfaces let light pass straight through: (3, N)."""
        limit = self.settings.transparent_depth
        return transmittance(self.scene, self._casters(worker), o, d, tmax, limit, worker, ray)

    def _casters(self, worker):
        """What shadow rays are asked against."""
        return self.scene.accel

    def _cast_some(self, o, d, tmax, worker, ray=SHADOW_RAY):
        """The same where lights without shadow ask for rays of no length."""
        arena = worker.scratch
        lanes = np.flatnonzero(tmax >= SHORTEST)
        seen = self._cast(*(arena.take(a, lanes) for a in (o, d, tmax)), worker, ray.at(lanes))
        out = arena.full((*seen.shape[:-1], tmax.size), 1.0)
        out[..., lanes] = seen
        return out


def surface_context(surface, geometry, arena, ray=CAMERA_RAY):
    """The `Context` in which programs run over the lanes of `surface`."""
    return Context(arena, surface.prim.size, surface, geometry, ray=ray)


def gather(columns, lanes, arena):
    """Lanes of a NamedTuple of arrays, dense; the same array twice is gathered once."""
    taken = {}
    for a in columns:
        if a is not None and id(a) not in taken:
            taken[id(a)] = arena.take(a, lanes)
    return type(columns)(*(None if a is None else taken[id(a)] for a in columns))


def slices(columns, start, stop):
    """Lanes start to stop of a NamedTuple of arrays, as views; the same array twice stays one."""
    views = {id(a): a[..., start:stop] for a in columns if a is not None}
    return type(columns)(*(None if a is None else views[id(a)] for a in columns))


def _add_indexed(row, lanes, values):
    row[lanes] += values


add_at = np.add.at if np.lib.NumpyVersion(np.__version__) >= "1.25.0" else _add_indexed
"""Add `values` (n,) to the unique `lanes` (n,) of a row: half the time by `numpy.add.at`, ten times before 1.25."""


def any_channel(color, arena):
    """Lanes of `color` (3, N) in which some channel is not zero."""
    with arena.frame():
        bits, rows = arena.empty(color.shape[1], np.uint32), color.view(np.uint32)
        np.copyto(bits, rows[0])
        for row in rows[1:]:
            np.bitwise_or(bits, row, out=bits)
        np.left_shift(bits, np.uint32(1), out=bits)  # -0 is zero
        return nonzero(bits, arena)


def nonzero(values, arena):
    """Lanes in which `values` (N,) are not zero; numpy looks for numbers ten times as long as for True."""
    with arena.frame():
        return np.not_equal(values, 0, out=arena.empty(values.shape, bool)).nonzero()[0]
