# SPDX-License-Identifier: GPL-3.0-or-later
"""Image textures: lookups, projections and the nodes."""

import dataclasses
import math

import numpy as np
import pytest

from zraka.core.arena import Arena
from zraka.core.diagnostics import Diagnostics
from zraka.core.nodes import OPERATIONS
from zraka.core.nodes.base import Context
from zraka.core.nodes.projections import box, box_weights, sphere, tube
from zraka.core.nodes.texels import Texels
from zraka.core.sampling.color import srgb_to_linear
from zraka.core.scene import Image, Link, Material, Node

from .scenes import looking_down, placed, quad, radiance

WIDTH, HEIGHT = 7, 5
SCALES = {np.uint8: 255, np.uint16: 65535, np.float16: 1, np.float32: 1}
INTERPOLATIONS = ("Linear", "Closest", "Cubic", "Smart")
EXTENSIONS = ("REPEAT", "EXTEND", "CLIP", "MIRROR")


def pixels(dtype=np.uint8, channels=4, seed=0):
    values = np.random.default_rng(seed).random((HEIGHT, WIDTH, channels)) * SCALES[dtype]
    return (np.rint(values) if np.dtype(dtype).kind == "u" else values).astype(dtype)


def sampled(texels, x, y, interpolation="Closest", extension="REPEAT", rows=4, **more):
    out = np.full((rows, len(x)), np.nan, np.float32)
    x, y = (np.array(a, np.float32) for a in (x, y))
    texels.sample(x, y, interpolation, extension, Arena(), out, **more)
    return out


# -- lookups -----------------------------------------------------------------------------------------------------------


def wrapped(i, size, extension):
    """Texel `i` of one axis, None outside."""
    if extension == "REPEAT":
        return i % size
    if extension == "MIRROR":
        i %= 2 * size
        return min(i, 2 * size - 1 - i)
    return min(max(i, 0), size - 1) if extension == "EXTEND" or 0 <= i < size else None


def taps(coordinate, size, interpolation):
    """[(texel, weight)] by the definitions; B(s) is the uniform cubic B-spline."""
    if interpolation == "Closest":
        return [(math.floor(coordinate * size), 1.0)]
    t = coordinate * size - 0.5
    reach = 1 if interpolation == "Linear" else 2
    around = [math.floor(t) + k for k in range(1 - reach, reach + 1)]
    if interpolation == "Linear":
        return [(i, 1 - abs(t - i)) for i in around]
    return [(i, spline(abs(t - i))) for i in around]


def spline(s):
    return (4 - 6 * s**2 + 3 * s**3) / 6 if s < 1 else (2 - s) ** 3 / 6


@pytest.mark.parametrize("extension", EXTENSIONS)
@pytest.mark.parametrize("interpolation", INTERPOLATIONS)
def test_lookups_follow_their_definition(interpolation, extension):
    picture = pixels(np.float32)
    rng = np.random.default_rng(1)
    x, y = rng.uniform(-2.3, 3.3, (2, 300))
    expected = np.zeros((4, 300))
    for lane in range(300):
        for i, wx in taps(x[lane], WIDTH, interpolation):
            for j, wy in taps(y[lane], HEIGHT, interpolation):
                column, row = wrapped(i, WIDTH, extension), wrapped(j, HEIGHT, extension)
                if column is not None and row is not None:
                    expected[:, lane] += wx * wy * picture[row, column]
    value = sampled(Texels.of(picture), x, y, interpolation, extension)
    np.testing.assert_allclose(value, expected, atol=2e-5)


@pytest.mark.parametrize("channels", [1, 4])
@pytest.mark.parametrize("dtype", SCALES)
def test_texels_keep_their_type(dtype, channels):
    picture = pixels(dtype, channels)
    texels = Texels.of(picture)
    assert texels.nbytes == picture.nbytes
    assert np.shares_memory(texels.values, picture)
    value = sampled(texels, [2.5 / WIDTH], [3.5 / HEIGHT])[:, 0]
    expected = picture[3, 2].astype(np.float32) / SCALES[dtype]
    np.testing.assert_allclose(value, expected if channels == 4 else [*expected.repeat(3), 1], rtol=1e-6)


@pytest.mark.parametrize("dtype", SCALES)
def test_colours_stored_by_srgb_are_made_linear_after_the_lookup(dtype):
    texels = Texels.of(pixels(dtype), encoded=True)
    x, y = np.random.default_rng(2).random((2, 500))
    stored = sampled(Texels.of(texels.values.reshape(HEIGHT, WIDTH, 4)), x, y, "Linear")
    value = sampled(texels, x, y, "Linear")
    np.testing.assert_allclose(value[:3], srgb_to_linear(stored[:3]), atol=2e-5)
    np.testing.assert_array_equal(value[3], stored[3])


