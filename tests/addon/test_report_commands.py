# SPDX-License-Identifier: GPL-3.0-or-later
"""``zraka converge``, ``compare`` and ``thesis``: from end to end on tiny pictures, what they write, how they end."""

from __future__ import annotations

import csv
import re
from html import unescape
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest

from zraka.addon import cli
from zraka.addon.report import converge, display, glyphs, measure, text, thesis, thesis_document
from zraka.addon.report.sheet import contact_sheet
from zraka.core.report import metrics
from zraka.core.report.table import number

SAMPLES = Path(__file__).resolve().parents[2] / "sample_blends"
CORNELL = SAMPLES / "cornell.blend"
SMALL = ("--size", "24x24", "--threads", "1")


def refused(capsys, *args):
    """Arguments that are refused in one line, which is returned."""
    try:
        code = cli.main([str(arg) for arg in args])
    except SystemExit as stop:
        code = stop.code
    out, err = capsys.readouterr()
    assert (code, out, err.count("\n")) == (2, "", 1)
    return err


# -- arguments ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (("converge",), "required"),
        (("converge", CORNELL), "--output"),
        (("converge", CORNELL, "--output", "x", "--methods", "magic"), "unknown method 'magic'"),
        (("converge", CORNELL, "--output", "x", "--against", "EEVEE"), "EEVEE"),
        (("converge", CORNELL, "--output", "x", "--time-limit", "soon"), "not a number of seconds"),
        (("converge", CORNELL, "--output", "x", "--reference-samples", "1"), "not between 8"),
        (
            ("converge", CORNELL, "--output", "x", "--reference-samples", "9", "--reference", "y.exr"),
            "not allowed with",
        ),
        (("converge", "none.blend", "--output", "x"), "no such file: none.blend"),
        (("compare", "none.blend", "--output", "x"), "no such file: none.blend"),
        (("compare", CORNELL, "--output", "sheet.jpg"), "ends in .png"),
        (("compare", CORNELL, "--output", "nowhere/sheet.png"), "there is no folder"),
        (("thesis", "--output", "x", "--experiment", "4.9"), "4.9"),
    ],
)
def test_bad_arguments(capsys, tmp_path, monkeypatch, args, words):
    monkeypatch.chdir(tmp_path)
    assert words in refused(capsys, *args)
    assert not list(tmp_path.iterdir())


def test_a_reference_must_fit(capsys, tmp_path):
    wrong, path = tmp_path / "wrong.exr", tmp_path / "small.png"
    wrong.write_text("no picture")
    display.write(np.zeros((4, 6, 3), np.uint8), path)
    args = ("converge", CORNELL, "--output", tmp_path / "out", *SMALL)
    assert "wrong.exr is no picture" in refused(capsys, *args, "--reference", wrong)
    assert "none.exr is no picture" in refused(capsys, *args, "--reference", tmp_path / "none.exr")
    assert "6 × 4 pixels and the scene 24 × 24" in refused(capsys, *args, "--reference", path)


# -- converge ----------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """A report of a small Cornell box, and what was measured."""
    folder = tmp_path_factory.mktemp("report") / "new"
    plan = measure.Plan(("raycast", "pathtrace"), reference_samples=256, time_limit=0.0, size=(24, 24), threads=1)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(measure._Measurement, "_most_samples", lambda self: 32)
        measured = converge.converge(CORNELL, plan, folder)
    return folder, measured


def test_ray_casting_is_flat_and_path_tracing_falls(report):
    _, measured = report
    cast, traced = measured.rungs["raycast"], measured.rungs["pathtrace"]
    assert [r.samples for r in cast] == [1, 4, 16]
    assert [r.samples for r in traced][:5] == [1, 2, 4, 8, 16]
    assert cast[0].error == pytest.approx(cast[-1].error, rel=0.15)
    assert cast[-1].bias > 0.8 * cast[-1].error  # what is wrong about it is bias
    assert traced[0].error > 4 * traced[-1].error
    assert all(r.bias < 0.3 * r.noise for r in traced[:5])
    slope = np.polyfit(np.log([r.samples for r in traced]), np.log([r.error for r in traced]), 1)[0]
    assert -0.9 < slope < -0.45
    assert measured.convergence("raycast") is None
    assert measured.convergence("pathtrace").slope > 0.4


def test_noise_is_told_from_the_error_against_the_reference(report):
    """Of path tracing the error is noise: two ways to measure it agree."""
    for rung in report[1].rungs["pathtrace"][2:5]:
        assert rung.noise == pytest.approx(rung.error, rel=0.2)


def test_the_report_says_where_path_tracing_passes_below(report):
    sentence = text.findings(report[1])[0]
    assert re.match(r"Ray casting stays at \d+\.\d% of error: .* path tracing passes below it after [\d.]+ s", sentence)


