# SPDX-License-Identifier: GPL-3.0-or-later
"""Error over time in Blender: the chart, the panel's words, the image, the page, and what an animation leaves."""

from __future__ import annotations

import csv
import math
import xml.etree.ElementTree
from itertools import pairwise
from types import SimpleNamespace

import bpy
import numpy as np
import pytest

from zraka.addon import error_curve, headless, progress, session, ui
from zraka.addon.monitor import KEPT, Monitor, Record, Shot, error_picture, monitor
from zraka.addon.report import latest, raster
from zraka.addon.report.chart import Line, Text, error_chart
from zraka.addon.report.svg import svg
from zraka.core.diagnostics import SceneError
from zraka.core.film import Film, Step
from zraka.core.settings import Settings

COUNTS = (4, 16, 64, 256)


def record(counts=COUNTS, settings=None, first=0.4, slope=0.5, **stats):
    """One whose error falls by a power law from 4 samples on; a sample takes a tenth of a second."""
    history = tuple(Step(n, 0.1 * n, first * (n / 4) ** -slope) for n in counts)
    known = {"seconds": history[-1].seconds, "error": history[-1].error} if history else {"seconds": 0.0}
    known |= {"rays": {"camera": 1000}, "threads": 2, **stats}
    samples = history[-1].samples if history else 0
    return Record(Shot("Scene", 1), "ViewLayer", settings or Settings(samples=1024), history, samples, known)


