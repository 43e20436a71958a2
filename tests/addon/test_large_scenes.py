# SPDX-License-Identifier: GPL-3.0-or-later
"""Many instances and large meshes: they render, or one sentence says why not; export is a small part of the time."""

from __future__ import annotations

import time

import numpy as np
import pytest

from zraka.addon.bench.engines import operate, watched
from zraka.core.compile import memory
from zraka.core.diagnostics import SceneError

from . import large_cases


@pytest.fixture
def scene(blender_scene):
    """A camera and a sun."""
    large_cases.prepare(blender_scene)
    return blender_scene


@pytest.mark.slow
def test_ten_thousand_instances_end_with_a_sentence(scene, monkeypatch):
    """Of ten thousand triangles each, where 8 GB are free."""
    monkeypatch.setattr(memory, "available_bytes", lambda: large_cases.FREE)
    large_cases.instances(10_000, 10_000)
    started = time.perf_counter()
    with pytest.raises(SceneError, match=r"10,00\d instances of \d\d?,\d{3} triangles: show fewer instances"):
        operate(scene, "ZRAKA")
    assert time.perf_counter() - started < 60


@pytest.mark.slow
def test_a_thousand_instances_render(scene):
    if (memory.available_bytes() or 10**10) < 4 * 10**9:
        pytest.skip("less than 4 GB are free")
    large_cases.instances(1024, 10_000)
    with watched() as seen:
        picture, _ = operate(scene, "ZRAKA")
    assert seen.messages == []
    assert np.isfinite(picture).all() and (picture.sum(axis=-1) > 0).mean() > 0.2


@pytest.mark.slow
@pytest.mark.parametrize("smooth", [False, True])
def test_export_is_at_most_a_tenth_of_the_tree(scene, smooth):
    export, tree = large_cases.export_share(scene, smooth)
    assert export < 0.1 * tree


@pytest.mark.parametrize("persistent", [True, False])
def test_still_meshes_are_exported_once(scene, persistent):
    assert large_cases.animate(scene, persistent) == [1 if persistent else large_cases.FRAMES] * 5
