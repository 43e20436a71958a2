# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of the first hit, where the answer is known."""

import dataclasses

import numpy as np
import pytest

from zraka.core.compile import compile_scene
from zraka.core.diagnostics import Diagnostics
from zraka.core.methods.cryptomatte import metadata, name_hash, name_id, ranked
from zraka.core.methods.guides import CHANNELS, NOTHING, render_guides
from zraka.core.scene import Instance, Material, Spheres, World
from zraka.core.settings import Guides, Settings

from .scenes import camera, cornell, looking_down, placed, quad, scene

MATTES = {"crypto_object", "crypto_material", "crypto_asset"}


def guides(description, *names, size=16, samples=4, **options):
    own = {k: options.pop(k) for k in ("threads", "chunk") if k in options}
    chosen = Guides(names=frozenset(names), **options)
    settings = Settings(width=size, height=size, samples=samples, guides=chosen, **({"threads": 1} | own))
    compiled = compile_scene(description, settings, Diagnostics())
    return render_guides(compiled, description, settings, around=(description, description))


def centre(picture, size=16):
    return picture.reshape(-1, size, size)[:, size // 2, size // 2]


def ball(material, center=(0, 0, 0), radius=1.0):
    return Spheres(np.array([center], float), np.array([radius]), material)


# -- geometry ----------------------------------------------------------------------------------------------------------


def test_depth_is_along_the_axis_and_one_ray_of_the_centre():
    floor = placed(quad(100.0), Material.diffuse())
    view = scene(camera((0, 0, 3), (0, 0, 0), fov=1.0, up=(0, 1, 0)), floor)
    np.testing.assert_allclose(guides(view, "depth")["depth"], 3.0, rtol=1e-5)
    position = guides(view, "position")["position"].reshape(3, 16, 16)
    np.testing.assert_allclose(position[0, 0], 3 * ((np.arange(16) + 0.5) / 8 - 1), atol=1e-5)
    np.testing.assert_allclose(position[2], 0, atol=1e-5)


def test_nothing_is_far_and_all_mist():
    found = guides(looking_down(), *CHANNELS, *MATTES)
    assert (found.pop("depth") == np.float32(NOTHING)).all()
    assert (found.pop("mist") == 1).all()
    for name, picture in found.items():
        assert not picture.any(), name


def test_normals_face_the_viewer():
    below = looking_down(placed(quad(4.0, normal="-z"), Material.diffuse()))
    np.testing.assert_allclose(centre(guides(below, "normal")["normal"]), (0, 0, 1), atol=1e-6)
    turned = guides(below, "denoising_normal")["denoising_normal"]
    np.testing.assert_allclose(centre(turned), (0, 0, -1), atol=1e-6)


def test_uv_tells_where_there_is_a_map():
    plain = quad(2.0)
    mapped = dataclasses.replace(plain, uvs={"a": np.float32([[0, 0], [1, 0], [1, 1], [0, 0], [1, 1], [0, 1]])})
    for mesh, expected in ((plain, (0, 0, 0)), (mapped, (0.5, 0.5, 1))):
        uv = guides(looking_down(placed(mesh, None)), "uv")["uv"]
        np.testing.assert_allclose(uv.mean(axis=1), expected, atol=2e-3)


def test_indices_by_name_or_as_described():
    material = dataclasses.replace(Material.diffuse(), index=7)
    view = looking_down(Instance(quad(4.0), materials=(material,), name="floor"))
    found = guides(view, "object_index", "material_index", indices={"floor": 3})
    assert (found["object_index"] == 3).all() and (found["material_index"] == 7).all()
    assert (guides(view, "object_index")["object_index"] == 0).all()


@pytest.mark.parametrize("falloff, expected", [("LINEAR", 0.25), ("QUADRATIC", 0.0625), ("INVERSE_QUADRATIC", 0.5)])
def test_mist_grows_with_distance(falloff, expected):
    view = looking_down(placed(quad(4.0), None), height=3.0)
    mist = guides(view, "mist", mist_start=1.0, mist_depth=8.0, mist_falloff=falloff)["mist"]
    np.testing.assert_allclose(mist, expected, atol=1e-3)


# -- what is looked through --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("alpha, depth", [(0.8, 1.0), (0.3, 2.0)])
def test_surfaces_that_are_clear_enough_are_looked_through(alpha, depth):
    veil = placed(quad(4.0), Material.principled(alpha=alpha))
    view = looking_down(veil, placed(quad(4.0, (0, 0, -1)), None))
    np.testing.assert_allclose(guides(view, "depth")["depth"], depth, rtol=1e-4)
    assert (guides(view, "depth", alpha_threshold=0.0)["depth"] < 1.1).all()


def test_mattes_share_a_pixel_by_opacity():
    view = looking_down(
        Instance(quad(4.0), materials=(Material.principled(alpha=0.75),), name="veil"),
        Instance(quad(4.0, (0, 0, -1)), materials=(Material.diffuse(),), name="floor"),
    )
    layer = guides(view, "crypto_object", samples=16)["crypto_object"]
    ids = layer[[0, 2]].view(np.uint32)
    coverage = {name: layer[[1, 3]][ids == name_id(name)].sum() / layer.shape[1] for name in ("veil", "floor")}
    assert coverage["veil"] == pytest.approx(0.75, abs=0.02)
    assert coverage["floor"] == pytest.approx(0.25, abs=0.02)
    assert (layer[1] >= layer[3]).all()
    assert not layer[4:].any()


# -- colours -----------------------------------------------------------------------------------------------------------


def test_colours_by_what_the_lobes_do():
    names = ("diffuse_color", "glossy_color", "transmission_color")
    white = (1.0, 1.0, 1.0)
    f0 = 0.04  # of glass of index 1.5
    for material, expected in (
        (Material.diffuse((0.8, 0.4, 0.2)), ((0.8, 0.4, 0.2), 0, 0)),
        (Material.glossy((0.5, 0.6, 0.7)), (0, (0.5, 0.6, 0.7), 0)),
        (Material.glass(white), (0, f0, 1 - f0)),
        (Material.single("translucent", color=(0.3, 0.2, 0.1)), ((0.3, 0.2, 0.1), 0, 0)),
    ):
        found = guides(looking_down(placed(quad(4.0), material)), *names)
        for name, color in zip(names, expected, strict=True):
            np.testing.assert_allclose(centre(found[name]), np.broadcast_to(color, 3), atol=2e-3)


def test_emission_and_environment_are_seen_directly():
    lamp = ball(Material.emission((1.0, 0.5, 0.25), 4.0), radius=0.003)
    view = dataclasses.replace(looking_down(), spheres=(lamp,), world=World((0.1, 0.2, 0.3)))
    found = guides(view, "emission", "environment")
    np.testing.assert_allclose(centre(found["emission"]), (4, 2, 1), rtol=1e-5)
    assert not centre(found["environment"]).any()
    np.testing.assert_allclose(found["environment"][:, 0], (0.1, 0.2, 0.3), rtol=1e-5)
    assert not found["emission"][:, 0].any()


@pytest.mark.parametrize("roughness, shows_itself", [(0.0, False), (0.2, False), (0.5, True)])
def test_a_denoiser_is_told_what_mirrors_show(roughness, shows_itself):
    mirror = placed(quad(4.0), Material.glossy((0.9, 0.9, 0.9), roughness))
    ceiling = placed(quad(400.0, (0, 0, 2), "-z"), Material.diffuse((0.2, 0.4, 0.8)))
    parts = ("albedo", "normal", "depth", "specular", "roughness")
    found = guides(looking_down(mirror, ceiling), *(f"denoising_{part}" for part in parts), samples=16)
    albedo, normal, depth, specular, rough = (found[f"denoising_{part}"].mean(axis=1) for part in parts)
    assert rough == pytest.approx(roughness, abs=1e-3)
    np.testing.assert_allclose(specular, 0.0 if shows_itself else 0.9, rtol=0.02)
    if shows_itself:
        np.testing.assert_allclose(albedo, 0.9, rtol=0.1)
        np.testing.assert_allclose(normal, (0, 0, -1), atol=1e-3)
        assert depth == pytest.approx(1.0, rel=1e-3)
    else:
        np.testing.assert_allclose(albedo, 0.9 * np.array([0.2, 0.4, 0.8]), rtol=0.05)
        np.testing.assert_allclose(normal, (0, 0, 1), atol=1e-2)
        assert depth == pytest.approx(3.0, rel=0.1)


def test_what_shows_itself_and_others_is_blended():
    """By Cycles' smoothsteps of the lobe's width, 0.04 of 0.15, and of the share that shows itself, of one half."""
    smooth = lambda x: 3 * x**2 - 2 * x**3  # noqa: E731
    plain = smooth(0.04 / 0.15)
    shown = smooth(plain / 0.5)
    mirror = placed(quad(4.0), Material.glossy((0.9, 0.9, 0.9), 0.2))
    ceiling = placed(quad(400.0, (0, 0, 2), "-z"), Material.diffuse((0.2, 0.4, 0.8)))
    parts = ("albedo", "normal", "specular")
    found = guides(looking_down(mirror, ceiling), *(f"denoising_{part}" for part in parts), samples=16, blends=True)
    albedo, normal, specular = (found[f"denoising_{part}"].mean(axis=1) for part in parts)
    left = 0.9 * (1 - plain) * (1 - shown)
    np.testing.assert_allclose(specular, 0.9 * (1 - plain), rtol=0.02)
    np.testing.assert_allclose(albedo, 0.9 * plain * shown + left * np.array([0.2, 0.4, 0.8]), rtol=0.03)
    np.testing.assert_allclose(normal, (0, 0, left - shown), atol=0.01)


# -- schedule ----------------------------------------------------------------------------------------------------------


def test_same_bytes_whatever_the_schedule():
    names = (*CHANNELS, *MATTES)
    base = guides(cornell(), *names, size=24)
    assert set(base) == set(names)
    for schedule in ({"threads": 3}, {"chunk": 100}):
        other = guides(cornell(), *names, size=24, **schedule)
        for name in names:
            np.testing.assert_array_equal(base[name], other[name], name)


def test_only_what_is_asked_for():
    assert guides(cornell()) == {}
    assert set(guides(cornell(), "depth")) == {"depth"}


def test_a_stop_leaves_nothing_half_done():
    settings = Settings(width=64, height=64, samples=16, threads=1, chunk=64, guides=Guides(frozenset({"normal"})))
    view = cornell()
    assert render_guides(compile_scene(view, settings, Diagnostics()), view, settings, lambda: True) == {}


# -- Cryptomatte -------------------------------------------------------------------------------------------------------


def test_hashes_of_names():
    # Published vectors of MurmurHash3_x86_32, seed 0.
    assert name_hash("") == 0
    assert name_hash("test") == 0xBA6BD213
    assert name_hash("Hello, world!") == 0xC0363E43
    assert name_hash("The quick brown fox jumps over the lazy dog") == 0x2E4FF723


def test_ids_are_normal_numbers():
    ids = np.array([name_id(f"thing {k}") for k in range(5000)], np.uint32)
    values = ids.view(np.float32)
    assert np.isfinite(values).all()
    assert (np.abs(values) >= np.finfo(np.float32).tiny).all()
    assert any(name_hash(f"thing {k}") != ids[k] for k in range(5000))


def test_metadata_is_found_by_name():
    fields = metadata("ViewLayer.CryptoObject", ["Ä"])
    assert fields["cryptomatte/542cafa/name"] == "ViewLayer.CryptoObject"
    assert fields["cryptomatte/542cafa/manifest"] == f'{{"Ä":"{name_id("Ä"):08x}"}}'
    assert {key.split("/")[2] for key in fields} == {"name", "hash", "conversion", "manifest"}


def test_ranks_are_by_coverage():
    number = np.array([[0, 2], [1, 2], [1, 0], [1, 0]])
    weight = np.float32([[1, 0], [1, 0], [1, 0.5], [1, 0]])
    out = ranked(number, weight, np.array([11, 22, 33], np.uint32), 1)
    assert out[[0, 2]].view(np.uint32).T.tolist() == [[22, 11], [11, 0]]
    assert out[[1, 3]].T.tolist() == [[0.75, 0.25], [0.125, 0]]


def test_things_of_one_name_are_one():
    out = ranked(np.array([[0], [1]]), np.ones((2, 1), np.float32), np.array([5, 5], np.uint32), 1)
    assert out[:, 0].tolist()[1:] == [1, 0, 0]