def noisy_film(samples=16, width=16, height=12):
    """Its right half is noise, its left half has none."""
    film, rng = Film(width, height), np.random.default_rng(3)
    noise = np.tile(np.arange(width) >= width // 2, height)
    for sample in range(samples):
        film.add(
            slice(None), np.float32(1 + noise * rng.normal(0, 0.3, (3, width * height))).astype(np.float32), [sample]
        )
    film.samples = samples
    film.history = [Step(samples, 1.0, film.error())]
    film.stats = {"seconds": 1.0, "error": film.history[-1].error, "rays": {}, "stopped": "samples", "threads": 1}
    return film


def lines_of(chart, role):
    return [line for line in chart.lines if line.role == role]


# -- chart -------------------------------------------------------------------------------------------------------------


def test_a_power_law_is_a_line_and_the_root_law_lies_on_it():
    chart = error_chart(record(stopped="samples"))
    curve, *dots = lines_of(chart, "curve")
    assert len(dots) == len(COUNTS) == len(curve.points)
    np.testing.assert_allclose(np.diff(curve.points, 2, axis=0), 0, atol=1e-6)
    (root,) = lines_of(chart, "root")
    slopes = [np.divide(*(line.points[-1] - line.points[0])[::-1]) for line in (curve, root)]
    assert slopes[0] == pytest.approx(slopes[1])
    assert slopes[0] > 0  # downwards, in pixels from the top
    steeper = lines_of(error_chart(record(slope=0.7, stopped="samples")), "curve")[0].points
    (root,) = lines_of(error_chart(record(slope=0.7, stopped="samples")), "root")
    assert np.interp(steeper[-1, 0], *root.points.T) < steeper[-1, 1]


def test_the_forecast_goes_on_to_the_target():
    chart = error_chart(record(settings=Settings(samples=1 << 20, noise_target=0.02)))
    (ahead,), (target,) = lines_of(chart, "forecast"), lines_of(chart, "target")
    assert ahead.dashed
    np.testing.assert_allclose(ahead.points[0], lines_of(chart, "curve")[0].points[-1])
    assert ahead.points[-1, 1] == pytest.approx(target.points[0, 1])
    assert np.ptp(target.points[:, 1]) == 0
    assert "forecast" in {text.text for text in chart.texts}


@pytest.mark.parametrize(
    ("settings", "end"), [({"samples": 1024}, 102.4), ({"samples": 4096, "time_limit": 50.0}, 50.0)]
)
def test_the_forecast_ends_with_the_render(settings, end):
    chart = error_chart(record(settings=Settings(**settings)))
    (ahead,), curve = lines_of(chart, "forecast"), lines_of(chart, "curve")[0].points
    a_decade = (curve[-1, 0] - curve[0, 0]) / math.log10(64)
    assert (ahead.points[-1, 0] - curve[-1, 0]) / a_decade == pytest.approx(math.log10(end / 25.6), abs=1e-6)
    assert not lines_of(error_chart(record(stopped="samples")), "forecast")


def test_all_stays_within_the_picture():
    before = record(first=4.0)
    for size in ((640, 360), (320, 200)):
        chart = error_chart(
            record(settings=Settings(samples=1 << 30, noise_target=1e-4, time_limit=60.0)), before, *size
        )
        points = np.concatenate([line.points for line in chart.lines])
        assert (points >= 0).all()
        assert (points <= size).all()
        assert all(0 <= text.x <= size[0] and 0 <= text.y <= size[1] for text in chart.texts)
        assert lines_of(chart, "before")


def test_what_has_no_curve():
    assert error_chart(record(())) is None
    assert error_chart(Record(Shot("Scene"), history=(Step(1, 0.1, math.inf), Step(2, 0.2, 0.0)))) is None
    alone = error_chart(record((4,)))
    assert len(lines_of(alone, "curve")) == 2  # the line of one point, and its dot


def test_lines_and_letters_are_drawn_where_they_belong():
    picture = raster.paper(60, 40)
    raster.draw(picture, SimpleNamespace(lines=[Line(np.array([[10.0, 20.5], [50.0, 20.5]]), "target", 3.0)], texts=[]))
    drawn = np.abs(picture[..., :3] - raster.DARK["paper"]).max(axis=-1) > 0.05
    assert drawn[19:22, 12:48].all()
    assert not drawn[:17].any()
    assert not drawn[25:].any()
    np.testing.assert_allclose(picture[20, 30, :3], raster.DARK["target"], atol=1e-6)
    dashed = raster.paper(60, 40)
    raster.draw(
        dashed, SimpleNamespace(lines=[Line(np.array([[0.0, 20.5], [60.0, 20.5]]), "target", 1.0, True)], texts=[])
    )
    share = (np.abs(dashed[20, :, :3] - raster.DARK["paper"]).max(axis=-1) > 0.2).mean()
    assert 0.4 < share < 0.8
    raster.write(picture, Text(100.0, 5.0, "left out"))
    raster.write(picture, Text(40.0, 38.0, "cut", anchor="end"))
    assert picture[28:, :40].max() > 0.5


def test_the_same_as_svg():
    chart = error_chart(record(), record(first=0.8))
    found = xml.etree.ElementTree.fromstring(svg(chart))
    assert len(found) == len(chart.lines) + len(chart.texts)


# -- words -------------------------------------------------------------------------------------------------------------


def test_when_errors_were_and_will_be_reached():
    found = {error: (seconds, foretold) for error, seconds, foretold in progress.reaches(record())}
    assert found[0.1] == (pytest.approx(6.4), False)
    assert found[0.05] == (pytest.approx(25.6), False)
    assert found[0.02] == (pytest.approx(0.1 * 4 * 20**2), True)
    assert progress.reaches_text(record()) == [
        "10% after 6.4 s",
        "5% after 25.6 s",
        "2% in about 2.2 min",
        "1% in about 10 min",
    ]
    assert progress.reaches_text(record(stopped="samples"))[-1] == "1% would take about 11 min"
    assert progress.reaches(record(())) == []


def test_reached_before_anything_was_known_is_left_out():
    assert [error for error, *_ in progress.reaches(record(first=0.04))] == [0.02, 0.01]


def test_steps_are_thinned_from_the_last():
    steps = [Step(n, n, 1 / n) for n in (1, 4, 16, 64, 80, 96, 112, 128)]
    kept = [step.samples for step in progress.thinned(steps)]
    assert kept[-1] == 128
    assert all(b >= 1.4 * a for a, b in pairwise(kept))
    assert {1, 4, 16} <= set(kept)


def test_the_file_is_told_the_same():
    fields = progress.stamp(record(stopped="noise"), Settings())
    assert fields["stopped"] == "noise"
    assert fields["error_over_time"].startswith("4 samples 0.4 s 40.00%; 16 samples")
    assert fields["seconds_to_error"].endswith("(foretold)")
    assert "error_over_time" not in progress.stamp(record(()), Settings())


def test_the_panels_words():
    running = error_curve.sentences(record(settings=Settings(samples=1 << 14, noise_target=0.01, time_limit=900.0)))
    assert running[0].startswith("Path Tracing, ")
    assert running[1] == "Error 5.00% after 25.60 s"
    assert running[2].startswith("1% in about ")
    assert len(set(running)) == len(running)
    assert running[3] == "Ends below 1% or at 16384 samples or after 900 s"
    for stopped in ("samples", "noise", "time", "cancelled"):
        assert "Ended by" in error_curve.sentences(record(stopped=stopped))[2]
    assert error_curve.table(record())[1] == ("4", "0.40", "40.00%")
    assert error_curve.sentences(record(()))[1] == "Error unknown after 0.00 s"


# -- what is remembered ------------------------------------------------------------------------------------------------


def test_the_latest_renders_of_each_scene():
    kept, film = Monitor(), noisy_film()
    assert kept.latest("A") is None
    for place in ("first", "second", "third"):
        kept.begin(Shot("A"), place, Settings())
    kept.begin(Shot("B"), "other", Settings())
    assert (kept.latest("A").place, kept.before("A").place, kept.before("B")) == ("third", "second", None)
    assert KEPT == 2
    changes = kept.changes
    kept.note(Shot("A"), film)
    assert kept.changes > changes
    assert kept.latest("A").history == tuple(film.history)
    kept.end(Shot("A"), film, ["said"])
    assert kept.latest("A").is_done
    assert kept.latest("A").where.shape == (12, 16)
    kept.end(Shot("B"), None, [])  # a render that failed
    assert kept.latest("B").stats["stopped"] == "cancelled"
    kept.forget()
    kept.note(Shot("A"), film)
    kept.end(Shot("A"), film, [])
    assert kept.latest("A") is None


def test_where_the_error_is():
    where = error_picture(noisy_film())
    assert where[:, :5].max() < 1e-3  # beyond the reach of the neighbours' noise
    assert np.median(where[:, 10:]) == pytest.approx(
        0.3 / math.sqrt(16) * math.sqrt(0.2126**2 + 0.7152**2 + 0.0722**2), rel=0.3
    )
    empty = Film(2, 2)
    assert error_picture(empty) is None


# -- in Blender --------------------------------------------------------------------------------------------------------


@pytest.fixture
def noisy_scene(blender_scene, add_camera):
    """A floor under a lamp with an extent."""
    monitor.forget()
    add_camera(blender_scene)
    bpy.ops.mesh.primitive_plane_add(size=20)
    lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "AREA"))
    lamp.location.z = 1.0
    blender_scene.collection.objects.link(lamp)
    blender_scene.zraka.samples = 8
    return blender_scene


