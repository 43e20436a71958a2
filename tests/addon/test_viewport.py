# SPDX-License-Identifier: GPL-3.0-or-later
"""Rendered shading without a window: what a region sees, and the thread that traces it."""

from __future__ import annotations

import gc
import time
from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from zraka.addon import preload
from zraka.addon.engine import ZrakaRenderEngine
from zraka.addon.export.camera import export_camera
from zraka.addon.viewport import viewport as viewport_module
from zraka.addon.viewport import worker as worker_module
from zraka.addon.viewport.view import View, _in_region, view_of, window_of
from zraka.addon.viewport.worker import Job, Worker
from zraka.core import compile as compile_package
from zraka.core import scene as description
from zraka.core.arena import Arena
from zraka.core.camera import CameraRays
from zraka.core.compile import compile_scene
from zraka.core.diagnostics import Diagnostics, SceneError
from zraka.core.render import render
from zraka.core.settings import Settings

QUAD = description.Mesh(
    np.float32([(-1, -1, -3), (1, -1, -3), (1, 1, -3), (-1, 1, -3)]), np.int32([(0, 1, 2), (0, 2, 3)])
)
SCENE = description.Scene(
    camera=description.Camera(),
    instances=(description.Instance(QUAD),),
    lights=(description.PointLight((0.5, 1.0, 0.0), (300, 200, 100)),),
)
VIEW = View(tuple(np.eye(4).ravel().tolist()), (-0.5, 0.5, -0.4, 0.4), "PERSPECTIVE", 0.1, 100.0, 100, 80)


def until(condition, seconds=120.0):
    """Wait for a condition."""
    end = time.perf_counter() + seconds
    while not condition():
        assert time.perf_counter() < end
        time.sleep(0.005)


@pytest.fixture
def worker():
    worker = Worker()
    yield worker
    worker.stop(wait=10.0)
    assert worker._thread is None or not worker._thread.is_alive()


def job(scene=SCENE, view=VIEW, **settings):
    return Job(scene, Settings(method="raycast", samples=4, **settings), Diagnostics(), view)


def camera_rays(view, divider):
    width, height = view.size(divider)
    return CameraRays(view.camera(divider), width, height, np.zeros(3))


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
def test_the_window_of_a_projection_matrix(kind):
    """As of a camera with the same matrix."""
    data = bpy.data.cameras.new("Camera")
    data.type, data.shift_x, data.shift_y, data.lens, data.ortho_scale = kind, 0.2, -0.1, 35, 4
    thing = bpy.data.objects.new("Camera", data)
    graph = bpy.context.evaluated_depsgraph_get()
    matrix = thing.calc_matrix_camera(graph, x=200, y=100)
    span = 4 if kind == "ORTHO" else 36 / 35
    middle = (0.2 * span, -0.1 * span)
    expected = middle[0] - span / 2, middle[0] + span / 2, middle[1] - span / 4, middle[1] + span / 4
    np.testing.assert_allclose(window_of(np.array(matrix), kind == "PERSP"), expected, rtol=1e-5)


def test_large_pixels_lie_on_small_ones():
    """Pixel (x, y) of a coarse picture begins where pixel (d x, d y) of the fine one does, over the edge as well."""
    fine = camera_rays(VIEW, 1)
    for divider in (2, 8, 16):
        coarse = camera_rays(VIEW, divider)
        np.testing.assert_allclose(coarse._corner, fine._corner, rtol=1e-6)
        np.testing.assert_allclose(coarse._dx, np.multiply(fine._dx, divider), rtol=1e-6)
        np.testing.assert_allclose(coarse._dy, np.multiply(fine._dy, divider), rtol=1e-6)


def test_borders_of_large_pixels_hold_those_of_small_ones():
    view = replace(VIEW, border=(3, 5, 98, 80))
    assert view.frame(8) == {"width": 13, "height": 10, "border": (0, 0, 13, 10)}
    assert not view.is_empty
    assert replace(VIEW, border=(10, 10, 10, 20)).is_empty


def test_a_cameras_border_in_a_region():
    """The camera's frame is the middle half of the region; its border the right half of that."""
    render = bpy.data.scenes.new("border").render
    render.use_border = True
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.5, 1, 0, 1
    found = _in_region(render, (-0.5, 0.5, -0.5, 0.5), (-1, 1, -1, 1))
    np.testing.assert_allclose(found, (0.5, 0.25, 0.75, 0.75))


