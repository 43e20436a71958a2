# SPDX-License-Identifier: GPL-3.0-or-later
"""Voronoi Texture against a search through all cells, and its random numbers against whole numbers of Python."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from zraka.core.arena import Arena
from zraka.core.nodes.base import Context, as_vector
from zraka.core.nodes.voronoi import OPERATIONS
from zraka.core.nodes.voronoi_cells import LOOKUP3, PCG, offsets

RNG = np.random.default_rng(5)
POINTS = RNG.uniform(-3.0, 3.0, (4, 300)).astype(np.float32)
HASHES = {"voronoi": PCG, "voronoi_4": LOOKUP3}


def run(op="voronoi", properties=None, n=POINTS.shape[1], **inputs):
    """Outputs of the node at `POINTS`, scale 1."""
    operation = OPERATIONS[op]
    given = {name: as_vector(v) for name, v in operation.inputs.items() if v is not None}
    given |= {"vector": POINTS[:3], "w": POINTS[3], "scale": as_vector(1.0)}
    given |= {name: v if isinstance(v, np.ndarray) else as_vector(v) for name, v in inputs.items()}
    return operation.run(Context(Arena(), n), given, properties or {})


def lanes(dimensions):
    """Where the lanes are, (D, N)."""
    return {1: POINTS[3:], 2: POINTS[:2], 3: POINTS[:3], 4: POINTS}[dimensions]


def all_points(hash_, dimensions, randomness=1.0):
    """Points and colours of all cells around `POINTS`."""
    cell = np.array(list(itertools.product(range(-6, 6), repeat=dimensions)), np.float32).T
    return cell + randomness * hash_.point(cell, Arena()), hash_.color(cell, Arena())


def lengths(vector, metric, exponent=0.7):
    """Lengths of vectors (D, ...)."""
    v = np.abs(vector)
    if metric == "EUCLIDEAN":
        return np.sqrt((v * v).sum(axis=0))
    if metric == "MANHATTAN":
        return v.sum(axis=0)
    return v.max(axis=0) if metric == "CHEBYCHEV" else (v**exponent).sum(axis=0) ** (1 / exponent)


def pcg(cell):
    """The hash of a cell in Python's own numbers."""

    def signed(x):
        return (x + 2**31) % 2**32 - 2**31

    v = [signed(x * 1664525 + 1013904223) for x in cell]
    steps = {
        2: ((0, lambda: v[1] * 1664525), (1, lambda: v[0] * 1664525)),
        3: ((0, lambda: v[1] * v[2]), (1, lambda: v[2] * v[0]), (2, lambda: v[0] * v[1])),
        4: ((0, lambda: v[1] * v[3]), (1, lambda: v[2] * v[0]), (2, lambda: v[0] * v[1]), (3, lambda: v[1] * v[2])),
    }[len(cell)]
    for turn in range(2):
        for row, product in steps:
            v[row] = signed(v[row] + product())
        if turn == 0:
            v = [x ^ (x >> 16) for x in v]
    return [(x & 0x7FFFFFFF) / 2**31 for x in v]


@pytest.mark.parametrize("dimensions", [2, 3, 4])
def test_the_hash_of_cells(dimensions):
    cells = RNG.integers(-1000, 1000, (dimensions, 20))
    ours = PCG.point(cells.astype(np.float32), Arena())
    np.testing.assert_allclose(ours.T, [pcg([int(x) for x in c]) for c in cells.T], atol=1e-7)


def test_cells_are_visited_with_x_running_fastest():
    assert offsets(2, 1).tolist()[:4] == [[-1, -1], [0, -1], [1, -1], [-1, 0]]
    assert offsets(4, 2).shape == (625, 4)


@pytest.mark.parametrize("op", HASHES)
@pytest.mark.parametrize("dimensions", [1, 2, 3])
@pytest.mark.parametrize("metric", ["EUCLIDEAN", "MANHATTAN", "CHEBYCHEV", "MINKOWSKI"])
def test_nearest_and_next_points(op, dimensions, metric):
    """The cells next to a lane's own hold the nearest point nearly always."""
    p = lanes(dimensions)
    point, color = all_points(HASHES[op], dimensions)
    distance = lengths(p[:, :, None] - point[:, None, :], metric)
    order = np.argsort(distance, axis=1)
    for rank, feature in enumerate(("F1", "F2")):
        properties = {"voronoi_dimensions": f"{dimensions}D", "distance": metric, "feature": feature}
        out = run(op, properties, exponent=0.7)
        right = np.isclose(out["distance"], np.take_along_axis(distance, order, 1)[:, rank], rtol=1e-4, atol=1e-5)
        assert right.mean() > (0.9 if metric == "MINKOWSKI" else 0.97 if rank == 0 else 0.9)
        nearest = order[:, rank]
        np.testing.assert_allclose(out["color"][:, right], color[:, nearest[right]], atol=1e-6)
        position = [out["w"]] if dimensions == 1 else out["position"][:dimensions]
        np.testing.assert_allclose(np.array(position)[:, right], point[:, nearest[right]], atol=1e-5)


@pytest.mark.parametrize("dimensions", [1, 2, 3])
def test_distance_to_edge_is_where_two_points_are_equally_far(dimensions):
    properties = {"voronoi_dimensions": f"{dimensions}D", "feature": "DISTANCE_TO_EDGE"}
    ours = run(properties=properties)["distance"]
    point, _ = all_points(PCG, dimensions)
    p = lanes(dimensions).astype(np.float64)
    away = point[:, None, :] - p[:, :, None]
    nearest = np.take_along_axis(away, np.argmin((away**2).sum(axis=0), axis=1)[None, :, None], 2)
    across = away - nearest
    length = np.sqrt((across**2).sum(axis=0))
    plane = (0.5 * (away + nearest) * across).sum(axis=0) / np.where(length > 0.01, length, 1.0)
    edge = np.where(length > 0.01, plane, np.inf).min(axis=1)
    assert np.isclose(ours, edge, atol=1e-5).mean() > 0.95


