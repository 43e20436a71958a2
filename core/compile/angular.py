# SPDX-License-Identifier: GPL-3.0-or-later
"""Lobes of constant materials, tabulated over the cosine of view.

What a closure makes of constant inputs (energy that the layers above let pass, compensation for what microfacets lose)
depends on the material, the cosine of view and the side alone. It is computed here once for each, then looked up.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arena import Arena
from ..bsdf.mixture import ALBEDO
from ..limits import within
from ..nodes.base import Context
from ..vecmath import dot

_STEPS = 155  # a multiple of 31, so that the nodes of the energy tables are nodes here
_SIDES = 2
_MOST_VALUES = 1 << 22  # of a closure's tables; scenes with more materials than that gives compute at each hit


class _View(NamedTuple):
    """As much of a surface as the closures may ask for."""

    wo: np.ndarray
    ns: np.ndarray
    ng: np.ndarray
    front: np.ndarray


class _Cells(NamedTuple):
    """Where lanes stand in the tables."""

    lower: np.ndarray
    share: np.ndarray


class Row:
    """One number of an entry: constant, by material, or by material, side and cosine.

    Parameters
    ----------
    values : (M, 2, steps + 1) float32
    """

    def __init__(self, values):
        self.varies = bool((values != values[..., :1]).any() or (values != values[:, :1]).any())
        is_shared = bool((values == values[0]).all())
        self._by_material = None if self.varies or is_shared else np.ascontiguousarray(values[:, 0, 0])
        self.constant = values[0, 0, :1].copy()
        self._lower = np.ascontiguousarray(values).reshape(-1)
        self._rise = np.diff(values, axis=-1, append=values[..., -1:]).reshape(-1)

    def at(self, rows, cells, arena):
        """Values over lanes, (N,) or (1,)."""
        if not self.varies:
            return self.constant if self._by_material is None else arena.take(self._by_material, rows)
        out = arena.take(self._rise, cells.lower)
        np.multiply(out, cells.share, out=out)
        with arena.frame():
            np.add(out, arena.take(self._lower, cells.lower), out=out)
        return out


class Rows:
    """A number or colour of an entry; a colour whose channels are equal is one `Row`."""

    def __init__(self, values):
        grey = values.ndim == 4 and bool((values == values[:1]).all())
        self.is_color = values.ndim == 4
        self._rows = [Row(v) for v in (values[:1] if grey else values)] if self.is_color else [Row(values)]
        self.varies = any(row.varies for row in self._rows)

    def at(self, rows, cells, arena):
        """Values over lanes, (N,) or (1,), for a colour (3, N) or (3, 1)."""
        found = [row.at(rows, cells, arena) for row in self._rows]
        if not self.is_color:
            return found[0]
        count = max(v.size for v in found)
        if len(found) == 1:
            return np.broadcast_to(found[0], (3, count))
        out = arena.empty((3, count))
        for channel, values in zip(out, found, strict=True):
            np.copyto(channel, values)
        return out


class _Entry(NamedTuple):
    lobe: object
    weight: Rows
    takes_color: bool
    params: dict
    albedo: Rows


class AngularTables:
    """Stands in for a closure's `build`, see `tabulate`.

    Parameters
    ----------
    entries : list of _Entry
    color : str or None
        Input that varies over lanes and multiplies the weights of some entries.
    """

    def __init__(self, entries, color):
        self._entries, self._color = entries, color
        every = [rows for e in entries for rows in (e.weight, e.albedo, *e.params.values())]
        self._varies = any(rows.varies for rows in every)

    def build(self, context, inputs, rows):
        """[(lobe, weight, params, None)] over lanes; `rows` (N,) are the materials', None where there is one."""
        arena = context.arena
        cells = self._cells(context, rows) if self._varies else None
        found = []
        for entry in self._entries:
            weight = entry.weight.at(rows, cells, arena)
            if entry.takes_color:
                color = np.maximum(inputs[self._color], 0)
                weight = np.multiply(weight, color, out=arena.empty(np.broadcast_shapes(weight.shape, color.shape)))
            params = {name: value.at(rows, cells, arena) for name, value in entry.params.items()}
            found.append((entry.lobe, weight, params | {ALBEDO: entry.albedo.at(rows, cells, arena)}, None))
        return found

    def _cells(self, context, rows):
        """Cells of the tables in which the lanes' cosines of view stand."""
        arena, surface = context.arena, context.surface
        lower, share = arena.empty(context.count, np.intp), arena.empty(context.count)  # numpy copies other indices
        with arena.frame():
            whole = arena.empty(context.count)
            dot(surface.ns, surface.wo, arena, out=share)
            within(share, 0.0, 1.0, share)
            np.multiply(share, float(_STEPS), out=share)
            np.floor(share, out=whole)
            np.subtract(share, whole, out=share)
            np.copyto(lower, whole, casting="unsafe")
            number = np.logical_not(surface.front, out=arena.empty(context.count, bool))
            first = np.multiply(number, _STEPS + 1, out=arena.empty(context.count, np.intp))
            np.add(lower, first, out=lower)
            if rows is not None:
                np.add(lower, np.multiply(rows, _SIDES * (_STEPS + 1), out=first), out=lower)
        return _Cells(lower, share)


