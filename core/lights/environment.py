# SPDX-License-Identifier: GPL-3.0-or-later
"""Light from infinity all around.

A constant environment is never chosen by the light sampler: cosine or lobe sampling of the surface draws its
directions already with the best density there is, so a shadow ray towards it would only cost. Its density as a light
is therefore 0, and rays that leave the scene count it in full, which the MIS weight of density 0 does unasked.

For the same reason an environment map is sampled by how much brighter than its mean it is: scattered rays find the
rest. Source: Karlík et al., "MIS Compensation: Optimizing Sampling Techniques in Multiple Importance Sampling", ACM
TOG 38(6), 2019.
"""

from __future__ import annotations

import math

import numpy as np

from ..arena import Arena
from ..sampling.color import luminance
from ..sampling.distributions import Distribution2D
from ..sampling.warp import circle
from .base import LightSample
from .environment_suns import EnvironmentSuns

_SUN_SHARE = 0.8  # of all samples at most go to suns
_ROWS_AT_ONCE = 16  # of cells; enough directions for calls to cost little beside their work
_EVEN = 1e-3  # share of the light above the mean below which a map is as good as constant


class ConstantEnvironment:
    """The same `radiance` (3,) from every direction."""

    is_constant = True
    by_ray = False

    def __init__(self, radiance):
        self.radiance = np.asarray(radiance, np.float32).reshape(3, 1)
        self.mean = self.radiance[:, 0]
        self.is_black = not self.radiance.any()
        self._never = np.zeros(1, np.float32)

    def eval(self, d, arena, ray=None):
        """Radiance that arrives against `d` (3, N), (3, 1)."""
        return self.radiance

    def pdf(self, d, arena):
        """Solid-angle density with which the light sampler would have drawn `d`, choice included, (1,)."""
        return self._never