def test_an_opaque_picture_is_clear_where_it_is_clipped():
    picture = pixels()
    picture[..., 3] = 255
    assert sampled(Texels.of(picture), [0.5, 1.5], [0.5, 0.5], "Linear", "CLIP")[3].tolist() == [1, 0]
    assert sampled(Texels.of(picture), [0.5, 1.5], [0.5, 0.5], "Linear", "REPEAT")[3].tolist() == [1, 1]


@pytest.mark.parametrize("extension", EXTENSIONS)
@pytest.mark.parametrize("interpolation", INTERPOLATIONS)
def test_coordinates_that_are_no_numbers(interpolation, extension):
    x = [np.nan, np.inf, -np.inf, 3e38, 0.5]
    for u, v in ((x, x[::-1]), (x, [0.5] * 5)):
        assert np.isfinite(sampled(Texels.of(pixels()), u, v, interpolation, extension)).all()


def test_one_texel():
    for interpolation in INTERPOLATIONS:
        for extension in ("REPEAT", "EXTEND", "MIRROR"):
            value = sampled(Texels.of(pixels()[:1, :1]), [-3.7, 0.1, 9.9], [0.2, 0.9, -4], interpolation, extension)
            np.testing.assert_allclose(value, (pixels()[0, 0] / 255)[:, None].repeat(3, 1), rtol=1e-5)


def test_the_mean_of_a_large_picture():
    picture = np.random.default_rng(3).random((90, 170, 4), np.float32)
    small = Texels.of(picture).averaged(17, 9)
    expected = picture[..., :3].reshape(9, 10, 17, 10, 3).mean(axis=(1, 3))
    np.testing.assert_allclose(small.values[:, :3].reshape(9, 17, 3), expected, rtol=1e-5)
    linear = Texels.of(np.full((3, 3, 4), 128, np.uint8), encoded=True).averaged(8, 8)
    assert linear.values[0, 0] == pytest.approx(0.2158605, rel=1e-5)


# -- projections ---------------------------------------------------------------------------------------------


def test_sphere_and_tube():
    """+Y is in the middle, +X left of it; the axis has no coordinates."""
    at = np.array([[0.5, 1, 0.5], [1, 0.5, 0.5], [0.5, 0.5, 1], [0.5, 1, 1], [0.5, 0.5, 0.5]], np.float32).T
    np.testing.assert_allclose(sphere(at, Arena()), [[0.5, 0.25, 0, 0.5, 0], [0.5, 0.5, 1, 0.75, 0]], atol=1e-6)
    np.testing.assert_allclose(tube(at, Arena()), [[0.5, 0.25, 0, 0.5, 0], [0.5, 0.5, 0, 1, 0]], atol=1e-6)


@pytest.mark.parametrize("blend", [0.0, 0.01, 0.3, 1.0])
def test_shares_of_a_box(blend):
    """They add up to 1, an axis has its side alone, and they change little with the normal where sides blend."""
    rng = np.random.default_rng(6)
    normal = rng.normal(size=(3, 20_000)).astype(np.float32)
    weights = box_weights(normal, blend, Arena())
    np.testing.assert_allclose(weights.sum(axis=0), 1, atol=1e-4)
    assert (weights >= -1e-4).all()
    np.testing.assert_array_equal(box_weights(np.eye(3, dtype=np.float32) * -5, blend, Arena()), np.eye(3))
    if blend >= 0.3:
        normal /= np.linalg.norm(normal, axis=0)
        step = np.abs(box_weights(normal + np.float32(1e-3), blend, Arena()) - weights)
        assert step.max() < 0.05
    else:
        assert (weights == 1).any(axis=0).mean() > 0.97


def test_sides_of_a_box_are_not_mirrored():
    """Seen from outside, u runs to the right: (up × normal) · gradient(u) > 0, with v up."""
    p, arena = np.full((3, 1), 0.3, np.float32), Arena()
    for side, axis in enumerate(np.eye(3, dtype=np.float32)):
        for sign in (1, -1):
            n = (sign * axis).reshape(3, 1)

            def uv(point, n=n, side=side):
                u, v = box(point.astype(np.float32), n, arena)[side]
                return np.array([u[0], v[0]])

            gradient = np.array([uv(p + 0.1 * e.reshape(3, 1)) - uv(p) for e in np.eye(3)]).T / 0.1
            assert np.dot(np.cross(*gradient), n[:, 0]) == pytest.approx(1, abs=1e-4)


