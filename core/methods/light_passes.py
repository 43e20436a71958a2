# SPDX-License-Identifier: GPL-3.0-or-later
"""Path tracing that also sums its light by the way it came: Cycles' light passes.

A path belongs to what scattered it first, diffuse, glossy or transmission, straight passages not counted: where several
lobes could have, by their shares of the mixture's value. Light is *direct* that was sampled at the first hit or met by
the ray scattered there, and *indirect* beyond. So with the colours of the surfaces seen

    picture = Σ colour · (direct + indirect) + emission + environment,

sample by sample. Source: Blender manual, "Passes"; Cycles, `kernel/film/light_passes.h`, for what belongs where.

The picture itself is summed by the very code of `PathTrace`. Beside its rows, a chunk's radiance gets rows of the
passes asked for, and at the end four that tell how each lane's light is to be split: the diffuse share of three
channels, and 1 where the rest was transmitted.
"""

from __future__ import annotations

import numpy as np

from ..bsdf.base import Lobe
from ..bsdf.split import SplitMixture, share_of
from ..vecmath import dot
from .met import Met
from .occlusion import add_occlusion

KINDS = ("diffuse", "glossy", "transmission")
LIGHT = tuple(f"{kind}_{part}" for kind in KINDS for part in ("direct", "indirect"))
COLORS = tuple(f"{kind}_color" for kind in KINDS)
SEEN = ("emission", "environment")
OCCLUSION = "ambient_occlusion"

_SHARES = 4  # rows: the diffuse share by channel, and whether the rest was transmitted


def summed(settings):
    """Names of the pictures that are summed beside the picture, three channels each, in the order of their rows.

    Colours, and what is seen directly, are among them where some light is: only of the same samples they make up the
    picture with it. Otherwise `core.methods.guides` makes them, and nothing is summed.
    """
    names = settings.guides.names
    if settings.method != "pathtrace" or names.isdisjoint((*LIGHT, OCCLUSION)):
        return ()
    divisors = {_color_of(name) for name in names.intersection(LIGHT)}
    return tuple(name for name in (*LIGHT, *COLORS, *SEEN, OCCLUSION) if name in names | divisors)


def light_pictures(film, settings):
    """The pictures that `settings.guides` names of those that `film` has summed.

    Returns
    -------
    dict of str to (3, H·W) float32
        By name, row 0 at the bottom. Light is divided by the colour that sent it on.
    """
    rows = summed(settings)

    def mean(name):
        return film.extra(3 * rows.index(name), 3 * rows.index(name) + 3)

    wanted = [name for name in rows if name in settings.guides.names]
    return {name: divided(mean(name), mean(_color_of(name))) if name in LIGHT else mean(name) for name in wanted}


def divided(light, color):
    """`light` over `color`, (3, N); channels without colour take the mean of the others. Source: Cycles."""
    has = color != 0
    with np.errstate(over="ignore"):  # a colour next to nothing
        out = np.divide(light, color, out=np.zeros_like(light), where=has)
    out[~np.isfinite(out)] = 0
    count = has.sum(axis=0)
    grey = out.sum(axis=0) / np.maximum(count, 1).astype(np.float32)
    return np.where(has, out, grey)


def _color_of(name):
    return name.split("_")[0] + "_color"


