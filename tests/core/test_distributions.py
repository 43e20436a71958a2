# SPDX-License-Identifier: GPL-3.0-or-later
"""Choice from a finite set, and the weights of two techniques."""

import numpy as np
import pytest
from scipy import stats

from zraka.core.arena import Arena
from zraka.core.sampling import mis
from zraka.core.sampling.distributions import DiscreteDistribution, Distribution2D

WEIGHTS = [
    [1.0],
    [1.0, 1.0],
    [0.0, 3.0, 0.0, 1.0, 0.0],
    [1e-30, 1e30, 2e30],
    np.linspace(0.0, 1.0, 1000) ** 4,
]


def chi_square_p(weights, count=400_000, probabilities=None):
    """p-value of the counts of indices against `probabilities`, by default the ones wanted."""
    u = np.random.default_rng(5).random(count, np.float32)
    index = DiscreteDistribution(weights).sample(u, Arena()).index
    observed = np.bincount(index, minlength=len(weights))
    expected = np.asarray(weights) / np.sum(weights) if probabilities is None else np.asarray(probabilities)
    expected = expected * count
    often = expected > 20.0
    observed = np.append(observed[often], observed[~often].sum())
    expected = np.append(expected[often], expected[~often].sum())
    cells = expected > 0.0
    return stats.chisquare(observed[cells], expected[cells]).pvalue if cells.sum() > 1 else 1.0


@pytest.mark.parametrize("weights", WEIGHTS, ids=len)
def test_frequencies_are_the_weights(weights):
    assert chi_square_p(weights) > 1e-3


def test_frequencies_can_be_wrong():
    weights = np.arange(1.0, 21.0)
    skewed = weights.copy()
    skewed[3] *= 1.05
    assert chi_square_p(weights, probabilities=skewed / skewed.sum()) < 1e-3


@pytest.mark.parametrize("weights", WEIGHTS, ids=len)
def test_pmf(weights):
    distribution = DiscreteDistribution(weights)
    u = np.random.default_rng(6).random(10_000, np.float32)
    choice = distribution.sample(u, Arena())
    assert distribution.pmf.sum(dtype=np.float64) == pytest.approx(1.0, abs=1e-5)
    assert np.array_equal(choice.pmf, distribution.pmf[choice.index])
    assert (choice.pmf > 0).all()  # what has no weight is never chosen


def test_what_is_left_of_the_number_is_uniform():
    u = np.random.default_rng(7).random(100_000, np.float32)
    choice = DiscreteDistribution([1.0, 5.0, 2.5]).sample(u, Arena())
    assert choice.u.min() >= 0.0 and choice.u.max() < 1.0
    for i in range(3):
        assert stats.kstest(choice.u[choice.index == i], "uniform").pvalue > 1e-3


@pytest.mark.parametrize("size", [1, 3, 1000, 100_003])
def test_ends_of_the_interval(size):
    u = np.array([0.0, np.nextafter(np.float32(1), np.float32(0)), 0.5], np.float32)
    choice = DiscreteDistribution(np.ones(size)).sample(u, Arena())
    assert choice.index.min() >= 0 and choice.index.max() < size


@pytest.mark.parametrize("weights", [[], [0.0, 0.0], [1.0, -1.0], [1.0, np.inf], [np.nan]])
def test_nothing_to_choose_from(weights):
    with pytest.raises(ValueError, match="distribution"):
        DiscreteDistribution(weights)


def grid(rows=7, columns=300):
    """Weights of all orders, a black row and many black cells."""
    weights = np.random.default_rng(9).random((rows, columns)) ** 20
    weights[2], weights[3, 10:200] = 0.0, 0.0
    return weights


def cells_p(weights, factor=1.0, count=400_000):
    """p-value of the cells drawn against the probabilities, one of them times `factor`."""
    distribution = Distribution2D(weights)
    row, column, _, _ = distribution.sample(*np.random.default_rng(10).random((2, count), np.float32), Arena())
    observed = np.bincount(row * weights.shape[1] + column, minlength=weights.size)
    expected = distribution.pmf.astype(np.float64).ravel()
    assert not observed[expected == 0].any()
    expected[np.argmax(expected)] *= factor
    often = expected * count > 20.0
    observed = np.append(observed[often], observed[~often].sum())
    expected = np.append(expected[often], expected[~often].sum()) * count
    return stats.chisquare(observed, expected * count / expected.sum()).pvalue


def test_cells_are_drawn_by_their_weights():
    assert cells_p(grid()) > 1e-3
    assert cells_p(grid(), 1.2) < 1e-3


def test_probabilities_of_cells():
    weights = grid()
    pmf = Distribution2D(weights).pmf.astype(np.float64)
    assert pmf.sum() == pytest.approx(1.0, abs=1e-6)
    np.testing.assert_allclose(pmf, weights / weights.sum(), atol=2e-7)


def test_places_in_cells_are_uniform_and_ordered():
    u = np.random.default_rng(11).random((2, 100_000), np.float32)
    row, column, y, x = Distribution2D(grid()).sample(*u, Arena())
    for place in (x, y):
        assert place.min() >= 0.0 and place.max() < 1.0
    assert stats.kstest(y, "uniform").pvalue > 1e-3
    by_row = np.argsort(u[0])
    assert (np.diff(row[by_row] + y[by_row].astype(np.float64)) >= 0).all()
    own = row == row[0]
    by_column = np.argsort(u[1][own])
    assert (np.diff((column + x.astype(np.float64))[own][by_column]) >= 0).all()


@pytest.mark.parametrize("shape", [(1, 1), (1, 5), (512, 1024)])
def test_ends_of_both_intervals(shape):
    u = np.array([0.0, np.nextafter(np.float32(1), np.float32(0))], np.float32)
    row, column, _, _ = Distribution2D(np.ones(shape)).sample(u, u, Arena())
    assert row.tolist() == [0, shape[0] - 1] and column.tolist() == [0, shape[1] - 1]


@pytest.mark.parametrize("weights", [[[0.0]], [[1.0, -1.0]], [[np.inf, 1.0]], [[np.nan]]])
def test_nothing_to_choose_cells_from(weights):
    with pytest.raises(ValueError, match="distribution"):
        Distribution2D(weights)


def test_power_heuristic_where_the_textbook_form_is_nan():
    pairs = [(1, 1), (3, 1), (0, 1), (1, 0), (0, 0), (np.inf, 2), (np.inf, 0), (np.inf, np.inf), (2, np.inf)]
    pairs += [(3e19, 3e19), (1e-24, 1e-24), (1e-24, 2e-24), (3e38, 1e-38), (np.inf, 3e38)]
    pa, pb = np.array(pairs, np.float32).T
    expected = [0.5, 0.9, 0, 1, 0, 1, 1, 1, 0, 0.5, 0.5, 0.2, 1, 1]
    result = mis.weight(np.ascontiguousarray(pa), np.ascontiguousarray(pb), Arena())
    assert result.dtype == np.float32
    np.testing.assert_allclose(result, expected, atol=1e-12, rtol=1e-6)


def test_two_weights_add_to_one():
    rng = np.random.default_rng(8)
    pa, pb = (10.0 ** rng.uniform(-20, 20, (2, 1000))).astype(np.float32)
    arena = Arena()
    np.testing.assert_allclose(mis.weight(pa, pb, arena) + mis.weight(pb, pa, arena), 1.0, rtol=1e-6)
