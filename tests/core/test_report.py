# SPDX-License-Identifier: GPL-3.0-or-later
"""The measure of errors against pictures whose error is known, and the text and plots made of it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from zraka.core.film import Step
from zraka.core.report import error
from zraka.core.report.forecast import Forecast
from zraka.core.report.plot import Curve, plot
from zraka.core.report.table import number, percent, table

SIZE = (48, 64, 3)


def gradient():
    """A picture from 0.2 to 2."""
    return np.broadcast_to(np.linspace(0.2, 2.0, SIZE[1])[:, None], SIZE)


def noisy(share, seed, count=4, mean=None):
    """Independent renders whose standard deviation is `share` of what they show."""
    mean = gradient() if mean is None else mean
    return mean * (1 + share * np.random.default_rng(seed).standard_normal((count, *SIZE)))


# -- one picture -------------------------------------------------------------------------------------------------------


def measured(share, reference_share, count=4, factor=1.0, **kwargs):
    """Root mean square over some pictures of the error that is found."""
    reference = noisy(reference_share, 1, count)
    weight = error.weights(gradient())
    found = [error.relative_rmse(factor * p, reference, weight, **kwargs) ** 2 for p in noisy(share, 2, 8)]
    return math.sqrt(np.mean(found))


def known(share):
    """What the definition says of gaussian noise, trim apart."""
    square = (gradient() ** 2).sum(axis=-1)
    return share * math.sqrt((square / (square + 0.01 * square.mean())).mean())


def test_error_of_known_noise():
    assert measured(0.1, 0.0, trim=0.0) == pytest.approx(known(0.1), rel=0.01)
    assert measured(0.1, 0.0) == pytest.approx(known(0.1), rel=0.02)


@pytest.mark.parametrize("reference", [0.05, 0.2])
def test_a_noisy_reference_does_not_lengthen_the_error(reference):
    assert measured(0.1, reference) == pytest.approx(known(0.1), rel=0.05)


def test_without_the_subtraction_it_would(monkeypatch):
    monkeypatch.setattr(error, "noise", lambda *args: 0.0)
    assert measured(0.1, 0.2) > 1.2 * known(0.1)


def test_a_bias_is_an_error():
    assert measured(0.0, 0.0, factor=1.05) == pytest.approx(known(0.05), rel=0.01)


def test_a_few_fireflies_do_not_decide():
    reference = noisy(0.01, 1)
    weight = error.weights(gradient())
    picture = noisy(0.1, 2, 1)[0]
    clean = error.relative_rmse(picture, reference, weight)
    picture[10, 10], picture[20, 30] = 500.0, 1000.0
    assert error.relative_rmse(picture, reference, weight) == pytest.approx(clean, rel=0.05)
    assert error.relative_rmse(picture, reference, weight, trim=0.0) > 5


def test_black_pixels_do_not_decide():
    mean = gradient().copy()
    mean[:, :8] = 0.0
    weight = error.weights(mean)
    assert np.isfinite(weight).all()
    reference = noisy(0.0, 1, mean=mean)
    assert error.relative_rmse(mean + 1e-3, reference, weight) < 0.01
    assert np.isfinite(error.weights(np.zeros(SIZE))).all()


def test_a_picture_within_the_references_noise_has_no_error():
    reference = noisy(0.2, 1)
    assert error.relative_rmse(reference.mean(axis=0), reference, error.weights(gradient())) == 0.0


# -- agreement ---------------------------------------------------------------------------------------------------------


def test_references_agree_or_are_told_apart():
    ours, theirs = noisy(0.05, 1), noisy(0.05, 2)
    assert error.agreement(ours, theirs) >= 0.99
    assert error.agreement(1.05 * ours, theirs) < 0.5
    assert error.power(ours, theirs) > 0.5


# -- error over samples and time ---------------------------------------------------------------------------------------

LADDER = (1, 2, 4, 8, 32)


def curve(a=0.5, start=0.2, each=0.05):
    return error.Convergence(LADDER, [0.4 * n**-a for n in LADDER], [start + each * n for n in LADDER])


def test_seconds_between_the_rungs_and_beyond():
    found = curve()
    assert found.slope == pytest.approx(0.5)
    samples, seconds, extrapolated = found.reach(0.1)
    assert (samples, seconds, extrapolated) == (pytest.approx(16), pytest.approx(0.2 + 16 * 0.05), False)
    assert found.reach(0.05) == (pytest.approx(64), pytest.approx(0.2 + 64 * 0.05), True)
    assert found.reach(0.5) == (1.0, pytest.approx(0.25), True)


def test_a_rung_itself_is_not_extrapolated():
    found = curve()
    for n in LADDER:
        samples, outside = found.samples_to(0.4 * n**-0.5)
        assert samples == pytest.approx(n)
        assert not outside or n in (LADDER[0], LADDER[-1])  # rounding


def test_the_slope_beyond_has_bounds():
    assert curve(a=0.75).reach(0.4 * 64**-0.75).samples == pytest.approx(64)
    assert curve(a=0.2).reach(0.4 * 32**-0.2 / 2).samples == pytest.approx(32 * 4)
    assert curve(a=1.5).reach(0.4 * 32**-1.5 / 2).samples == pytest.approx(32 * 2)


def test_a_slope_takes_two_rungs():
    with pytest.raises(ValueError, match="two rungs"):
        error.Convergence([4], [0.1], [1.0])
    with pytest.raises(ValueError, match="above 0"):
        error.Convergence([4, 8], [0.1, 0.0], [1.0, 2.0])


def test_lines():
    found = error.line([1, 2, 4, 8], [1.5, 2.5, 4.5, 8.5])
    assert found == (pytest.approx(0.5), pytest.approx(1.0), pytest.approx(1.0))
    through_zero = error.line([1, 2, 4], [0.5, 2.0, 4.5])
    assert through_zero.start == 0.0
    assert through_zero.each > 0
    falling = error.line([1, 2], [2.0, 1.0])
    assert falling.each > 0
    assert error.line([1, 2, 4], [1.0, 3.0, 2.0]).r2 < 0.9


def test_geometric_mean():
    assert error.geometric_mean([1.0, 4.0]) == pytest.approx(2.0)
    assert error.geometric_mean([None, 3.0]) == pytest.approx(3.0)
    assert error.geometric_mean([]) is None


# -- text and plots ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (1.2345, "1.23"),
        (123.4, "123"),
        (0.012345, "0.0123"),
        (-2.5, "-2.50"),
        (0.0, "0"),
        (10**6, "1000000"),
        (None, "–"),
        (math.inf, "–"),
        (math.nan, "–"),
        ("4.1*", "4.1*"),
    ],
)
def test_numbers(value, text):
    assert number(value) == text


def test_tables_stand_in_columns():
    lines = table(["scene", "s"], [["cornell", 1.5], ["a", 20.25]]).splitlines()
    assert lines == [
        "| scene   |    s |",
        "|---------|-----:|",
        "| cornell | 1.50 |",
        "| a       | 20.2 |",
    ]
    assert percent(0.123) == "12.3%"
    assert percent(None) == "–"


@pytest.mark.parametrize("log", [True, False])
def test_a_plot_is_a_png(tmp_path, log):
    pytest.importorskip("matplotlib")
    path = tmp_path / "curves.png"
    plot(path, [Curve("one", [1, 2, 4], [1, 2, 4]), Curve("two", [1, 2], [3, 1])], "Title", "x", "y", log)
    assert path.read_bytes().startswith(b"\x89PNG")


# -- what is to come ---------------------------------------------------------------------------------------------------


def forecast(a=0.5, samples=(1, 4, 16, 64), start=0.2, each=0.05):
    return Forecast([Step(n, start + each * n, math.inf if n == 1 else 0.4 * n**-a) for n in samples])


def test_a_forecast_carries_the_error_on():
    told = forecast()
    assert told.slope == pytest.approx(0.5)
    assert told.samples_to(0.4 / 16) == pytest.approx(256)
    assert told.seconds_to(0.4 / 16) == pytest.approx(0.2 + 0.05 * 256)
    assert told.error_at(0.2 + 0.05 * 256) == pytest.approx(0.4 / 16)


def test_a_forecast_believes_a_steep_slope_more_than_a_flat_one():
    assert forecast(a=0.8).slope == pytest.approx(0.74)
    assert forecast(a=0.3).slope == pytest.approx(0.43)
    assert forecast(a=-0.5).slope == 0.35
    assert forecast(samples=(1, 4)).slope == 0.5


def test_one_odd_step_does_not_turn_a_forecast():
    steps = [Step(n, 0.1 * n, 0.4 * n**-0.5 * (1.5 if n == 128 else 1)) for n in (16, 32, 64, 128, 256)]
    assert Forecast(steps).slope == pytest.approx(0.5, abs=0.03)


def test_a_forecast_of_nothing_is_unknown():
    for history in ([], [Step(1, 0.1, math.inf)]):
        told = Forecast(history)
        assert not told.is_known
        assert math.isnan(told.samples_to(0.1)) and math.isnan(told.error_at(3.0)) and math.isnan(told.seconds_to(0.1))
