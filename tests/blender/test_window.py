# SPDX-License-Identifier: GPL-3.0-or-later
"""Zraka in the windows of whole Blenders: panels, previews, renders that are watched, Rendered shading."""

from __future__ import annotations

import json
import shutil

import numpy as np
import pytest

from .pictures import blurred, read

pytestmark = [pytest.mark.blender, pytest.mark.window]


def test_the_window(blender):
    """The engine is chosen, its panels are drawn, a render shows its passes and is cancelled."""
    folder = blender.folder / "window"
    folder.mkdir()
    script = blender.script("window.py", folder)
    done = blender("--window-geometry", 0, 0, 1280, 800, "cornell.blend", *script, gui=True, timeout=300)
    assert done.returncode == 0, done.stdout
    assert "Traceback" not in done.stdout
    log = json.loads((folder / "log.json").read_text(encoding="utf-8"))
    assert log["engine"] == "ZRAKA"
    assert set(log["panels"]) == set(log["drawn"])
    assert len(log["previews"]) >= 3
    assert np.median(log["previews"]) < 1
    assert log["took_over"] == [77, 4]
    assert read(folder / "methods.png")[..., :3].mean() > 0.05
    assert log["longest_pause"] < 1  # between two calls of Blender's timer, which draws by software
    assert log["left"] == 0
    assert log["handlers"] == ["render_cancel"] * 2
    assert len(log["shown"]) >= 4
    # Half a second is the aim; here OpenGL is software and takes the same cores.
    assert log["returned"] - log["breaks"][0] < 1
    assert read(folder / "kept.png")[..., :3].mean() > 0.1
    assert log["errors"] >= 3
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert page.endswith("</html>\n")
    assert "data:image/jpeg" in page


def test_previews(blender):
    """Of materials, worlds and lamps: what Cycles shows in the same place, without more noise than is told from it."""
    folder = blender.folder / "previews"
    folder.mkdir()
    for engine in ("CYCLES", "ZRAKA"):
        script = blender.script("previews.py", folder, engine)
        done = blender("--window-geometry", 0, 0, 1280, 800, "cornell.blend", *script, gui=True, timeout=300)
        assert done.returncode == 0, done.stdout
        assert "Traceback" not in done.stdout
    log = json.loads((folder / "log.json").read_text(encoding="utf-8"))
    rows = {"material": slice(240, 364), "world": slice(152, 276), "light": slice(152, 276)}
    assert len(log["things"]) == 4
    for name, kind in log["things"].items():
        ours, cycles = (read(folder / f"{engine}-{name}.png")[rows[kind], 64:960, :3] for engine in ("ZRAKA", "CYCLES"))
        assert cycles.max() > 0.3, name
        blocks = np.abs(blurred(ours) - blurred(cycles))
        assert blocks.mean() < 0.01, name
        assert np.percentile(blocks, 99) < 0.08, name
        assert np.abs(ours - cycles).mean() < 0.025, name


def test_rendered_shading(blender):
    """The viewport shows what a render does, follows what changes, and leaves nothing running."""
    folder = blender.folder / "viewport"
    folder.mkdir()
    script = blender.script("viewport.py", folder)
    done = blender("--window-geometry", 0, 0, 720, 480, "cornell.blend", *script, gui=True, timeout=600)
    assert done.returncode == 0, done.stdout
    assert "Traceback" not in done.stdout
    log = json.loads((folder / "log.json").read_text(encoding="utf-8"))

    def shown(name):
        x, y, width, height = log["region"]
        screen = read(folder / f"{name}.png")[..., :3]
        return screen[screen.shape[0] - y - height : screen.shape[0] - y, x : x + width]

    for name in ("perspective", "orthographic"):
        # The same noise, but for paths that the last bits of a camera's matrix turn another way.
        picture, render = shown(f"viewport-{name}"), read(folder / f"f12-{name}.png")[..., :3]
        assert (np.abs(picture - render).max(axis=2) > 3 / 255).mean() < 0.06, name
        assert np.abs(picture.mean(axis=(0, 1)) - render.mean(axis=(0, 1))).max() < 1.5 / 255, name
    by_method = [shown(f"viewport-{method}") for method in ("PHONG", "RAYCAST", "RAYTRACE", "PATHTRACE")]
    assert np.abs(by_method[0] - by_method[1]).max() > 0.1  # shadows
    assert np.abs(by_method[1] - by_method[3]).max() > 0.1
    reddest = [np.max(shown(name)[..., 0] - shown(name)[..., 1]) for name in ("before", "red")]
    assert reddest[1] > reddest[0] + 0.1
    assert np.abs(shown("deleted") - shown("red")).max() > 0.3
    assert np.abs(shown("undone") - shown("red")).mean() < 1 / 255
    assert (log["exports_of_a_view"], log["exports_of_a_selection"]) == (0, 0)
    running = ("threads_in_BLENDER_WORKBENCH", "threads_in_CYCLES", "threads_after_load", "threads_after_edits")
    assert [log[name] for name in running] == [0, 0, 0, 1]
    # The wall clock tells here of OpenGL by software; the first time, modules are read.
    busy = [seconds for name in ("update", "draw") for _, seconds in log[name][1:]]
    assert np.percentile(busy, 99) < 0.05


@pytest.mark.slow
def test_random_edits(blender):
    """Five hundred of them, with undo and redo, under Rendered shading: no crash, no leak, the right picture."""
    folder = blender.folder / "edits"
    folder.mkdir()
    script = blender.script("edits.py", folder, 500)
    done = blender("--window-geometry", 0, 0, 1164, 655, "cornell.blend", *script, gui=True, timeout=1200)
    assert done.returncode == 0, done.stdout
    assert "Traceback" not in done.stdout
    log = json.loads((folder / "log.json").read_text(encoding="utf-8"))
    assert log["began"]
    assert log["mean"] > 0.01
    assert log["different"] < 0.001  # from a fresh start's picture, sample by sample
    early, late = log["megabytes"]
    assert late - early < 50
    assert log["threads"] == 1
    assert max(seconds for name in ("update", "draw") for _, seconds in log[name]) < 0.05
    assert np.percentile(log["cancel"], 95) < 0.5  # of wall clock, which tells of everything else that runs here


@pytest.mark.slow
def test_no_call_holds_up_the_window(blender, samples):
    """What Blender's own thread spends on Zraka at each update and each redraw, in the sample scenes.

    Without the first update, which reads all; and without `many`, of whose objects it looks at each where one is an
    instancer, comes or goes.
    """
    files = sorted(file for file in samples.glob("*.blend") if file.stem != "many")
    for file in files:
        shutil.copy(file, blender.folder)
    folder = blender.folder / "stalls"
    folder.mkdir()
    script = blender.script("stalls.py", folder, *(file.name for file in files))
    done = blender("--window-geometry", 0, 0, 1164, 655, "cornell.blend", *script, gui=True, timeout=1200)
    assert done.returncode == 0, done.stdout
    log = json.loads((folder / "log.json").read_text(encoding="utf-8"))
    assert "stopped" not in log, log["stopped"]
    for file in files:
        calls = log[file.name]
        assert len(calls["update"]) > 10
        assert max(calls["update"][1:] + calls["draw"]) < 0.05, file.name
