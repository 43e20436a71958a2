# SPDX-License-Identifier: GPL-3.0-or-later
"""The engine inside Blender: what it registers, shows, reports and writes."""

from __future__ import annotations

from types import SimpleNamespace

import bpy
import numpy as np
import pytest

import zraka
from zraka.addon import denoise, headless, passes, properties, session, ui
from zraka.core import compile as compiling
from zraka.core import render as rendering
from zraka.core.diagnostics import Diagnostics, SceneError
from zraka.core.film import Film
from zraka.core.settings import METHODS, Settings

SETTINGS = """method samples depth diffuse_bounces glossy_bounces transmission_bounces transparent_depth seed time_limit
noise_target adaptive clamp_direct clamp_indirect
use_reflectivity reflectivity use_transparency transparency use_ior ior use_exponent exponent use_ambient ambient"""


def gradient(width, height):
    """Red rises to the right, green upward."""
    picture = np.ones((height, width, 4), np.float32)
    picture[..., 0] = np.arange(width)[None, :] / width
    picture[..., 1] = np.arange(height)[:, None] / height
    picture[..., 2] = 0.25
    return picture


def film_of(settings, samples):
    """A film that shows the gradient of the whole frame."""
    x0, y0, x1, y1 = settings.region
    film = Film(x1 - x0, y1 - y0)
    rows = gradient(settings.width, settings.height)[y0:y1, x0:x1, :3].reshape(-1, 3).T
    for sample in range(samples):
        film.add(np.arange(rows.shape[1]), rows.copy(), [sample])
        film.samples += 1
    return film


@pytest.fixture
def stub_core(monkeypatch):
    """In place of tracing: four passes that show a gradient, stopped where `cancelled` says so."""
    calls = SimpleNamespace(settings=[], passes=0)

    def render(compiled, settings, on_pass=None, on_tile=None, cancelled=None):
        calls.settings.append(settings)
        for number in range(1, 5):
            film = film_of(settings, number)
            calls.passes += 1
            on_pass(film, number / 4)
            if cancelled():
                break
        return film

    monkeypatch.setattr(compiling, "compile_scene", lambda scene, settings, diagnostics, before=None: None)
    monkeypatch.setattr(rendering, "render", render)
    return calls


def render_to(scene, path):
    """Render to an EXR file and read it: (H, W, 4), row 0 at the bottom."""
    image_settings = scene.render.image_settings
    if hasattr(image_settings, "media_type"):
        image_settings.media_type = "IMAGE"
    image_settings.file_format, image_settings.color_mode, image_settings.color_depth = "OPEN_EXR", "RGBA", "32"
    scene.render.filepath = str(path)
    with headless.quiet():
        bpy.ops.render.render(write_still=True)
    return read_picture(path)


