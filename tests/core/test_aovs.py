# SPDX-License-Identifier: GPL-3.0-or-later
"""Values that materials tell by name, as pictures."""

import dataclasses

import numpy as np
import pytest

from zraka.core.compile import compile_scene
from zraka.core.diagnostics import Diagnostics
from zraka.core.methods.guides import render_guides
from zraka.core.scene import Link, Material, Node
from zraka.core.settings import Guides, Settings

from .scenes import looking_down, placed, quad

COLOR, VALUE = "aov_color:mine", "aov_value:mine"


def told(description, size=8, samples=16, **options):
    chosen = Guides(names=frozenset((COLOR, VALUE, "depth")), **options)
    settings = Settings(width=size, height=size, samples=samples, guides=chosen, threads=1)
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


def test_materials_are_compiled_as_without():
    plain, more = Material.diffuse(), telling(Material.diffuse())
    made = [compile_scene(looking_down(placed(quad(4), m)), Settings(), Diagnostics()) for m in (plain, more)]
    assert made[0].features == made[1].features
    assert [p.operations for p in made[0].materials.programs] == [p.operations for p in made[1].materials.programs]