def rendered(scene, **kwargs):
    with headless.quiet():
        bpy.ops.render.render(**kwargs)
    return monitor.latest(scene.name)


def test_errors_of_all_pixels_are_kept_for_the_pass_that_shows_them(noisy_scene):
    assert not rendered(noisy_scene).settings.pixel_errors
    noisy_scene.view_layers[0].zraka.use_pass_error = True
    assert rendered(noisy_scene).settings.pixel_errors


def test_a_large_picture_without_errors_of_all_pixels_shows_where_they_are():
    every, some = Film(560, 500), Film(560, 500, pixel_errors=False)
    assert some.error_step == 2
    rng = np.random.default_rng(2)
    for film in (every, some):
        film.history.append(Step(2, 1.0, 0.1))
    for number in range(2):
        sample = rng.random((3, 280000), np.float32)
        for film in (every, some):
            film.add(slice(0, 280000), sample.copy(), (number,))
    assert error_picture(every).shape == (167, 187)
    assert error_picture(some).shape == (125, 140)


def test_a_render_is_shown_and_kept(noisy_scene, tmp_path):
    assert not bpy.ops.zraka.error_curve.poll()
    assert not bpy.ops.zraka.error_report.poll()
    first, found = rendered(noisy_scene), rendered(noisy_scene)
    assert monitor.before(noisy_scene.name) is first
    assert (found.samples, found.is_done, found.place) == (8, True, noisy_scene.view_layers[0].name)
    assert found.where.shape == (24, 32)
    assert found.history[-1].error == pytest.approx(found.stats["error"])
    assert bpy.ops.zraka.error_curve() == {"FINISHED"}
    image = bpy.data.images[error_curve.IMAGE]
    pixels = np.zeros(len(image.pixels), np.float32)
    image.pixels.foreach_get(pixels)
    shown = pixels.reshape(image.size[1], image.size[0], 4)[::-1]
    np.testing.assert_allclose(shown, error_curve.error_sheet(found, first), atol=1 / 255)
    assert image.packed_file is not None
    assert bpy.ops.zraka.error_curve() == {"FINISHED"}  # into the same image
    assert error_curve.look() == error_curve.LOOK_EVERY

    noisy_scene.render.image_settings.file_format = "OPEN_EXR"
    noisy_scene.render.image_settings.color_depth = "32"
    with headless.quiet():
        assert bpy.ops.zraka.error_report(filepath=str(tmp_path / "report")) == {"FINISHED"}
    kind = noisy_scene.render.image_settings
    assert (kind.file_format, kind.color_depth) == ("OPEN_EXR", "32")
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    for part in ("<svg", "data:image/jpeg", "data:image/png", "Where it errs", "Noise target", "Processor", "None."):
        assert part in page
    assert "http" not in page.replace("http://www.w3.org/2000/svg", "")  # all is in the file
    monitor.forget()
    assert not bpy.ops.zraka.error_report.poll()


