# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels, presets, preferences and what is taken over from Cycles."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import bpy
import numpy as np
import pytest

from zraka.addon import headless, monitor, preferences, presets, properties, takeover, ui, view_layer
from zraka.addon.ui import curve
from zraka.core.film import Film, Step
from zraka.core.settings import Settings
from zraka.core.visibility import UNLIMITED


class Layout:
    """Stands for Blender's layout: what it is asked to draw must exist."""

    def __init__(self, log):
        self._log = log

    def prop(self, data, name, **_):
        assert name in data.bl_rna.properties, f"{data} has no {name}"
        self._log.append(name)

    def operator(self, name, **_):
        module, function = name.split(".")
        assert getattr(getattr(bpy.ops, module), function).get_rna_type()
        self._log.append(name)
        return SimpleNamespace()

    def label(self, text="", **_):
        self._log.append(text)

    def popover(self, panel, **_):
        assert hasattr(bpy.types, panel)

    def template_preview(self, data):
        self._log.append("preview")

    template_curve_mapping = prop

    def template_icon(self, icon, scale):
        self._log.append("icon")

    def template_list(self, kind, name, data, items, owner, active, **_):
        assert hasattr(bpy.types, kind)
        self.prop(data, items)
        self.prop(owner, active)

    def template_node_view(self, tree, node, socket):
        self._log.append(socket.name)

    def column(self, **_):
        return Layout(self._log)

    row = grid_flow = column


def drawn(cls, context):
    """What a panel shows, None where it is not shown."""
    if not cls.poll(context):
        return None
    log = []
    panel = SimpleNamespace(layout=Layout(log))
    for name in ("draw", "draw_settings", "draw_more", "draw_header", "draw_header_preset", "switches"):
        function = getattr(cls, name, None)
        if callable(function):
            function = function.__get__(panel)
        setattr(panel, name, function)
    for name in ("draw_header", "draw_header_preset", "draw"):
        if getattr(panel, name) is not None:
            getattr(panel, name)(context)
    return log


@pytest.fixture
def context(blender_scene, add_camera):
    """A context as the properties editor gives it, of a scene with one of everything."""
    camera = add_camera(blender_scene)
    camera.data.type = "PANO"
    light = bpy.data.lights.new("Lamp", "AREA")
    return SimpleNamespace(
        engine="ZRAKA",
        scene=blender_scene,
        view_layer=blender_scene.view_layers[0],
        object=bpy.data.objects.new("Ground", None),
        camera=camera.data,
        light=light,
        material=bpy.data.materials.new("Grey"),
        world=bpy.data.worlds.new("Sky"),
    )


PANELS = [*ui.CLASSES, *(cls for cls in view_layer.CLASSES if issubclass(cls, bpy.types.Panel))]


@pytest.mark.parametrize("method", ["PHONG", "RAYCAST", "RAYTRACE", "PATHTRACE"])
def test_every_panel_draws(context, method):
    context.scene.zraka.method = method
    seen = {cls.__name__: drawn(cls, context) for cls in PANELS}
    seen["mesh"] = None
    context.object = bpy.data.objects.new("Cube", bpy.data.meshes.new("Cube"))
    seen |= {cls.__name__: drawn(cls, context) for cls in PANELS if "ray_visibility" in cls.__name__}
    hidden = {name for name, words in seen.items() if words is None} - {"mesh"}
    only_paths = {"RENDER_PT_zraka_clamping", "RENDER_PT_zraka_film_transparency"}
    only_classic = {"RENDER_PT_zraka_overrides"}
    assert hidden == (only_classic if method == "PATHTRACE" else only_paths)
    limits = [name for name in seen["RENDER_PT_zraka_max_bounces"] if name.endswith(("depth", "bounces"))]
    assert limits == {
        "RAYTRACE": ["depth", "glossy_bounces", "transmission_bounces", "transparent_depth"],
        "PATHTRACE": ["depth", "diffuse_bounces", "glossy_bounces", "transmission_bounces", "transparent_depth"],
    }.get(method, ["transparent_depth"])


def test_no_panel_is_shown_to_other_engines(context):
    context.engine = "CYCLES"
    assert not [cls.__name__ for cls in PANELS if cls.poll(context)]


def test_parents_are_there_and_shown(context):
    """A panel inside one of Blender's is seen only if that one is Zraka's too."""
    for cls in PANELS:
        parent = getattr(cls, "bl_parent_id", None)
        if parent:
            assert "ZRAKA" in getattr(bpy.types, parent).COMPAT_ENGINES


def test_blenders_panels_are_borrowed_one_by_one(context):
    """Panels may share a set of engines; Cycles' do."""
    wanted = {cls.__name__ for cls in (*PANELS, *ui.shared_panels())}
    assert {"EEVEE_WORLD_PT_mist", "DATA_PT_EEVEE_light", "OBJECT_PT_visibility", "DATA_PT_lens"} <= wanted
    shown = {
        name
        for name in dir(bpy.types)
        if "ZRAKA" in getattr(getattr(bpy.types, name), "COMPAT_ENGINES", ()) and "zraka" not in name.lower()
    }
    assert shown <= wanted
    assert "CYCLES_RENDER_PT_sampling" not in shown