def read_picture(path):
    image = bpy.data.images.load(str(path))
    pixels = np.zeros(image.size[0] * image.size[1] * 4, np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(image.size[1], image.size[0], 4)


# -- registration ------------------------------------------------------------------------------------------------------


def test_register_and_unregister_twice():
    for _ in range(2):
        zraka.register()
        zraka.register()
        assert bpy.types.Scene.bl_rna.properties["zraka"]
        assert "ZRAKA" in bpy.types.MATERIAL_PT_preview.COMPAT_ENGINES
        zraka.unregister()
        zraka.unregister()
        assert not hasattr(bpy.types.Scene, "zraka")
        assert not hasattr(bpy.types.Object, "zraka")
        assert not [
            p
            for p in bpy.types.Panel.__subclasses__()
            if "ZRAKA" in getattr(p, "COMPAT_ENGINES", ()) and not p.__module__.startswith("zraka.")
        ]


def test_blenders_panels_are_shared(blender_scene):
    names = {panel.__name__ for panel in ui.shared_panels()}
    assert {"RENDER_PT_color_management", "EEVEE_MATERIAL_PT_surface", "DATA_PT_lens"} <= names
    assert "VIEWLAYER_PT_layer_passes" not in names
    assert len(names) > 200


def test_settings_have_their_names_and_defaults(blender_scene):
    scene = bpy.data.scenes.new("fresh")
    assert set(SETTINGS.split()) <= set(scene.zraka.bl_rna.properties.keys())
    found = properties.settings_of(scene, width=640, height=480)
    # As Cycles; the core's box is plain, and it forks for nobody who has not asked. No window is open here.
    assert found == Settings(pixel_filter="blackman_harris", processes=True, shown=False)
    items = scene.zraka.bl_rna.properties["method"].enum_items
    assert [item.identifier.lower() for item in items] == list(METHODS)


def test_settings_of_a_scene(blender_scene):
    group = blender_scene.zraka
    group.method, group.depth, group.use_ior, group.ior, group.reflectivity = "RAYTRACE", 1024, True, 2.0, 0.5
    blender_scene.render.threads_mode, blender_scene.render.threads = "FIXED", 3
    found = properties.settings_of(blender_scene, samples=None, seed=7)
    assert (found.method, found.depth, found.samples, found.seed, found.threads) == ("raytrace", 1024, 2, 7, 3)
    assert (found.ior, found.reflectivity) == (2.0, None)


def test_an_empty_may_be_a_plane(blender_scene):
    empty = bpy.data.objects.new("Ground", None)
    assert not empty.zraka.plane
    empty.zraka.plane, empty.zraka.plane_material = True, bpy.data.materials.new("Grass")
    assert empty.zraka.plane_material.name == "Grass"


# -- pictures ----------------------------------------------------------------------------------------------------------


def test_the_picture_arrives(blender_scene, add_camera, stub_core, tmp_path):
    add_camera(blender_scene)
    picture = render_to(blender_scene, tmp_path / "whole.exr")
    np.testing.assert_allclose(picture, gradient(32, 24), atol=1e-6)
    assert stub_core.passes == 4


def test_the_compositor_comes_after(blender_scene, add_camera, stub_core, tmp_path):
    add_camera(blender_scene)
    denoising = denoise.set_up(blender_scene, blender_scene.view_layers[0])  # a tree in each Blender's way
    blender_scene.view_layers[0].zraka.use_pass_denoising = False
    tree, (link,) = denoising.id_data, denoising.outputs["Image"].links
    node = tree.nodes.new("CompositorNodeInvert")
    tree.links.new(denoising.inputs["Image"].links[0].from_socket, node.inputs["Color"])
    tree.links.new(node.outputs["Color"], link.to_socket)
    picture = render_to(blender_scene, tmp_path / "composed.exr")
    np.testing.assert_allclose(picture[..., :3], 1 - gradient(32, 24)[..., :3], atol=1e-5)


def test_the_sequencer_comes_after(blender_scene, add_camera, stub_core, tmp_path):
    """A strip shows what Zraka renders of another scene."""
    add_camera(blender_scene)
    cut = bpy.data.scenes.new("Cut")
    cut.render.resolution_x, cut.render.resolution_y, cut.render.resolution_percentage = 32, 24, 100
    cut.render.engine, cut.frame_end = "ZRAKA", 1
    cut.sequencer_colorspace_settings.name = bpy.context.scene.sequencer_colorspace_settings.name
    editor = cut.sequence_editor_create()
    strips = editor.strips if hasattr(editor, "strips") else editor.sequences  # before 4.4
    strips.new_scene("Shot", blender_scene, 1, 1)
    with bpy.context.temp_override(scene=cut):
        picture = render_to(cut, tmp_path / "cut.exr")
    assert stub_core.passes == 4
    difference = np.abs(picture[..., :3] - gradient(32, 24)[..., :3])
    assert difference.max() < 0.01
    bpy.data.scenes.remove(cut)


@pytest.mark.parametrize("crop", [False, True])
@pytest.mark.parametrize("edges", [(0.25, 0.75, 0.5, 1.0), (0.1, 0.7, 0.3, 0.9)])
@pytest.mark.parametrize("stripe", [50, 1 << 18])
def test_a_border(blender_scene, add_camera, stub_core, tmp_path, monkeypatch, crop, edges, stripe):
    monkeypatch.setattr(session, "STRIPE", stripe)
    add_camera(blender_scene)
    render = blender_scene.render
    render.resolution_x, render.resolution_y = 50, 30
    render.use_border, render.use_crop_to_border = True, crop
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = edges
    picture = render_to(blender_scene, tmp_path / "border.exr")
    (settings,) = stub_core.settings
    x0, y0, x1, y1 = settings.border
    inside = picture if crop else picture[y0:y1, x0:x1]
    np.testing.assert_allclose(inside, gradient(50, 30)[y0:y1, x0:x1], atol=1e-6)
    framed = headless.framed(film_of(settings, 1).image(), settings, crop)
    np.testing.assert_allclose(framed, picture, atol=1e-6)


def test_every_view_layer_is_rendered(blender_scene, add_camera, stub_core):
    add_camera(blender_scene)
    blender_scene.view_layers.new("second")
    blender_scene.view_layers.new("off").use = False
    with headless.quiet():
        bpy.ops.render.render()
    assert len(stub_core.settings) == 2


# -- errors ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("error", "sentence"),
    [
        (SceneError("mesh 'Cube' is too thin; give it a volume"), "mesh 'Cube' is too thin; give it a volume"),
        (ZeroDivisionError("by\nzero"), r"Zraka stopped \(ZeroDivisionError: by zero\)"),
        (ImportError("No module named 'embreex'"), r"Zraka lacks a library \(No module named 'embreex'\)"),
        (KeyboardInterrupt(), "The render was interrupted"),
    ],
)
def test_an_error_is_one_sentence(blender_scene, add_camera, stub_core, monkeypatch, error, sentence):
    def fail(*args, **kwargs):
        raise error

    add_camera(blender_scene)
    monkeypatch.setattr(rendering, "render", fail)
    with headless.quiet(), pytest.raises(RuntimeError, match=sentence):
        bpy.ops.render.render()