def context_of(camera, width, height):
    """Of a region whose middle half is the camera's frame."""
    graph = bpy.context.evaluated_depsgraph_get()
    wider = Matrix.Diagonal((0.5, 0.5, 1, 1)) @ camera.calc_matrix_camera(graph, x=width, y=height)
    return SimpleNamespace(
        region=SimpleNamespace(width=width, height=height),
        space_data=SimpleNamespace(use_local_camera=False, camera=None, clip_start=0.1, clip_end=100.0),
        region_data=SimpleNamespace(
            window_matrix=wider,
            view_matrix=camera.matrix_world.inverted(),
            is_perspective=True,
            view_perspective="CAMERA",
        ),
    )


def test_a_panoramic_camera_fills_its_frame(monkeypatch):
    """Which is the middle half of the region; the render's border cuts it."""
    scene = bpy.context.scene
    data = bpy.data.cameras.new("Camera")
    data.type, data.panorama_type, data.shift_x, data.latitude_max = "PANO", "EQUIRECTANGULAR", 0.1, 0.5
    thing = bpy.data.objects.new("Camera", data)
    scene.collection.objects.link(thing)
    render = scene.render
    for owner, name, value in (
        (scene, "camera", thing),
        *((render, f"resolution_{name}", value) for name, value in (("x", 40), ("y", 20), ("percentage", 100))),
    ):
        monkeypatch.setattr(owner, name, value)
    graph = bpy.context.evaluated_depsgraph_get()
    camera, context = export_camera(graph, Diagnostics()), context_of(thing, 80, 40)
    view = view_of(context, graph)
    assert (view.projection, view.panorama) == ("PANORAMIC", camera.panorama)
    np.testing.assert_allclose(np.subtract(view.window, camera.window), (-0.5, 0.5, -0.5, 0.5), atol=1e-5)
    assert view.border == (20, 10, 60, 30)
    fine, region = CameraRays(camera, 40, 20, np.zeros(3)), camera_rays(view, 1)
    pixel, jitter = np.int32([5]), np.full((2, 1), 0.5, np.float32)
    expected = fine.rays(pixel, jitter.copy(), Arena())[1]
    np.testing.assert_allclose(region.rays(pixel + 10 * 80 + 20, jitter, Arena())[1], expected, atol=1e-5)
    monkeypatch.setattr(render, "use_border", True)
    monkeypatch.setattr(render, "border_max_x", 0.5)
    assert view_of(context, bpy.context.evaluated_depsgraph_get()).border == (20, 10, 40, 30)
    scene.collection.objects.unlink(thing)


def test_equal_views_are_equal():
    """Else the viewport would begin anew with every picture it draws."""
    matrix = Matrix.Rotation(0.3, 4, "X")
    first, second = (replace(VIEW, transform=tuple(np.array(matrix).ravel().tolist())) for _ in range(2))
    assert first == second != VIEW


def test_the_last_picture_is_that_of_a_render(worker):
    worker.want(job())
    until(lambda: not worker.busy)
    settings = replace(job().settings, **VIEW.frame())
    compiled = compile_scene(replace(SCENE, camera=VIEW.camera()), settings, Diagnostics())
    expected = render(compiled, settings).image()
    assert expected[..., :3].max() > 0.1
    np.testing.assert_array_equal(worker.picture.pixels, expected)
    assert worker.text == "Sample 4/4"


def test_another_view_compiles_nothing(worker):
    worker.want(job())
    until(lambda: not worker.busy)
    compiled, first = worker._compiled, worker.picture
    worker.want(job(view=replace(VIEW, window=(-1, 1, -0.8, 0.8), border=(10, 20, 60, 70))))
    until(lambda: not worker.busy)
    assert worker._compiled is compiled
    assert worker.picture is not first
    picture = worker.picture
    assert (picture.x, picture.y, picture.width, picture.height) == (10, 20, 50, 50)
    whole = replace(VIEW, window=(-1, 1, -0.8, 0.8))
    settings = replace(job().settings, **whole.frame())
    expected = render(compile_scene(replace(SCENE, camera=whole.camera()), settings, Diagnostics()), settings).image()
    np.testing.assert_array_equal(picture.pixels, expected[20:70, 10:60])


