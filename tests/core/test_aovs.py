# SPDX-License-Identifier: GPL-3.0-or-later
"""Values that materials tell by name, as pictures."""

import dataclasses

import numpy as np
import pytest

from zraka.core.compile import compile_scene
from zraka.core.diagnostics import Diagnostics
from zraka.core.methods.guides import render_guides
from zraka.core.scene import Link, Material, Node, World
from zraka.core.settings import Guides, Settings
from zraka.core.visibility import ALL_RAYS, Rays, Visibility

from .scenes import looking_down, placed, quad

COLOR, VALUE = "aov_color:mine", "aov_value:mine"


def told(description, size=8, samples=16, film=False, **options):
    chosen = Guides(names=frozenset((COLOR, VALUE, "depth")), **options)
    settings = Settings(width=size, height=size, samples=samples, guides=chosen, threads=1, transparent_film=film)
    return render_guides(compile_scene(description, settings, Diagnostics()), description, settings)


def telling(material, color=(0.1, 0.2, 3.0), value=0.5, name="mine"):
    return dataclasses.replace(material, aovs=((name, color, value),))


def test_constants():
    found = told(looking_down(placed(quad(4), telling(Material.diffuse()))))
    np.testing.assert_allclose(found[COLOR].T, [(0.1, 0.2, 3.0, 1.0)] * 64, rtol=1e-6)
    np.testing.assert_allclose(found[VALUE], 0.5)


def test_nothing_where_nothing_is_told():
    for view in (
        looking_down(),
        looking_down(placed(quad(4), Material.diffuse())),
        looking_down(placed(quad(4), telling(Material.diffuse(), name="other"))),
    ):
        found = told(view)
        assert not found[COLOR].any() and not found[VALUE].any()


def test_values_are_computed_of_the_surface():
    """A node that the surface itself does not read; the scene prepares what it needs."""
    nodes = (Node("diffuse", {}), Node("tex_coord", {}), Node("geometry", {}))
    for link, expected in ((Link(1, "generated"), (0.5, 0.5, 0.5)), (Link(2, "normal"), (0, 0, 1))):
        material = Material("told", nodes, 0, aovs=(("mine", link, 0.0),))
        found = told(looking_down(placed(quad(4), material)))
        np.testing.assert_allclose(found[COLOR][:3].mean(axis=1), expected, atol=0.01)


@pytest.mark.parametrize("alpha, threshold, expected", [(0.8, 0.5, 1.0), (0.25, 0.5, 1.0 + 0.75 * 2), (0.25, 0.0, 1.0)])
def test_surfaces_that_are_clear_enough_are_looked_through(alpha, threshold, expected):
    veil = placed(quad(4, (0, 0, 0.2)), telling(Material.principled(alpha=alpha), value=1.0))
    floor = placed(quad(4), telling(Material.diffuse(), value=2.0))
    found = told(looking_down(veil, floor), alpha_threshold=threshold)
    np.testing.assert_allclose(found[VALUE], expected, rtol=1e-5)


def test_the_world_tells_where_the_camera_sees_it():
    """Beside a veil, and through it by the share that it lets through; a direction is that of the ray."""
    nodes = (Node("tex_coord", {}),)
    world = World(nodes=nodes, aovs=(("mine", Link(0, "generated"), 2.0),))
    veil = placed(quad(4), telling(Material.principled(alpha=0.25), value=1.0))
    for things, expected in (((), 2.0), ((veil,), 1.0 + 0.75 * 2)):
        view = dataclasses.replace(looking_down(*things), world=world)
        np.testing.assert_allclose(told(view)[VALUE], expected, rtol=1e-5)
    color = told(dataclasses.replace(looking_down(), world=world))[COLOR]
    np.testing.assert_allclose(color.mean(axis=1)[2:], (-1.0, 1.0), atol=0.1)
    np.testing.assert_allclose(np.linalg.norm(color[:3], axis=0), 1, atol=1e-3)


def test_a_world_that_is_not_seen_tells_nothing():
    world = World(aovs=(("mine", (0.1, 0.2, 3.0), 2.0),))
    assert told(dataclasses.replace(looking_down(), world=world))[VALUE].any()
    hidden = dataclasses.replace(world, visibility=Visibility(ALL_RAYS & ~Rays.CAMERA))
    assert not told(dataclasses.replace(looking_down(), world=hidden))[VALUE].any()
    assert not told(dataclasses.replace(looking_down(), world=world), film=True)[VALUE].any()


def test_materials_are_compiled_as_without():
    plain, more = Material.diffuse(), telling(Material.diffuse())
    made = [compile_scene(looking_down(placed(quad(4), m)), Settings(), Diagnostics()) for m in (plain, more)]
    assert made[0].features == made[1].features
    assert [p.operations for p in made[0].materials.programs] == [p.operations for p in made[1].materials.programs]
