# SPDX-License-Identifier: GPL-3.0-or-later
"""Extreme and stiff scenes: each defect that they showed, the grid's judgement, and how far each quantity may go."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from zraka.core.compile import compile_scene
from zraka.core.diagnostics import Diagnostics
from zraka.core.lights.triangle import first_in_place
from zraka.core.scene import Material
from zraka.core.settings import Settings
from zraka.core.stability import document, glasses, hair, items, lamps, meshes, moving, pictures, placing, sight, stiff
from zraka.core.stability.axis import Axis, holds, run_value, widest
from zraka.core.stability.case import ALL_VARIANTS, Case, Outcome, Variant, compiled_of, measure
from zraka.core.stability.run import AXES, Report, run

RANGES = json.loads(Path(__file__).with_name("stability_ranges.json").read_text(encoding="utf-8"))
AXIS_OF = {axis.name: axis for axis in AXES}


def verdict(case, *variant):
    outcome = measure(case, *variant)
    return outcome.verdict, outcome.note


# -- defects found -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("form", ["vertex at 1e10", "vertex at 1e30", "vertex at -3e38"])
def test_a_vertex_far_away_leaves_the_others_their_places(form):
    """The tables' zero was the middle of all, from which float32 did not tell the others apart."""
    assert verdict(meshes.FORMS[form])[0] == "pass"


@pytest.mark.parametrize("distance", [1e6, 1e8, 1e30])
def test_an_object_far_away_leaves_the_others_their_form(distance):
    assert verdict(AXIS_OF["distance of another object"].case(distance))[0] == "pass"


def test_the_zero_is_the_middle_where_nothing_is_far():
    description = placing.with_an_outlier(1e3)
    settings = Settings(width=1, height=1)
    geometry = compile_scene(description, settings, Diagnostics()).geometry
    assert np.allclose(geometry.origin[0], (1000.5 - 2) / 2)


@pytest.mark.parametrize("radius", [1e-6, 1e-5, 1e-4, 1e-2])
def test_the_back_of_a_tiny_emitter_does_not_shine_through_its_front(radius):
    """Shadow rays ended by a share of their length early that was more than the whole ball: it shone twice."""
    assert verdict(AXIS_OF["emitting ball, radius"].case(radius))[0] == "pass"


@pytest.mark.parametrize("value", [1e37, np.inf])
def test_a_picture_of_huge_texels_on_an_emitter_gives_no_warning_of_numpy(value):
    """The mean by which the emitter is chosen had no float32: found by fuzz, core seed 1717."""
    case = Case(lambda: pictures.pictured(pictures.level(4, 4, value)), settings={"depth": 2}, told="not finite")
    assert verdict(replace(case, finite=np.isfinite(value)))[0] == "pass"


def test_emitters_in_one_place_shine_once():
    """Each of two coincident faces was a light of its own, and shadow rays pass both."""
    assert verdict(meshes.FORMS["a room whose walls are there twice"])[0] == "pass"


def test_triangles_in_one_place_are_found_whatever_their_corners_order():
    triangles = np.random.default_rng(0).random((5, 3, 3)).astype(np.float32)
    again = triangles[[3, 1]][:, [2, 0, 1]]
    corners = np.concatenate([triangles, again, triangles[:1]]).reshape(-1, 9).T
    kind = np.array([0, 0, 0, 0, 0, 0, 0, 7])
    assert first_in_place(corners, kind).tolist() == [0, 1, 2, 3, 4, 3, 1, 7]
    assert first_in_place(np.zeros((9, 0)), np.zeros(0, int)).size == 0


@pytest.mark.parametrize("place", ["area light in a black ceiling", "area light in a black floor"])
def test_a_lamp_in_a_surface_is_seen_by_shadow_rays_and_scattered_rays_alike(place):
    """Only shadow rays ended before the surface, so that scattered rays lost their share: 5% too dark."""
    assert verdict(lamps.PLACES[place])[0] == "pass"


