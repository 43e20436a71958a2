# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader AOVs: values that materials and the world tell by name, as pictures.

A surface that is less opaque than the threshold adds its value and lets the rays on to what stands behind, by the share
that it lets through. In Cycles paths go on by a chance that the colour of the surface takes part in; there 0.74 instead
of 0.7 of a grey one. Source: Cycles, `kernel/svm/aov.h`, for which surfaces count. The world tells where the camera
sees it: nothing on a transparent film, nor where it is hidden from the camera; measured in Cycles 5.0.
"""

from __future__ import annotations

import numpy as np

from ..compile.code import Code, Table
from ..compile.graph import Builder, post_order
from ..compile.world import over_directions
from ..interaction import spawn
from ..nodes.base import CAMERA_RAY, Context
from ..scene import Link
from ..settings import AOV_COLOR, AOV_VALUE
from ..visibility import Rays
from .transparency import straight_weight
from .wavefront import gather, surface_context


def is_aov(name):
    """Whether the picture `name` is an AOV."""
    return name.startswith((AOV_COLOR, AOV_VALUE))


def channels(name):
    """Channels of an AOV."""
    return 4 if name.startswith(AOV_COLOR) else 1


class ShaderValues:
    """The AOVs `names` of all materials of a scene, and of its world.

    Parameters
    ----------
    scene : CompiledScene
    names : iterable of str
    transparent_film : bool
        Whether the camera does not see the world.
    """

    def __init__(self, scene, names, transparent_film=False):
        self._scene = scene
        self._codes, self._world = {}, None
        for number, material in enumerate(scene.geometry.materials):
            told = _told(material, names)
            if told:
                self._codes[number] = _compiled(material, told, scene.diagnostics)
        world = scene.described.world
        told = _told(world, names) if Rays.CAMERA in world.visibility.rays and not transparent_film else None
        if told:
            self._world = _compiled(over_directions(world), told, scene.diagnostics, "world")

    def add(self, hits, o, d, tmax, threshold, transparent_depth, sums, accel, worker):
        """Add what the camera rays `o`, `d`, `tmax` see first, which is `hits`, to the pictures `sums` by name."""
        if not self._codes and self._world is None:
            return
        scene, arena = self._scene, worker.scratch
        miss = np.flatnonzero(hits.prim < 0)
        if worker.unseen is not None:
            miss = np.setdiff1d(miss, worker.unseen)
        self._add_world(d[:, miss], miss, arena.full(miss.size, 1.0), sums, arena)
        lane = np.flatnonzero(hits.prim >= 0)
        hits, o, d = gather(hits, lane, arena), arena.take(o, lane), arena.take(d, lane)
        tmax, share = None if tmax is None else arena.take(tmax, lane), arena.full(lane.size, 1.0)
        for _ in range(transparent_depth + 1):
            surface = scene.interact(hits, o, d, arena)
            self._add_surfaces(surface, lane, share, sums, arena)
            through = straight_weight(scene, surface, arena, CAMERA_RAY).mean(axis=0)
            on = np.flatnonzero(1 - through < threshold)
            if on.size == 0:
                return
            lane, share, d, hits = lane[on], share[on] * through[on], d[:, on], gather(hits, on, arena)
            o = spawn(surface.p[:, on], surface.offset[on], surface.ng[:, on], d, arena)
            tmax = None if tmax is None else tmax[on] - hits.t
            hits = accel.intersect(o, d, tmax, arena, clock=worker.clock)
            met, miss = np.flatnonzero(hits.prim >= 0), np.flatnonzero(hits.prim < 0)
            self._add_world(d[:, miss], lane[miss], share[miss], sums, arena)
            hits, lane, share, o, d = gather(hits, met, arena), lane[met], share[met], o[:, met], d[:, met]
            tmax = None if tmax is None else tmax[met]

    def _add_surfaces(self, surface, lane, share, sums, arena):
        material = arena.take(self._scene.geometry.material, surface.prim)
        for number, (code, table) in self._codes.items():
            own = np.flatnonzero(material == number)
            if own.size == 0:
                continue
            context = surface_context(gather(surface, own, arena), self._scene.geometry, arena)
            _add_values(code, table, context, lane[own], share[own], sums, arena)

    def _add_world(self, d, lane, share, sums, arena):
        if self._world is None or lane.size == 0:
            return
        context = Context(arena, lane.size, direction=d, ray=CAMERA_RAY, view=self._scene.geometry.view)
        _add_values(*self._world, context, lane, share, sums, arena)


def _add_values(code, table, context, lane, share, sums, arena):
    constants = table.over(arena.zeros(lane.size, np.int32), arena)
    for name, value in code.run(context, constants).items():
        picture = sums[name]
        rows = min(len(picture), 3)
        picture[:rows, lane] += value * share
        picture[rows:, lane] += share


def _told(material, names):
    """What a material or the world tells of the AOVs `names`, by name."""
    told = {}
    for name, color, value in getattr(material, "aovs", ()):
        told |= {AOV_COLOR + name: color, AOV_VALUE + name: value}
    return {name: told[name] for name in names if name in told}


def _compiled(material, told, diagnostics, subject="material"):
    """(Code, Table) of the values `told` by name."""
    builder = Builder(material, diagnostics, subject)
    for value in told.values():
        for index in post_order(material.nodes, value.node) if isinstance(value, Link) else ():
            builder.node_outputs(index)  # from the leaves, so that no call nests as deep as the graph
    defaults = {name: (0.0, 0.0, 0.0) if name.startswith(AOV_COLOR) else 0.0 for name in told}
    results = {name: builder.value(value, defaults[name]) for name, value in told.items()}
    code = Code(builder, results, {name: min(channels(name), 3) for name in told})
    return code, Table([code.row])