def test_a_page_that_cannot_be_written(noisy_scene, tmp_path):
    found = rendered(noisy_scene)
    (tmp_path / "file").write_text("")
    with pytest.raises(SceneError, match="cannot be made"):
        latest.write_report(tmp_path / "file" / "report.html", noisy_scene, found)


def test_frames_have_a_table(noisy_scene, tmp_path):
    scene = noisy_scene
    scene.zraka.samples, scene.frame_start, scene.frame_end = 4, 2, 3
    scene.render.filepath = f"{tmp_path}/a_"
    found = rendered(scene, write_still=True)
    assert found.shot.table is None
    scene.zraka.use_error_table = False
    rendered(scene, animation=True)
    assert not list(tmp_path.glob("*.csv"))
    scene.zraka.use_error_table = True
    found = rendered(scene, animation=True)
    assert found.where is None  # which would take time at each frame
    with (tmp_path / "a_error.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [(row["frame"], row["samples"], row["stopped"]) for row in rows] == [
        ("2", "4", "samples"),
        ("3", "4", "samples"),
    ]
    assert float(rows[1]["error"]) == pytest.approx(found.stats["error"], rel=1e-4)


def test_previews_are_not_remembered():
    assert session.shot_of(SimpleNamespace(is_preview=True), None) is None


def test_a_file_that_is_loaded_forgets(noisy_scene):
    rendered(noisy_scene)
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    assert monitor.latest("Scene") is None


def test_the_icon_is_drawn(noisy_scene):
    icon = ui.curve.error_icon(record())
    assert isinstance(icon, int)  # 0 without a window
    assert ui.curve.error_icon(record(())) == 0
    ui.curve.forget()


def test_png_is_read_as_it_was_written(tmp_path):
    picture = np.random.default_rng(1).integers(0, 256, (5, 7, 3)).astype(np.uint8)
    path = tmp_path / "a.png"
    path.write_bytes(latest.png(picture))
    image = bpy.data.images.load(str(path))
    pixels = np.zeros(5 * 7 * 4, np.float32)
    image.pixels.foreach_get(pixels)
    np.testing.assert_array_equal(np.round(255 * pixels.reshape(5, 7, 4)[::-1, :, :3]), picture)


def test_heat():
    np.testing.assert_array_equal(latest.heat(np.float32([[0.0, 1.0, 3.0, 9.0]]), 3.0)[0, :, 0], [0, 255, 255, 255])
    np.testing.assert_array_equal(latest.heat(np.float32([[0.0, 1.0, 3.0]]), 3.0)[0, :, 2], [0, 0, 255])
