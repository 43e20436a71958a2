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

_EVEN = 1e-3  # share of the light above the mean below which a map is as good as constant


class ConstantEnvironment:
    """The same `radiance` (3,) from every direction."""

    is_constant = True

    def __init__(self, radiance):
        self.radiance = np.asarray(radiance, np.float32).reshape(3, 1)
        self.mean = self.radiance[:, 0]
        self.is_black = not self.radiance.any()
        self._never = np.zeros(1, np.float32)

    def eval(self, d, arena):
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
        detail may be missed.
    shape : (rows, columns)
        Of the grid: rows from +Z to -Z, columns from -X over +Y, +X and -Y.

    Attributes
    ----------
    mean : (3,) float32
        Mean radiance over all directions.
    is_sampled : bool
        Whether light sampling pays: not where the map is even.
    choice : float
        Probability with which the light sampler chooses the map, set by who makes the sampler; 0 until then.
    """

    is_constant = False
    extended = False  # who leaves the scene asks `eval`
    at_infinity = True
    count = 1

    def __init__(self, radiance, shape=(512, 1024)):
        self.eval = radiance
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
        self.is_black = not cells.any()
        brightness = np.maximum(luminance(cells), 0.0)
        average = float((brightness * weight).sum())
        surplus = np.maximum(brightness - average, 0.0) * weight
        self.is_sampled = float(surplus.sum()) > _EVEN * average
        self.power = np.array([math.pi * float(surplus.sum())])  # of what is sampled
        if self.is_sampled:
            self._distribution = Distribution2D(surplus)
            self._density = (self._distribution.pmf / solid_angle).astype(np.float32).reshape(-1)

    def sample(self, rows, p, u0, u1, arena):
        """A direction, bright ones more often."""
        n = p.shape[-1]
        wi = arena.empty((3, n))
        row, column, y, x = self._distribution.sample(u0, u1, arena)
        pdf = arena.take(self._density, row * self._columns + column)
        with arena.frame():
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
        weight = arena.empty((3, n))
        with arena.frame():
            np.divide(self.eval(wi, arena), pdf, out=weight)
        return LightSample(wi, arena.full(n, math.inf), weight, pdf)

    def pdf(self, d, arena):
        """Solid-angle density with which the light sampler would have drawn `d` (3, N), choice included, (N,)."""
        if not self.choice:
            return np.zeros(1, np.float32)
        n = d.shape[-1]
        pdf = arena.empty(n)
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
            np.take(self._density, row, out=pdf, mode="clip")
        return np.multiply(pdf, self.choice, out=pdf)

    def _cells(self):
        """Mean radiance of each cell, (3, R, C) float64."""
        theta = (np.arange(self._rows) + 0.5) * (math.pi / self._rows)
        phi = math.pi - (np.arange(self._columns) + 0.5) * (2.0 * math.pi / self._columns)
        circle_, arena = np.stack([np.cos(phi), np.sin(phi)]), Arena()
        cells = np.zeros((3, self._rows, self._columns))
        for k, angle in enumerate(theta):
            with arena.frame():
                d = np.append(math.sin(angle) * circle_, np.full((1, phi.size), math.cos(angle)), axis=0)
                cells[:, k] = self.eval(d.astype(np.float32), arena, averaged=True)
        # Linear interpolation spreads a texel over its neighbours: its mean over each of the cells around.
        cells = 0.75 * cells + 0.125 * (np.roll(cells, 1, axis=2) + np.roll(cells, -1, axis=2))
        padded = np.concatenate((cells[:, :1], cells, cells[:, -1:]), axis=1)
        return 0.75 * cells + 0.125 * (padded[:, :-2] + padded[:, 2:])