def test_every_setting_has_a_tooltip_and_a_place(context):
    shown = set()
    for method in ("RAYTRACE", "PATHTRACE"):
        context.scene.zraka.method = method
        for cls in PANELS:
            shown |= set(drawn(cls, context) or ())
    names = [name for name in context.scene.zraka.bl_rna.properties.keys() if name not in {"rna_type", "name"}]
    assert set(names) - shown == {"took_over"}
    for name in names:
        assert len(context.scene.zraka.bl_rna.properties[name].description) > 20


# -- presets -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "samples", "depth"), [("draft", 16, 4), ("final", 4096, 16), ("thesis", 30, 5)])
def test_presets(blender_scene, name, samples, depth):
    (folder,) = [path for path in bpy.utils.preset_paths(presets.FOLDER) if "presets" in path]
    path = Path(folder) / f"{name}.py"
    for value in presets.VALUES:
        assert f"zraka.{value} = " in path.read_text(encoding="utf-8")
    bpy.ops.script.execute_preset(filepath=str(path), menu_idname="ZRAKA_PT_sampling_presets")
    assert (blender_scene.zraka.samples, blender_scene.zraka.depth) == (samples, depth)


# -- preferences -------------------------------------------------------------------------------------------------------


def test_preferences(blender_scene, monkeypatch):
    log = []
    page = SimpleNamespace(layout=Layout(log), bl_rna=preferences.ZrakaPreferences.bl_rna)
    preferences.ZrakaPreferences.draw(page, None)
    assert {"threads", "viewport_budget"} <= set(log)
    pytest.importorskip("embreex")
    assert preferences.install_trouble() == ""
    monkeypatch.setattr(preferences.importlib.util, "find_spec", lambda name: None)
    assert "embreex for Python" in preferences.install_trouble()
    assert (preferences.preferred_threads(), preferences.viewport_budget()) == (0, 0.04)


def test_preferred_threads_are_those_of_scenes_without_a_number(blender_scene, monkeypatch):
    monkeypatch.setattr(properties, "preferred_threads", lambda: 3)
    assert properties.settings_of(blender_scene).threads == 3
    blender_scene.render.threads_mode, blender_scene.render.threads = "FIXED", 2
    assert properties.settings_of(blender_scene).threads == 2


# -- Cycles' settings --------------------------------------------------------------------------------------------------


@pytest.fixture
def fresh(blender_scene):
    """A scene whose settings nobody touched."""
    return bpy.data.scenes.new("Fresh")


def test_cycles_settings_are_taken_over(fresh):
    cycles = fresh.cycles
    cycles.samples, cycles.preview_samples, cycles.adaptive_threshold = 77, 33, 0.05
    cycles.use_preview_adaptive_sampling = False
    cycles.max_bounces, cycles.transparent_max_bounces = 5, 6
    cycles.diffuse_bounces, cycles.glossy_bounces, cycles.transmission_bounces = 1, 0, 12
    cycles.sample_clamp_direct, cycles.sample_clamp_indirect = 0.0, 4.0
    cycles.film_exposure, cycles.pixel_filter_type, cycles.filter_width = 2.0, "GAUSSIAN", 2.5
    cycles.seed, cycles.time_limit = 9, 60.0
    cycles.caustics_reflective = False
    cycles.film_transparent_glass, cycles.film_transparent_roughness = True, 0.25
    said = takeover.first_use(fresh)
    found = properties.settings_of(fresh)
    assert found == Settings(
        width=found.width,
        height=found.height,
        samples=77,
        depth=6,
        diffuse_bounces=1,
        glossy_bounces=0,
        transmission_bounces=12,
        transparent_depth=6,
        seed=9,
        time_limit=60.0,
        noise_target=pytest.approx(0.05),
        adaptive=True,
        clamp_indirect=12.0,
        pixel_filter="gaussian",
        filter_width=2.5,
        exposure=2.0,
        processes=True,
        shown=False,
        transparent_glass=True,
        transparent_roughness=0.25,
    )
    assert (fresh.zraka.viewport_samples, fresh.zraka.viewport_noise_target) == (33, 0.0)
    assert "77 samples" in said
    assert "not taken over: no reflective caustics" in said
    assert takeover.pop_unsaid()[-1] == said
    assert takeover.pop_unsaid() == []


def test_it_happens_once_and_only_where_nothing_was_chosen(fresh):
    assert takeover.first_use(fresh) == ""  # nobody chose anything of Cycles'
    fresh.cycles.samples = 50
    fresh.zraka.depth = 3
    assert takeover.first_use(fresh) == ""
    fresh.zraka.property_unset("depth")
    assert takeover.first_use(fresh)
    fresh.cycles.samples = 60
    assert takeover.first_use(fresh) == ""
    assert fresh.zraka.samples == 50