def test_the_csv_and_the_page_hold_the_same_numbers(report):
    folder, measured = report
    with (folder / "error-vs-time.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == sum(map(len, measured.rungs.values()))
    html = (folder / "report.html").read_text(encoding="utf-8")
    body = html[html.index("All that was measured") :]
    cells = [re.findall(r"<td>(.*?)</td>", line) for line in re.findall(r"<tr>(.*?)</tr>", body)[1:]]
    for row, shown in zip(rows, cells, strict=True):
        assert [unescape(cell) for cell in shown[:4]] == [
            measure.NAMES[row["method"]],
            row["samples"],
            number(float(row["seconds"])),
            number(100 * float(row["error"])),
        ]
    assert [float(row["error"]) for row in rows] == [rung.error for rung in text.all_rungs(measured)]


def test_the_page_stands_alone(report):
    folder, _ = report
    html = (folder / "report.html").read_text(encoding="utf-8")
    sources = re.findall(r'src="([^"]*)"', html)
    assert len(sources) >= 5  # a reference, two pictures and where they err
    assert all(source.startswith("data:image/") for source in sources)
    assert "http" not in re.sub(r'src="[^"]*"', "", html)
    for words in ("Processor", "left out: ", "Noise of the reference", "s to 5%", "Diagnostics"):
        assert words in html


def test_the_plot_is_drawn(report):
    pytest.importorskip("matplotlib")
    folder, _ = report
    assert (folder / "error-vs-time.png").stat().st_size > 10_000
    svg = (folder / "error-vs-time.svg").read_text(encoding="utf-8")
    assert "data:image/svg+xml" in (folder / "report.html").read_text(encoding="utf-8")
    assert svg.startswith("<?xml")


def test_without_matplotlib_all_else_is_written(report, monkeypatch, tmp_path):
    def missing(*args, **kwargs):
        raise ImportError("No module named 'matplotlib'")

    monkeypatch.setattr(converge, "plot", missing)
    said = []
    assert not converge._draw(report[1], tmp_path, said.append)
    assert said == ["no plot: matplotlib is missing; pip install 'zraka[bench]'"]


def test_several_files_a_file_as_reference_and_an_index(tmp_path, capsys, report):
    truth = tmp_path / "truth.exr"
    image = oiio.ImageBuf(np.ascontiguousarray(report[1].references["zraka"].mean(axis=0), np.float32))
    assert image.write(str(truth))
    args = ("--methods", "pathtrace", "--reference", truth, "--time-limit", "0.3", *SMALL, "--output", tmp_path / "out")
    other = SAMPLES / "room_open.blend"
    assert cli.main([str(a) for a in ("converge", CORNELL, other, *args)]) == 0
    assert "cornell, 24 × 24" in capsys.readouterr().out
    index = (tmp_path / "out" / "index.html").read_text(encoding="utf-8")
    assert 'href="room_open/report.html"' in index
    assert (tmp_path / "out" / "cornell" / "error-vs-time.csv").is_file()


def test_cycles_and_zraka_are_judged_by_each_other(tmp_path):
    plan = measure.Plan(("pathtrace",), True, reference_samples=32, size=(24, 24), threads=1, rungs=(2, 8))
    _, measured = measure.measure(CORNELL, plan)
    assert set(measured.references) == {"zraka", "cycles"}
    assert measured.judge("pathtrace") is measured.references["cycles"]
    assert measured.judge("cycles") is measured.references["zraka"]
    assert [rung.samples for rung in measured.rungs["cycles"]] == [2, 8]
    assert all(rung.error > 0 and rung.estimate is None for rung in measured.rungs["cycles"])
    assert 0 <= measured.agreement() <= 1


@pytest.mark.parametrize("renders", [0, 4, 9])
def test_what_was_measured_before_ctrl_c_is_written(tmp_path, renders):
    """Ended while it warms up, makes its reference, and climbs."""
    asked = []

    def interrupted():
        return len(asked) > renders

    plan = measure.Plan(("pathtrace",), reference_samples=16, time_limit=600.0, size=(16, 16), threads=1)
    run = measure._Measurement._render

    def counted(self, *args):
        asked.append(1)
        return run(self, *args)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(measure._Measurement, "_render", counted)
        measured = converge.converge(CORNELL, plan, tmp_path, interrupted)
    assert measured.interrupted
    assert len(text.all_rungs(measured)) == (2 if renders == 9 else 0)
    assert "Interrupted: what follows is not whole." in (tmp_path / "report.html").read_text(encoding="utf-8")
    lines = (tmp_path / "error-vs-time.csv").read_text().splitlines()
    assert len(lines) == 1 + len(text.all_rungs(measured))


def test_ctrl_c_ends_with_130(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(measure.Bench, "run", lambda *args, **kwargs: (_ for _ in ()).throw(measure.Interrupted))

    class Pressed:
        def __enter__(self):
            return self

        def __exit__(self, *error):
            return False

        def is_set(self):
            return True

    for name in ("converge", "compare", "thesis"):
        monkeypatch.setattr(f"zraka.addon.commands.{name}.interruptible", Pressed)
    assert cli.main(["converge", str(CORNELL), "--output", str(tmp_path)]) == 130
    assert cli.main(["compare", str(CORNELL), "--output", str(tmp_path)]) == 130
    assert cli.main(["thesis", "--experiment", "4.1", "--output", str(tmp_path)]) == 130
    assert not (tmp_path / "compare.png").exists()


# -- compare -----------------------------------------------------------------------------------------------------------


def test_a_contact_sheet(tmp_path, capsys):
    args = ["compare", str(CORNELL), "--samples", "2", "--reference-samples", "16", *SMALL, "--output"]
    assert cli.main([*args, str(tmp_path / "new")]) == 0
    out = capsys.readouterr().out
    assert out.count("2 samples, ") == 4
    assert "Path tracing: 2 samples" in out
    sheet = oiio.ImageBuf(str(tmp_path / "new" / "compare.png"))
    assert sheet.spec().width > 2 * 24
    assert cli.main([*args, str(tmp_path / "one.png")]) == 0
    assert (tmp_path / "one.png").is_file()


def test_pictures_stand_side_by_side():
    red, clear = np.zeros((10, 100, 3), np.uint8), np.zeros((10, 100, 4), np.float32)
    red[..., 0] = 255
    sheet = contact_sheet([red, clear], ["Red\n12 s", "Clear"], columns=2, title="Two")
    assert sheet.dtype == np.float32
    assert sheet.shape == (2 * glyphs.HEIGHT + 10 + glyphs.HEIGHT + 3 * 8, 2 * 100 + 3 * 8, 4)
    assert (sheet[..., 3] == 1).all()
    assert (sheet[-9, 8:108, :3] == (1, 0, 0)).all()
    assert (sheet[8 + 20 + 8 + 20 + 2, 116:216, :3] == 1).all()  # what is transparent shows the paper
    assert sheet[36:56, 8:40].min() < 0.3  # the caption's ink


def test_captions_that_are_too_long_are_cut():
    assert glyphs.fitted("short", 200) == "short"
    cut = glyphs.fitted("a caption that is too long", 80)
    assert cut.endswith("...")
    assert glyphs.width(cut) <= 80
    assert glyphs.draw("Č× \u4e2d").max() == pytest.approx(1.0, abs=0.1)  # unknown letters are drawn as others
    assert glyphs.draw("").shape == (glyphs.HEIGHT, 0)


# -- thesis ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "names", [("4.2", "4.3"), pytest.param(tuple(thesis.EXPERIMENTS), marks=pytest.mark.slow)], ids=["two", "all"]
)
def test_experiments_make_figures_tables_and_sentences(tmp_path, monkeypatch, names):
    monkeypatch.setattr(thesis, "RUNS", 1)
    monkeypatch.setattr(thesis.thesis, "CASES", {"depth 1": ("room_open", 1, 1.09)})
    monkeypatch.setattr(thesis.thesis, "SAMPLES", 1)
    reference = thesis._reference
    monkeypatch.setattr(thesis, "_reference", lambda lab, scene, samples: reference(lab, scene, 8))
    found = thesis_document.make(names, tmp_path, size=(32, 32))
    assert tuple(found) == names
    written = (tmp_path / "thesis.md").read_text(encoding="utf-8")
    for name, result in found.items():
        assert f"## {result.title}" in written
        assert result.text in written
        if name not in ("4.6", "table-4.1"):
            assert (tmp_path / "figures" / f"thesis-{name}.jpg").is_file()
    rays = [row[2] for row in found["4.2"].rows]
    assert rays[0] < rays[1] < rays[2]  # deeper takes more
    assert found["4.3"].rows[0][2] == rays[0]  # without reflection it is ray casting


def test_commands_know_the_experiments():
    from zraka.addon.commands.thesis import EXPERIMENTS

    assert EXPERIMENTS == tuple(thesis.EXPERIMENTS)


# -- errors ------------------------------------------------------------------------------------------------------------


def test_noise_and_bias_are_told_apart():
    rng = np.random.default_rng(1)
    truth = np.ones((64, 64, 3))
    reference = truth + 0.02 * rng.standard_normal((4, 64, 64, 3))
    noisy = truth + 0.2 * rng.standard_normal((2, 64, 64, 3))
    parts = metrics.noise_and_bias(noisy, reference)
    scale = 1 / np.sqrt(1 + 0.01)  # the floor of the weights
    assert parts.noise == pytest.approx(0.2 * scale, rel=0.05)
    assert parts.bias < 0.01
    parts = metrics.noise_and_bias(0.9 * noisy, reference)  # a tenth darker
    assert parts.bias == pytest.approx(0.1 * scale, rel=0.1)


def test_errors_of_the_literature():
    truth = np.full((4, 4, 3), 0.5)
    assert metrics.relative_mse(truth + 0.1, truth) == pytest.approx(0.01 / 0.26)
    assert metrics.psnr(truth + 0.1, truth) == pytest.approx(20.0)
    assert metrics.psnr(truth, truth) == np.inf
    np.testing.assert_allclose(
        metrics.displayed([0.0, 0.002, 0.5, 1.0, 9.0, np.nan]), [0, 0.02584, 0.7354, 1, 1, 0], 1e-3
    )


def test_flip_of_equal_pictures_is_zero():
    pytest.importorskip("flip_evaluator")
    shown = np.random.default_rng(0).random((32, 32, 3), np.float32)
    assert metrics.flip(shown, shown) == 0
    assert 0.05 < metrics.flip(1 - shown, shown) < 1
