# SPDX-License-Identifier: GPL-3.0-or-later
"""Pieces of hair that are long for their radius are cut into shorter ones."""

from __future__ import annotations

import numpy as np
import pytest

from zraka.core.arena import Arena
from zraka.core.compile.needs import Needs
from zraka.core.diagnostics import Diagnostics
from zraka.core.scene import Curves

from .test_strands import geometry_of, hits_of


def test_a_long_piece_is_cut_where_it_runs(monkeypatch):
    """Its shares are cubics with control points of their own; radii go along."""
    points = np.random.default_rng(2).uniform(-1, 1, (6, 3))
    curves = Curves(points, np.linspace(1, 6, 6) * 1e-5, [6])
    cut = geometry_of(curves).strands
    monkeypatch.setattr("zraka.core.compile.strands.SLIMMEST", np.inf)
    whole = geometry_of(curves).strands
    assert whole.count == 5 and cut.count > 5 * 40
    arena, number, u = Arena(), np.repeat(np.arange(cut.count), 3), np.tile(np.float32([0, 0.3, 1]), cut.count)
    at = cut.at(number, u, arena)
    ends = at.reshape(4, -1, 3)
    np.testing.assert_allclose(ends[:, :-1, 2], ends[:, 1:, 0], atol=3e-7)
    # Each point lies on the uncut curve.
    fine = whole.at(np.repeat(np.arange(5), 20001), np.tile(np.linspace(0, 1, 20001, dtype=np.float32), 5), arena)
    for k in range(0, at.shape[1], 97):
        nearest = np.abs(fine - at[:, k, None])[:3].max(axis=0).argmin()
        np.testing.assert_allclose(fine[:3, nearest], at[:3, k], atol=3e-4)
        np.testing.assert_allclose(fine[3, nearest], at[3, k], rtol=1e-2)
    np.testing.assert_array_equal(cut._runs, [0, cut.count])


def test_a_cut_piece_keeps_what_nodes_read_along_it():
    """Here the intercept: four fifths of the strand's length lie in its first piece."""
    first, second = 158, 40
    curves = Curves([(0, 0, 0), (4, 0, 0), (5, 0, 0)], [1 / 250 / 39.5] * 3, [3])
    geometry = geometry_of(curves, needs=Needs(strand=True))
    assert geometry.segment_count == first + second
    begins = np.concatenate([np.arange(first) / first * 0.8, 0.8 + np.arange(second) / second * 0.2])
    root, tip = geometry.corner_values["strand"][:, 0], geometry.corner_values["strand"][:, 4]
    np.testing.assert_allclose(root, begins, atol=1e-6)
    np.testing.assert_array_equal(root[1:], tip[:-1])
    assert tip[-1] == 1


def test_a_cut_piece_with_an_infinite_radius_keeps_the_rest():
    """What nodes read of the radius along it is no number; the intercept stays."""
    curves = Curves([(0, 0, 0), (4, 0, 0), (5, 0, 0)], [1 / 250 / 39.5] * 2 + [-np.inf], [3])
    strand = geometry_of(curves, needs=Needs(strand=True)).corner_values["strand"]
    assert len(strand) > 100
    assert np.isfinite(strand[:, :2]).all()


def test_a_very_long_piece_is_met_exactly():
    """Embree alone meets a tenth too much or too little of it, by the processor's instructions."""
    radius, count = 1e-4, 4000
    geometry = geometry_of(Curves([(-2, 0, 0), (2, 0, 0)], [radius] * 2, [2]))
    rng = np.random.default_rng(3)
    beside = np.where(np.arange(count) % 2, rng.uniform(-0.95, 0.95, count), rng.uniform(1.05, 2, count))
    o = np.stack([rng.uniform(-1.9, 1.9, count), radius * beside, np.full(count, 1e-2)])
    hits, _ = hits_of(geometry, o, np.tile([[0], [0], [-1]], count))
    np.testing.assert_array_equal(hits.prim >= 0, np.abs(beside) < 1)


def test_rays_from_inside_pass_where_a_piece_is_cut():
    """A cut is no open end by which they could have come in."""
    geometry = geometry_of(Curves([(-2, 0, 0), (2, 0, 0)], [1e-3] * 2, [2]))
    o = np.stack([np.linspace(-1.9, 1.0, 200), np.zeros(200), np.zeros(200)])
    hits, _ = hits_of(geometry, o, np.tile([[1], [0], [2e-3]], 200))
    assert (hits.prim < 0).all()
    assert geometry.segment_count > 10


@pytest.mark.parametrize("length, count", [(1e5, 0), (1e6, 1)])
def test_pieces_too_long_for_their_radius_are_said(length, count):
    diagnostics = Diagnostics()
    geometry_of(Curves([(0, 0, 0), (length, 0, 0)], [0.1, 0.1], [2], name="Fur"), diagnostics=diagnostics)
    assert len(diagnostics.messages()) == count
    assert all("too long for their radius" in m and "(Fur" in m for m in diagnostics.messages())


def test_where_too_many_would_come_of_it_nothing_is_cut(monkeypatch):
    monkeypatch.setattr("zraka.core.compile.strands._MOST_MORE", 38)
    diagnostics, curves = Diagnostics(), Curves([(0, 0, 0), (1, 0, 0)], [1 / 250 / 39.5] * 2, [2], name="Fur")
    assert geometry_of(curves, diagnostics=diagnostics).segment_count == 1
    assert "too long for their radius" in diagnostics.messages()[0]
    monkeypatch.setattr("zraka.core.compile.strands._MOST_MORE", 39)
    assert geometry_of(curves).segment_count == 40
