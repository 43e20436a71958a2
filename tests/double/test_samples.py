# SPDX-License-Identifier: GPL-3.0-or-later
"""The sample scenes that the second renderer can carry, as the add-on exports them."""

from pathlib import Path

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from zraka.addon.export.scene import export_scene  # noqa: E402 - Blender is there
from zraka.core.diagnostics import Diagnostics  # noqa: E402

from ..reference import open_blend  # noqa: E402
from .test_classic import apart, both  # noqa: E402
from .test_paths import agrees, ours, theirs, z_scores  # noqa: E402

FOLDER = Path(__file__).resolve().parents[2] / "sample_blends"


def sample(name):
    """The description of a sample and its scene in Blender, a square picture."""
    scene = open_blend(FOLDER / f"{name}.blend")
    return export_scene(bpy.context.evaluated_depsgraph_get(), Diagnostics(), size=(20, 20)), scene


@pytest.mark.parametrize("name", ["thesis", "room_open", "room_closed"])
@pytest.mark.parametrize(("method", "depth"), [("phong", 1), ("raycast", 1), ("raytrace", 4)])
def test_the_scenes_of_the_thesis(name, method, depth):
    description, _ = sample(name)
    a, b = both(description, method, depth, reflectivity=0.2, exponent=32.0, ambient=0.2)
    assert np.mean(apart(a, b) > 1e-4) < 0.015, np.sort(apart(a, b))[-10:]


def test_the_cornell_box():
    description, _ = sample("cornell")
    a, b = ours(description, 5, 64), theirs(description, 5, 12)
    assert agrees(a, b), (z_scores(a, b).round(1), (a.mean(axis=(0, 1)) / b.mean(axis=(0, 1))).round(4))