@pytest.mark.parametrize("many", [0, 1 << 21])
def test_what_changed_is_compiled(worker, monkeypatch, many):
    """Another material leaves Embree's tree; of what is large, nothing is kept beside what takes its place."""
    monkeypatch.setattr(worker_module, "MANY_TRIANGLES", many)
    red = description.Material.diffuse((0.8, 0.1, 0.1))
    painted = replace(SCENE, instances=(description.Instance(QUAD, materials=(red,)),))
    moved = replace(SCENE, instances=(description.Instance(QUAD, np.diag([2.0, 1, 1, 1]), materials=(red,)),))
    served, compiled = [], []
    compile_anew = compile_package.compile_scene

    def note(*args, before, editable):
        served.append(before)
        compiled.append(compile_anew(*args, before=before, editable=editable))
        return compiled[-1]

    monkeypatch.setattr(compile_package, "compile_scene", note)
    for scene in (SCENE, painted, moved):
        worker.want(job(scene))
        until(lambda: not worker.busy)
    assert served == [None, compiled[0], compiled[1] if many else None]
    assert compiled[1].accel is compiled[0].accel is not compiled[2].accel
    settings = replace(job().settings, **VIEW.frame())
    expected = render(compile_anew(replace(moved, camera=VIEW.camera()), settings, Diagnostics()), settings).image()
    np.testing.assert_array_equal(worker.picture.pixels, expected)


def test_a_newer_job_takes_over(worker):
    worker.want(Job(SCENE, Settings(method="raycast", samples=10**6), Diagnostics(), VIEW))
    until(lambda: worker.picture is not None)
    worker.want(job())
    until(lambda: not worker.busy)
    assert worker.text == "Sample 4/4"


def test_the_first_picture_is_coarse(worker):
    sizes = []
    show = worker._show
    worker._show = lambda *args: (show(*args), sizes.append(worker.picture.pixels.shape[:2]))
    worker.want(job())
    until(lambda: not worker.busy)
    assert sizes[0] == (10, 13)
    assert sizes[-1] == (80, 100)


@pytest.mark.parametrize(("error", "said"), [(SceneError("too much"), "too much"), (KeyError("x"), "KeyError")])
def test_what_goes_wrong_is_said(worker, monkeypatch, error, said):
    def fail(*_):
        raise error

    monkeypatch.setattr(worker, "_compile", fail)
    worker.want(job())
    until(lambda: not worker.busy)
    assert said in worker.text
    monkeypatch.undo()
    worker.want(job())
    until(lambda: not worker.busy)
    assert worker.text == "Sample 4/4"


def test_nothing_is_wanted(worker):
    worker.want(job())
    until(lambda: not worker.busy)
    worker.want(None)
    until(lambda: not worker.busy)
    assert worker.picture is None


# -- what tells the viewport -------------------------------------------------------------------------------------------


def test_a_setting_that_a_script_changes_is_an_update(blender_scene):
    scene, seen = blender_scene, []

    def note(_, graph):
        seen.extend(update.id.name for update in graph.updates)

    bpy.context.view_layer.update()
    bpy.app.handlers.depsgraph_update_post.append(note)
    try:
        scene.zraka.seed += 1
        bpy.context.view_layer.update()
    finally:
        bpy.app.handlers.depsgraph_update_post.remove(note)
    assert scene.name in seen


def test_nothing_waits_for_modules(monkeypatch):
    """The viewport begins at the first redraw after they were read; Blender is told to ask for it."""
    asked, said = [], []
    engine = SimpleNamespace(viewport=None, update_stats=lambda *args: said.append(args))
    engine.view_update = partial(ZrakaRenderEngine.view_update, engine)
    monkeypatch.setattr(preload, "is_done", lambda: False)
    monkeypatch.setattr(preload, "redraw_when_done", asked.append)
    engine.view_update(None, None)
    ZrakaRenderEngine.view_draw(engine, None, None)
    assert (asked, said) == ([engine] * 2, [("", "Loading Zraka")])
    monkeypatch.undo()
    monkeypatch.setattr(preload, "_thread", None)
    preload.start()
    until(preload.is_done)
    assert gc.get_freeze_count() > 0  # no search for garbage among what was read
    preload.finish()
    assert gc.get_freeze_count() == 0
    done = []
    made = SimpleNamespace(update=lambda *_: done.append("update"), draw=lambda *_: done.append("draw"))
    monkeypatch.setattr(viewport_module, "Viewport", lambda _: made)
    ZrakaRenderEngine.view_draw(engine, None, None)
    assert done == ["update", "draw"]