class LightPasses:
    """What path tracing does more where such passes are asked for; comes before the method among the bases."""

    def __init__(self, compiled, settings):
        super().__init__(compiled, settings)
        names = summed(settings)
        self._first = self.channels  # row of the first pass
        self.extra = 3 * len(names)
        self.channels += self.extra + _SHARES
        self._row = {name: self._first + 3 * k for k, name in enumerate(names)}
        programs = compiled.materials.programs
        self._mixtures = {id(p.mixture): SplitMixture(p.mixture) for p in programs}
        flags = [lobe.flags for p in programs for lobe in p.mixture.lobes]
        self._transmits = any(Lobe.TRANSMISSION in f and Lobe.DIFFUSE not in f for f in flags)
        self._all_diffuse = all(Lobe.DIFFUSE in f for f in flags)
        self._looks = OCCLUSION in self._row or not self._row.keys().isdisjoint(COLORS)

    def radiance(self, chunk, worker):
        """As of `Wavefront`, with the rows of the passes."""
        rows = super().radiance(chunk, worker)
        worker.rows = None
        if rows is None:
            return None
        passes = rows[self._first : self._first + self.extra]
        if worker.unseen is not None:
            passes[:, worker.unseen] = 0
        passes[~np.isfinite(passes)] = 0  # what the picture leaves out is the film's to count
        return rows[: self._first + self.extra]

    # -- what is seen directly -----------------------------------------------------------------------------------------

    def _look(self, paths, hits, samples, radiance, worker):
        """Colours of the surfaces that the camera sees, and how free they are."""
        wanted, arena = not self._row.keys().isdisjoint(COLORS), worker.scratch
        with arena.frame():
            met = Met(self.scene, hits, paths.o, paths.d, arena)
            beta = 1.0 if paths.beta is None else arena.take(paths.beta, met.lane)
            for name, color in zip(COLORS, met.colors() if wanted else (), strict=False):
                if name in self._row:
                    self._rows(radiance, name)[:, met.lane] += color * beta
            if OCCLUSION in self._row and met.lane.size:
                add_occlusion(self, met, paths, samples, beta, self._rows(radiance, OCCLUSION), worker)

    def _add_constant_environment(self, paths, hits, depth, radiance, worker):
        self._add_background(super()._add_constant_environment, paths, hits, depth, radiance, worker)

    def _add_environment_map(self, paths, hits, depth, radiance, worker):
        self._add_background(super()._add_environment_map, paths, hits, depth, radiance, worker)

    def _add_background(self, add, paths, hits, depth, radiance, worker):
        """Let `add` do its work; what the camera sees of it is no emission but environment."""
        if depth > 0 or "environment" not in self._row:
            add(paths, hits, depth, radiance, worker)
            return
        environment = self._rows(radiance, "environment")
        if self._sees_film:  # shown by the pass alone
            arena = worker.scratch
            missed = np.flatnonzero(hits.prim < 0)
            light = self.scene.lights.environment.eval(arena.take(paths.d, missed), arena)
            environment[:, missed] += light if paths.beta is None else light * arena.take(paths.beta, missed)
            return
        before = radiance[:3].copy()
        seen = self._rows(radiance, "emission").copy() if "emission" in self._row else None
        add(paths, hits, depth, radiance, worker)
        environment += radiance[:3] - before
        if seen is not None:
            self._rows(radiance, "emission")[:] = seen

    # -- what is scattered ---------------------------------------------------------------------------------------------

    def _mixture(self, program, ray):
        return self._mixtures[id(program.mixture)] if ray.camera else program.mixture

    def _scatter(self, paths, hits, depth, samples, radiance, worker):
        worker.rows = radiance
        if depth == 0 and self._looks:
            self._look(paths, hits, samples, radiance, worker)
        return super()._scatter(paths, hits, depth, samples, radiance, worker)

    def _add_direct(self, paths, surface, light, direct, depth, radiance, worker):
        if depth == 0:
            arena = worker.scratch
            with arena.frame():
                share = share_of(direct[1], direct[0], out=arena.empty(direct[1].shape))
                self._split(worker, paths, share, surface, light.wi, arena)
            direct = direct[0]
        super()._add_direct(paths, surface, light, direct, depth, radiance, worker)

    def _go_on(self, paths, surface, scattered, u, depth, worker):
        if depth == 0:
            self._split(worker, paths, scattered.diffuse, surface, scattered.wi, worker.scratch)
        return super()._go_on(paths, surface, scattered, u, depth, worker)

    def _split(self, worker, paths, share, surface, wi, arena):
        """Note how the light that the paths find in the directions `wi` is to be split."""
        lanes = slice(None) if paths.lane is None else paths.lane
        rows = worker.rows[-_SHARES:]
        if not self._all_diffuse:
            for row, values in zip(rows, share, strict=False):
                row[lanes] = values
        if self._transmits:
            rows[3, lanes] = np.less(dot(wi, surface.ng, arena), 0.0)

    # -- film ----------------------------------------------------------------------------------------------------------

    def _rows(self, radiance, name):
        return radiance[self._row[name] : self._row[name] + 3]

    def _add_plain(self, radiance, lanes, light, bounces):
        super()._add_plain(radiance, lanes, light, bounces)
        if bounces < 0:
            self._add_to("emission", radiance, lanes, light)
            return
        part = "indirect" if bounces else "direct"
        if self._all_diffuse:
            self._add_to(f"diffuse_{part}", radiance, lanes, light)
            return
        diffuse = light * radiance[-_SHARES : -_SHARES + 3, lanes]
        self._add_to(f"diffuse_{part}", radiance, lanes, diffuse)
        rest = light - diffuse
        if self._transmits:
            through = radiance[-1, lanes]
            self._add_to(f"transmission_{part}", radiance, lanes, rest * through)
            rest *= 1 - through
        self._add_to(f"glossy_{part}", radiance, lanes, rest)

    def _add_to(self, name, radiance, lanes, light):
        if name in self._row:
            for row, values in zip(self._rows(radiance, name), light, strict=True):
                row[lanes] += values