def test_limits_of_one_kind_of_bounce_are_told_where_they_count(fresh):
    fresh.cycles.samples = 50
    said = takeover.take_over(fresh)
    assert "depth 13, 4 diffuse bounces, 4 glossy bounces, transparent depth 8" in said
    assert "not taken over" not in said
    fresh.cycles.max_bounces = 4
    assert "depth 5, transparent depth 8" in takeover.take_over(fresh)


def test_as_many_bounces_as_the_slider_has_are_no_limit(fresh):
    """Blender's own files have deep paths too."""
    fresh.zraka.depth = 4000
    assert not properties.settings_of(fresh).limits_kinds
    fresh.zraka.glossy_bounces = 1023
    assert properties.settings_of(fresh).bounces == (UNLIMITED, 1023, UNLIMITED)


def test_the_button_takes_defaults_over_too(blender_scene):
    bpy.ops.zraka.take_over_cycles()
    assert (blender_scene.zraka.samples, blender_scene.zraka.depth, blender_scene.zraka.clamp_indirect) == (
        4096,
        13,
        30,
    )
    assert blender_scene.zraka.took_over


def test_cycles_own_defaults_are_known(fresh):
    for name, value in takeover.DEFAULTS.items():
        assert getattr(fresh.cycles, name) == (pytest.approx(value) if isinstance(value, float) else value)


def test_a_file_tells_without_cycles_add_on(fresh):
    """The numbers stay in the file, an enumeration as a bare one."""
    fresh.cycles.samples, fresh.cycles.pixel_filter_type = 50, "GAUSSIAN"
    known = {name: getattr(fresh, name) for name in ("objects", "zraka")}
    stored = takeover._stored(fresh)
    assert (stored["samples"], stored["pixel_filter_type"]) == (50, 1)
    bare = SimpleNamespace(**known, bl_system_properties_get=lambda: {"cycles": stored}, get=lambda name: None)
    values, chosen = takeover.cycles_settings(bare)
    assert (values["samples"], values["pixel_filter_type"], values["max_bounces"]) == (50, "GAUSSIAN", 12)
    assert chosen == {"samples", "pixel_filter_type"}
    assert takeover.cycles_settings(SimpleNamespace(get=lambda name: None))[1] == set()


def test_automatic_thresholds():
    values = takeover.DEFAULTS | {"adaptive_threshold": 0.0, "samples": 100, "preview_samples": 0}
    settings = takeover.to_zraka(values)
    assert (settings["noise_target"], settings["viewport_samples"]) == (0.01, 100)


def test_a_render_without_a_window_takes_over(fresh, monkeypatch, add_camera):
    """``blender -b file -E ZRAKA -f 1`` tells no subscriber of the engine."""
    fresh.cycles.samples = 50
    takeover._on_render(fresh)
    assert not fresh.zraka.took_over  # another engine's scene
    fresh.render.engine = "ZRAKA"
    takeover._on_render(fresh)
    assert fresh.zraka.samples == 50


def test_the_command_line_takes_over_and_says_so(blender_scene, add_camera):
    add_camera(blender_scene)
    blender_scene.zraka.property_unset("samples")
    blender_scene.cycles.samples, blender_scene.cycles.film_exposure = 50, 2.0
    names = ("method", "samples", "depth", "threads", "seed", "time_limit")
    job = headless.export(bpy, blender_scene, SimpleNamespace(size=(8, 8), **dict.fromkeys(names)))
    assert (job.settings.samples, job.settings.exposure) == (50, 2.0)
    assert any("Taken over from Cycles: 50 samples" in message for message in job.diagnostics.messages())


# -- the latest render -------------------------------------------------------------------------------------------------


def test_the_latest_render_is_shown(context, monkeypatch):
    latest = monitor.Monitor()
    monkeypatch.setattr(ui.latest, "monitor", latest)
    assert drawn(ui.latest.RENDER_PT_zraka_latest, context) == ["Nothing was rendered yet", "use_error_table"]
    shot = monitor.Shot(context.scene.name)
    latest.begin(shot, "", Settings(method="raytrace"))
    drawn(ui.latest.RENDER_PT_zraka_latest, context)  # before the first pass
    film = Film(2, 2)
    rng = np.random.default_rng(1)
    for sample in range(8):
        film.add(np.arange(4), rng.random((3, 4), np.float32), [sample])
        film.samples, film.stats = sample + 1, {"seconds": 0.1 * (sample + 1), "rays": {"camera": 1000}}
        film.history.append(Step(film.samples, film.stats["seconds"], film.error()))
        latest.note(shot, film)
    words = drawn(ui.latest.RENDER_PT_zraka_latest, context)
    assert [word for word in words if word.startswith("Ray Tracing, ")]  # without a window there are no icons
    assert "0.80" in words
    assert {"zraka.error_curve", "zraka.error_report"} <= set(words)
    curve.forget()
