# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps that rays cross.

Lamps with an extent (area lights, spheres, disks, sun disks) are no geometry: they do not stop rays and, as in
Blender, the camera does not see them; rays scattered at a surface do. Call this for scattered rays only.
"""

from __future__ import annotations

import numpy as np

from ..sampling.mis import weight


class LampHits:
    """What scattered rays see of the lamps.

    Parameters
    ----------
    sampler : LightSampler
        Its extended kinds are the lamps.

    Attributes
    ----------
    count : int
        Number of lamps; with 0 there is nothing to call.
    """

    def __init__(self, sampler):
        self._lamps = []
        first = 0
        for kind in sampler.kinds:
            if kind.extended:
                self._lamps += [(kind, row, float(sampler.pmf[first + row])) for row in range(kind.count)]
            first += kind.count
        self.count = len(self._lamps)

    def crossings(self, o, d, tmax, arena, passed=None):
        """Every lamp that rays cross.

        Parameters
        ----------
        o, d : (3, N) float32
            Origins and unit directions.
        tmax : (N,) float32
            Distance to the surface that is hit, inf where there is none.
        passed : (N,) float32, optional
            Distance that a ray came before `o`, straight through transparent surfaces: its light is sought, and was
            sampled, from where it started. None is 0.

        Yields
        ------
        lanes : (n,) int
            Rays that cross one of the lamps between `o` and `tmax`, each once.
        radiance : (3, n) or (3, 1)
            Radiance that arrives along them.
        pdf : (n,)
            Density with which the light sampler would have drawn the direction, choice included.

        Notes
        -----
        The arrays live until the next step of the iteration.
        """
        with arena.frame():
            tmin = 0.0
            if passed is not None:
                tmin, tmax = passed, np.add(tmax, passed, out=arena.empty(passed.shape))
                o = np.subtract(o, np.multiply(d, passed, out=arena.empty(d.shape)), out=arena.empty(d.shape))
            for kind, row, pmf in self._lamps:
                with arena.frame():
                    hits = kind.intersect(row, o, d, tmin, tmax, arena)
                    if hits.lanes.size:
                        np.multiply(hits.pdf, pmf, out=hits.pdf)
                        yield hits

    def radiance(self, o, d, tmax, pdf_bsdf, arena, passed=None):
        """Light of all lamps along rays drawn with density `pdf_bsdf` (N,), MIS weight included, (3, N)."""
        total = arena.zeros(d.shape)
        for lanes, emitted, pdf_light in self.crossings(o, d, tmax, arena, passed):
            share = weight(arena.take(pdf_bsdf, lanes), pdf_light, arena)
            for i in range(3):
                total[i][lanes] += emitted[i] * share
        return total
