# SPDX-License-Identifier: GPL-3.0-or-later
"""Lobes on normals that nodes turned."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from zraka.core.arena import Arena
from zraka.core.bsdf import diffuse
from zraka.core.bsdf.bumped import SMOOTH, bumped, older_softening, softening
from zraka.core.bsdf.shading_normal import lifted_normal
from zraka.core.scene import Curves, Instance, Link, Material, Node

from .scenes import camera, quad, radiance, scene


def test_a_normal_is_lifted_until_its_mirror_ray_leaves():
    rng = np.random.default_rng(0)
    n, wo = (v / np.linalg.norm(v, axis=0) for v in rng.normal(size=(2, 3, 4000)))
    n[2], wo[2] = np.abs(n[2]), np.abs(wo[2])
    n, wo = n.astype(np.float32), wo.astype(np.float32)
    ng = np.repeat(np.float32([[0], [0], [1]]), n.shape[1], axis=1)
    found = lifted_normal(n, ng, wo, Arena())
    rise = 2 * (found * wo).sum(0) * found[2] - wo[2]
    assert (rise >= np.minimum(0.9 * wo[2], 0.01) - 1e-5).all()
    np.testing.assert_allclose((found * found).sum(0), 1, atol=1e-5)
    kept = 2 * (n * wo).sum(0) * n[2] - wo[2] >= 0.02
    assert kept.any() and (found[:, kept] == n[:, kept]).all() and (found[:, ~kept] != n[:, ~kept]).any()


def test_softening_is_one_unturned_and_less_where_turned():
    n = np.repeat(np.float32([[0], [0], [1]]), 3, axis=1)
    wi = np.float32([(0, 0, 1), (0.6, 0, 0.8), (0.99995, 0, 0.01)]).T
    np.testing.assert_allclose(softening(n, n, wi, Arena()), 1)
    turned = np.repeat(np.float32([[0.8], [0], [0.6]]), 3, axis=1)
    found = softening(n, turned, wi, Arena())
    assert found[0] == 1 and (np.diff(found) < 0).all() and found[2] < 0.5
    assert softening(n[:, :1], turned[:, :1], np.float32([[0.9], [0], [-0.43]]), Arena())[0] == 0


def test_the_older_softening_falls_from_one_to_zero():
    """By the ratio g of cosines it is 1 from g = 1 on, 0 from 0 down, between them -g³ + g² + g."""
    g = np.float32([1.5, 0.5, 0.0, -0.5])
    n, turned = (np.repeat(np.float32(v)[:, None], 4, axis=1) for v in ((0, 0, 1), (0.8, 0, 0.6)))
    wi = np.stack([1 - np.float32(0.36) * g, 0 * g, np.float32(0.48) * g])  # of any length: it goes out of the ratio
    np.testing.assert_allclose(older_softening(n, turned, wi, Arena()), [1, 0.625, 0, 0], atol=1e-6)
    np.testing.assert_allclose(older_softening(n, n, turned, Arena()), 1, rtol=1e-6)
    assert (older_softening(n, turned, 0 * wi, Arena()) == 0).all()


@pytest.mark.parametrize("is_older", [False, True])
def test_a_softened_lobe_samples_what_it_evaluates(is_older):
    rng = np.random.default_rng(1)
    n = np.repeat(np.float32([[0.6], [0], [0.8]]), 1000, axis=1)
    params = {SMOOTH: np.repeat(np.float32([[0], [0], [1]]), 1000, axis=1)}
    lobe, arena = bumped(diffuse, True, is_older), Arena()
    assert lobe is bumped(diffuse, True, is_older) and lobe.flags == diffuse.flags
    s = lobe.sample(params, n, n, *rng.random((3, 1000), np.float32), arena)
    f, pdf = lobe.eval_pdf(params, n, n, s.wi, arena)
    np.testing.assert_allclose(f, s.weight * s.pdf, atol=1e-5)
    np.testing.assert_allclose(pdf, s.pdf, atol=1e-5)


def turned_normals(closure, older):
    """Light of the sky that a quad and a strand reflect, whose normals a node turned by 63 degrees: each by itself."""
    nodes = Node("combine_xyz", {"x": 2.0, "z": 1.0}), Node(closure, {"normal": Link(0, "vector"), "color": (1.0,) * 3})
    material, view = Material("turned", nodes, 1, older=older), camera((0, 0, 3), (0, 0, 0), fov=0.1)
    points = np.stack([np.linspace(-2, 2, 5), np.zeros(5), np.zeros(5)], axis=1)
    strand = Curves(points, np.ones(5), np.array([5]), material=material)
    plain = scene(view, Instance(quad(4), materials=(material,)), world=1.0)
    for made in (plain, replace(scene(view, world=1.0), curves=(strand,))):
        yield radiance(made, depth=1)


def test_turned_normals_of_older_blenders():
    """Before 5.0 strands lost light from below as other surfaces do; before 4.5 both lost less of the rest."""
    quad_now, strand_now = turned_normals("diffuse", ())
    quad_5, strand_5 = turned_normals("diffuse", ("strands",))
    quad_4, strand_4 = turned_normals("diffuse", ("softening", "strands"))
    assert quad_5 == quad_now and strand_5 < 0.6 * strand_now
    assert quad_4 > 1.2 * quad_5 and strand_4 > 1.2 * strand_5


@pytest.mark.parametrize("closure", ["diffuse", "glossy", "principled", "glass", "translucent"])
def test_turned_normals_make_no_light(closure):
    nodes = (
        Node("noise", {"scale": 20.0}),
        Node("bump", {"height": Link(0, "fac")}),
        Node(closure, {"color": (1.0,) * 3, "base_color": (1.0,) * 3, "roughness": 0.5, "normal": Link(1, "normal")}),
    )
    view = camera((0, -2, 1.5), (0, 0, 0), fov=0.2)
    mesh = Instance(quad(4), materials=(Material("bumpy", nodes, 2),))
    found = radiance(scene(view, mesh, world=1.0), samples=64, depth=1)
    assert 0.2 < found < 1.01
