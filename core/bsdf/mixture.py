# SPDX-License-Identifier: GPL-3.0-or-later
"""A surface as a weighted list of lobes.

`eval_pdf` and `sample` do for the list what a lobe does alone, with colours, over dense lanes. A list of one lobe, the
common case, is passed on without choice, gather or sum. Multiple lobes are sampled one at a time and weighed by all:
the one-sample model with the balance heuristic (Veach 1997, 9.2.4).

Light must not leak through the surface that `ng` describes when a lobe's normal differs from it: reflection below it
and transmission above it are dropped.
"""

from __future__ import annotations

import numpy as np

from ..limits import at_least, within
from ..vecmath import dot
from .base import BSDFSample, Lobe

ALBEDO = "albedo"
"""A lobe's parameter that holds its albedo, where that is known before."""

MARK = "mark"
"""A lobe's parameter: bits (1,) or (N,) uint8 that the flags of its samples have besides the lobe's own."""

UNTESTED = "untested"
"""A lobe's parameter: lanes (N,) bool in which light may leak through the surface, e.g. of hair."""

_OF_MIXTURE = (ALBEDO, MARK, UNTESTED)  # what lobes do not read
_TINY = 1e-20
_BELOW_ONE = 1.0 - 2.0**-24
_LUMINANCE = np.float32((0.2126, 0.7152, 0.0722))
_DIFFUSE = Lobe.REFLECTION | Lobe.DIFFUSE
_REFRACTS = Lobe.GLOSSY | Lobe.DELTA
_MAY_BE_DELTA = Lobe.DELTA | Lobe.TRANSMISSION  # rough glass is delta where the indices are equal


class Mixture:
    """What scatters at the surfaces of one program; the lobes are static, their colours and parameters are not.

    The methods take `entries`: for each lobe, in order, a tuple (lobe, weight (3, N) or (3, 1), params, n), where `n`
    (3, N) is the lobe's normal, None for the shading normal; and `surface` with `wo`, `ng`, `ns` (3, N). Flat surfaces
    pass one array as `ng` and `ns`: it saves the leak test.

    Attributes
    ----------
    is_smooth : bool
        Whether a lobe can be evaluated; else no light can be sampled from here.
    has_straight : bool
        Whether rays may pass unbent.
    refracts : bool
        Whether rays may be bent at a change of index.
    """

    def __init__(self, lobes):
        self.lobes = tuple(lobes)
        flags = [lobe.flags for lobe in self.lobes]
        self.is_smooth = any(Lobe.DELTA not in f for f in flags)
        self.has_straight = any(Lobe.STRAIGHT in f for f in flags)
        self.refracts = any(_REFRACTS & f and Lobe.STRAIGHT not in f and Lobe.TRANSMISSION in f for f in flags)
        self._default_flags = _default_flags(flags)
        self._sample = (_sample_none, _sample_one, _sample_many)[min(len(flags), 2)]

    def shares(self, entries, surface, arena):
        """Probability of each lobe (K, N), to be passed on to `eval_pdf` and `sample`; None without a choice."""
        return _choice_probabilities(entries, surface, arena) if len(entries) > 1 else None

    def eval_pdf(self, entries, surface, wi, arena, shares=None):
        """f·|cosθ| with colours (3, N) and density (N,) of all lobes that are not delta."""
        f, pdf = arena.empty(wi.shape), arena.empty(wi.shape[-1])
        if len(entries) == 1 and self.is_smooth:
            with arena.frame():
                value, density = _eval_lobe(entries[0], surface, wi, arena)
                np.multiply(entries[0][1], value, out=f)
                np.copyto(pdf, density)
            return f, pdf
        with arena.frame():
            if shares is None and self.is_smooth:
                shares = _choice_probabilities(entries, surface, arena)
            _sum_lobes(entries, shares, surface, wi, arena, f, pdf)
        return f, pdf

    def eval_diffuse(self, entries, surface, wi, arena):
        """f·|cosθ| with colours (3, N) of the diffuse lobes alone."""
        f = arena.zeros(wi.shape)
        for entry in entries:
            if Lobe.DIFFUSE not in entry[0].flags:
                continue
            with arena.frame():
                value, _ = _eval_lobe(entry, surface, wi, arena)
                np.add(f, np.multiply(entry[1], value, out=arena.empty(f.shape)), out=f)
        return f

    def sample(self, entries, surface, uc, u0, u1, arena, shares=None, with_flags=False):
        """A direction of one of the lobes, as `BSDFSample`; `uc` chooses the lobe and is used again within it."""
        flags = arena.full(uc.shape, self._default_flags, np.uint8) if with_flags else None
        return self._sample(entries, surface, uc, u0, u1, shares, flags, arena)

    def albedo(self, entries, surface, arena):
        """Sum of the lobes' colour times albedo, (3, N): an estimate."""
        total = arena.zeros(surface.wo.shape)
        with arena.frame():
            for lobe, weight, params, n in entries:
                share = lobe.albedo(params, surface.ns if n is None else n, surface.wo, arena)
                np.add(total, weight * share, out=total)
        return total


