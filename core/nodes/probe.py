# SPDX-License-Identifier: GPL-3.0-or-later
"""The Ambient Occlusion and Bevel nodes: what lies around a point, found by short rays.

Both cast the node's number of rays wherever they are evaluated. Their directions are points of a lattice, shifted in
each lane by a hash of where it is, so that they depend on neither chunks nor threads.

Source: Blender manual, "Ambient Occlusion Node", "Bevel Node"; King, Kulla, Conty and Fajardo, "BSSRDF Importance
Sampling", SIGGRAPH Talks 2013, for the discs that are projected along three axes; Cycles for the cubic falloff of the
bevel, the axes' shares and which rays see it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from .. import vecmath
from ..interaction import spawn
from ..vecmath import dot, normalize
from . import spaces
from .base import Operation
from .hashing import hash_to_unit

PROBING = frozenset(["ambient_occlusion", "bevel"])  # operations that need a `Probe`

_SAMPLES = 16
_LATTICE = 0.7548776662466927, 0.5698402909980532  # of the plastic number. Source: Roberts, "R2 sequence", 2018
_MOST_HITS = 4  # of its own object, that a ray of the bevel counts
_MOST_STEPS = 8  # surfaces that a ray is followed through
_SHARES = (0.5, 0.25, 0.25)  # of the bevel's rays along the normal and the two axes across it

# Inverse of the share of (1 - r)³ that lies within r of the centre of a disc.
_RADII = np.linspace(0, 1, 1025)
_WITHIN = _RADII**2 * (10 + _RADII * (-20 + _RADII * (15 - 4 * _RADII)))


class Probe(NamedTuple):
    """What nodes cast rays with: the scene's `Accel`, and what tells of a hit (`core.interaction`)."""

    accel: object
    interact: Callable


def _probe_of(context):
    """The `Probe` where rays can be cast: from hits, of rays that ask for more than whether light passes."""
    if context.surface is None or context.geometry is None or getattr(context.surface, "offset", None) is None:
        return None
    shadow = context.ray.shadow
    return None if np.ndim(shadow) == 0 and shadow else context.geometry.probe


def _shifts(context):
    """Two random numbers (N,) of each lane."""
    s, arena = context.surface, context.arena
    words = [np.ascontiguousarray(row) for row in s.p]
    return [hash_to_unit([*words, np.full(1, salt, np.uint32)], arena) for salt in (0x9E3779B9, 0x85EBCA6B)]


def _point(shifts, number, out):
    """Point `number` of the lattice, shifted, into `out`, two rows."""
    for shift, step, row in zip(shifts, _LATTICE, out, strict=True):
        np.add(shift, (number * step) % 1.0, out=row)
        np.subtract(row, np.floor(row), out=row)
    return out


def _given_normal(context, inputs):
    """The unit normal that a node was given, else the shading normal."""
    n = inputs.get("normal")
    if n is None:
        return spaces.shading_normal(context)
    n = np.array(np.broadcast_to(n, (3, context.count)), np.float32)
    return normalize(n, context.arena, out=n)


def _following(probe, o, d, tmax, arena):
    """Yield (lanes, `Hits`, `Interaction`) of all surfaces along rays, nearest first."""
    lanes = np.arange(tmax.size)
    for _ in range(_MOST_STEPS):
        hits = probe.accel.intersect(o, d, tmax, arena)
        met = np.flatnonzero(hits.prim >= 0)
        if met.size == 0:
            return
        lanes = lanes[met]
        hits = type(hits)(*(arena.take(a, met) for a in hits))
        o, d = arena.take(o, met), arena.take(d, met)
        surface = probe.interact(hits, o, d, arena)
        yield lanes, hits, surface
        tmax = np.maximum(arena.take(tmax, met) - hits.t, np.float32(0))
        o = spawn(surface.p, surface.offset, surface.ng, d, arena)


# -- ambient occlusion -------------------------------------------------------------------------------------------------


def _ambient_occlusion(context, inputs, properties):
    open_ = _openness(context, inputs, properties)
    return {"color": inputs["color"] * open_, "ao": open_}


def _openness(context, inputs, properties):
    """Share (N,) of the rays about the normal that meet nothing within the distance."""
    arena, probe = context.arena, _probe_of(context)
    samples = int(properties.get("samples", _SAMPLES))
    distance = np.broadcast_to(inputs["distance"], (context.count,))
    lanes = np.flatnonzero(distance > 0)
    if probe is None or samples < 1 or lanes.size == 0:
        return np.ones(1, np.float32)
    out = arena.full(context.count, 1.0)
    with arena.frame():
        part = context if lanes.size == context.count else context.at(lanes)
        s, tmax = part.surface, np.ascontiguousarray(distance[lanes])
        n = _given_normal(part, {"normal": inputs["normal"][:, lanes]} if _varies(inputs, "normal") else inputs)
        if properties.get("inside"):
            n = np.negative(n, out=arena.empty(n.shape))
        axes, shifts = vecmath.frame(n, arena), _shifts(part)
        blocked, u = arena.zeros(lanes.size), arena.empty((2, lanes.size))
        for number in range(samples):
            with arena.frame():
                d = _about(n, axes, *_point(shifts, number, u), arena)
                o = spawn(s.p, s.offset, s.ng, d, arena)
                if properties.get("only_local"):
                    met = _meets_itself(probe, part, o, d, tmax)
                else:
                    met = probe.accel.occluded(o, d, tmax, arena)
                np.add(blocked, met, out=blocked)
        out[lanes] = 1 - blocked * np.float32(1 / samples)
    return out


def _varies(inputs, name):
    return name in inputs and inputs[name].shape[-1] > 1


