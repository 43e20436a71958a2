# SPDX-License-Identifier: GPL-3.0-or-later
"""Ambient occlusion: how free the surfaces that the camera sees stand, as a pass.

The share of a hemisphere, weighted by the cosine, in which nothing stands within a distance. It knows no colour; the
normal is that of the diffuse lobes. Source: Cycles, `kernel/integrator/shade_surface.h`, for what it counts.
"""

from __future__ import annotations

from ..bsdf.base import Lobe
from ..compile.features import Feature
from ..interaction import spawn
from ..sampling.sampler import Draw
from ..sampling.warp import square_to_cosine_hemisphere
from ..vecmath import frame, to_world


def add_occlusion(method, met, paths, samples, beta, out, worker):
    """Add to `out` (3, N) how free the lanes in `met` (n of them) stand, by one ray each.

    Parameters
    ----------
    method : Wavefront
    met : Met
    paths : Paths
        From the camera.
    samples : tuple of int
        In the chunk.
    beta : (3, n) float32 or float
        What the lanes in `met` have left.
    """
    arena, surface = worker.scratch, met.surface
    keys = arena.take(paths.keys, met.lane)
    slots = None if paths.slots is None else arena.take(paths.slots, met.lane)
    u0, u1 = method.scene.sampler.draw(Draw.BSDF.at(0), (0, 1), keys, slots, samples, arena)
    n = met.normal(Lobe.DIFFUSE)
    d = to_world(square_to_cosine_hemisphere(u0, u1, arena), *frame(n, arena), n, arena)
    o = spawn(surface.p, surface.offset, surface.ng, d, arena)
    reach = arena.full(met.lane.size, method.settings.guides.ambient_distance)
    free = method.visibility(o, d, reach, worker)
    if Feature.TRANSPARENCY in method.features:
        beta = beta * met.alpha()
    out[:, met.lane] += free * beta