@pytest.mark.parametrize(
    "material",
    [Material.diffuse(1.01), Material.principled(base_color=(0.5, 2.0, 0.5)), Material.glossy((1.5, 1, 1), 0.3)],
)
def test_an_albedo_above_one_is_told(material):
    diagnostics = Diagnostics()
    settings = Settings(width=1, height=1)
    compile_scene(meshes.sunlit(meshes.placed(meshes.quad(), material)), settings, diagnostics)
    assert "albedo above 1" in "".join(diagnostics.messages())


def test_nothing_is_told_of_an_albedo_of_one():
    diagnostics = Diagnostics()
    things = [meshes.placed(meshes.quad(), m) for m in (Material.diffuse(1.0), Material.emission(strength=9.0))]
    compile_scene(meshes.sunlit(*things), Settings(width=1, height=1), diagnostics)
    assert diagnostics.messages() == []


# -- judgement ---------------------------------------------------------------------------------------------------------

FLOOR = Case(lambda: placing.lit_floor(1.0), placing.LIT, settings={"depth": 1})


@pytest.mark.parametrize("variant", ALL_VARIANTS)
def test_a_right_picture_passes_by_every_method_route_and_set_of_features(variant):
    assert verdict(replace(FLOOR, methods=(variant.method,)), variant)[0] == "pass"


@pytest.mark.parametrize(
    ("change", "found"),
    [
        ({"truth": placing.LIT * 1.01}, "fail"),
        ({"truth": placing.LIT * 1.01, "methods": ("phong",)}, "pass"),
        ({"told": "never said"}, "fail"),
        ({"build": lambda: 1 / 0}, "fail"),
        ({"build": lambda: np.float32(3e38) * np.float32(9)}, "fail"),
    ],
)
def test_a_wrong_picture_fails(change, found):
    assert verdict(replace(FLOOR, **change))[0] == found


def test_samples_that_are_not_finite_fail_where_the_scene_is_finite():
    case = pictures.TEXTURES["NaN texel"]
    assert verdict(case)[0] == "pass"
    spoiled = Case(lambda: pictures.emitting(np.inf), settings={"depth": 2})
    assert verdict(spoiled) == ("fail", spoiled and measure(spoiled).note)


def test_noise_that_hides_everything_fails():
    noisy = Case(lambda: stiff._slit(), stiff.slit_truth(), samples=64, settings={"depth": 1})
    assert verdict(noisy) == ("fail", "too noisy to tell")


def test_the_widest_range_grows_from_the_usual_value_to_the_first_failure():
    axis = Axis("a", "", None, (1, 2, 3, 4, 5), 3, (2, 4))
    outcome = Outcome("pathtrace", "", "", 0.0, 0.0, 0, 0.0, "pass", "")

    def found(bad):
        results = [
            type("R", (), {"axis": axis, "value": v, "verdict": "fail" if v in bad else "pass"}) for v in axis.values
        ]
        return widest(axis, results)

    assert outcome.verdict == "pass"
    assert found(()) == (1, 5)
    assert found((1, 5)) == (2, 4)
    assert found((1, 4)) == (2, 3)
    assert found((3,)) is None
    assert holds(axis, (2, 4), axis.values)
    assert not holds(axis, (2, 3), axis.values)
    assert holds(axis, (2, 3), (2, 3))
    assert not holds(axis, None, axis.values)


# -- the grid ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", RANGES["quick"])
def test_every_range_is_as_wide_as_ever(name):
    """`stability_ranges.json` holds the widest ranges that passed, of both runs; they may only grow."""
    for value in RANGES["quick"][name]:
        assert verdict(AXIS_OF[name].case(value))[0] == "pass", value


@pytest.mark.slow
@pytest.mark.parametrize("name", RANGES["full"])
def test_every_range_of_the_full_run_is_as_wide_as_ever(name):
    for value in set(RANGES["full"][name]) - set(RANGES["quick"][name]):
        assert verdict(AXIS_OF[name].case(value))[0] == "pass", value


def test_every_numeric_axis_has_its_ranges_on_record():
    assert set(RANGES["quick"]) == {axis.name for axis in AXES if axis.usual is not None}
    assert set(RANGES["full"]) == set(RANGES["quick"])
    for kind, ranges in RANGES.items():
        for name, found in ranges.items():
            assert holds(AXIS_OF[name], found, AXIS_OF[name].chosen(kind == "quick")), name
    for axis in AXES:
        assert set(axis.quick) <= set(axis.values), axis.name
        assert axis.usual is None or axis.usual in axis.chosen(True)


