# SPDX-License-Identifier: GPL-3.0-or-later
"""Shadow catchers: objects that stand for what is behind the picture, of which only the shade is seen.

Where a path that still sees the film meets a catcher it is split. It goes on as if the catcher were an ordinary object,
into the picture C; and once more with the same random numbers in a scene where catchers, their lights and the world are
alone, into L. M is what the path had found before, and for all other paths what they find. Of the means over a pixel

    light left = mean over the channels of (C - M) / L, at most 1

a transparent film shows M, with the alpha of what is no catcher and, of the share of the catchers, 1 - light left; an
opaque one M + light left · the world behind the catchers. Catchers that are met later are ordinary objects, and so are
those that hold out what is behind. What half transparent catchers let pass to a transparent film counts twice, in C and
in L, as in Cycles, which takes both for what shade does not cover. Source: Blender manual, "Shadow Catcher"; Cycles,
`kernel/integrator/shadow_catcher.h` and `kernel/film/read.h`, whose approximation for Combined this is. There the world
is that of the whole pixel, so that outlines of objects before catchers come out darker on an opaque film.

The error is estimated, and samples are distributed, by C, as there.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import groupby

import numpy as np

from ..compile.features import Feature
from .paths import together
from .wavefront import gather


@dataclass
class Caught:
    """Where the paths of a chunk were split.

    done (lanes,) bool; parts: (depth, `Paths`, their `Hits`, what `radiance` (channels, n) held of them) each,
        where the film is seen without the alpha that they carried.
    """

    done: np.ndarray
    parts: list = field(default_factory=list)


class Catchers:
    """What path tracing does more in scenes with `Feature.CATCHERS`; comes before the method among the bases.

    Attributes
    ----------
    alone : VisibilityPathTrace
        The method of the scene in which catchers are alone, None where there are none. `method_of` sets it.
    """

    waves = 1  # paths are split by their lanes in the chunk
    alone = None

    def __init__(self, compiled, settings):
        super().__init__(compiled, settings)
        first = self.channels
        # Rows: L, with less than nothing for what passes straight to the film; M; its alpha or the world behind.
        matte, last = (4, 1) if self._sees_film else (3, 3)
        self._alone_rows, self._matte_rows = slice(first, first + 3), slice(first + matte, first + matte + 3)
        self.behind = matte + 3 + last
        self._last_rows = slice(first + matte + 3, first + self.behind)
        self.channels += self.behind

    def compose(self, means):
        """The picture, (3 or 4, P), of the means (channels, P) of its channels and those behind."""
        matte, alone, last = means[self._matte_rows], means[self._alone_rows], means[self._last_rows]
        left = np.ones_like(alone)
        with np.errstate(over="ignore"):  # light next to nothing
            np.divide(means[:3] - matte, alone, out=left, where=alone != 0)
        left = left.mean(axis=0).clip(0, 1)
        if not self._sees_film:
            return matte + last * left
        covered = (means[3] + means[self._alone_rows.stop]).clip(0, 1)
        alpha = last + (1 - last) * covered * (1 - left)
        return np.concatenate((matte, alpha.clip(0, 1)))

    def radiance(self, chunk, worker):
        """As of `Wavefront`, with the rows behind the picture."""
        rows = super().radiance(chunk, worker)
        if rows is not None and worker.unseen is not None:
            rows[self._alone_rows.start : self._matte_rows.stop, worker.unseen] = 0
            rows[self._last_rows, worker.unseen] = float(self._sees_film)
        return rows

    def trace(self, chunk, worker):
        """Radiance of a chunk, (channels, lanes); None when stopped."""
        radiance = super().trace(chunk, worker)
        caught, worker.caught = worker.caught, None
        if radiance is None:
            return None
        for depth, parts in groupby(sorted(caught.parts, key=_depth), key=_depth):
            parts = list(parts)
            paths, hits = together([part[1] for part in parts]), together([part[2] for part in parts])
            if not self._trace_alone(paths, hits, depth, chunk.samples, radiance, worker):
                return None
        # What is seen without catchers is written last: over the alpha of paths among them, which is nobody's.
        radiance[self._matte_rows] = radiance[:3]
        if self._sees_film:
            radiance[self._last_rows] = radiance[3]
        for _, paths, _, before in caught.parts:
            self._take_back(paths, before, radiance)
        if self.settings.exposure != 1:
            radiance[self._alone_rows] *= self.settings.exposure
            radiance[self._matte_rows] *= self.settings.exposure
            if not self._sees_film:
                radiance[self._last_rows] *= self.settings.exposure
        return radiance

    def _start(self, chunk, worker):
        worker.caught = Caught(worker.output.zeros(chunk.lanes, bool))
        return super()._start(chunk, worker)

    def _cross(self, paths, part, hits, depth, radiance, worker):
        super()._cross(paths, part, hits, depth, radiance, worker)
        if depth <= self._film_depth and self.alone is not None:
            self._catch(paths, part, hits, depth, radiance, worker)

    def _catch(self, paths, part, hits, depth, radiance, worker):
        """Note the paths `part` (None: all) that meet a catcher at `hits` and see the film, each once."""
        caught, arena = worker.caught, worker.output
        met = np.flatnonzero(np.take(self.scene.visibility.catcher_prim, hits.prim, mode="wrap"))
        lanes = met if part is None else part[met]
        seen = self._before_film(paths, lanes, depth)
        met, lanes = met[seen], lanes[seen]
        where = lanes if paths.lane is None else paths.lane[lanes]
        fresh = np.flatnonzero(~caught.done[where])
        if fresh.size == 0:
            return
        where = where[fresh]
        caught.done[where] = True
        own = paths.at(lanes[fresh], arena)
        own.lane = where
        before = radiance[:, where]
        if self._sees_film:  # paths change later
            before[3] -= 1.0 if own.beta is None else own.beta.mean(axis=0)
        caught.parts.append((depth, own, gather(hits, met[fresh], arena), before))

    def _trace_alone(self, paths, hits, depth, samples, radiance, worker):
        """Follow split paths from `hits` on where catchers are alone; tells whether it came to the end."""
        start = self._alone_rows.start
        found = radiance[start : start + self.alone.channels]
        if not self._sees_film and Feature.ENVIRONMENT in self.features:
            with worker.scratch.frame():
                beyond = hits._replace(prim=np.full_like(hits.prim, -1))
                self.alone._add_world(paths, beyond, depth, radiance[self._last_rows], worker)
        with worker.scratch.frame():
            paths = self.alone._meet(paths, hits, depth, samples, found, worker)
        while paths is not None and paths.keys.size:
            if worker.stop.is_set():
                return False
            depth += 1
            with worker.scratch.frame():
                paths = self.alone._bounce(paths, depth, samples, found, worker)
        return True

    def _take_back(self, paths, before, radiance):
        """Let M, its alpha and all passes have what the paths had found `before` they were split."""
        radiance[self._matte_rows, paths.lane] = before[:3]
        if self._sees_film:
            radiance[self._last_rows, paths.lane] = before[3]
        radiance[self._last_rows.stop :, paths.lane] = before[self._last_rows.stop :]


def _depth(part):
    return part[0]
