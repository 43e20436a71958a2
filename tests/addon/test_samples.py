# SPDX-License-Identifier: GPL-3.0-or-later
"""Every sample scene renders by every method, without a non-finite sample and without a black picture."""

from pathlib import Path

import bpy
import numpy as np
import pytest

from zraka.addon.export.scene import export_scene
from zraka.core.compile import compile_scene
from zraka.core.diagnostics import Diagnostics
from zraka.core.render import render
from zraka.core.settings import METHODS, Settings

from ..reference import open_blend

BLENDS = sorted((Path(__file__).resolve().parents[2] / "sample_blends").glob("*.blend"))
# The thesis' ceiling is a cube without height; the vase is turned around an axis that its outline touches.
EXPECTED = {"thesis": "triangles without area", "interior": "triangles without area"}
# What the methods without further rays leave out, and say.
LEFT_OUT = ("mirrors and glass show highlights alone", "lamps are not seen by this method")


def test_all_samples_are_there_and_small():
    names = {path.stem for path in BLENDS}
    assert names == {"cornell", "thesis", "whitted", "room_open", "room_closed", "interior", "many", "spheres"}
    assert max(path.stat().st_size for path in BLENDS) < 300_000


@pytest.mark.parametrize("path", BLENDS, ids=lambda path: path.stem)
def test_every_method_renders(path):
    scene = open_blend(path)
    diagnostics = Diagnostics()
    size = (96, round(96 * scene.render.resolution_y / scene.render.resolution_x))
    description = export_scene(bpy.context.evaluated_depsgraph_get(), diagnostics, size=size)
    for method in METHODS:
        settings = Settings(method=method, width=size[0], height=size[1], samples=4, depth=scene.zraka.depth)
        film = render(compile_scene(description, settings, diagnostics), settings)
        picture = film.image()[..., :3]
        assert film.nonfinite == 0 and np.isfinite(picture).all(), method
        assert 0.02 < np.median(picture.max(axis=-1)) < 5, method
    messages = [message for message in diagnostics.messages() if not message.startswith(LEFT_OUT)]
    expected = EXPECTED.get(path.stem)
    assert len(messages) == bool(expected) and all(expected in message for message in messages)