def _default_flags(flags):
    """Value of the flags in the lanes where `_sample_many` does not choose another lobe."""
    if not flags:
        return 0
    return flags[0].value if len(flags) == 1 else _DIFFUSE.value


def _sample_none(entries, surface, uc, u0, u1, shares, flags, arena):
    """Nothing scatters: every sample fails."""
    wi = np.negative(surface.wo, out=arena.empty(surface.wo.shape))
    return BSDFSample(wi, arena.zeros(wi.shape), arena.zeros(uc.shape), flags=flags)


def _sample_one(entries, surface, uc, u0, u1, shares, flags, arena):
    """The only lobe, without choice; a constant colour stays (3, 1) where nothing else weighs."""
    lobe, color, params, n = entries[0]
    n = surface.ns if n is None else n
    s = lobe.sample(params, n, surface.wo, uc, u0, u1, arena)
    if flags is not None and MARK in params:
        np.bitwise_or(flags, params[MARK], out=flags)
    straight = arena.full(uc.shape, True, bool) if Lobe.STRAIGHT in lobe.flags else None
    weight = s.weight
    keep = _on_its_side(lobe, n, surface.ng, s.wi, arena, params.get(UNTESTED))
    if keep is not None:
        np.copyto(s.pdf, 0.0, where=np.logical_not(keep))
        weight = np.multiply(weight, keep, out=arena.empty(np.broadcast_shapes(np.shape(weight), keep.shape)))
    if np.ndim(weight) == 0:
        return BSDFSample(s.wi, color, s.pdf, s.eta, straight, flags)
    return BSDFSample(s.wi, np.multiply(color, weight, out=arena.empty(s.wi.shape)), s.pdf, s.eta, straight, flags)


def _sample_many(entries, surface, uc, u0, u1, shares, flags, arena):
    """Choose a lobe in each lane, sample it there, then weigh by all."""
    count = uc.size
    wi, weight, pdf = arena.empty((3, count)), arena.zeros((3, count)), arena.empty(count)
    has_straight = any(Lobe.STRAIGHT in entry[0].flags for entry in entries)
    straight = arena.zeros(count, bool) if has_straight else None
    if shares is None:
        shares = _choice_probabilities(entries, surface, arena)
    everywhere = _cheapest(entries)
    with arena.frame():
        if everywhere is None:
            np.negative(surface.wo, out=wi)
            pdf.fill(0)
        else:
            lobe, _, params, n = entries[everywhere]
            s = lobe.sample(params, surface.ns if n is None else n, surface.wo, uc, u0, u1, arena)
            np.copyto(wi, s.wi)
            np.copyto(pdf, s.pdf)
    with arena.frame():
        for entry, share, lanes, uc_again in _chosen(entries, everywhere, shares, uc, arena):
            s, color = _sample_lanes(entry, surface, lanes, uc_again, u0, u1, arena)
            for row, values in zip(wi, s.wi, strict=True):
                row[lanes] = values
            pdf[lanes] = s.pdf
            if flags is not None:
                flags[lanes] = entry[0].flags.value
                if MARK in entry[2]:
                    flags[lanes] |= _at(entry[2][MARK], lanes, arena)
            if _MAY_BE_DELTA & entry[0].flags:
                # Only the lobe that made a delta direction has any weight there.
                alone = color * s.weight / share
                weight[:, lanes] = np.where(np.isinf(s.pdf), alone, 0.0)
            if Lobe.STRAIGHT in entry[0].flags:
                straight[lanes] = True
        if any(Lobe.DELTA not in entry[0].flags for entry in entries):
            _weigh_by_all(entries, shares, surface, wi, arena, weight, pdf)
    return BSDFSample(wi, weight, pdf, None, straight, flags)


