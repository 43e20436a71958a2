# SPDX-License-Identifier: GPL-3.0-or-later
"""Directional albedo of GGX lobes, and the energy that single scattering loses between the facets.

The tables in `energy.npz` hold averages of the lobes' own sample weights (`energy_tables` writes them). Axes, each from
0 to 1: [index,] roughness = sqrt(α), cosθ; the index is taken as sqrt((η - 1)/(η + 1)) of η >= 1.

- ``reflection`` (32, 32): E of `glossy.Rough`
- ``glass`` (16, 16, 16): E of `glass.Rough` for η
- ``glass_inside`` (16, 16, 16): the same for 1/η as Cycles has it, measured from its renders by
  `tests/addon/nodes/measure_glass.py`: at grazing angles it is larger than what the lobe returns, so light stays lost
- ``schlick`` (16, 16, 16): mean of `fresnel.interpolation` over the samples of `dielectric.Rough`, 0 for those that
  fail, as in Cycles

Source of the compensation: Kulla and Conty, "Revisiting Physically Based Shading at Imageworks", SIGGRAPH course 2017.
"""

from __future__ import annotations

import functools
import os

import numpy as np

from . import lookup


@functools.cache
def tables():
    """The tables by name, float32, read once."""
    with np.load(os.path.join(os.path.dirname(__file__), "energy.npz")) as stored:
        return {name: stored[name] for name in stored.files}


@functools.cache
def _averages():
    """∫ 2 cosθ E dcosθ of each table: its last axis integrated by Simpson's rule on the linear interpolant."""
    return {name: _hemisphere_average(table) for name, table in tables().items()}


def _hemisphere_average(table):
    """∫ 2 μ E(μ) dμ, exact for the piecewise linear E."""
    mu = np.linspace(0.0, 1.0, table.shape[-1], dtype=np.float32)
    left, right, low, high = table[..., :-1], table[..., 1:], mu[:-1], mu[1:]
    return ((high - low) * (left * (2 * low + high) + right * (low + 2 * high)) / 3).sum(-1)


def reflection(mu, alpha, arena):
    """(E (N,), average E (1,) or (N,)) of GGX reflection without Fresnel."""
    return _pair("reflection", (np.sqrt(alpha),), mu, arena)


def glass(mu, alpha, ior, inside, arena):
    """(E, average E) of GGX glass, for `ior` >= 1; `inside` (N,) tells lanes that look from the dense side."""
    roughness, z = np.sqrt(alpha), _index(ior)
    e, average = _pair("glass", (z, roughness), mu, arena)
    if inside is not None and inside.any():
        e_in, average_in = _pair("glass_inside", (z, roughness), mu, arena)
        e, average = np.where(inside, e_in, e), np.where(inside, average_in, average)
    return e, average


def schlick(mu, alpha, eta, arena):
    """Mean interpolation from F0 to white over the facets of a dielectric reflection, (N,)."""
    return _lookup(tables()["schlick"], (_index(eta), np.sqrt(alpha), mu), arena)


def compensation(e, average, color):
    """Factor on a lobe that returns what single scattering loses: 1 + F_ms (1 - E)/E.

    `color` (3, ·) or (1,) is the mean Fresnel reflectance F_ss of the facets; each further bounce takes it on again.
    """
    bounced = color * average / (1.0 - color * (1.0 - average))
    return 1.0 + bounced * ((1.0 - e) / e)


def _index(ior):
    return np.sqrt(np.abs((ior - 1.0) / (ior + 1.0)))


def _pair(name, coordinates, mu, arena):
    return _lookup(tables()[name], (*coordinates, mu), arena), _lookup(_averages()[name], coordinates, arena)


def _lookup(table, coordinates, arena):
    """Multilinear interpolation of `table` at coordinates in [0, 1], (1,) or (N,) each.

    Axis after axis, the first ones for the whole table where their coordinates are constant: most materials leave a row
    over cosθ. The order is always the same, for of a single lane nobody can tell which coordinates are constant.
    """
    kept = list(coordinates)
    while kept and kept[0].size == 1:
        (low,), t = lookup.cell(kept.pop(0), table.shape[0])
        table = table[low] + (table[low + 1] - table[low]) * t
    if not kept:
        return table.reshape(-1)
    if len(kept) == 1:
        return lookup.linear(table, kept[0], arena)
    kept = [np.broadcast_to(x, kept[0].shape) for x in kept]
    return lookup.multilinear(np.ascontiguousarray(table), kept, arena)
