# SPDX-License-Identifier: GPL-3.0-or-later
"""A quantity driven to its extremes, and how far it may go."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from .case import ALL_VARIANTS, METHOD_VARIANTS, Case, measure


@dataclass(frozen=True)
class Axis:
    """Values of one quantity, each a case.

    Parameters
    ----------
    name : str
    truth : str
        The scene and its closed form, in words.
    case : callable
        ``case(value) -> Case``.
    values : tuple
        Ascending numbers, or names.
    usual : float, optional
        The value from which the widest range grows; None for names.
    must : (least, greatest), optional
        Values that the range must hold.
    quick : tuple
        The values of the quick run; () is all of them.
    variants : tuple of Variant
        How each value is rendered; () is by all methods, and some by all variants.
    """

    name: str
    truth: str
    case: Callable[[object], Case]
    values: tuple
    usual: float | None = None
    must: tuple | None = None
    quick: tuple = ()
    variants: tuple = ()

    def chosen(self, quick):
        """Values of the quick or of the full run."""
        return self.quick if quick and self.quick else self.values


class Result(NamedTuple):
    """All renders of one value of an axis."""

    axis: Axis
    value: object
    case: Case
    outcomes: list

    @property
    def verdict(self):
        """The worst of the renders'."""
        found = {o.verdict for o in self.outcomes}
        return next(v for v in ("fail", "out of range", "pass") if v in found)


def run_value(axis, value, quick):
    """Render one value: by all methods; in the full run, and at the end, by both routes and with all features, too.

    Returns
    -------
    Result
    """
    case = axis.case(value)
    variants = METHOD_VARIANTS if quick and value != axis.values[-1] else ALL_VARIANTS
    return Result(axis, value, case, [measure(case, variant) for variant in axis.variants or variants])


def widest(axis, results):
    """The widest range around the usual value in which every result of `axis` passes, or None.

    Parameters
    ----------
    axis : Axis
    results : sequence of Result

    Returns
    -------
    (least, greatest) or None
    """
    if axis.usual is None:
        return None
    passing = {r.value: r.verdict == "pass" for r in results if r.axis is axis}
    values = sorted(passing)
    if not passing.get(axis.usual):
        return None
    low = high = values.index(axis.usual)
    while low > 0 and passing[values[low - 1]]:
        low -= 1
    while high + 1 < len(values) and passing[values[high + 1]]:
        high += 1
    return values[low], values[high]


def holds(axis, found, tried):
    """Whether a widest range is as wide as it must be, as far as the values `tried` tell."""
    needed = [v for v in tried if axis.must and axis.must[0] <= v <= axis.must[1]]
    return not needed or (found is not None and found[0] <= needed[0] and found[1] >= needed[-1])
