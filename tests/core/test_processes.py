# SPDX-License-Identifier: GPL-3.0-or-later
"""Forked workers: the picture of threads, byte for byte, and an end that nobody notices."""

import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from multiprocessing import active_children
from pathlib import Path

import numpy as np
import pytest

from zraka.core import render as rendering
from zraka.core.bake import Bake, bake, points_of
from zraka.core.compile import compile_scene
from zraka.core.diagnostics import Diagnostics, SceneError
from zraka.core.render import render
from zraka.core.settings import Settings, can_fork

from .scenes import cornell

pytestmark = pytest.mark.skipif(not can_fork(), reason="this system cannot fork")

SIZE = 48


@pytest.fixture(autouse=True)
def always_worth_it(monkeypatch):
    monkeypatch.setattr(rendering, "_LANES_WORTH_FORKS", 0)
    monkeypatch.setattr(rendering, "_LANES_A_TRIANGLE", 0)
    yield
    assert not active_children()


def prepared(**settings):
    chosen = {"width": SIZE, "height": SIZE, "samples": 64, "threads": 2, "processes": True}
    settings = Settings(**(chosen | settings))
    return compile_scene(cornell(), settings, Diagnostics()), settings


def forks(monkeypatch):
    """A list that gets the worker count of every fork."""
    from zraka.core import processes

    made, begin = [], processes.Processes.__init__

    def watched(self, trace, count):
        made.append(count)
        begin(self, trace, count)

    monkeypatch.setattr(processes.Processes, "__init__", watched)
    return made


@pytest.mark.parametrize(
    "more",
    [
        {},
        {"threads": 5, "chunk": 3000},
        {"samples": 23},
        {"adaptive": True},
        {"method": "raytrace"},
        {"transparent_film": True, "exposure": 2.0, "pixel_errors": False},
    ],
    ids=str,
)
def test_pictures_are_those_of_threads(more, monkeypatch):
    made = forks(monkeypatch)
    compiled, settings = prepared(**more)
    apart = render(compiled, settings)
    together = render(compiled, replace(settings, processes=False))
    assert made == [settings.threads]
    assert apart.image().tobytes() == together.image().tobytes()
    assert apart.counts().tobytes() == together.counts().tobytes()
    assert apart.pixel_error().tobytes() == together.pixel_error().tobytes()
    assert [step.error for step in apart.history] == [step.error for step in together.history]
    assert apart.stats["rays"] == together.stats["rays"]
    assert apart.stats["embree_seconds"] > 0
    assert apart.stats["threads"] == settings.threads


@pytest.mark.parametrize("more", [{"threads": 1}, {"samples": 1}, {"processes": False}, {"time_limit": 0.5}], ids=str)
def test_threads_trace_where_forks_gain_nothing(more, monkeypatch):
    made = forks(monkeypatch)
    render(*prepared(**more))
    assert not made


def test_short_renders_are_not_forked(monkeypatch):
    monkeypatch.setattr(rendering, "_LANES_WORTH_FORKS", SIZE * SIZE * 64)
    made = forks(monkeypatch)
    render(*prepared(samples=63))
    assert not made
    render(*prepared(samples=64))
    assert made == [2]


