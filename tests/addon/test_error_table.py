# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of errors beside an animation's frames."""

import csv
import math
from types import SimpleNamespace

import pytest

from zraka.addon import error_table
from zraka.core.diagnostics import SceneError

from .test_error_curve import record


@pytest.mark.parametrize(
    ("path", "table"),
    [
        ("shot_", "shot_error.csv"),
        ("shot_####.png", "shot_error.csv"),
        ("######", "error.csv"),
        ("", "error.csv"),
        ("a_##_b", "a__b_error.csv"),
        ("take2.", "take2_error.csv"),
    ],
)
def test_where_the_table_stands(blender_scene, tmp_path, path, table):
    blender_scene.render.filepath = f"{tmp_path}/{path}"
    assert error_table.table_path(blender_scene.render) == tmp_path / table


def test_the_table_of_a_film(blender_scene, tmp_path):
    render = SimpleNamespace(frame_path=lambda frame: str(tmp_path / "film0001-0250.mp4"))
    assert error_table.table_path(render) == tmp_path / "film0001-0250_error.csv"


def test_rows_of_frames_replace_each_other(tmp_path):
    path = tmp_path / "new" / "error.csv"
    for frame, seconds in ((10, 1.0), (9, 2.0), (-1, 4.0), (10, 3.0)):
        error_table.write_row(path, frame, "L", record(seconds=seconds, stopped="noise"))
    error_table.write_row(path, 9, "K", record(error=math.inf, stopped="time"))
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [(row["frame"], row["layer"], float(row["seconds"])) for row in rows] == [
        ("-1", "L", 4.0),
        ("9", "K", 25.6),
        ("9", "L", 2.0),
        ("10", "L", 3.0),
    ]
    assert (rows[1]["error"], rows[1]["stopped"], rows[3]["error"]) == ("", "time", "0.05")
    assert [file.name for file in path.parent.iterdir()] == ["error.csv"]


def test_a_file_of_somebody_else_is_left_alone(tmp_path):
    path = tmp_path / "error.csv"
    path.write_text("my,own,notes\n1,2,3\n", encoding="utf-8")
    with pytest.raises(SceneError, match="left as it is"):
        error_table.write_row(path, 1, "L", record(stopped="noise"))
    assert path.read_text(encoding="utf-8").startswith("my,own")
    with pytest.raises(SceneError, match="cannot be written"):
        error_table.write_row(path / "below.csv", 1, "L", record(stopped="noise"))


def test_half_a_table_is_mended(tmp_path):
    path = tmp_path / "error.csv"
    path.write_text(",".join(error_table.FIELDS) + "\n1,L,1,4,0.1,noise\n2,L\nx,L,1,4,0.1,noise\n", encoding="utf-8")
    error_table.write_row(path, 3, "L", record(stopped="noise"))
    rows = path.read_text(encoding="utf-8").split()
    assert [row.split(",")[0] for row in rows] == ["frame", "1", "3"]
