# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line: arguments, exit codes, files."""

from __future__ import annotations

import gzip
import json
import os
import signal
import sys
from pathlib import Path
from types import SimpleNamespace

import bpy
import numpy as np
import pytest

from zraka.addon import cli, headless
from zraka.addon.commands import files
from zraka.core.diagnostics import SceneError


def save(path, compress=False):
    with headless.quiet():
        bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=compress)
    return path


@pytest.fixture
def blend(blender_scene, add_camera, tmp_path):
    """A small lit scene with two cameras, in a folder with a blank in its name."""
    add_camera(blender_scene)
    add_camera(blender_scene, "Other", 9.0)
    bpy.ops.mesh.primitive_plane_add(size=20)
    matte = bpy.data.materials.new("Matte")
    if matte.node_tree is None:  # before 5.0
        matte.use_nodes = True
    matte.node_tree.nodes["Principled BSDF"].inputs["Specular IOR Level"].default_value = 0
    bpy.context.object.data.materials.append(matte)
    lamp = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    lamp.data.energy = np.pi
    lamp.data.angle = 0.0
    blender_scene.collection.objects.link(lamp)
    folder = tmp_path / "with blank"
    folder.mkdir()
    return save(folder / "scene.blend")


def refused(capsys, *args):
    """Run in this process arguments that are refused; the one line that says why."""
    try:
        code = cli.main([str(a) for a in args])
    except SystemExit as stop:
        code = stop.code
    out, err = capsys.readouterr()
    assert code == 2
    assert out == ""
    assert err.count("\n") == 1
    assert err.startswith("zraka")
    return err


# -- refused before Blender is asked -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("args", "words"),
    [
        ((), "required"),
        (("render",), "required"),
        (("render", "x.blend", "--method", "magic"), "magic"),
        (("render", "x.blend", "--samples", "0"), "not between 1"),
        (("render", "x.blend", "--depth", "deep"), "not a whole number"),
        (("render", "x.blend", "--size", "640"), "bad size '640'"),
        (("render", "x.blend", "--size", "0x10"), "bad size '0x10'"),
        (("render", "x.blend", "--time-limit", "-1"), "not a number of seconds"),
        (("render", "x.blend", "--time-limit", "nan"), "not a number of seconds"),
        (("render", "no such.blend"), "no such file: no such.blend"),
        (("render", "."), "no such file"),
    ],
)
def test_bad_arguments(capsys, args, words):
    assert words in refused(capsys, *args)


@pytest.mark.parametrize(
    "content", [b"", b"BLEND", b"\x89PNG....", gzip.compress(b"no blend", mtime=0), b"\x1f\x8bcut"]
)
def test_not_a_blend(capsys, tmp_path, content):
    path = tmp_path / "fake.blend"
    path.write_bytes(content)
    assert str(path) in refused(capsys, "render", path)


@pytest.mark.parametrize("content", [b"BLENDER-v405", b"BLENDER17-01v0500", gzip.compress(b"BLENDER-v279", mtime=0)])
def test_blends_are_known_by_their_first_bytes(tmp_path, content):
    path = tmp_path / "true.blend"
    path.write_bytes(content)
    files.check_blend(path)


def test_bad_outputs(capsys, tmp_path):
    path = tmp_path / "true.blend"
    path.write_bytes(b"BLENDER-v405")
    assert "ends in .png or .exr" in refused(capsys, "render", path, "--output", tmp_path / "a.jpg")
    assert "there is no folder" in refused(capsys, "render", path, "--output", tmp_path / "none" / "a.png")
    assert "there is no folder" in refused(capsys, "render", path, "--json", tmp_path / "none" / "a.json")
    (tmp_path / "folder.png").mkdir()
    assert "is a folder" in refused(capsys, "render", path, "--output", tmp_path / "folder.png")


def test_each_result_has_a_name_of_its_own(capsys, tmp_path):
    path = tmp_path / "true.blend"
    path.write_bytes(b"BLENDER-v405")
    same = tmp_path / "a.png"
    assert "cannot be written twice" in refused(capsys, "render", path, "--output", same, "--json", same)
    assert not same.exists()


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="only Linux has such a folder")
def test_a_folder_where_nobody_may_write_not_even_root():
    with pytest.raises(SceneError, match=r"^/proc/a.png cannot be written: "):
        files.check_output(Path("/proc/a.png"))


def test_writing_is_tried_without_a_trace(tmp_path):
    old, new = tmp_path / "old.png", tmp_path / "new.png"
    old.write_bytes(b"old")
    files.check_output(old)
    files.check_output(new)
    assert old.read_bytes() == b"old"
    assert not new.exists()


def test_what_was_cut_short_by_a_full_disk_is_told(blender_scene, tmp_path, monkeypatch):
    monkeypatch.setattr(headless.shutil, "disk_usage", lambda folder: SimpleNamespace(free=0))
    picture = np.random.default_rng(1).random((32, 32, 4), np.float32)
    for kind in (".png", ".exr"):
        path = (tmp_path / "a").with_suffix(kind)
        headless.write_picture(bpy, blender_scene, picture, path)
        whole = path.read_bytes()
        for content in (whole[:-200], whole[:300], b""):
            path.write_bytes(content)
            assert not headless.is_whole(path)
    monkeypatch.setattr(headless, "is_whole", lambda path: False)
    with pytest.raises(SceneError, match="is the disk full"):
        headless.write_picture(bpy, blender_scene, picture, path)


