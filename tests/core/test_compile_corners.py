# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of what shader nodes read at the corners of triangles."""

from __future__ import annotations

import numpy as np
import pytest

from zraka.core.compile.connectivity import island_random, pointiness, triangle_sides
from zraka.core.compile.geometry import compile_geometry
from zraka.core.compile.needs import Needs
from zraka.core.compile.tangents import corner_frames
from zraka.core.diagnostics import SceneError
from zraka.core.scene import Attribute, Camera, Instance, Mesh, Scene

from .scenes import box, disk, merged, quad


def tables(*meshes, **needs):
    """The tables of meshes that stand at the origin."""
    scene = Scene(Camera(), tuple(Instance(m) for m in meshes))
    return compile_geometry(scene, needs=Needs(**needs)).corner_values


def square(attribute):
    mesh = quad(2)
    return Mesh(mesh.vertices, mesh.triangles, attributes={"A": attribute})


@pytest.mark.parametrize(
    ("domain", "count", "expected"),
    [
        ("vertex", 4, [[0, 1, 2], [0, 2, 3]]),
        ("corner", 6, [[0, 1, 2], [3, 4, 5]]),
        ("triangle", 2, [[0, 0, 0], [1, 1, 1]]),
        ("mesh", 1, [[0, 0, 0], [0, 0, 0]]),
    ],
)
def test_attributes_of_all_domains(domain, count, expected):
    values = np.arange(count, dtype=np.float32)[:, None]
    found = tables(square(Attribute(values, domain)), attributes={"A"})["attribute", "A"].reshape(2, 3, 4)
    np.testing.assert_array_equal(found[..., :3], np.repeat(np.float32(expected)[..., None], 3, axis=-1))
    assert (found[..., 3] == 1).all()


def test_two_numbers_are_read_as_the_first():
    found = tables(square(Attribute(np.float32([[0.2, 0.6]]), "mesh")), attributes={"A"})["attribute", "A"]
    np.testing.assert_allclose(found.reshape(2, 3, 5)[0, 0], (0.2, 0.6, 0, 1, 0.2))


def test_what_is_missing_is_zero_but_for_the_alpha_of_attributes():
    found = tables(quad(), attributes={"A"}, colors={"A", None})
    assert set(found) == {("attribute", "A"), ("color", "A"), ("color", None)}
    assert found["attribute", "A"].reshape(-1, 4).sum(0).tolist() == [0, 0, 0, 6]
    assert not found["color", "A"].any() and not found["color", None].any()


def test_too_few_values_are_an_error():
    with pytest.raises(SceneError, match="attribute 'A'"):
        tables(square(Attribute(np.zeros((3, 1), np.float32), "vertex")), attributes={"A"})


def test_rows_follow_mirrored_instances_and_dropped_triangles():
    flat = Mesh(np.float32([(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 1, 0)]), np.int32([[0, 1, 2], [0, 1, 3]]))
    mirror = Instance(flat, np.diag((-1.0, 1, 1, 1)))
    found = compile_geometry(Scene(Camera(), (mirror,)), needs=Needs(generated=True)).corner_values["generated"]
    np.testing.assert_allclose(found.reshape(3, 3), [(0, 0, 0.5), (0, 1, 0.5), (0.5, 0, 0.5)])


def test_a_mesh_without_the_uv_map_has_no_tangents():
    assert not tables(quad(), tangents={"A"})["tangent", "A"].any()
    found = tables(quad(), tangents={""})["tangent", ""].reshape(-1, 7)
    np.testing.assert_allclose((found[:, :3] ** 2).sum(1), 1, atol=1e-6)


def test_tangents_follow_the_map():
    position = np.array([[(0, 0, 0), (1, 0, 0), (0, 1, 0)]], float)
    normal = np.broadcast_to((0.0, 0.0, 1.0), position.shape)
    tangent, sign = corner_frames(position, normal, np.array([[(0, 0), (0, 1), (-1, 0)]], float))
    np.testing.assert_allclose(tangent[0], [(0, -1, 0)] * 3, atol=1e-12)
    assert (sign == 1).all()
    tangent, sign = corner_frames(position, normal, np.array([[(0, 0), (-1, 0), (0, 1)]], float))
    np.testing.assert_allclose(tangent[0], [(-1, 0, 0)] * 3, atol=1e-12)
    assert (sign == -1).all()


def test_a_map_without_area_gives_finite_tangents():
    position = np.random.default_rng(0).random((5, 3, 3))
    tangent, _ = corner_frames(position, np.broadcast_to((0.0, 0.0, 1.0), position.shape), np.zeros((5, 3, 2)))
    np.testing.assert_allclose((tangent**2).sum(-1), 1)


def test_pointiness_of_a_disk_and_a_box():
    flat, cube = disk(1.0, segments=16), box()
    inside = pointiness(np.asarray(flat.vertices, float), flat.triangles, triangle_sides(flat.triangles))[-1]
    assert inside == pytest.approx(0.5, abs=1e-6)
    found = pointiness(np.asarray(cube.vertices, float), cube.triangles, triangle_sides(cube.triangles))
    assert (found > 0.6).all()


def test_islands_have_numbers_of_their_own():
    mesh = merged([quad(1), quad(1, (3, 0, 0)), quad(1, (6, 0, 0))])
    found = island_random(mesh.triangles, triangle_sides(mesh.triangles), len(mesh.vertices))
    assert (found[::2] == found[1::2]).all() and len(set(found.tolist())) == 3
    assert ((found >= 0) & (found <= 1)).all()