def test_much_geometry_is_forked_later(monkeypatch):
    made = forks(monkeypatch)
    compiled, settings = prepared()
    monkeypatch.setattr(rendering, "_LANES_A_TRIANGLE", 1 + SIZE * SIZE * 64 // compiled.geometry.triangle_count)
    render(compiled, settings)
    assert not made


def test_moments_of_a_shutter(monkeypatch):
    from .test_shutter import bar_at, film_of, run

    made = forks(monkeypatch)
    apart, together = (film_of(run(bar_at), threads=2, processes=on) for on in (True, False))
    assert made == [2]
    assert apart.image().tobytes() == together.image().tobytes()


def test_baking(monkeypatch):
    made = forks(monkeypatch)
    found = []
    for on in (True, False):
        compiled, settings = prepared(width=1, height=1, processes=on)
        where = np.linspace(0.1, 0.4, 50)
        points, _ = points_of(compiled, 0, np.zeros(50, int), where, where, *np.zeros((2, 2, 50)))
        found.append(bake(compiled, points, Bake("diffuse", frozenset({"direct", "indirect", "color"})), settings)[0])
    assert made == [2]
    assert found[0].tobytes() == found[1].tobytes()
    assert found[0][:, :3].max() > 0.01


def test_cancel_ends_processes_at_once():
    compiled, settings = prepared(samples=1 << 20, width=256, height=256)
    started = time.perf_counter()
    shown, asked = [], []

    def cancelled():
        if shown and active_children():
            asked.append(time.perf_counter())
        return len(asked) > 3

    film = render(compiled, settings, on_pass=lambda film, progress: shown.append(progress), cancelled=cancelled)
    assert film.stats["stopped"] == "cancelled"
    assert film.counts().min() >= 1
    assert film.stats["rays"]["camera"] > film.counts().sum()  # what is given up was traced as well
    assert np.isfinite(film.image()).all()
    assert time.perf_counter() - asked[-1] < 10
    assert asked[-1] > started


def test_the_picture_is_shown_while_processes_trace(monkeypatch):
    monkeypatch.setattr(rendering, "_SHOW_EVERY", 0.0)
    compiled, settings = prepared(samples=128, width=96, height=96)
    seen = []
    film = render(compiled, settings, on_pass=lambda film, done: seen.append((done, float(film.image().mean()))))
    assert len(seen) > len(film.history)
    assert seen[-1][0] == 1.0
    assert seen[-1][1] == pytest.approx(seen[0][1], rel=0.1)


def test_an_exception_comes_back(monkeypatch):
    compiled, settings = prepared()
    here = os.getpid()

    def fails(self, where, radiance, samples):
        if os.getpid() != here:
            raise FloatingPointError("a defect")
        return add(self, where, radiance, samples)

    add = rendering.Film.add
    monkeypatch.setattr(rendering.Film, "add", fails)
    with pytest.raises(FloatingPointError, match="a defect"):
        render(compiled, settings)


def test_a_process_that_is_killed_is_said(monkeypatch):
    compiled, settings = prepared()
    here, kept = os.getpid(), []

    def dies(self, where, radiance, samples):
        if os.getpid() != here and samples[0]:
            with self._lock:  # which is then never given back
                os.kill(os.getpid(), signal.SIGKILL)
        return add(self, where, radiance, samples)

    add = rendering.Film.add
    monkeypatch.setattr(rendering.Film, "add", dies)
    with pytest.raises(SceneError, match="memory ran out"):
        render(compiled, settings, on_pass=lambda film, progress: kept.append(film))
    assert np.isfinite(kept[-1].image()).all()  # the samples so far can be read


@pytest.mark.parametrize("granted", [0, 1])
def test_where_a_fork_is_refused_threads_go_on(granted, monkeypatch):
    compiled, settings = prepared()
    expected = render(compiled, replace(settings, processes=False))
    fork, asked = os.fork, []

    def refused():
        asked.append(1)
        if len(asked) <= granted:
            return fork()
        raise OSError("no memory")

    monkeypatch.setattr(os, "fork", refused)
    assert render(compiled, settings).image().tobytes() == expected.image().tobytes()


_LONG = """
import multiprocessing, sys
from zraka.core.render import render
from zraka.tests.core.test_processes import prepared
def tell(film, progress):
    print(*(child.pid for child in multiprocessing.active_children()), flush=True)
render(*prepared(width=256, height=256, samples=1 << 20), on_pass=tell)
"""


def test_forks_end_with_a_parent_that_is_killed():
    with subprocess.Popen([sys.executable, "-c", _LONG], stdout=subprocess.PIPE, text=True) as parent:
        forks = [Path(f"/proc/{number}/stat") for number in parent.stdout.readline().split()]
        assert len(forks) == 2
        parent.kill()
    until = time.perf_counter() + 10
    while any(_runs(fork) for fork in forks) and time.perf_counter() < until:
        time.sleep(0.05)
    assert not any(_runs(fork) for fork in forks)


def _runs(stat):
    """Whether a process runs, which may have ended with nobody to ask how."""
    try:
        return stat.read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False