# -- operations --------------------------------------------------------------------------------------------------------


def run(op, inputs, **properties):
    operation = OPERATIONS[op]
    if operation.prepare:
        properties = operation.prepare(properties, Diagnostics(), "here")
    inputs = {name: np.asarray(value, np.float32) for name, value in inputs.items()}
    context = Context(Arena(), max(v.shape[-1] for v in inputs.values()))
    return operation.run(context, inputs, properties)


def test_alpha_is_constant_where_it_is_not_linked():
    image = Image("plain", pixels(), colorspace="Non-Color")
    vector = np.random.default_rng(7).random((3, 9))
    assert run("image", {"vector": vector}, image=image)["alpha"].shape == (1,)
    assert run("image", {"vector": vector}, image=image, linked={"alpha"})["alpha"].shape == (9,)


@pytest.mark.parametrize("projection", ["FLAT", "SPHERE", "TUBE"])
def test_vectors_that_are_no_numbers(projection):
    vector = np.array([[np.nan, 0, 0], [np.inf, -np.inf, 1], [3e38, -3e38, 3e38], [0.5, 0.5, 0.5]]).T
    for interpolation in INTERPOLATIONS:
        value = run(
            "image", {"vector": vector}, image=Image("p", pixels()), projection=projection, interpolation=interpolation
        )
        assert np.isfinite(value["color"]).all()
    value = run("environment", {"vector": vector}, image=Image("p", pixels()))
    assert np.isfinite(value["color"]).all()


def test_texture_mapping():
    vector = np.array([[1, 2, 3], [4, 5, 6]], np.float32).T
    rows = {"x": [[0], [0], [2]], "y": [[1], [0], [0]], "z": [[0], [0], [0]], "offset": [[0], [0.5], [4]]}
    value = run("texture_mapping", {"vector": vector, **rows}, coordinates="uv")["vector"]
    np.testing.assert_allclose(value.T, [[6, 1.5, 4], [12, 4.5, 4]])
    value = run("texture_mapping", {"vector": vector, **rows}, coordinates="uv", normalize=True)["vector"]
    np.testing.assert_allclose(np.linalg.norm(value, axis=0), 1, rtol=1e-6)


def glowing(*nodes):
    """What is seen of a square whose emission is the colour of the last node, with UV from 0 to 1."""
    mesh = dataclasses.replace(quad(4), uvs={"UVMap": np.array([[0, 0], [1, 0], [1, 1]] * 2, np.float32)})
    nodes = (*nodes, Node("emission", {"color": Link(len(nodes) - 1, "color"), "strength": 1.0}))
    return radiance(looking_down(placed(mesh, Material("m", nodes, len(nodes) - 1))), 1, method="raycast")


def test_a_box_looks_at_the_object_s_normal():
    """The square faces +Z: x is up in the picture and y runs to the left of its right edge, as seen in Blender."""
    picture = np.zeros((2, 2, 4), np.float32)
    picture[..., 3] = 1
    picture[1, 0] = 1
    image = Image("corner", picture, colorspace="Non-Color")
    vector = (0.75, 0.75, 0.0)  # v = x = 0.75, u = 1 - y = 0.25
    node = Node("image", {"vector": vector}, {"image": image, "projection": "BOX", "interpolation": "Closest"})
    assert glowing(node) == 1.0
    assert glowing(Node("image", {"vector": (0.25, 0.75, 0.0)}, dict(node.properties))) == 0.0


def test_a_picture_of_directions_on_a_surface():
    """Without coordinates it takes the position in the world."""
    picture = np.zeros((8, 16, 4), np.float32)
    picture[..., 3] = 1
    picture[:, 8:, 0] = picture[:, 8:, 1] = picture[:, 8:, 2] = 1  # right half: -Y
    image = Image("sky", picture, colorspace="Non-Color")
    mesh = quad(4)
    nodes = (
        Node("environment", {}, {"image": image}),
        Node("emission", {"color": Link(0, "color"), "strength": 1.0}),
    )
    for y, expected in ((-1.0, 1.0), (1.0, 0.0)):
        view = looking_down(placed(mesh, Material("m", nodes, 1)), at=(0.1, y, 0))
        assert radiance(view, 1, method="raycast") == pytest.approx(expected, abs=1e-3)
