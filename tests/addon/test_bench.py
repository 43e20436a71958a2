# SPDX-License-Identifier: GPL-3.0-or-later
"""The benchmark: a small suite from end to end, what it writes, and how it ends."""

from __future__ import annotations

import json

import bpy
import numpy as np
import pytest

from zraka.addon import cli
from zraka.addon.bench import convergence, document, engines, full_size, scaling, scenes, suite, thesis
from zraka.core.diagnostics import SceneError

TINY = scenes.Plan(("cornell",), 6, (1, 2), 32, 2, 2, 6, (1, 2), (200,), (1, 3))


@pytest.fixture
def tiny(monkeypatch):
    """A plan of seconds; memory takes processes of its own and is left out."""
    monkeypatch.setitem(scenes.PLANS, "quick", TINY)
    monkeypatch.setattr(thesis, "FULL_HD", (96, 54))
    monkeypatch.setattr(thesis, "SAMPLES", 1)
    monkeypatch.setattr(thesis, "CASES", {"depth 1": ("room_open", 1, 1.09), "closed": ("room_closed", 2, 3.31)})
    nothing = {"peak_mb": None, "render_mb": None}
    monkeypatch.setattr(convergence, "peak_memory", lambda *args: nothing)
    monkeypatch.setattr(suite, "peak_memory", lambda *args: nothing)


def small(scene):
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 24, 16, 100
    return scene


# -- from end to end ---------------------------------------------------------------------------------------------------


def test_a_suite_is_measured_and_written(tiny, tmp_path, capsys):
    folder = tmp_path / "new" / "bench"
    assert cli.main(["bench", "--output", str(folder)]) == 0
    out, err = capsys.readouterr()
    assert "cornell" in out
    assert "geometric mean" in out
    assert "scene cornell" in err

    result = json.loads((folder / "bench.json").read_text())
    scene = result["scenes"]["cornell"]
    assert result["geometric_mean"] == pytest.approx(scene["ratios"]["5%"])
    assert not result["interrupted"]
    for side in ("zraka", "cycles"):
        rungs = scene[side]["rungs"]
        assert [r["samples"] for r in rungs] == [1, 2, 16]
        assert rungs[0]["error"] > rungs[-1]["error"] > 0
        assert all(r["seconds"] > 0 for r in rungs)
        assert scene[side]["seconds_to"]["2%"]["seconds"] >= scene[side]["seconds_to"]["5%"]["seconds"]
    assert 0 < scene["zraka"]["embree_share"] < 1
    assert scene["zraka"]["rays"]["camera"] == 30 * 30 * 16
    assert scene["references"]["brightness"] == pytest.approx(1.0, abs=0.15)
    assert set(result["studies"]) == {"memory", "materials", *full_size.STUDIES, *scaling.STUDIES, *thesis.STUDIES}

    rows = result["studies"]["thesis"]
    assert rows[0]["rays"] == 1.0  # depth 1 is ray casting
    assert rows[1]["rays"] > 1.5
    assert result["studies"]["raycast_over_embree"]["rays"] > 96 * 54
    text = (folder / "bench.md").read_text()
    for title in ("# Zraka beside Cycles", "samples at full size", "## Lights", "## The thesis' table", "over alone"):
        assert title in text
    assert not list(folder.glob("*.png")) or "error-cornell.png" in text


# -- how it ends -------------------------------------------------------------------------------------------------------


def test_what_was_measured_before_ctrl_c_is_written(tiny, tmp_path):
    asked = []

    def interrupted():
        asked.append(1)
        return "threads" in said

    said = []
    result = suite.run("quick", "ZRAKA", tmp_path, interrupted, lambda text: said.append(text.removeprefix("study ")))
    assert result["interrupted"]
    assert "threads" not in result["studies"]
    assert 0.1 < result["geometric_mean"] < 10  # against itself
    assert "Interrupted" in (tmp_path / "bench.md").read_text()
    assert "again" in json.loads((tmp_path / "bench.json").read_text())["scenes"]["cornell"]


def test_interrupted_at_once(tiny, tmp_path):
    result = suite.run("quick", "CYCLES", tmp_path, lambda: True)
    assert result["interrupted"]
    assert json.loads((tmp_path / "bench.json").read_text())["geometric_mean"] is None
    assert "–" in document.summary(result)


