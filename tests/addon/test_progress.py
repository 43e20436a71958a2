# SPDX-License-Identifier: GPL-3.0-or-later
"""What the status line says."""

import math

import pytest

from zraka.addon.progress import duration, progress_line
from zraka.core.film import Film, Step
from zraka.core.settings import Settings


def film(*steps, seconds=None):
    made = Film(2, 2)
    made.history = [Step(*step) for step in steps]
    made.samples = made.history[-1].samples if steps else 0
    made.stats = {"seconds": seconds or (made.history[-1].seconds if steps else 0.0)}
    if steps:
        made.stats["error"] = made.history[-1].error
    return made


def test_nothing_is_foretold_before_an_error_is_known():
    assert progress_line(film(), Settings()) == "Sample 0/128, error unknown"
    assert progress_line(film((1, 1.0, math.inf)), Settings()) == "Sample 1/128, error unknown"


def test_the_next_round_error_and_when():
    line = progress_line(film((4, 4.0, 0.08), (16, 16.0, 0.04)), Settings(samples=256))
    assert line == "Sample 16/256, error 4.00%, 2% in about 48 s"


def test_time_passes_within_a_pass():
    assert progress_line(film((16, 16.0, 0.04), seconds=40.0), Settings(samples=256)).endswith("2% in about 24 s")


def test_the_noise_target_is_what_is_waited_for():
    line = progress_line(film((4, 4.0, 0.08), (16, 16.0, 0.04)), Settings(samples=4096, noise_target=0.005))
    assert line.endswith("0.5% in about 17 min")


@pytest.mark.parametrize("settings", [{"samples": 36}, {"samples": 4096, "time_limit": 36.0}])
def test_an_end_that_comes_before(settings):
    line = progress_line(film((4, 4.0, 0.08), (16, 16.0, 0.04)), Settings(**settings))
    assert line.endswith("error 4.00%, about 2.7% at the end")


def test_the_end_itself_says_no_more():
    assert progress_line(film((64, 9.0, 0.02)), Settings(samples=64)) == "Sample 64/64, error 2.00%"


def test_durations_are_guesses():
    said = [duration(seconds) for seconds in (-3, 0.2, 41.3, 89.9, 125, 4000, 9000, 1e6)]
    assert said == ["about " + text for text in ("1 s", "1 s", "41 s", "90 s", "2.1 min", "67 min", "2.5 h", "280 h")]
