# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces that cut a hole into the picture: the Holdout shader node."""

from __future__ import annotations

import numpy as np

from .wavefront import gather, surface_context


def has_holdouts(scene):
    """Whether some material cuts holes."""
    return any(program.holdout is not None for program in scene.materials.programs)


def holes(scene, hits, o, d, ray, arena):
    """Lanes whose surface cuts a hole into what the rays `ray` see, and by what share of their alpha, (n,)."""
    met = np.flatnonzero(hits.prim >= 0)
    met = met[_cuts(scene)[scene.geometry.material[hits.prim[met]]]]
    if met.size == 0:
        return met, arena.zeros(0)
    surface = scene.interact(gather(hits, met, arena), arena.take(o, met), arena.take(d, met), arena)
    material = arena.take(scene.geometry.material, surface.prim)
    share, ray = arena.zeros(met.size), ray.at(met)
    for number, lanes in scene.materials.groups(material, arena):
        code = scene.materials.programs[number].holdout
        lanes = slice(None) if lanes is None else lanes
        part = surface if isinstance(lanes, slice) else gather(surface, lanes, arena)
        constants = scene.materials.constants(number, "holdout", material[lanes], arena)
        value = code.run(surface_context(part, scene.geometry, arena, ray.at(lanes)), constants)["H"]
        share[lanes] = value.mean(axis=0) if value.ndim > 1 else value  # of a coloured mix, as alpha has one channel
    return met, np.clip(share, 0, 1, out=share)


def _cuts(scene):
    """Of each material: whether it cuts holes."""
    programs = scene.materials.programs
    return np.array([programs[number].holdout is not None for number in scene.materials.program_of])
