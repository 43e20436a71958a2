# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps that rays cross.

Lamps with an extent (area lights, spheres, disks, sun disks) are no geometry: they do not stop rays and, as in
Blender, the camera does not see them; rays scattered at a surface do. Call this for scattered rays only.
"""

from __future__ import annotations

import numpy as np

from ..sampling.mis import weight
from .boxes import LampBoxes

_FEW = 8  # lamps that are tried one by one in less time than Embree takes to sort them out


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
        self._sampler = sampler
        self._lamps, self._boxed = [], []
        first = 0
        for kind in sampler.kinds:
            if kind.extended:
                lamps = [(kind, row, first + row) for row in range(kind.count)]
                (self._lamps if kind.at_infinity else self._boxed).extend(lamps)
            first += kind.count
        self.count = len(self._lamps) + len(self._boxed)
        if len(self._boxed) > _FEW:
            self._box_up()
        else:
            self._lamps += self._boxed
            self._boxes = None

    def _box_up(self):
        """Build the boxes, and tables from a lamp's number among them to its kind, row and number as a light."""
        kinds = list(dict.fromkeys(kind for kind, _, _ in self._boxed))
        low, high = zip(*(kind.box() for kind in kinds), strict=True)
        self._boxes = LampBoxes(np.concatenate(low, axis=1), np.concatenate(high, axis=1))
        self._boxed_kinds = kinds
        self._kind = np.array([kinds.index(kind) for kind, _, _ in self._boxed])
        self._row = np.array([row for _, row, _ in self._boxed])
        self._light = np.array([light for _, _, light in self._boxed])

    def crossings(self, o, d, tmax, arena, passed=None, asking=None):
        """Every lamp that rays cross, without its number: what `numbered_crossings` yields second.

        Yields
        ------
        LightHits
        """
        for _, hits in self.numbered_crossings(o, d, tmax, arena, passed, asking):
            yield hits

    def numbered_crossings(self, o, d, tmax, arena, passed=None, asking=None):
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
        asking : Ray, optional
            What the shaders of lights are told of the rays; None where none asks.

        Yields
        ------
        light : int or (n,) int
            Number of the lamp as a light.
        hits : LightHits
            Rays that cross one of the lamps between `o` and `tmax`, each once; `pdf` includes the choice.

        Notes
        -----
        The arrays live until the next step of the iteration.
        """
        with arena.frame():
            tmin = 0.0
            if passed is not None:
                tmin, tmax = passed, np.add(tmax, passed, out=arena.empty(passed.shape))
                o = np.subtract(o, np.multiply(d, passed, out=arena.empty(d.shape)), out=arena.empty(d.shape))
            for kind, row, light in self._lamps:
                with arena.frame():
                    hits = _crossed(kind, row, o, d, tmin, tmax, arena, asking)
                    if hits.lanes.size:
                        pmf = self._sampler.pmf_at(light, arena.take(o, hits.lanes), arena)
                        np.multiply(hits.pdf, pmf, out=hits.pdf)
                        yield light, hits
            if self._boxes is not None:
                for lanes, lamp in self._boxes.candidates(o, d, tmin, tmax, arena):
                    yield from self._of_candidates(lanes, lamp, o, d, tmin, tmax, arena, asking)

    def _of_candidates(self, lanes, lamp, o, d, tmin, tmax, arena, asking):
        """What the rays `lanes` (n,) cross of the lamps `lamp` (n,), one each."""
        kinds = arena.take(self._kind, lamp)
        for number, kind in enumerate(self._boxed_kinds):
            with arena.frame():
                own = np.flatnonzero(kinds == number)
                if own.size == 0:
                    continue
                ray, which = lanes[own], lamp[own]
                rays = (arena.take(a, ray) if isinstance(a, np.ndarray) else a for a in (o, d, tmin, tmax))
                start, *rest = rays
                told = None if asking is None else asking.at(ray)
                hits = _crossed(kind, arena.take(self._row, which), start, *rest, arena, told)
                if hits.lanes.size:
                    light = arena.take(self._light, which[hits.lanes])
                    pmf = self._sampler.pmf_at(light, arena.take(start, hits.lanes), arena)
                    np.multiply(hits.pdf, pmf, out=hits.pdf)
                    yield light, hits._replace(lanes=ray[hits.lanes])

    def radiance(self, o, d, tmax, pdf_bsdf, arena, passed=None):
        """Light of all lamps along rays drawn with density `pdf_bsdf` (N,), MIS weight included, (3, N)."""
        total = arena.zeros(d.shape)
        for lanes, emitted, pdf_light in self.crossings(o, d, tmax, arena, passed):
            share = weight(arena.take(pdf_bsdf, lanes), pdf_light, arena)
            for i in range(3):
                total[i][lanes] += emitted[i] * share
        return total


def _crossed(kind, rows, o, d, tmin, tmax, arena, asking):
    """Rays that cross lamps `rows` of `kind`."""
    if asking is not None and getattr(kind, "is_shaded", False):
        return kind.intersect(rows, o, d, tmin, tmax, arena, asking)
    return kind.intersect(rows, o, d, tmin, tmax, arena)
