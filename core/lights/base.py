# SPDX-License-Identifier: GPL-3.0-or-later
"""What all lights share. Their contract is in docs/design.md, "A light".

A *kind* of light is a table of lights of one sort, with

```
count                                      number of lights
extended                                   whether rays can cross its lights, which are no geometry
at_infinity                                whether its lights have no distance
power (count,) float64                     emitted power, W; of lights at infinity the irradiance, W/m2
bounds()                                   -> Bounds; kinds at a finite distance only
box()                                      -> corners of bounding boxes; extended kinds at a finite distance only
sample(rows, p, u0, u1, arena)             -> LightSample, given that light `rows` was chosen
intersect(rows, o, d, tmin, tmax, arena)   -> LightHits of rays that cross the light; extended kinds only
is_shaded                                  true of kinds whose light may depend on the ray that asks for it; then
                                           `sample` takes a `Ray` of core.nodes.base, or None, as a sixth argument,
                                           `intersect` as a seventh
by_ray                                     true of those that ask the ray for more than its distance
prim, density(rows, p, wi, distance, arena) of kinds that are geometry: numbers of the primitives, (count,) or
                                           (2, count), and the density (N,) of `sample`
```

`rows` is one light's number, or one for each lane, (N,). A light is crossed at a distance above `tmin`, (N,) or 0.0,
and below `tmax`, (N,); `o` is the point whose light is sought.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..vecmath import dot

_NO_LENGTH = 1e-18  # its square is still a normal float32
NEAREST_SQUARED = 1e-24  # squared distances are kept above, so that no weight overflows


class LightSample(NamedTuple):
    """A direction towards a light.

    wi (3, N) unit; distance (N,), inf for lights at infinity, 0 for lights without shadow; weight (3, N) = Le/pdf, 0
    where nothing arrives; pdf (N,) per solid angle, inf for delta lights; light (N,) the number of the light, where the
    sampler tells it.
    """

    wi: np.ndarray
    distance: np.ndarray
    weight: np.ndarray
    pdf: np.ndarray
    light: np.ndarray | None = None


class LightHits(NamedTuple):
    """Rays that cross a light.

    lanes (n,) of the rays given; radiance (3, n) or (3, 1) that arrives along them; pdf (n,) or (1,) per solid angle
    with which `sample` would have chosen the direction from the ray's origin.
    """

    lanes: np.ndarray
    radiance: np.ndarray
    pdf: np.ndarray


class Bounds(NamedTuple):
    """Where lights are and where they shine.

    center (3, count); spread (count,) mean squared distance of the light's points from there; axis (3, count) normal of
    lights that shine to one side, None where all shine all around.
    """

    center: np.ndarray
    spread: np.ndarray
    axis: np.ndarray | None = None


def rows_of(table, rows, arena):
    """Entries `rows` of `table` (C, count) or (count,): one light's as (C, 1), else one for each lane."""
    if isinstance(rows, int):
        return table[..., rows : rows + 1]
    return arena.take(table, rows)


def rows_at(rows, lanes, arena):
    """`rows` of some of the lanes."""
    return rows if isinstance(rows, int) else arena.take(rows, lanes)


def towards(p, target, arena):
    """Unit vectors from `p` to `target` (3, N) and the distance (N,); +Z where both are at the same place."""
    w, distance = arena.empty(p.shape), arena.empty(p.shape[-1])
    np.subtract(target, p, out=w)
    normalize_length(w, distance, arena)
    return w, distance


def normalize_length(w, length, arena):
    """Make `w` (3, N) unit in place and write its `length` (N,); the zero vector becomes +Z, of length 1e-18."""
    np.add(w[2], _NO_LENGTH, out=w[2])  # changes nothing that is longer than 1e-11
    dot(w, w, arena, out=length)
    np.sqrt(length, out=length)
    np.divide(w, length, out=w)
