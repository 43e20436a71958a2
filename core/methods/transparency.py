# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces that let light pass straight through: alpha and the Transparent BSDF.

A passage is no hit: paths decide by chance whether to go on, shadow rays multiply what is left.
"""

from __future__ import annotations

import numpy as np

from ..interaction import SHORTEST, spawn
from ..nodes.base import SHADOW_RAY, Context
from ..sampling.sampler import Draw
from ..vecmath import dot
from .trails import pass_straight

_ROUNDED = np.float32(1 - 5e-7)  # room for the rounding of what is left of a shadow ray
_PASSAGE_GROUPS = 1 << 16  # dimensions of each further passage of one bounce


def straight_weight(scene, surface, arena, ray):
    """What each lane's surface lets pass unbent of the rays `ray`, (3, N)."""
    weight = arena.zeros((3, surface.prim.size))
    material = arena.take(scene.geometry.material, surface.prim)
    for number, lanes in scene.materials.groups(material, arena):
        program = scene.materials.programs[number]
        if program.transparency is None:
            continue
        part = surface if lanes is None else type(surface)(*(None if a is None else a[..., lanes] for a in surface))
        constants = scene.materials.constants(
            number, "transparency", material if lanes is None else material[lanes], arena
        )
        context = Context(arena, part.prim.size, part, scene.geometry, ray=ray if lanes is None else ray.at(lanes))
        value = program.transparency.run(context, constants)["T"]
        weight[:, slice(None) if lanes is None else lanes] = value
    return weight


def transmittance(scene, accel, o, d, tmax, transparent_depth, worker, ray=SHADOW_RAY):
    """Light that reaches the end of shadow rays, (3, N): 0 behind an opaque surface of those in `accel`.

    `ray` describes the rays at their start; a `length` of None is not counted.
    """
    arena = worker.scratch
    n = o.shape[1]
    left = arena.full((3, n), 1.0)
    lane = np.arange(n)
    for _ in range(transparent_depth + 1):
        worker.rays["shadow"] += lane.size
        hits = accel.intersect(o, d, tmax, arena, clock=worker.clock)
        met = np.flatnonzero(hits.prim >= 0)
        if met.size == 0:
            return left
        hits = type(hits)(*(arena.take(a, met) for a in hits))
        o, d, lane = arena.take(o, met), arena.take(d, met), lane[met]
        surface = scene.interact(hits, o, d, arena)
        ray = ray.at(met)
        if ray.length is not None:
            ray = ray._replace(length=ray.length + hits.t)
        left[:, lane] *= straight_weight(scene, surface, arena, ray)
        goes = np.flatnonzero(left[:, lane].any(axis=0))
        lane, start, d, tmax = lane[goes], o[:, goes], d[:, goes], tmax[met][goes]
        o, d, tmax = _onwards(type(surface)(*(a[..., goes] for a in surface)), start, d, tmax, arena)
        ray = ray.at(goes)
        ray = ray._replace(transparent_depth=ray.transparent_depth + 1)
        if lane.size == 0:
            return left
    left[:, lane] = 0
    return left


def _onwards(surface, start, d, tmax, arena):
    """What is left of shadow rays beyond a surface, (o, d, tmax): aimed anew at where they end.

    One that only went on parallel, or for as long as it had to from the surface, would meet the light's own. A ray that
    ends within the surface's error has arrived: there is nothing to aim at.
    """
    scale = np.abs(d).max(axis=0)
    scale[scale < 2] = 1  # rays within a surface's error are long vectors, whose squares float32 does not hold
    unit = d / scale
    squared = dot(unit, unit, arena)
    left = np.maximum(tmax - dot(surface.p - start, unit, arena) / (squared * scale), SHORTEST)
    o = spawn(surface.p, surface.offset, surface.ng, d, arena)
    step = o - surface.p
    arrived = left * np.sqrt(squared) * scale <= np.abs(step).max(axis=0)
    step[:, arrived], left[arrived] = 0, SHORTEST
    return o, d - step / left, left * _ROUNDED


def pass_through(scene, state, hits, depth, transparent_depth, samples, worker, trace=None, clear=None):
    """Carry lanes through surfaces that they pass straight.

    Changes `state` (beta, o, passed, trail) and `hits` in place: at the end each hit is one that scatters, or a miss.
    ``trace(lanes, o, d, tmax)`` gives the `Hits` of further segments; `clear` (P + 1,) bool tells which primitives do
    nothing else. None is what the scene has.

    Yields
    ------
    (lanes, hits)
        Of each further segment.
    """
    arena = worker.scratch
    clear = scene.clear_prim if clear is None else clear
    lane = np.flatnonzero(np.take(scene.transparent_prim, hits.prim, mode="wrap"))
    for passage in range(transparent_depth + 1):
        if lane.size == 0:
            return
        part = type(hits)(*(a[lane] for a in hits))
        d = arena.take(state.d, lane)
        surface = scene.interact(part, arena.take(state.o, lane), d, arena)
        weight = straight_weight(scene, surface, arena, state.ray(depth, part.t, arena, lane))
        chance = np.clip(weight.max(axis=0), 0.0, 1.0)
        chance[np.take(clear, surface.prim)] = 1  # nothing else happens there, so nothing is left to chance
        slots = None if state.slots is None else state.slots[lane]
        group = Draw.STRAIGHT.at(depth) + _PASSAGE_GROUPS * (passage + 1)
        u = scene.sampler.draw(group, (0,), state.keys[lane], slots, samples, arena)[0]
        passes = u < chance
        stays = np.flatnonzero(~passes)
        state.beta[:, lane[stays]] /= 1 - chance[stays]
        goes = np.flatnonzero(passes)
        lane = lane[goes]
        state.beta[:, lane] *= weight[:, goes] / chance[goes]
        if passage == transparent_depth:
            state.beta[:, lane] = 0
            return
        d = d[:, goes]
        o = spawn(surface.p[:, goes], surface.offset[goes], surface.ng[:, goes], d, arena)
        state.o[:, lane] = o
        state.passed[lane] += part.t[goes]
        if state.trail is not None:
            pass_straight(state.trail, lane)
        tmax = None
        if state.tmax is not None:
            state.tmax[lane] -= part.t[goes]
            tmax = state.tmax[lane]
        worker.rays["secondary"] += lane.size
        if trace is None:
            further = scene.accel.intersect(o, d, tmax, arena, clock=worker.clock)
        else:
            further = trace(lane, o, d, tmax)
        for column, values in zip(hits, further, strict=True):
            column[lane] = values
        yield lane, further
        lane = lane[np.take(scene.transparent_prim, further.prim, mode="wrap")]