def test_ctrl_c_waits_until_blender_stands(monkeypatch):
    monkeypatch.delitem(sys.modules, "bpy")
    reached = []
    # A shell's background process ignores Ctrl-C.
    found = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt), headless._ctrl_c_held_back():
            signal.raise_signal(signal.SIGINT)
            reached.append(True)
        assert reached
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, found)


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_without_permission(tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(SceneError, match="read-only"):
        files.check_output(tmp_path / "a.png")


# -- refused by Blender ------------------------------------------------------------------------------------------------


def test_a_damaged_file(capsys, tmp_path):
    path = tmp_path / "cut.blend"
    path.write_bytes(b"BLENDER-v405" + b"\0" * 100)
    assert "cannot be opened" in refused(capsys, "render", path, "--output", tmp_path / "a.png")


def test_no_camera(capsys, blender_scene, tmp_path):
    path = save(tmp_path / "empty.blend", compress=True)
    assert "has no camera;" in refused(capsys, "render", path, "--output", tmp_path / "a.png")
    assert "no camera named 'Eye'" in refused(capsys, "render", path, "--camera", "Eye")


# -- rendered ----------------------------------------------------------------------------------------------------------


def render(run_python, *args):
    return run_python("-m", "zraka", "render", *args)


def test_a_picture_and_its_numbers(run_python, blend):
    png, exr, stats = (blend.with_suffix(s) for s in (".png", ".exr", ".json"))
    done = render(
        run_python, blend, "--samples", 4, "--size", "40x20", "--seed", 3, "--threads", 1, "--method", "pathtrace",
        "--depth", 2, "--camera", "Other", "--output", png, "--output", exr, "--json", stats,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert done.stdout.count("\n") == 1
    assert done.stdout.startswith("pathtrace: 4 samples")
    assert "rays/s" in done.stdout
    assert "estimated error" in done.stdout

    numbers = json.loads(stats.read_text())
    assert numbers["bpy"].startswith("{}.{}".format(*bpy.app.version))
    expected = {"method": "pathtrace", "size": [40, 20], "samples": 4, "depth": 2, "threads": 1, "seed": 3}
    assert {key: numbers[key] for key in expected} == expected
    assert set(numbers["seconds"]) == {"export", "compile", "render", "total"}
    assert set(numbers["rays"]) == {"camera", "shadow", "secondary"}
    assert numbers["rays"]["camera"] == 40 * 20 * 4
    assert set(numbers["features"]) == {"in_use", "left_out"}
    assert (numbers["nonfinite"], numbers["stopped"]) == (0, "samples")
    assert numbers["diagnostics"] == []
    assert 0 <= numbers["estimated_error"] < 0.1
    assert 0 < numbers["embree_seconds"] < numbers["seconds"]["total"]

    image = bpy.data.images.load(str(exr))
    assert tuple(image.size) == (40, 20)
    pixels = np.array(image.pixels[:]).reshape(20, 40, 4)
    np.testing.assert_allclose(pixels[..., :3], 0.8, rtol=1e-3)
    assert png.stat().st_size > 0


def test_the_scene_decides_what_is_not_given(run_python, blender_scene, blend):
    blender_scene.zraka.method = "PHONG"
    blender_scene.render.filepath = "//out_####"
    blender_scene.frame_current = 7
    save(blend)
    stats = blend.with_suffix(".json")
    done = render(run_python, blend, "--json", stats)
    assert done.returncode == 0, done.stderr
    assert (blend.parent / "out_0007.png").exists()
    numbers = json.loads(stats.read_text())
    assert (numbers["method"], numbers["samples"], numbers["size"]) == ("phong", 2, [32, 24])


def test_one_sample_claims_no_error(run_python, blend):
    stats = blend.with_suffix(".json")
    done = render(run_python, blend, "--samples", 1, "--output", blend.with_suffix(".png"), "--json", stats)
    assert done.stdout.endswith("estimated error unknown\n")
    assert json.loads(stats.read_text())["estimated_error"] is None


# Ctrl-C one second after the render began, and not before.
INTERRUPTED = """
import os, signal, sys, threading
from zraka.addon import cli
from zraka.addon.commands import render

progress_bar = render._progress_bar

def begin(settings):
    threading.Timer(1.0, os.kill, (os.getpid(), signal.SIGINT)).start()
    return progress_bar(settings)

render._progress_bar = begin
sys.exit(cli.main(sys.argv[1:]))
"""


@pytest.mark.skipif(os.name == "nt", reason="Windows cannot send SIGINT to one process")
def test_ctrl_c_keeps_the_samples(run_python, blend):
    output, stats = blend.with_suffix(".exr"), blend.with_suffix(".json")
    args = ["render", blend, "--samples", "10000000", "--size", "160x120", "--output", output, "--json", stats]
    done = run_python("-c", INTERRUPTED, *args)
    assert done.returncode == 130, done.stderr
    assert output.exists()
    numbers = json.loads(stats.read_text())
    assert 0 < numbers["samples"] < 10000000
    assert numbers["stopped"] == "cancelled"
    assert numbers["seconds"]["render"] < 2.5