def _cheapest(entries):
    """Number of a lobe that costs less to sample in every lane than to sample where it was chosen, or None."""
    diffuse = [k for k, entry in enumerate(entries) if entry[0].flags == _DIFFUSE]
    return diffuse[-1] if diffuse else None


def _chosen(entries, but, shares, uc, arena):
    """Yield (entry, its share, lanes, `uc` stretched to [0, 1) again) of the lobes, `but` one, that some lane chose."""
    start, end, chosen = arena.zeros(uc.size), arena.zeros(uc.size), arena.empty(uc.size, bool)
    below = arena.empty(uc.size, bool)
    for k, entry in enumerate(entries):
        np.copyto(start, end)
        np.add(end, shares[k], out=end)
        if k == but:
            continue
        np.greater_equal(uc, start, out=chosen)
        if k < len(entries) - 1:
            np.logical_and(chosen, np.less(uc, end, out=below), out=chosen)
        np.logical_and(chosen, np.greater(shares[k], 0.0, out=below), out=chosen)
        lanes = np.flatnonzero(chosen)
        if lanes.size:
            with arena.frame():
                share, u = arena.take(shares[k], lanes), arena.take(uc, lanes)
                np.subtract(u, arena.take(start, lanes), out=u)
                np.divide(u, share, out=u)
                within(u, 0.0, _BELOW_ONE, u)
                yield entry, share, lanes, u


def _sample_lanes(entry, surface, lanes, uc, u0, u1, arena):
    """`LobeSample` of one lobe over `lanes`, leaks dropped, and the lobe's colour there."""
    lobe, color, params, n = entry
    n = surface.ns if n is None else n
    untested = _at(params[UNTESTED], lanes, arena) if UNTESTED in params else None
    params = {name: _at(value, lanes, arena) for name, value in params.items() if name not in _OF_MIXTURE}
    normal, wo = _at(n, lanes, arena), arena.take(surface.wo, lanes)
    s = lobe.sample(params, normal, wo, uc, arena.take(u0, lanes), arena.take(u1, lanes), arena)
    ng = normal if n is surface.ng else _at(surface.ng, lanes, arena)
    keep = _on_its_side(lobe, normal, ng, s.wi, arena, untested)
    if keep is not None:
        np.copyto(s.pdf, 0.0, where=np.logical_not(keep))
    return s, _at(color, lanes, arena)


def _weigh_by_all(entries, shares, surface, wi, arena, weight, pdf):
    """Write f/pdf of all lobes, and their density, to the lanes whose `pdf` is neither 0 nor inf."""
    if not any(_MAY_BE_DELTA & entry[0].flags for entry in entries):
        with arena.frame():
            sampled = None
            if surface.ns is not surface.ng or any(n is not None for _, _, _, n in entries):
                sampled = np.not_equal(pdf, 0.0, out=arena.empty(pdf.shape, bool))
            _sum_lobes(entries, shares, surface, wi, arena, weight, pdf)
            density = at_least(pdf, _TINY, arena.empty(pdf.shape))
            np.divide(weight, density, out=weight)
            if sampled is not None:  # on one normal f = 0 elsewhere; on turned ones another lobe may reflect from there
                np.multiply(weight, sampled, out=weight)
        return
    with arena.frame():
        smooth, finite = arena.empty(pdf.shape, bool), arena.empty(pdf.shape, bool)
        np.greater(pdf, 0.0, out=smooth)
        np.logical_and(smooth, np.isfinite(pdf, out=finite), out=smooth)
        f, density = arena.empty(wi.shape), arena.empty(pdf.shape)
        _sum_lobes(entries, shares, surface, wi, arena, f, density)
        np.copyto(pdf, density, where=smooth)
        at_least(density, _TINY, density)
        np.divide(f, density, out=f)
        np.copyto(weight, f, where=smooth)