@pytest.mark.parametrize(
    ("args", "words"),
    [
        ((), "--output"),
        (("--suite", "long", "--output", "x"), "long"),
        (("--against", "EEVEE", "--output", "x"), "EEVEE"),
    ],
)
def test_bad_arguments(capsys, args, words):
    with pytest.raises(SystemExit) as stop:
        cli.main(["bench", *args])
    assert stop.value.code == 2
    error = capsys.readouterr().err
    assert words in error
    assert error.count("\n") == 1


def test_output_that_is_a_file(capsys, tmp_path):
    path = tmp_path / "taken"
    path.write_text("")
    assert cli.main(["bench", "--output", str(path)]) == 2
    assert "cannot be made" in capsys.readouterr().err


def test_outside_of_the_repository(monkeypatch, tmp_path):
    monkeypatch.setattr(scenes, "SAMPLES", tmp_path)
    with pytest.raises(SceneError, match="runs in Zraka's repository"):
        scenes.find("cornell", tmp_path)


# -- its parts ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", scenes.PLANS["quick"].scenes)
def test_sample_scenes_are_there(name, tmp_path):
    assert scenes.find(name, tmp_path).is_file()


def test_the_reference_is_long_enough():
    for plan in scenes.PLANS.values():
        assert plan.reference >= 16 * plan.ladder[-1]
        assert plan.reference % plan.reference_runs == 0
        assert plan.reference_runs >= 2


@pytest.mark.parametrize("count", [200, 5000])
def test_hills_have_their_triangles(count):
    scenes.terrain(count)
    hills = bpy.data.objects["Hills"].data
    assert not hills.validate()
    assert 2 * len(hills.polygons) == pytest.approx(count, rel=0.1)


@pytest.mark.parametrize("name", ["lamps", "sky", "terrain"])
def test_made_scenes_render_in_both_engines(name):
    scene = small(
        {"terrain": lambda: scenes.terrain(200), "lamps": lambda: scenes.lamps(20), "sky": scenes.sky}[name]()
    )
    for engine in ("ZRAKA", "CYCLES"):
        assert engines.picture(scene, engine, 2, seed=1).mean() > 0.01


def test_what_zraka_does_not_support_is_left_out_of_the_mean():
    ratios = {"ratios": {"5%": 2.0}}
    assert convergence.overall({"a": ratios, "b": {"ratios": {"5%": 9.0}, "not_supported": ["sky"]}}, "5%") == 2.0


def test_all_stages_give_the_same_picture():
    from zraka.core.compile.features import Feature

    scene = small(scenes.lamps(3))
    runs = []
    for force in (None, Feature.all()):
        bench = engines.Bench({"zraka": "ZRAKA"}, 1)  # a fresh one has the same seeds
        runs.append(bench.run(scene, "zraka", 2, force_features=force).picture)
    np.testing.assert_array_equal(*runs)


def test_runs_have_seeds_of_their_own():
    scene = small(scenes.lamps(3))
    bench = engines.Bench({"zraka": "ZRAKA", "cycles": "CYCLES"}, 1)
    for side in bench.sides:
        first, second = (bench.run(scene, side, 1).picture for _ in range(2))
        assert not np.array_equal(first, second)


def test_cycles_is_set_alike():
    scene = small(scenes.lamps(1))
    scene.zraka.depth, scene.zraka.samples, scene.zraka.seed = 3, 7, 5
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = True
    engines.match(scene)
    cycles = scene.cycles
    assert (cycles.max_bounces, cycles.samples, cycles.seed) == (2, 7, 5)
    assert not (cycles.use_denoising or cycles.use_adaptive_sampling)
    assert (cycles.pixel_filter_type, cycles.filter_width) == ("BOX", 1.0)


def test_the_watch_leaves_everything_as_it_was():
    from zraka.addon import session
    from zraka.core import compile as compiling
    from zraka.core import render as rendering

    before = session.export_job, compiling.compile_scene, rendering.render
    with pytest.raises(RuntimeError, match="no"), engines.watched():
        assert session.export_job is not before[0]
        raise RuntimeError("no")
    assert (session.export_job, compiling.compile_scene, rendering.render) == before