def tabulate(closure, lobes, properties, inputs, color=None):
    """`AngularTables` of a closure; None where its lobes do not follow from material, cosine and side.

    Parameters
    ----------
    closure : Closure
    lobes, properties : dict
        As `Closure.build` takes them.
    inputs : mapping of str to (M,) or (3, M) float32
        Of every material.
    color : str, optional
        The only input that varies over lanes.
    """
    count = next((v.shape[-1] for v in inputs.values()), 1)
    if count * _SIDES * (_STEPS + 1) * 16 > _MOST_VALUES:
        return None
    given = {name: _spread(value, count) for name, value in inputs.items()}
    with np.errstate(all="ignore"):  # what is not finite goes through
        return _tabulated(closure, lobes, properties, given, color, count)


def _tabulated(closure, lobes, properties, given, color, count):
    context = view_context(count)
    if color is None:
        return AngularTables(
            [_entry(e, None, context, count) for e in closure.build(context, given, lobes, properties)], None
        )
    built = [
        closure.build(context, given | {color: np.full((3, 1), level, np.float32)}, lobes, properties)
        for level in (0.0, 0.5, 1.0)
    ]
    entries = []
    for at in zip(*built, strict=True):
        takes = _takes_color(*at, count)
        if takes is None:
            return None
        entries.append(_entry(at[2], takes, context, count))
    return AngularTables(entries, color)


def view_context(count):
    """Lanes for every material, side and cosine, in this order."""
    mu = np.tile(np.linspace(0.0, 1.0, _STEPS + 1, dtype=np.float32), _SIDES * count)
    n = np.zeros((3, mu.size), np.float32)
    n[2] = 1
    wo = np.stack([np.sqrt(np.maximum(1 - mu * mu, 0)), np.zeros_like(mu), mu])
    front = np.tile(np.repeat([True, False], _STEPS + 1), count)
    return Context(Arena(1 << 16), mu.size, _View(wo, n, n, front))


def _spread(values, count):
    """Inputs (·, M) over the lanes of `view_context`; a single material's stay (·, 1)."""
    return values if count == 1 else np.repeat(values, _SIDES * (_STEPS + 1), axis=-1)


def _entry(built, takes_color, context, count):
    lobe, weight, params, _ = built
    surface = context.surface
    albedo = lobe.albedo(params, surface.ns, surface.wo, context.arena)
    return _Entry(
        lobe,
        Rows(_gridded(weight, count, True)),
        bool(takes_color),
        {name: Rows(_gridded(value, count)) for name, value in params.items()},
        Rows(_gridded(albedo, count)),
    )


def _gridded(value, count, is_color=False):
    """A value over the lanes as (M, 2, steps + 1), or (3, M, 2, steps + 1)."""
    value = np.asarray(value, np.float32)
    lead = (3,) if is_color or value.ndim == 2 else ()
    lanes = count * _SIDES * (_STEPS + 1)
    return np.array(np.broadcast_to(value, (*lead, lanes))).reshape(*lead, count, _SIDES, _STEPS + 1)


def _takes_color(black, grey, white, count):
    """Whether an entry's weight is the colour times what it is in white (True) or does not depend on it (False)."""
    same = all(
        np.array_equal(_gridded(black[2][name], count), _gridded(value, count)) for name, value in white[2].items()
    )
    if not same:
        return None
    low, middle, high = (_gridded(e[1], count, True) for e in (black, grey, white))
    if np.array_equal(low, high) and np.array_equal(middle, high):
        return False
    return True if not low.any() and np.allclose(2 * middle, high, rtol=1e-5, atol=0) else None
