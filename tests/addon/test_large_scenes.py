# SPDX-License-Identifier: GPL-3.0-or-later
"""Many instances and large meshes: they render, or one sentence says why not; export is a small part of the time."""

from __future__ import annotations

import time

import bpy
import numpy as np
import pytest

from zraka.addon.bench.engines import match, operate, watched
from zraka.core.compile import memory
from zraka.core.diagnostics import SceneError

from .geometry_scenes import grid_of, primitive

NODE = "GeometryNodeInstanceOnPoints"


@pytest.fixture
def scene(blender_scene, add_camera):
    """A camera and a sun."""
    add_camera(blender_scene, height=30.0)
    bpy.ops.object.light_add(type="SUN")
    render = blender_scene.render
    render.resolution_x = render.resolution_y = 16
    render.threads_mode, render.threads = "FIXED", 2
    blender_scene.zraka.samples = 1
    match(blender_scene)
    return blender_scene


def instances(number, triangles):
    """A square of `number` instances of a grid of about `triangles` triangles, by geometry nodes."""
    rock = primitive("grid", x_subdivisions=(side := round((triangles / 2) ** 0.5)), y_subdivisions=side, size=0.5)
    rock.location.z = -50
    points = round(number**0.5)
    plane = primitive("grid", x_subdivisions=points - 1, y_subdivisions=points - 1, size=20)
    (on_points,) = grid_of(plane, None, (NODE, {}))
    group = on_points.id_data
    source = group.nodes.new("GeometryNodeObjectInfo")
    source.inputs["Object"].default_value = rock
    source.inputs["As Instance"].default_value = True
    group.links.new(source.outputs["Geometry"], on_points.inputs["Instance"])


@pytest.mark.slow
def test_ten_thousand_instances_end_with_a_sentence(scene, monkeypatch):
    """Of ten thousand triangles each, where 8 GB are free."""
    monkeypatch.setattr(memory, "available_bytes", lambda: 8 * 10**9)
    instances(10_000, 10_000)
    started = time.perf_counter()
    with pytest.raises(SceneError, match=r"10,00\d instances of \d\d?,\d{3} triangles: show fewer instances"):
        operate(scene, "ZRAKA")
    assert time.perf_counter() - started < 60


@pytest.mark.slow
def test_a_thousand_instances_render(scene):
    if (memory.available_bytes() or 10**10) < 4 * 10**9:
        pytest.skip("less than 4 GB are free")
    instances(1024, 10_000)
    with watched() as seen:
        picture, _ = operate(scene, "ZRAKA")
    assert seen.messages == []
    assert np.isfinite(picture).all() and (picture.sum(axis=-1) > 0).mean() > 0.2