class Reports(list):
    """Stands for an engine; remembers what is reported."""

    is_preview = False

    def report(self, kind, message):
        self.append((*kind, message))


def test_a_warning_is_said_once():
    engine, diagnostics = Reports(), Diagnostics()
    job = SimpleNamespace(diagnostics=diagnostics)
    one = session.Session()
    diagnostics.warn("hair is not rendered")
    one._warn(engine, job)
    diagnostics.warn("volumes are not rendered")
    one._warn(engine, job)
    assert engine == [("WARNING", "hair is not rendered"), ("WARNING", "volumes are not rendered")]


def test_a_preview_says_nothing():
    engine, diagnostics = Reports(), Diagnostics()
    engine.is_preview = True
    diagnostics.warn("hair is not rendered")
    session.Session()._warn(engine, SimpleNamespace(diagnostics=diagnostics))
    assert engine == []


# -- progress and cancel -----------------------------------------------------------------------------------------------


class FakeEngine:
    """Stands for Blender's side of a render: one layer, one pass; keeps what is shown.

    `rows` are those of the results that were merged, in their order, and `open` those not yet ended.
    """

    is_preview = False

    def __init__(self, cancel_after=None):
        self.stamped = {}
        self.progress, self.rows, self.open, self.polls = [], [], 0, 0
        self.cancel_after = cancel_after
        self.picture = np.zeros((4, 8, 4), np.float32)

    def begin_result(self, x, y, width, height, layer="", view=""):
        self.open += 1
        pixels = np.zeros((height, width, 4), np.float32)

        def keep(values):
            assert values.dtype == np.float32
            assert values.shape == (pixels.size,)
            pixels.reshape(-1)[:] = values

        target = SimpleNamespace(name="Combined", rect=SimpleNamespace(foreach_set=keep))
        depth = SimpleNamespace(name="Depth")
        place = slice(y, y + height), slice(x, x + width)
        return SimpleNamespace(layers=[SimpleNamespace(name=layer, passes=[target, depth])], place=place, pixels=pixels)

    def get_result(self):
        return SimpleNamespace(stamp_data_add_field=self.stamped.__setitem__)

    def end_result(self, result, cancel=False):
        self.open -= 1
        if not cancel:
            self.picture[result.place] = result.pixels
            self.rows.append((result.place[0].start, result.place[0].stop))

    def update_progress(self, progress):
        self.progress.append(progress)

    def update_stats(self, stats, info):
        pass

    def test_break(self):
        self.polls += 1
        return self.cancel_after is not None and self.polls > self.cancel_after