def _sum_lobes(entries, shares, surface, wi, arena, f, pdf):
    """Write the sums of colour · f and share · pdf over the lobes that are not delta."""
    side = None  # of the geometric normal on which `wi` is: the same for all lobes
    if surface.ns is not surface.ng or any(n is not None for _, _, _, n in entries):
        side = dot(wi, surface.ng, arena)
    smooth = [k for k, entry in enumerate(entries) if Lobe.DELTA not in entry[0].flags]
    if not smooth:
        f.fill(0)
        pdf.fill(0)
    for k in smooth:
        entry = entries[k]
        with arena.frame():
            value, density = _eval_lobe(entry, surface, wi, arena, side)
            if k == smooth[0]:
                np.multiply(entry[1], value, out=f)
                np.multiply(density, shares[k], out=pdf)
            else:
                coloured = np.multiply(entry[1], value, out=arena.empty(f.shape))
                np.add(f, coloured, out=f)
                np.add(pdf, np.multiply(density, shares[k], out=coloured[0]), out=pdf)


def _eval_lobe(entry, surface, wi, arena, side=None):
    """f·|cosθ| and pdf of one lobe, leaks dropped."""
    lobe, _, params, n = entry
    n = surface.ns if n is None else n
    value, pdf = lobe.eval_pdf(params, n, surface.wo, wi, arena)
    keep = _on_its_side(lobe, n, surface.ng, wi, arena, params.get(UNTESTED), side)
    if keep is None:
        return value, pdf
    kept = np.multiply(pdf, keep, out=arena.empty(pdf.shape))
    return kept if value is pdf else np.multiply(value, keep, out=arena.empty(value.shape)), kept


def _choice_probabilities(entries, surface, arena):
    """Probability of each lobe, by the luminance of colour times albedo, (K, N); 0 everywhere where all are black.

    Negative colours count by their size.
    """
    shares = arena.empty((len(entries), surface.wo.shape[-1]))
    with arena.frame():
        t = arena.empty(surface.wo.shape[-1])
        for share, (lobe, color, params, n) in zip(shares, entries, strict=True):
            bright = params.get(ALBEDO)
            if bright is None:
                bright = lobe.albedo(params, surface.ns if n is None else n, surface.wo, arena)
            if np.ndim(bright) == 2:
                color, bright = np.multiply(color, bright, out=arena.empty((3, share.size))), 1.0
            np.multiply(_luminance(color, arena), bright, out=share)
            np.abs(share, out=share)
        np.add(shares[0], shares[1], out=t)
        for share in shares[2:]:
            np.add(t, share, out=t)
        at_least(t, _TINY, t)
        np.divide(shares, t, out=shares)
    return shares


def _luminance(color, arena):
    """Luminance (N,) or (1,) of a colour (3, N) or (3, 1); `einsum` takes ten times as long over one grey row."""
    if color.strides[0] == 0:
        return color[0]
    return np.einsum("c,cn->n", _LUMINANCE, color, out=arena.empty(color.shape[-1]))


def _on_its_side(lobe, n, ng, wi, arena, untested=None, side=None):
    """Lanes whose `wi` is on the side of `ng` that the lobe, with normal `n`, sent it to (bool); None when all are.

    So are those that are `untested`, (N,) bool. `side` (N,) is the cosine of `wi` to `ng` where it is known.
    """
    if n is ng or Lobe.STRAIGHT in lobe.flags:
        return None
    keep = arena.empty(wi.shape[-1], bool)
    with arena.frame():
        if side is None:
            side = dot(wi, ng, arena)
        if Lobe.REFLECTION not in lobe.flags:
            np.less(side, 0.0, out=keep)
        else:
            if Lobe.TRANSMISSION in lobe.flags:
                side = np.multiply(side, dot(wi, n, arena), out=arena.empty(side.shape))
            np.greater(side, 0.0, out=keep)
        return keep if untested is None else np.logical_or(keep, untested, out=keep)


def _at(array, lanes, arena):
    """Columns `lanes` of `array`, or the constant it is."""
    return array if array.shape[-1] == 1 else arena.take(array, lanes)
