# SPDX-License-Identifier: GPL-3.0-or-later
"""Instances, spheres and planes to tables."""

from time import perf_counter

import numpy as np
import pytest

from zraka.core.accel import Accel
from zraka.core.arena import Arena
from zraka.core.compile import triangles
from zraka.core.compile.geometry import compile_geometry
from zraka.core.diagnostics import Diagnostics, SceneError
from zraka.core.geometry import NORMAL, OFFSET, Geometry
from zraka.core.interaction import uv_at
from zraka.core.scene import Camera, Instance, Material, Mesh, Plane, Scene, Spheres

CUBE = np.float32([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
_QUADS = np.int32([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
FACES = np.concatenate([_QUADS[:, :3], _QUADS[:, [0, 2, 3]]])
QUAD = Mesh(np.float32([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), np.int32([[0, 1, 2], [0, 2, 3]]), name="quad")


def compiled(*things, uv_names=(), diagnostics=None):
    def of(kind):
        return tuple(t for t in things if isinstance(t, kind))

    return compile_geometry(Scene(Camera(), of(Instance), of(Spheres), of(Plane)), uv_names, diagnostics)


def transform(linear, move=(0, 0, 0)):
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = linear, move
    return matrix


def volume(geometry):
    """Signed volume inside the triangles; positive when fronts point outwards."""
    a, b, c = geometry.corners.astype(float).reshape(3, 3, -1)
    return (a * np.cross(b, c, axis=0)).sum() / 6


# -- placing -----------------------------------------------------------------------------------------------------------


def test_triangles_are_placed_relative_to_the_middle():
    g = compiled(Instance(QUAD, transform(2 * np.eye(3), (10, 20, 30))))
    np.testing.assert_array_equal(g.origin, [11, 21, 30])
    np.testing.assert_array_equal(g.corners[:, 0], [-1, -1, 0, 1, -1, 0, 1, 1, 0])
    np.testing.assert_array_equal(g.facets[:, NORMAL], [[0, 0, 1]] * 2)
    assert g.corners.shape == (9, 2)
    assert g.corners.flags.c_contiguous
    assert g.corners.dtype == np.float32
    assert g.normal_row is None
    assert (g.facets[:, OFFSET] > 0).all()


@pytest.mark.parametrize("count", [999, 1000, 2500])
def test_the_middle_is_of_all_vertices_that_are_finite(count):
    rng = np.random.default_rng(count)
    for k in (0, 998, count - 1):
        points = rng.uniform(-1, 1, (count, 3)).astype(np.float32)
        points[k], points[count // 2] = (9, -9, 9), np.nan
        others = np.concatenate([np.delete(points, (k, count // 2), axis=0), [(9, -9, 9)]]).astype(np.float64)
        geometry = compiled(Instance(Mesh(points, np.arange(count // 3 * 3, dtype=np.int32).reshape(-1, 3))))
        np.testing.assert_allclose(geometry.origin, (others.min(0) + others.max(0)) / 2, rtol=1e-6)


def test_what_is_not_turned_is_as_if_it_were():
    rng, arena, still = np.random.default_rng(3), Arena(), np.eye(3)
    vectors = rng.normal(size=(50, 3)).astype(np.float32)
    quarter = np.float64([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    for matrices in ([still], [still, still], [still, quarter], [2 * still]):
        expected = np.einsum("ijk,nk->inj", matrices, vectors.astype(np.float64))
        found = triangles._turned(vectors, np.array(matrices), arena)
        assert found.dtype == np.float64
        np.testing.assert_array_equal(found, expected)


def test_a_facet_does_not_depend_on_the_corner_it_begins_with():
    """The longest side, which bounds errors, may be any of the three."""
    corners = np.float32([[0, 0, 1e-3], [1, 0, 0], [-1, 0.1, 0]])
    facets = Geometry.from_arrays(triangles=[np.roll(corners, k, axis=0) for k in range(3)]).facets
    np.testing.assert_allclose(facets[:, OFFSET], facets[0, OFFSET], rtol=1e-5)
    np.testing.assert_allclose(facets[:, NORMAL], np.tile(facets[0, NORMAL], (3, 1)), atol=1e-6)


def test_far_scenes_keep_their_digits():
    far = transform(np.eye(3), (1e7, -1e7, 1e7 + 0.125))
    near, there = compiled(Instance(QUAD)), compiled(Instance(QUAD, far))
    np.testing.assert_array_equal(near.corners, there.corners)


@pytest.mark.parametrize("scale", [(1, 1, 1), (-1, 1, 1), (-2, -1, 1), (-1, -3, -1), (1, 1, -0.5)])
def test_fronts_stay_fronts_under_mirroring(scale):
    rotation = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    normals = CUBE / np.sqrt(np.float32(3))
    uvs = {"map": CUBE[FACES.reshape(-1), :2]}  # u, v = x, y in object space
    matrix = rotation @ np.diag(scale)
    g = compiled(Instance(Mesh(CUBE, FACES, normals=normals, uvs=uvs), transform(matrix)), uv_names=("map",))
    assert volume(g) == pytest.approx(8 * abs(np.prod(scale)), rel=1e-5)
    # Smooth normals lie on the front's side, and are those of the inverse transpose.
    rows = g.normals.reshape(12, 3, 3)
    assert ((rows * g.facets[:, None, NORMAL]).sum(-1) > 0).all()
    corners = g.corners.T.reshape(12, 3, 3).astype(float) @ np.linalg.inv(matrix).T
    expected = corners @ np.linalg.inv(matrix)
    expected /= np.linalg.norm(expected, axis=-1, keepdims=True)
    np.testing.assert_allclose(rows, expected, atol=1e-5)
    # UVs go with their corners.
    np.testing.assert_allclose(g.uvs["map"].reshape(12, 3, 2), corners[..., :2], atol=1e-5)


def test_flat_triangles_have_no_normal_row():
    """Vertex normals that are the face's normal cost nothing; one bent corner makes its triangles smooth."""
    normals = np.tile(np.float32([0, 0, 1]), (4, 1))
    flat = Mesh(QUAD.vertices, QUAD.triangles, normals=normals)
    assert compiled(Instance(flat, transform(np.diag([3, -2, 0.1])))).normal_row is None
    bent = normals.copy()
    bent[1] = [0.6, 0, 0.8]
    g = compiled(Instance(flat), Instance(Mesh(QUAD.vertices, QUAD.triangles, normals=bent)))
    np.testing.assert_array_equal(g.normal_row, [-1, -1, 0, -1])
    np.testing.assert_allclose(g.normals, [[0, 0, 1, 0.6, 0, 0.8, 0, 0, 1]], atol=1e-6)


def test_corner_normals_and_corner_numbers():
    corners = np.uint32([[5, 4, 3], [2, 1, 0]])
    normals = np.float32([[i, 0, 1] for i in range(6)])
    uvs = {"a": np.float32([[i, -i] for i in range(6)])}
    mesh = Mesh(QUAD.vertices, QUAD.triangles, corners, normals, "corner", uvs)
    g = compiled(Instance(mesh), uv_names=("", "a", "b"))
    found = g.normals.reshape(2, 3, 3)
    np.testing.assert_allclose(found[..., 0] / found[..., 2], corners, rtol=1e-5)
    np.testing.assert_array_equal(g.uvs["a"][:, ::2], corners)
    np.testing.assert_array_equal(g.uvs["a"], g.uvs[""])
    assert (g.uvs["b"] == 0).all()


def test_unusable_normals_are_the_faces():
    normals = np.float32([[0, 0, 0], [np.nan, 0, 1], [0, 0, 1], [0, 0, 1]])
    g = compiled(Instance(Mesh(QUAD.vertices, QUAD.triangles, normals=normals)))
    assert g.normal_row is None


def test_active_uv_is_the_named_or_the_first():
    uvs = {"a": np.full((6, 2), 1, np.float32), "b": np.full((6, 2), 2, np.float32)}
    first = Mesh(QUAD.vertices, QUAD.triangles, uvs=uvs)
    named = Mesh(QUAD.vertices, QUAD.triangles, uvs=uvs, active_uv="b")
    g = compiled(Instance(first), Instance(named), Instance(QUAD), uv_names=("",))
    np.testing.assert_array_equal(g.uvs[""][:, 0], [1, 1, 2, 2, 0, 0])


# -- numbers -----------------------------------------------------------------------------------------------------------


def test_materials_slots_and_objects():
    red, blue = Material.diffuse((1, 0, 0)), Material.diffuse((0, 0, 1))
    mesh = Mesh(np.tile(QUAD.vertices, (2, 1)), np.int32([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]),
                material_index=np.int32([0, 1, 7, -3]))  # fmt: skip
    g = compiled(
        Instance(mesh, materials=(red, None)),
        Instance(QUAD, materials=(blue,)),
        Instance(mesh, transform(np.eye(3), (0, 0, 5)), materials=(blue,)),
        Instance(QUAD),
        Spheres(np.zeros((2, 3)), np.ones(2), red),
        Plane((0, 0, 0), (0, 0, 1), blue),
    )
    names = [None if m.name == "default" else m for m in g.materials]
    owner = {}
    for obj, material in zip(g.object.tolist(), g.material.tolist(), strict=True):
        owner.setdefault(obj, []).append(names[material])
    assert owner == {0: [red, None, None, None], 1: [blue] * 2, 2: [blue] * 4, 3: [None] * 2, 4: [red] * 2, 5: [blue]}
    assert len(g.materials) == 3
    assert g.materials[names.index(None)].nodes[0].inputs["color"] == (0.8, 0.8, 0.8)
    assert (g.triangle_count, g.sphere_count, g.plane_count, g.count) == (12, 2, 1, 15)
    assert g.material.dtype == g.object.dtype == np.int32


def test_spheres_and_planes_are_recentred():
    g = compiled(Spheres(np.array([[99.0, 0, 0], [103, 0, 0]]), np.array([1.0, 2])), Plane((100, 7, 3), (0, 0, 2)))
    np.testing.assert_array_equal(g.origin, [101.5, 0, 0])
    np.testing.assert_array_equal(g.centers, [[-2.5, 1.5], [0, 0], [0, 0]])
    np.testing.assert_array_equal(g.plane_points[:, 0], [0, 0, 3])
    np.testing.assert_array_equal(g.plane_normals[:, 0], [0, 0, 1])


def test_an_empty_scene_is_fine():
    g = compiled()
    assert g.count == 0
    g = compiled(Instance(Mesh(np.zeros((0, 3)), np.zeros((0, 3), np.int32))), uv_names=("",))
    assert g.count == 0
    assert g.uvs[""].shape == (0, 6)


def test_uv_lookup_interpolates_and_is_zero_elsewhere():
    uvs = {"a": QUAD.vertices[QUAD.triangles.reshape(-1), :2]}
    g = compiled(Instance(Mesh(QUAD.vertices, QUAD.triangles, uvs=uvs)), Plane((0, 0, -1), (0, 0, 1)), uv_names=("a",))
    u, v = np.float32([0.25, 0.5, 0.3]), np.float32([0.5, 0.125, 0.3])
    found = uv_at(g, "a", np.int32([0, 1, 2]), u, v, Arena())
    np.testing.assert_allclose(found, [[0.75, 0.5, 0], [0.5, 0.625, 0]], atol=1e-6)
    only_plane = compiled(Plane((0, 0, -1), (0, 0, 1)), uv_names=("a",))
    assert (uv_at(only_plane, "a", np.int32([0]), u[:1], v[:1], Arena()) == 0).all()


# -- what is left out --------------------------------------------------------------------------------------------------


def test_degenerate_triangles_are_dropped_and_told():
    vertices = np.float32([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.5, 0, 0], [np.nan, 0, 0], [np.inf, 0, 0]])
    triangles = np.int32([[0, 1, 1], [0, 1, 2], [0, 1, 3], [0, 1, 4], [5, 1, 2], [2, 2, 2]])
    told = Diagnostics()
    uvs = {"a": np.float32(np.repeat(np.arange(6), 3)[:, None] * [1, 1])}
    mesh = Mesh(vertices, triangles, uvs=uvs)
    g = compiled(Instance(mesh, name="bad"), Instance(QUAD, name="good"), uv_names=("a",), diagnostics=told)
    assert g.triangle_count == 3
    np.testing.assert_array_equal(g.object, [0, 1, 1])
    np.testing.assert_array_equal(g.uvs["a"][0], np.ones(6))
    assert np.isfinite(g.facets[:, :12]).all()
    (line,) = told.messages()
    assert line.endswith("were left out (bad, 5 times)")


def test_area_lost_in_the_cast_is_no_area():
    """A triangle of 1e-6 at a distance of 1e6 is a point in float32."""
    far = transform(1e6 * np.eye(3), (1e6, 0, 0))
    g = compiled(Instance(QUAD, far), Instance(QUAD, transform(1e-6 * np.eye(3), (-1e6, 0, 0))))
    assert g.triangle_count == 2


def test_scale_zero_keeps_the_faces_that_remain():
    g = compiled(Instance(Mesh(CUBE, FACES, normals=CUBE), transform(np.diag([10, 0, 10.0]))))
    assert g.triangle_count == 4
    np.testing.assert_array_equal(np.abs(g.facets[:, NORMAL]), [[0, 1, 0]] * 4)
    assert np.isfinite(g.normals).all()
    o, d = np.float32([[1], [5], [2]]), np.float32([[0], [-1], [0]])
    assert Accel(g).intersect(o, d, None, Arena()).t[0] == 5


def test_spheres_without_radius_are_dropped_and_told():
    told = Diagnostics()
    g = compiled(
        Spheres(np.array([[0, 0, 0], [1, 0, 0], [np.nan, 0, 0.0]]), np.array([1, 0, 1.0]), name="s"), diagnostics=told
    )
    assert g.sphere_count == g.count == 1
    assert told.messages()[0].endswith("(s, 2 times)")


def test_transform_that_is_not_finite_drops_its_object():
    told = Diagnostics()
    g = compiled(Instance(QUAD), Instance(QUAD, transform(np.eye(3) * np.nan), name="lost"), diagnostics=told)
    assert g.triangle_count == 2
    np.testing.assert_array_equal(g.origin, [0.5, 0.5, 0])
    assert "lost" in told.messages()[0]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"triangles": np.int32([[0, 1, 4]])}, "triangles of mesh 'm' reach from 0 to 4; only 0 to 3 exist"),
        ({"triangles": np.int32([[0, -1, 2]])}, "triangles of mesh 'm' reach from -1"),
        ({"triangles": np.int8([[0, -1, 2]])}, "triangles of mesh 'm' reach from -1"),
        ({"triangles": np.int64([[0, 1 << 32, 2]])}, "triangles of mesh 'm' reach from 0 to 4294967296"),
        ({"triangles": np.uint32([[0, 1, 4]])}, "triangles of mesh 'm' reach from 0 to 4"),
        ({"corners": np.int64([[0, 1, 2], [0, 1, -3]])}, "corners of mesh 'm' reach from -3"),
        ({"vertices": np.zeros((0, 3))}, "triangles of mesh 'm' reach from 0 to 3; only 0 to -1 exist"),
        ({"triangles": np.float32([[0, 1, 2]])}, "make them integers"),
        ({"triangles": np.int32([[0, 1]])}, "make them integers"),
        ({"vertices": np.zeros((4, 2))}, "vertices of mesh 'm' have shape"),
        ({"corners": np.int32([[0, 1, 2]])}, "corners of mesh 'm' need one row"),
        ({"normals": np.zeros((3, 3))}, "normals of mesh 'm' need 4 rows"),
        ({"uvs": {"a": np.zeros((5, 2))}}, "UV map 'a' of mesh 'm' need 6 rows"),
        ({"material_index": np.zeros(3, np.int32)}, "material_index of mesh 'm' needs one number"),
    ],
)
def test_arrays_that_do_not_fit_are_refused(change, words):
    mesh = Mesh(**{"vertices": QUAD.vertices, "triangles": QUAD.triangles, "name": "m", **change})
    with pytest.raises(SceneError, match=words):
        compiled(Instance(mesh), uv_names=("",))


@pytest.mark.parametrize(
    "thing",
    [
        Instance(QUAD, np.eye(3)),
        Spheres(np.zeros((2, 3)), np.zeros(3)),
        Plane((0, 0, 0), (0, 0, 0)),
        Plane((np.nan, 0, 0), (0, 0, 1)),
    ],
)
def test_things_that_do_not_fit_are_refused(thing):
    with pytest.raises(SceneError):
        compiled(thing)


# -- bare arrays and size ----------------------------------------------------------------------------------------------


def test_bare_arrays_are_taken_as_they_are():
    triangles = np.float32([[[7, 0, 0], [8, 0, 0], [7, 1, 0]], [[0, 0, 0], [0, 0, 0], [0, 0, 0]]])
    g = Geometry.from_arrays(triangles=triangles, centers=[[1, 2, 3]], radii=[4])
    np.testing.assert_array_equal(g.corners.T.reshape(2, 3, 3), triangles)
    assert (g.count, g.triangle_count, g.sphere_count) == (3, 2, 1)


def test_many_instances_of_a_mesh_take_no_loop():
    mesh = Mesh(CUBE, FACES, normals=CUBE, uvs={"a": np.zeros((36, 2), np.float32)})
    rng = np.random.default_rng(2)
    matrices = np.tile(np.eye(4), (10000, 1, 1))
    matrices[:, :3, 3] = 100 * rng.random((10000, 3))
    instances = tuple(Instance(mesh, m, name=str(i)) for i, m in enumerate(matrices))
    start = perf_counter()
    g = compiled(*instances, uv_names=("",))
    assert perf_counter() - start < 2
    assert g.triangle_count == 120000
    np.testing.assert_array_equal(g.object, np.repeat(np.arange(10000), 12))
    middle = g.corners.reshape(3, 3, 10000, 12).mean(axis=(0, 3)).T + g.origin
    np.testing.assert_allclose(middle, matrices[:, :3, 3], atol=1e-4)


# -- blocks and threads ------------------------------------------------------------------------------------------------


def _hills(side, turned=False):
    """A mesh of more than one block of triangles, with normals by vertex or by corner."""
    y, x = np.mgrid[:side, :side].astype(np.float32)
    vertices = np.stack([x, y, np.sin(x) * np.cos(0.7 * y)], axis=-1).reshape(-1, 3)
    first = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).reshape(-1, 1)
    triangles = np.concatenate([first + np.array(corners) for corners in ((0, 1, side + 1), (0, side + 1, side))])
    normals = np.float32(np.random.default_rng(5).normal(size=vertices.shape)) + np.float32([0, 0, 3])
    normals[: len(normals) // 3] = 0
    if not turned:
        return Mesh(vertices, triangles, normals=normals)
    return Mesh(vertices, triangles, normals=normals[triangles.reshape(-1)], normals_domain="corner")


def _scene_of_many_blocks(by_corner):
    mirror = transform(np.diag([-1.0, 1, 2]), (3, 4, 5))
    small = tuple(Instance(QUAD, transform(np.eye(3), (k, 0, 9))) for k in range(900))
    return (Instance(_hills(150, by_corner)), Instance(_hills(150), mirror), *small, Instance(_hills(20), mirror))


@pytest.mark.parametrize("by_corner", [False, True])
def test_threads_and_blocks_change_nothing(by_corner, monkeypatch):
    found = []
    for threads, block in ((1, 1 << 13), (4, 1 << 11), (3, 777)):
        monkeypatch.setattr(triangles.os, "cpu_count", lambda n=threads: n)
        monkeypatch.setattr(triangles, "BLOCK", block)
        found.append(compiled(*_scene_of_many_blocks(by_corner)))
    for other in found[1:]:
        np.testing.assert_array_equal(other.facets.view(np.int32), found[0].facets.view(np.int32))
        for name in ("vertices", "index", "normals", "object"):
            np.testing.assert_array_equal(getattr(other, name), getattr(found[0], name))


@pytest.mark.parametrize("by_corner", [False, True])
def test_normals_stand_at_their_corners(by_corner):
    """Smooth, flat and mirrored meshes side by side, against a lookup triangle by triangle."""
    things = _scene_of_many_blocks(by_corner)
    g, row = compiled(*things), 0
    for thing in (things[0], things[1], things[-1]):
        mesh = thing.mesh
        number = things.index(thing)
        own = np.flatnonzero(g.object == number)
        normals = mesh.normals.astype(float) @ np.linalg.inv(thing.transform[:3, :3])
        with np.errstate(invalid="ignore"):
            normals /= np.linalg.norm(normals, axis=1)[:, None]
        corners = normals.reshape(-1, 3, 3) if mesh.normals_domain == "corner" else normals[mesh.triangles]
        if np.linalg.det(thing.transform[:3, :3]) < 0:
            corners = corners[:, (0, 2, 1)]
        face = g.facets[own][:, None, NORMAL]
        expected = np.where(np.isnan(corners), face, corners)
        smooth = (np.abs(expected - face) > 1e-4).any((1, 2))
        assert 0 < smooth.sum() < len(smooth)
        np.testing.assert_array_equal(g.normal_row[own] >= 0, smooth)
        np.testing.assert_array_equal(g.normal_row[own][smooth], row + np.arange(smooth.sum()))
        np.testing.assert_allclose(g.normals[g.normal_row[own][smooth]].reshape(-1, 3, 3), expected[smooth], atol=1e-6)
        row += smooth.sum()
    assert len(g.normals) == row


def test_embree_reads_the_corners_of_the_facets():
    mirror = transform(np.diag([-1.0, 1, 2]), (3, 4, 5))
    broken = Mesh(QUAD.vertices, np.int32([[0, 1, 1], [0, 1, 2], [2, 2, 2], [0, 2, 3]]), name="bad")
    g = compiled(Instance(broken), Instance(_hills(20), mirror), Instance(QUAD, mirror))
    assert g.triangle_count == len(g.index) == 2 + 722 + 2
    np.testing.assert_array_equal(g.vertices[g.index][..., :3].reshape(-1, 9), g.corners.T)
    low, high = g.bounds
    np.testing.assert_array_equal(low, g.corners.reshape(3, 3, -1).min((0, 2)))
    np.testing.assert_array_equal(high, g.corners.reshape(3, 3, -1).max((0, 2)))
