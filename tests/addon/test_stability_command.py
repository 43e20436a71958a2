# SPDX-License-Identifier: GPL-3.0-or-later
"""``zraka stability``: exit codes and files."""

import json
import os
import signal

import pytest

from zraka.addon import cli
from zraka.core.stability import run as grid
from zraka.core.stability.placing import AXES

AXIS = AXES[0]


@pytest.fixture
def short(monkeypatch):
    """A grid of one axis, which calls `before` first."""

    def shorten(axis=AXIS, before=lambda: None):
        whole = grid.run

        def some(quick, cancelled, say):
            before()
            return whole(quick, cancelled, say, axes=(axis,), scenes=())

        monkeypatch.setattr(grid, "run", some)

    return shorten


def call(folder):
    return cli.main(["stability", "--quick", "--output", str(folder)])


def test_a_good_grid_exits_with_0_and_writes_three_files(short, tmp_path, capsys):
    short()
    assert call(tmp_path / "new") == 0
    names = sorted(path.name for path in (tmp_path / "new").iterdir())
    assert names == ["stability.html", "stability.json", "stability.md"]
    assert json.loads((tmp_path / "new/stability.json").read_text(encoding="utf-8"))["failures"] == []
    assert "0 failing" in capsys.readouterr().out


def test_a_failing_case_exits_with_1(short, tmp_path, capsys):
    from dataclasses import replace

    short(replace(AXIS, case=lambda s: replace(AXIS.case(s), truth=1.0)))
    assert call(tmp_path) == 1
    assert "failed: scene scale, lit floor" in capsys.readouterr().err


def test_ctrl_c_writes_what_was_done(short, tmp_path):
    short(before=lambda: os.kill(os.getpid(), signal.SIGINT))
    assert call(tmp_path) == 130
    assert "Interrupted" in (tmp_path / "stability.md").read_text(encoding="utf-8")


def test_a_folder_that_cannot_be_made_is_told_in_one_line(tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert call(tmp_path / "file") == 2
    assert capsys.readouterr().err.count("\n") == 1
