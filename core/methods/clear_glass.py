# SPDX-License-Identifier: GPL-3.0-or-later
"""A transparent film that is seen through glass.

A path that only passed straight, or was sent through surfaces that are smooth enough, sees the film where it leaves the
scene: it takes what it carries from alpha instead of bringing the world's light. What mirrors of the world in the glass
is light. Source: Blender manual, "Film"; Cycles, `kernel/closure/bsdf.h` and `kernel/integrator/path_state.h`.

As there, light of a world that is sampled at glass which is not quite smooth is added all the same.
"""

from __future__ import annotations

import numpy as np

from ..bsdf import facets
from ..bsdf.base import Lobe
from ..bsdf.mixture import MARK
from ..compile.features import sees_film_through_glass
from .trails import hide_film, sees_film, with_film

_ROUNDED = 1 + 1e-6  # glass as rough as the limit is clear
_NOTHING, _CLEAR = np.zeros(1, np.uint8), np.full(1, Lobe.CLEAR.value, np.uint8)


class ClearGlass:
    """What path tracing does more in scenes with `Feature.CLEAR_GLASS`; comes before the method among the bases."""

    def __init__(self, compiled, settings):
        super().__init__(compiled, settings)
        self._tells_rays = True
        self._widest = -1.0  # alpha of facets through which the film is seen
        if sees_film_through_glass(settings):
            self._widest = settings.transparent_roughness**2 * _ROUNDED
            self._film_depth = settings.depth
            self._last_ray_matters = True

    def _start(self, chunk, worker):
        paths = super()._start(chunk, worker)
        paths.trail = with_film(paths.trail, worker.states[0])
        return paths

    def _leaving(self, paths, hits, depth):
        lanes = super()._leaving(paths, hits, depth)
        if depth == 0 or depth > self._film_depth:
            return lanes
        return lanes[~sees_film(paths.trail[:, lanes])]

    def _before_film(self, paths, lanes, depth):
        return sees_film(paths.trail[:, lanes])

    def _kept(self, lobes, ray):
        return [self._marked(*entry) for entry in super()._kept(lobes, ray)]

    def _marked(self, lobe, color, params, n):
        """A lobe's entry whose samples tell where they are clear."""
        if Lobe.TRANSMISSION not in lobe.flags or (Lobe.DIFFUSE | Lobe.STRAIGHT) & lobe.flags:
            return lobe, color, params, n
        clear = np.less_equal(_width(lobe, params), self._widest)
        return lobe, color, params | {MARK: np.where(clear, _CLEAR, _NOTHING)}, n

    def _trail_on(self, paths, surface, scattered, lanes, arena, out):
        trail = super()._trail_on(paths, surface, scattered, lanes, arena, out)
        hide_film(trail, arena.take(scattered.flags, lanes))
        return trail


def _width(lobe, params):
    """Alpha of a lobe's facets, (1,) or (n,): 0 of clear glass, 1 of what has none."""
    if Lobe.DELTA in lobe.flags:
        return np.zeros(1, np.float32)
    if "alpha" in params and ("stretch" in params or "tangent" not in params):
        return facets.mean_alpha(params)
    return np.ones(1, np.float32)  # hair, whose alpha is another