def test_radius_of_the_largest_ball_around_the_nearest_point():
    ours = run(properties={"feature": "N_SPHERE_RADIUS"})["radius"]
    point, _ = all_points(PCG, 3)
    nearest = np.argmin(lengths(lanes(3)[:, :, None] - point[:, None, :], "EUCLIDEAN"), axis=1)
    others = lengths(point[:, nearest, None] - point[:, None, :], "EUCLIDEAN")
    others[np.arange(nearest.size), nearest] = np.inf
    assert np.isclose(ours, others.min(axis=1) / 2, atol=1e-5).mean() > 0.95


def test_without_randomness_points_are_corners():
    out = run(randomness=0.0)
    np.testing.assert_allclose(out["position"], np.round(POINTS[:3]), atol=1e-5)
    np.testing.assert_allclose(out["distance"], np.sqrt(((POINTS[:3] - np.round(POINTS[:3])) ** 2).sum(0)), atol=1e-5)


def test_little_smoothness_is_none():
    sharp, smooth = run(), run(properties={"feature": "SMOOTH_F1"}, smoothness=1e-4)
    for name in ("distance", "color", "position"):
        assert np.isclose(sharp[name], smooth[name], atol=1e-3).mean() > 0.98
    mixed = np.where(np.arange(POINTS.shape[1]) % 2, 0.0, 0.5).astype(np.float32)
    out = run(properties={"feature": "SMOOTH_F1"}, smoothness=mixed)["distance"]
    assert np.isclose(out[1::2], sharp["distance"][1::2], atol=1e-4).mean() > 0.98
    assert (out[::2] < sharp["distance"][::2] + 1e-6).all()


@pytest.mark.parametrize("feature", ["F1", "DISTANCE_TO_EDGE"])
def test_detail_between_two_numbers_is_between(feature):
    low, half, high = (run(properties={"feature": feature}, detail=d)["distance"] for d in (1.0, 1.5, 2.0))
    np.testing.assert_allclose(half, 0.5 * (low + high), atol=1e-5)
    assert not np.allclose(low, high, atol=1e-2)
    per_lane = run(properties={"feature": feature}, detail=np.repeat(np.float32([1.0, 2.0]), 150))["distance"]
    np.testing.assert_allclose(per_lane, np.where(np.arange(300) < 150, low, high), atol=1e-6)


def test_normalized_distances_are_at_most_1():
    for metric in ("EUCLIDEAN", "MANHATTAN", "CHEBYCHEV", "MINKOWSKI"):
        out = run(properties={"normalize": True, "distance": metric}, detail=3.0)
        assert 0.1 < out["distance"].max() <= 1.0 and out["color"].max() <= 1.0


def test_blender_5_has_other_random_numbers():
    new, old = run("voronoi"), run("voronoi_4")
    assert np.isclose(new["distance"], old["distance"], atol=1e-3).mean() < 0.05
    one = {"voronoi_dimensions": "1D"}
    np.testing.assert_array_equal(run("voronoi", one)["color"], run("voronoi_4", one)["color"])


@pytest.mark.parametrize("feature", ["F1", "F2"])
def test_no_point_is_nearest_where_all_are_infinitely_far(feature):
    """Of exponent 0, before Blender 4.5; other exponents order points alike."""
    properties = {"distance": "MINKOWSKI", "feature": feature}
    by_length = properties | {"older": ("order",)}
    for name, values in run(properties=properties, exponent=0.7).items():
        np.testing.assert_array_equal(run(properties=by_length, exponent=0.7)[name], values)
    out = run(properties=by_length, exponent=0.0)
    np.testing.assert_allclose(out["position"], np.floor(POINTS[:3]), atol=1e-6)
    assert (out["distance"] == np.finfo(np.float32).max).all()
    np.testing.assert_array_equal(out["color"], PCG.color(np.floor(POINTS[:3]), Arena()))
    assert np.isinf(run(properties=properties, exponent=0.0)["distance"]).all()


def test_constants_give_constants():
    out = run(n=1, vector=np.float32([[0.2], [0.3], [0.4]]), w=0.5)
    assert [out[name].shape for name in ("distance", "color", "position")] == [(1,), (3, 1), (3, 1)]


@pytest.mark.parametrize("feature", ["F1", "F2", "SMOOTH_F1", "DISTANCE_TO_EDGE", "N_SPHERE_RADIUS"])
@pytest.mark.parametrize("op", HASHES)
def test_what_is_no_number_stays_in_its_lane(op, feature):
    bad = POINTS[:3].copy()
    bad[:, :4] = [[np.nan, np.inf, -np.inf, 3e38]] * 3
    for inputs in ({}, {"exponent": 0.0}, {"lacunarity": 0.0, "detail": 2.0}, {"scale": 0.0}, {"detail": np.nan}):
        properties = {"feature": feature, "distance": "MINKOWSKI" if inputs else "EUCLIDEAN"}
        good, out = run(op, properties, **inputs), run(op, properties, vector=bad, **inputs)
        for name, value in out.items():
            np.testing.assert_array_equal(value[..., 4:], good[name][..., 4:])