class EnvironmentMap:
    """Radiance that depends on the direction; a kind of light (`core.lights.base`) of one light.

    Directions are drawn from the cells of a grid of equal angles, uniformly within a cell.

    Parameters
    ----------
    radiance : callable
        ``radiance(d (3, N) unit, arena, averaged=False) -> (3, N)``; `averaged` is for cells of the grid, in which no
        detail may be missed. It also takes a `ray`; without, it tells what scattered rays see.
    shape : (rows, columns)
        Of the grid: rows from +Z to -Z, columns from -X over +Y, +X and -Y.
    suns : sequence of (axis, angle)
        Small discs of the sky that are sampled apart, as `EnvironmentSuns` takes them; `radiance` leaves them out
        where it is `averaged`.
    by_ray : bool
        Whether `radiance` depends on the kind of ray, so that some may see what others do not.

    Attributes
    ----------
    mean : (3,) float32
        Mean radiance over all directions, without suns.
    suns : EnvironmentSuns or None
    is_sampled : bool
        Whether light sampling pays: not where the map is even.
    choice : float
        Probability with which the light sampler chooses the map, set by who makes the sampler; 0 until then.
    """

    is_constant = False
    extended = False  # who leaves the scene asks `eval`
    at_infinity = True
    is_shaded = True
    count = 1

    def __init__(self, radiance, shape=(512, 1024), suns=(), by_ray=False):
        self.eval = radiance
        self.by_ray = by_ray
        found = EnvironmentSuns(radiance, suns) if suns else None
        self.suns = found if found is not None and found.power > 0.0 else None
        self.choice = 0.0
        self._rows, self._columns = shape
        # Around the nearer pole 1 - abs(cosθ) tells directions apart that cosθ does not.
        edges = np.linspace(0.0, math.pi, self._rows + 1)
        gap = 2.0 * np.sin(0.5 * np.minimum(edges, math.pi - edges)) ** 2
        solid_angle = np.abs(np.diff(np.cos(edges)))[:, None] * (2.0 * math.pi / self._columns)
        self._gap, self._gap_step = gap[:-1].astype(np.float32), np.diff(gap).astype(np.float32)
        self._side = np.where(edges[1:] <= 0.5 * math.pi + 1e-9, 1, -1).astype(np.float32)
        cells = self._cells()
        weight = solid_angle / (4.0 * math.pi)
        self.mean = (cells * weight).sum(axis=(1, 2)).astype(np.float32)
        self.is_black = not (cells.any() or self.suns or by_ray)
        brightness = np.maximum(luminance(cells), 0.0)
        average = float((brightness * weight).sum())
        surplus = np.maximum(brightness - average, 0.0) * weight
        uneven = float(surplus.sum()) > _EVEN * average
        power = math.pi * float(surplus.sum()) if uneven else 0.0
        if uneven:
            self._distribution = Distribution2D(surplus)
            self._density = (self._distribution.pmf / solid_angle).astype(np.float32).reshape(-1)
        self._sun_share = 0.0
        if self.suns is not None:
            # In the shade of the sun only the rest of the sky can be found.
            self._sun_share = min(self.suns.power / (self.suns.power + power), _SUN_SHARE) if uneven else 1.0
            power += self.suns.power
        self.is_sampled = power > 0.0
        self.power = np.array([power])  # of what is sampled

    def sample(self, rows, p, u0, u1, arena, ray=None):
        """A direction, bright ones more often."""
        n = p.shape[-1]
        wi, pdf = arena.empty((3, n)), arena.empty(n)
        if self.suns is None:
            self._draw(u0, u1, wi, pdf, arena)
        else:
            self._draw_with_suns(u0, u1, wi, pdf, arena)
        weight = arena.empty((3, n))
        with arena.frame():
            light = self.eval(wi, arena) if ray is None else self.eval(wi, arena, ray=ray)
            np.divide(light, pdf, out=weight)
        return LightSample(wi, arena.full(n, math.inf), weight, pdf)

    def _draw(self, u0, u1, wi, pdf, arena):
        """Write directions from the grid's cells and their density."""
        n = pdf.size
        with arena.frame():
            row, column, y, x = self._distribution.sample(u0, u1, arena)
            np.take(self._density, row * self._columns + column, out=pdf, mode="clip")
            # Uniform in cosθ within the row, so that the density within a cell is constant.
            gap = np.multiply(y, arena.take(self._gap_step, row), out=y)
            np.add(gap, arena.take(self._gap, row), out=gap)
            np.subtract(1.0, gap, out=wi[2])
            sine = np.multiply(np.subtract(2.0, gap, out=arena.empty(n)), gap, out=arena.empty(n))
            np.sqrt(np.maximum(sine, 0.0, out=sine), out=sine)
            np.multiply(wi[2], arena.take(self._side, row), out=wi[2])
            phi = np.add(x, column, out=arena.empty(n), casting="unsafe")
            np.multiply(phi, -2.0 * math.pi / self._columns, out=phi)
            np.add(phi, math.pi, out=phi)
            circle(phi, sine, wi[0], wi[1])

    def _draw_with_suns(self, u0, u1, wi, pdf, arena):
        """Write directions from the grid or from the discs, and the density of both together."""
        share = self._sun_share
        with arena.frame():
            if share < 1.0:
                rest = np.subtract(u0, share, out=arena.empty(u0.size))
                np.multiply(rest, 1.0 / (1.0 - share), out=rest)
                self._draw(np.clip(rest, 0.0, np.float32(1 - 2**-24), out=rest), u1, wi, pdf, arena)
            lanes = np.flatnonzero(u0 < share)
            wi[:, lanes] = self.suns.sample(arena.take(u0, lanes) / np.float32(share), arena.take(u1, lanes), arena)
            np.copyto(pdf, self._density_at(wi, arena))

    def pdf(self, d, arena):
        """Solid-angle density with which the light sampler would have drawn `d` (3, N), choice included, (N,)."""
        if not self.choice:
            return np.zeros(1, np.float32)
        pdf = self._density_at(d, arena)
        return np.multiply(pdf, self.choice, out=pdf)

    def _density_at(self, d, arena):
        """Density of `sample` at `d` (3, N), (N,)."""
        pdf = arena.zeros(d.shape[-1])
        if self._sun_share < 1.0:
            self._grid_density(d, arena, pdf)
        if self.suns is not None:
            with arena.frame():
                density = self.suns.density(d, arena)
                np.multiply(density, self._sun_share, out=density)
                np.multiply(pdf, 1.0 - self._sun_share, out=pdf)
                np.add(pdf, density, out=pdf)
        return pdf

    def _grid_density(self, d, arena, out):
        """Write the density of `_draw` at `d` to `out` (N,)."""
        n = d.shape[-1]
        with arena.frame():
            t, row, column = arena.empty(n), arena.empty(n, np.int32), arena.empty(n, np.int32)
            np.arctan2(d[1], d[0], out=t)
            np.subtract(math.pi, t, out=t)
            np.multiply(t, self._columns / (2.0 * math.pi), out=t)
            np.copyto(column, t, casting="unsafe")
            np.minimum(column, self._columns - 1, out=column)
            np.hypot(d[0], d[1], out=t)
            np.arctan2(t, d[2], out=t)
            np.multiply(t, self._rows / math.pi, out=t)
            np.copyto(row, t, casting="unsafe")
            np.minimum(row, self._rows - 1, out=row)
            np.multiply(row, self._columns, out=row)
            np.add(row, column, out=row)
            np.take(self._density, row, out=out, mode="clip")

    def _cells(self):
        """Mean radiance of each cell, (3, R, C) float64."""
        theta = (np.arange(self._rows) + 0.5) * (math.pi / self._rows)
        phi = math.pi - (np.arange(self._columns) + 0.5) * (2.0 * math.pi / self._columns)
        circle_, arena = np.stack([np.cos(phi), np.sin(phi)]), Arena()
        cells = np.zeros((3, self._rows, self._columns))
        for start in range(0, self._rows, _ROWS_AT_ONCE):
            rows = slice(start, start + _ROWS_AT_ONCE)
            with arena.frame():
                d = np.stack(
                    np.broadcast_arrays(
                        np.sin(theta[rows, None]) * circle_[0],
                        np.sin(theta[rows, None]) * circle_[1],
                        np.cos(theta[rows, None]),
                    )
                )
                seen = self.eval(d.reshape(3, -1).astype(np.float32), arena, averaged=True)
                cells[:, rows] = seen.reshape(3, -1, self._columns)
        # Linear interpolation spreads a texel over its neighbours: its mean over each of the cells around.
        cells = 0.75 * cells + 0.125 * (np.roll(cells, 1, axis=2) + np.roll(cells, -1, axis=2))
        padded = np.concatenate((cells[:, :1], cells, cells[:, -1:]), axis=1)
        return 0.75 * cells + 0.125 * (padded[:, :-2] + padded[:, 2:])