def _about(n, axes, u0, u1, arena):
    """Unit vectors about `n`, their density proportional to the cosine."""
    local = arena.empty((3, u0.size))
    radius, phi = np.sqrt(u0), u1 * (2 * math.pi)
    np.multiply(radius, np.cos(phi), out=local[0])
    np.multiply(radius, np.sin(phi), out=local[1])
    np.sqrt(np.maximum(1 - u0, 0), out=local[2])
    return vecmath.to_world(local, *axes, n, arena)


def _meets_itself(probe, context, o, d, tmax):
    """Whether rays meet the object that they start from, (N,) bool."""
    arena, geometry = context.arena, context.geometry
    own, met = geometry.object[context.surface.prim], np.zeros(tmax.size, bool)
    for lanes, hits, _ in _following(probe, o, d, tmax, arena):
        met[lanes] |= geometry.object[hits.prim] == own[lanes]
    return met


# -- bevel -------------------------------------------------------------------------------------------------------------


def _bevel(context, inputs, properties):
    """The mean normal of the object about the point, for the camera's rays and those of mirrors and clear glass."""
    ns, probe = spaces.shading_normal(context), _probe_of(context)
    normal, samples = inputs.get("normal", ns), int(properties.get("samples", _SAMPLES))
    if probe is None or samples < 1:
        return {"normal": normal}
    radius = np.broadcast_to(inputs["radius"], (context.count,))
    seen = np.logical_or(context.ray.camera, context.ray.singular)
    lanes = np.flatnonzero((radius > 0) & seen & (context.surface.prim < context.geometry.triangle_count))
    if lanes.size == 0:
        return {"normal": normal}
    out = np.array(np.broadcast_to(normal, (3, context.count)), np.float32)
    with context.arena.frame():
        mean = _mean_normal(probe, context.at(lanes), np.ascontiguousarray(radius[lanes]), samples)
        turned = out[:, lanes] + mean - ns[:, lanes]
        out[:, lanes] = normalize(turned, context.arena)
    return {"normal": out}


def _mean_normal(probe, context, radius, samples):
    """Mean of the normals of the own object within `radius`, (3, N) unit, turned to the viewer."""
    s, arena, geometry = context.surface, context.arena, context.geometry
    total, own, shifts = np.zeros((3, radius.size), np.float32), geometry.object[s.prim], _shifts(context)
    outward = s.ng * np.where(s.front, np.float32(1), np.float32(-1))
    axes = (outward, *vecmath.frame(outward, arena))
    u = arena.empty((2, radius.size))
    for number in range(samples):
        with arena.frame():
            ray = _dropped(s.p, axes, radius, *_point(shifts, number, u), arena)
            counted = np.zeros(radius.size, np.int8)
            for lanes, hits, surface in _following(probe, ray.o, ray.d, ray.tmax, arena):
                mine = (geometry.object[hits.prim] == own[lanes]) & (counted[lanes] < _MOST_HITS)
                counted[lanes] += mine
                weight = _weight(axes, radius, ray, s.p, lanes, surface, arena)
                front = np.where(surface.front, np.float32(1), np.float32(-1))
                total[:, lanes] += surface.ns * (front * weight * mine)
    length = np.sqrt(dot(total, total, arena))
    turned = np.where(s.front, np.float32(1), np.float32(-1)) / np.maximum(length, np.float32(1e-20))
    return np.where(length > 0, total * turned, s.ns)


class _Rays(NamedTuple):
    """Rays dropped on discs: origin, direction, length; `along`, number of the axis; `r`, distance from the centre."""

    o: np.ndarray
    d: np.ndarray
    tmax: np.ndarray
    along: np.ndarray
    r: np.ndarray


def _dropped(center, axes, radius, u0, u1, arena):
    """Rays through points of the ball of `radius`, along one of the axes, denser near its centre."""
    along = (u0 >= 0.5).astype(np.int8) + (u0 >= 0.75)
    phi = (u0 - np.take(np.float32([0, 0.5, 0.75]), along)) * np.take(np.float32([2, 4, 4]), along) * (2 * math.pi)
    r = np.interp(u1, _WITHIN, _RADII).astype(np.float32) * radius
    height = np.sqrt(np.maximum(radius * radius - r * r, 0))
    down, x, y = (np.choose(along, [axes[k] for k in order]) for order in ((0, 1, 2), (1, 0, 1), (2, 2, 0)))
    start = center + down * height + x * (r * np.cos(phi)) + y * (r * np.sin(phi))
    return _Rays(start, np.negative(down, out=arena.empty(down.shape)), 2 * height, along, r)


def _weight(axes, radius, ray, center, lanes, surface, arena):
    """Weight (n,) of hits: falloff by their true distance over density, by the power heuristic of the three axes."""
    pdfs = [share * np.abs(dot(axis[:, lanes], surface.ng, arena)) for axis, share in zip(axes, _SHARES, strict=True)]
    weight = np.choose(ray.along[lanes], pdfs) / np.maximum(sum(p * p for p in pdfs), np.float32(1e-12))
    away = surface.p - center[:, lanes]
    reach = radius[lanes]
    true = np.maximum(1 - np.sqrt(dot(away, away, arena)) / reach, 0)
    drawn = np.maximum(1 - ray.r[lanes] / reach, np.float32(1e-4))
    return weight * (true / drawn) ** 3


OPERATIONS = {
    "bevel": Operation(_bevel, {"radius": 0.05, "normal": None}, foldable=False),
    "ambient_occlusion": Operation(
        _ambient_occlusion, {"color": (1.0, 1.0, 1.0), "distance": 1.0, "normal": None}, foldable=False
    ),
}
