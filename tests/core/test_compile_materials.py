# SPDX-License-Identifier: GPL-3.0-or-later
"""Node graphs become programs: folded, shared, pruned, and never silently wrong."""

import numpy as np
import pytest

from zraka.core.arena import Arena
from zraka.core.bsdf import conductor, diffuse
from zraka.core.compile import compile_scene
from zraka.core.compile.graph import post_order
from zraka.core.compile.materials import compile_materials
from zraka.core.diagnostics import Diagnostics
from zraka.core.nodes.base import Context
from zraka.core.scene import Camera, Image, Instance, Link, Material, Node, Scene
from zraka.core.settings import Settings

from .scenes import quad


def compiled(*materials):
    diagnostics = Diagnostics()
    return compile_materials(materials, diagnostics), diagnostics.messages()


def colors(materials, m):
    """Weights (3,) of the lobes of material number m, which is constant."""
    number = materials.program_of[m]
    row = materials.constants(number, "scatter", np.array([m], np.int32), Arena())
    lobes = materials.programs[number].lobes_over(Context(Arena(), 1), row)
    return [np.broadcast_to(weight, (3, 1))[:, 0] for _, weight, _, _ in lobes]


def test_equal_structures_share_a_program_and_keep_their_constants():
    albedos = np.random.default_rng(0).random((200, 3))
    materials, _ = compiled(*(Material.diffuse(tuple(a)) for a in albedos))
    assert len(materials.programs) == 1
    for m in (0, 77, 199):
        np.testing.assert_allclose(colors(materials, m)[0], albedos[m], rtol=1e-6)


def test_principled_materials_share_by_the_lobes_they_need():
    materials, _ = compiled(
        *(Material.principled(roughness=r, metallic=0.0) for r in (0.2, 0.5)),
        *(Material.principled(roughness=r, metallic=1.0) for r in (0.2, 0.5)),
    )
    assert list(materials.program_of) == [0, 0, 1, 1]
    assert materials.programs[1].mixture.lobes == (conductor.Rough,)


@pytest.mark.parametrize("fac, expected", [(0.0, [0.2]), (1.0, [0.8]), (0.25, [0.15, 0.2])])
def test_mix_shader_weighs_its_sides_and_drops_what_has_no_weight(fac, expected):
    nodes = (
        Node("diffuse", {"color": (0.2,) * 3}),
        Node("translucent", {"color": (0.8,) * 3}),
        Node("mix_shader", {"fac": fac, "a": Link(0, "bsdf"), "b": Link(1, "bsdf")}),
    )
    materials, _ = compiled(Material("mix", nodes, 2))
    found = sorted(float(c[0]) for c in colors(materials, 0))
    np.testing.assert_allclose(found, sorted(expected), rtol=1e-6)


def test_a_closure_reached_twice_counts_twice():
    nodes = (Node("diffuse", {"color": (0.2,) * 3}), Node("add_shader", {"a": Link(0, "bsdf"), "b": Link(0, "bsdf")}))
    materials, _ = compiled(Material("twice", nodes, 1))
    assert sum(float(c[0]) for c in colors(materials, 0)) == pytest.approx(0.4)


def test_emission_is_told_apart():
    black = Material.principled(emission_color=(0, 0, 0), emission_strength=1.0)
    bright = Material.principled(emission_color=(1, 0.5, 0), emission_strength=2.0)
    materials, _ = compiled(black, bright, Material.emission((1, 1, 1), 3.0), Material.diffuse())
    assert materials.emission[0] is None and materials.emission[3] is None
    np.testing.assert_allclose(materials.emission[1], (2, 1, 0))
    np.testing.assert_allclose(materials.emission[2], (3, 3, 3))
    assert materials.programs[materials.program_of[2]].mixture.lobes == ()