def render_faked(engine, settings):
    job = session.Job(None, settings, Diagnostics(), 0.0)
    session.render_job(job, engine, SimpleNamespace(name="layer"))
    return job


def test_the_first_pass_is_shown_and_then_on_a_budget(stub_core, monkeypatch):
    engine = FakeEngine()
    monkeypatch.setattr(session, "SHOW_EVERY", 60.0)
    render_faked(engine, Settings(width=8, height=4))
    assert (len(engine.rows), engine.progress, engine.open) == (2, [0.25], 0)  # the first and the last
    monkeypatch.setattr(session, "SHOW_EVERY", 0.0)
    for shown, pictures in ((True, 5), (False, 1)):  # where no window is open, the last one alone
        engine = FakeEngine()
        render_faked(engine, Settings(width=8, height=4, shown=shown))
        assert (len(engine.rows), engine.progress) == (pictures, [0.25, 0.5, 0.75, 1.0])


def test_large_pictures_come_in_stripes(stub_core, monkeypatch):
    """Each is a result of its own: while one is open, Blender holds its pixels twice."""
    monkeypatch.setattr(session, "STRIPE", 30)
    monkeypatch.setattr(session, "SHOW_EVERY", 60.0)
    engine = FakeEngine()
    render_faked(engine, Settings(width=8, height=4))
    assert (engine.rows, engine.open) == ([(0, 3), (3, 4)] * 2, 0)
    np.testing.assert_array_equal(engine.picture, gradient(8, 4))


def test_a_render_that_fails_at_once_is_black(stub_core, monkeypatch):
    def failing(compiled, settings, on_pass, cancelled):
        raise ValueError

    monkeypatch.setattr(rendering, "render", failing)
    engine = FakeEngine()
    engine.picture += 1
    with pytest.raises(ValueError):
        render_faked(engine, Settings(width=8, height=4))
    assert engine.open == 0
    assert not engine.picture.any()


def test_cancel_keeps_what_was_rendered(stub_core):
    engine = FakeEngine(cancel_after=0)
    render_faked(engine, Settings(width=8, height=4))
    assert (stub_core.passes, engine.open) == (1, 0)
    np.testing.assert_array_equal(engine.picture, gradient(8, 4))


def test_an_interrupt_keeps_what_was_rendered(stub_core, monkeypatch):
    def interrupted(compiled, settings, on_pass, cancelled):
        on_pass(film_of(settings, 1), 0.1)
        raise KeyboardInterrupt

    monkeypatch.setattr(rendering, "render", interrupted)
    engine = FakeEngine()
    with pytest.raises(KeyboardInterrupt):
        render_faked(engine, Settings(width=8, height=4))
    assert engine.open == 0
    np.testing.assert_array_equal(engine.picture, gradient(8, 4))


def test_a_pass_that_is_not_rendered_is_named(stub_core):
    job = render_faked(FakeEngine(), Settings(width=8, height=4))
    assert job.diagnostics.messages() == ["the pass 'Depth' is not rendered; it stays empty"]


def test_passes_are_listed_once(blender_scene):
    names = [p.name for p in passes.passes_of(blender_scene.view_layers[0])]
    assert names == ["Combined"]
    assert len(names) == len(set(names))


# -- the whole way -----------------------------------------------------------------------------------------------------


def test_a_lit_floor_by_every_method(blender_scene, add_camera, tmp_path):
    add_camera(blender_scene)
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
    for method in METHODS:
        blender_scene.zraka.method = method.upper()
        picture = render_to(blender_scene, tmp_path / f"{method}.exr")
        assert np.isfinite(picture).all()
        assert picture[..., :3].min() > 0.1
    # White light of irradiance pi on albedo 0.8: radiance 0.8, and nothing comes back to a plane.
    np.testing.assert_allclose(picture[..., :3], 0.8, rtol=1e-3)
