# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a transparent film is seen: beside all objects, and through surfaces that cut a hole into the picture."""

from __future__ import annotations

import numpy as np

from .wavefront import gather, surface_context


class SeesFilm:
    """What path tracing does to alpha; a base of it."""

    def _cut_holes(self, paths, hits, depth, radiance, worker):
        if depth > self._film_depth:
            return
        ray = paths.ray(depth, hits.t, worker.scratch)
        lanes, share = holes(self.scene, hits, paths.o, paths.d, ray, worker.scratch)
        seen = self._before_film(paths, lanes, depth)
        self._uncover(paths, lanes[seen], share[seen], radiance)

    def _clear_film(self, paths, hits, depth, radiance, worker):
        if depth > self._film_depth:
            return
        missed = np.flatnonzero(hits.prim < 0)
        self._uncover(paths, missed[self._before_film(paths, missed, depth)], 1.0, radiance)

    def _uncover(self, paths, lanes, share, radiance):
        """Take the `share` (n,) of what the paths `lanes` carry from alpha."""
        where = lanes if paths.lane is None else paths.lane[lanes]
        radiance[3, where] -= share if paths.beta is None else share * paths.beta[:, lanes].mean(axis=0)

    def _before_film(self, paths, lanes, depth):
        """Which of `lanes`, an index into them, belong to paths that see the film at a hit not beyond `_film_depth`."""
        return slice(None)


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