def test_alpha_makes_a_passage_and_opaque_materials_have_none():
    materials, _ = compiled(Material.principled(alpha=0.25), Material.principled(), Material.single("transparent"))
    programs = [materials.programs[n] for n in materials.program_of]
    assert programs[1].transparency is None
    row = materials.constants(materials.program_of[0], "transparency", np.zeros(1, np.int32), Arena())
    assert programs[0].transparency.run(Context(Arena(), 1), row)["T"] == pytest.approx(0.75)
    assert programs[2].mixture.lobes == ()


def test_unsupported_nodes_are_named_once_and_the_default_is_used():
    nodes = (
        Node("unsupported", {}, {"label": "Voronoi Texture", "type": "ShaderNodeTexVoronoi"}),
        Node("diffuse", {"color": Link(0, "color"), "roughness": Link(0, "distance")}),
    )
    materials, messages = compiled(Material("Stone", nodes, 1), Material("Rock", nodes, 1))
    assert len(messages) == 1
    assert "Voronoi Texture" in messages[0] and "Stone" in messages[0] and "Rock" in messages[0]
    np.testing.assert_allclose(colors(materials, 0)[0], 0.8)


def test_an_unsupported_shader_is_grey_not_black():
    nodes = (Node("unsupported", {}, {"label": "Hair BSDF"}),)
    materials, messages = compiled(Material("Fur", nodes, 0))
    assert materials.programs[0].mixture.lobes == (diffuse,) and "Hair BSDF" in messages[0]


def test_what_is_approximated_is_named():
    skin, plain = Material.principled("Skin", subsurface_weight=1.0), Material.principled("Plain")
    _, messages = compiled(skin, plain)
    assert len(messages) == 1
    assert "subsurface scattering is approximated" in messages[0] and "'Skin'" in messages[0]


def test_a_missing_image_is_magenta_and_said():
    nodes = (
        Node("image", {}, {"image": Image("lost.png", filepath="/nowhere/lost.png")}),
        Node("emission", {"color": Link(0, "color"), "strength": 1.0}),
    )
    _, messages = compiled(Material("m", nodes, 1))
    assert "lost.png" in messages[0] and "magenta" in messages[0]


def test_a_graph_of_two_thousand_nodes_folds_to_a_constant():
    nodes = [Node("rgb", {"value": (0.5, 0.5, 0.5)})]
    nodes += [Node("multiply", {"a": Link(k, "value"), "b": 1.0}) for k in range(2000)]
    nodes.append(Node("diffuse", {"color": Link(2000, "value")}))
    materials, _ = compiled(Material("deep", tuple(nodes), 2001))
    assert materials.programs[0].scatter.is_constant
    np.testing.assert_allclose(colors(materials, 0)[0], 0.5)


def test_a_loop_is_cut():
    nodes = (Node("multiply", {"a": Link(1, "value")}), Node("multiply", {"a": Link(0, "value")}))
    assert post_order(nodes, 0) == [1, 0]


def test_material_without_surface_is_black():
    materials, _ = compiled(Material("empty"))
    assert materials.programs[0].mixture.lobes == ()


# -- pictures ----------------------------------------------------------------------------------------------------------


def emitting(color):
    """A material that shows a picture of one colour."""
    pixels = np.ones((2, 2, 4), np.float32)
    pixels[..., :3] = color
    image = Image("flat", pixels=pixels, colorspace="Non-Color")
    nodes = (Node("image", {}, {"image": image}), Node("emission", {"color": Link(0, "color")}))
    return Material("picture", nodes, 1)


def test_materials_that_differ_in_pictures_share_a_program():
    shades = np.random.default_rng(1).random((5, 3)).astype(np.float32)
    quads = tuple(Instance(quad(), materials=(emitting(shade),)) for shade in shades)
    compiled = compile_scene(Scene(Camera(np.eye(4), (-1, 1, -1, 1)), quads), Settings(), Diagnostics())
    assert len(compiled.materials.programs) == 1
    prim = np.array([0, 9, 4, 4, 7, 1, 2], np.int32)
    seen = compiled.emission_at(prim, *np.full((2, prim.size), 0.25, np.float32), Arena())
    np.testing.assert_allclose(seen.T, shades[prim // 2], rtol=1e-6)