@pytest.mark.parametrize(
    ("cases", "name"),
    [(meshes.FORMS, n) for n in meshes.FORMS]
    + [(pictures.EMISSIONS, n) for n in pictures.EMISSIONS]
    + [(pictures.TEXTURES, n) for n in pictures.TEXTURES]
    + [(hair.STRANDS, n) for n in hair.STRANDS]
    + [(sight.SEEN, n) for n in sight.SEEN]
    + [(moving.MOTIONS, n) for n in moving.MOTIONS if n != "NaN camera for a moment"]
    + [(glasses.NESTED, n) for n in ("overlapping balls", "touching balls", "camera in a ball", "camera on a ball")],
)
def test_what_is_bad_does_no_harm(cases, name):
    assert verdict(cases[name])[0] == "pass"


def test_what_cannot_be_rendered_is_told():
    assert verdict(moving.MOTIONS["NaN camera for a moment"])[0] == "out of range"


def test_the_other_route_casts_all_its_rays_through_it():
    """What some rays do not see has trees of its own."""
    case = sight.SEEN["roof unseen by shadow rays"]
    compiled = compiled_of(case.build(), Settings(width=1, height=1), Variant("pathtrace", False), Diagnostics())
    assert not compiled.visibility.shadow.native
    assert verdict(case, Variant("pathtrace", False))[0] == "pass"


def test_every_axis_belongs_to_an_item_and_every_item_has_one():
    names = [axis.name for axis in AXES] + [f"stiff: {s.name}" for s in stiff.STIFF]
    for item, beginnings in items.ITEMS.items():
        assert all(any(name.startswith(b) for name in names) for b in beginnings), item
    covered = tuple(b for beginnings in items.ITEMS.values() for b in beginnings)
    assert [name for name in names if not name.startswith(covered)] == []


@pytest.mark.parametrize("scene", [s for s in stiff.STIFF if s.quick], ids=lambda s: s.name)
def test_stiff_scenes_are_unbiased(scene):
    assert stiff.measure(scene._replace(case=replace(scene.case, samples=16))).verdict == "pass"


def test_a_biased_mean_is_found():
    sun = stiff.STIFF[0]
    wrong = sun._replace(case=replace(sun.case, truth=sun.case.truth * 1.002, samples=16))
    assert stiff.measure(wrong).verdict == "fail"


def test_a_report_is_written_and_may_be_interrupted():
    axis = replace(AXIS_OF["offset, sunlit floor, in vertices"], quick=(0.0, 1e6))
    asked = iter([False, False, True])
    report = run(True, lambda: next(asked, True), axes=(axis,), scenes=stiff.STIFF[:1])
    assert report.interrupted
    assert report.failures == []
    assert len(report.results) == 2
    sun = stiff.STIFF[0]
    sun = sun._replace(case=replace(sun.case, samples=16))
    full = report._replace(interrupted=False, findings=[stiff.measure(sun)])
    texts = document.markdown(full), document.page(full), json.dumps(document.data(full), allow_nan=False)
    assert all(axis.name in text and "sun disk" in text for text in texts)
    assert all("2 pass" in text and "not run" in text for text in texts[:2])
    assert full.ranges == {axis.name: (0.0, 1e6)}


def test_a_failing_case_and_a_narrow_axis_are_named():
    axis = Axis("bad", "", lambda v: replace(FLOOR, truth=v), (1.0, placing.LIT), placing.LIT, (1.0, placing.LIT))
    report = Report(False, [run_value(axis, v, True) for v in axis.values], [], 0.0, False)
    assert report.failures == ["bad: 1.0", "bad: narrower than it must be"]
    assert "too narrow" in document.markdown(report)
    assert 'class="fail"' in document.page(report)


def test_the_other_route_is_another():
    assert [v.route for v in (Variant("pathtrace"), Variant("pathtrace", native=False))] == ["C API", "TriangleMesh"]
