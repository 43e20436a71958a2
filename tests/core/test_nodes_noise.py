# SPDX-License-Identifier: GPL-3.0-or-later
"""Hashes, noise and procedural textures against their definitions, one number at a time."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from zraka.core.arena import Arena
from zraka.core.nodes import OPERATIONS
from zraka.core.nodes import fractal as fractals
from zraka.core.nodes.base import Context, as_vector
from zraka.core.nodes.fractal import Fractal, evaluate
from zraka.core.nodes.hashing import hash_to_unit, hash_words
from zraka.core.nodes.perlin import signed_noise

WORD = 0xFFFFFFFF
FAMILY = ("noise", "white_noise", "wave", "magic", "gradient", "brick", "gabor", "checker")


@pytest.fixture
def rng():
    return np.random.default_rng(4)


def run(name, vector, count=None, **given):
    """Outputs of an operation at `vector` (3, N), other inputs their defaults or as given."""
    operation = OPERATIONS[name]
    inputs = {key: as_vector(value) for key, value in operation.inputs.items() if value is not None}
    inputs |= {key: given.pop(key) for key in tuple(given) if key in operation.inputs}
    inputs = {key: as_vector(v) if isinstance(v, int | float | tuple) else v for key, v in inputs.items()}
    context = Context(Arena(), vector.shape[-1] if count is None else count)
    return operation.run(context, inputs | {"vector": vector}, given)


def points(rng, n=500, size=5.0, dimension=3):
    return rng.uniform(-size, size, (dimension, n)).astype(np.float32)


# -- one number at a time ----------------------------------------------------------------------------------------------


def rotated(x, k):
    return (x << k | x >> (32 - k)) & WORD


def lookup3(*words):
    """The hash in Python's integers."""
    state = [(0xDEADBEEF + 4 * len(words) + 13) & WORD] * 3
    for i, word in enumerate(words[:3]):
        state[i] = (state[i] + word) & WORD
    a, b, c = state
    if len(words) == 4:
        for k in (4, 6, 8, 16, 19, 4):
            a = ((a - c) & WORD) ^ rotated(c, k)
            c = (c + b) & WORD
            a, b, c = b, c, a
        a = (a + words[3]) & WORD
    for k in (14, 11, 25, 16, 4, 14, 24):
        c = ((c ^ b) - rotated(b, k)) & WORD
        a, b, c = b, c, a
    return b


def gradient(h, *p):
    """Product of the gradient that the hash chooses and an offset."""

    def signed(value, bit):
        return -value if h >> bit & 1 else value

    if len(p) == 1:
        return signed(1 + (h & 7), 3) * p[0]
    if len(p) == 2:
        u, v = p if h & 7 < 4 else p[::-1]
        return signed(u, 0) + signed(2 * v, 1)
    if len(p) == 3:
        (x, y, z), h = p, h & 15
        u, v = x if h < 8 else y, y if h < 4 else x if h in (12, 14) else z
        return signed(u, 0) + signed(v, 1)
    (x, y, z, w), h = p, h & 31
    return signed(x if h < 24 else y, 0) + signed(y if h < 16 else z, 1) + signed(z if h < 8 else w, 2)


def noise(*p):
    """Gradient noise, the corners of a cell one after the other."""
    cell = [math.floor(x) for x in p]
    offset = [x - i for x, i in zip(p, cell, strict=True)]
    fade = [t**3 * (t * (6 * t - 15) + 10) for t in offset]
    total = 0.0
    for corner in itertools.product((0, 1), repeat=len(p)):
        weight = math.prod(t if side else 1 - t for side, t in zip(corner, fade, strict=True))
        h = lookup3(*((i + side) & WORD for i, side in zip(cell, corner, strict=True)))
        total += weight * gradient(h, *(x - side for x, side in zip(offset, corner, strict=True)))
    return total * (0.25, 0.6616, 0.982, 0.8344)[len(p) - 1]


# -- hashes and noise --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_hash_is_lookup3(rng, count):
    words = rng.integers(0, 2**32, (count, 64), dtype=np.uint32)
    expected = [lookup3(*(int(w) for w in column)) for column in words.T]
    assert hash_words(list(words), Arena()).tolist() == expected


@pytest.mark.parametrize("count", [2, 3, 4])
def test_hash_of_words_that_broadcast(rng, count):
    words = [w.reshape(-1, *(1,) * i) for i, w in enumerate(rng.integers(0, 2**32, (count, 3), dtype=np.uint32))]
    full = [np.ascontiguousarray(w) for w in np.broadcast_arrays(*words)]
    assert (hash_words(words, Arena()) == hash_words(full, Arena())).all()


def test_hash_to_unit_takes_the_bits_of_floats():
    value = hash_to_unit([np.float32([0.5, -0.5])], Arena())
    bits = np.float32([0.5, -0.5]).view(np.uint32)
    assert value == pytest.approx([lookup3(int(b)) / 2**32 for b in bits], abs=1e-7)


@pytest.mark.parametrize("dimension", [1, 2, 3, 4])
def test_noise_is_its_definition(rng, dimension):
    p = points(rng, 200, 20.0, dimension)
    expected = [noise(*(float(x) for x in column)) for column in p.T]
    assert signed_noise(p, Arena()) == pytest.approx(expected, abs=3e-6)


@pytest.mark.parametrize("dimension", [1, 2, 3, 4])
def test_looking_corners_up_changes_no_bit(rng, dimension):
    p = points(rng, 300, 3.0, dimension)
    alone = signed_noise(p, Arena()).copy()
    far = np.concatenate([p, np.full((dimension, 1), 9e4, np.float32)], axis=1)
    assert (signed_noise(far, Arena())[:-1] == alone).all()


def test_noise_repeats_beyond_100000():
    p = np.float32([[1.25, -3.5, 7.75], [0.5, -0.25, -99.5]])
    farther = p + np.float32(100000) * np.sign(p)
    assert signed_noise(farther, Arena()) == pytest.approx(signed_noise(p, Arena()), abs=1e-6)


def test_noise_beyond_a_million_is_not_zero():
    assert signed_noise(np.float32([[5.0, 2e6, -3e7]]), Arena()).astype(bool).tolist() == [False, True, True]


# -- fractals ----------------------------------------------------------------------------------------------------------


def fractal(kind, detail, **given):
    numbers = {"roughness": 0.6, "lacunarity": 2.1, "offset": 0.7, "gain": 1.4} | given
    return Fractal(kind, np.float32(np.atleast_1d(detail)), **{k: np.float32([v]) for k, v in numbers.items()})


KINDS = ("FBM", "MULTIFRACTAL", "HETERO_TERRAIN", "HYBRID_MULTIFRACTAL", "RIDGED_MULTIFRACTAL")


@pytest.mark.parametrize("kind", KINDS)
def test_fractals_are_their_definitions(rng, kind):
    p = points(rng, 20, 3.0, 2)
    expected = []
    for x, y in p.T.astype(float):
        n = [noise(x * 2.1**i, y * 2.1**i) for i in range(4)]
        r, offset, gain, share = 0.6, 0.7, 1.4, 0.4
        if kind == "FBM":
            sums = [sum(v * r**i for i, v in enumerate(n[:k])) / sum(r**i for i in range(k)) for k in (3, 4)]
            value = 0.5 + 0.5 * (sums[0] + share * (sums[1] - sums[0]))
        elif kind == "MULTIFRACTAL":
            value = math.prod(1 + s * v * r**i for i, (s, v) in enumerate(zip((1, 1, 1, share), n, strict=True)))
        elif kind == "HETERO_TERRAIN":
            value = n[0] + offset
            for i, s in ((1, 1), (2, 1), (3, share)):
                value += s * (n[i] + offset) * r**i * value
        elif kind == "HYBRID_MULTIFRACTAL":
            value, weight = 0.0, 1.0
            for i, s in enumerate((1, 1, 1, share)):
                signal = (n[i] + offset) * r**i
                if weight > 0.001:
                    value += s * min(weight, 1) * signal
                    weight = min(weight, 1) * gain * signal
        else:
            signal = value = (offset - abs(n[0])) ** 2
            for i in (1, 2):
                signal = (offset - abs(n[i])) ** 2 * min(max(signal * gain, 0), 1)
                value += signal * r**i
        expected.append(value)
    assert evaluate(fractal(kind, 2.4), p, Arena()) == pytest.approx(expected, abs=2e-5)


@pytest.mark.parametrize("kind", KINDS)
def test_detail_may_differ_between_lanes(rng, kind):
    p = points(rng, 40)
    details = np.repeat(np.float32([0.0, 1.3, 2.0, 4.7]), 10)
    together = evaluate(fractal(kind, details), p, Arena())
    for detail in np.unique(details):
        lanes = details == detail
        alone = evaluate(fractal(kind, detail), p[:, lanes], Arena())
        assert together[lanes] == pytest.approx(alone, abs=1e-6)


def test_blocks_change_no_bit(rng, monkeypatch):
    p = points(rng, 1000)
    whole = evaluate(fractal("FBM", np.linspace(0, 3, 1000)), p, Arena())
    monkeypatch.setattr(fractals, "BLOCK", 300)
    assert (evaluate(fractal("FBM", np.linspace(0, 3, 1000)), p, Arena()) == whole).all()


@pytest.mark.parametrize("detail", [-3.0, np.nan, np.inf, 400.0])
def test_detail_is_kept_in_its_limits(rng, detail):
    limit = 15.0 if detail > 0 else 0.0
    p = points(rng, 10)
    expected = evaluate(fractal("FBM", limit), p, Arena())
    assert (evaluate(fractal("FBM", detail), p, Arena()) == expected).all()


# -- textures ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", FAMILY)
def test_odd_coordinates_give_no_warning_and_stay_in_their_lane(rng, name):
    p = points(rng, 64)
    odd = p.copy()
    odd[:, 1::2] = rng.choice(np.float32([np.nan, np.inf, -np.inf, 1e30, -3e38, 0.0]), (3, 32))
    outputs, alone = run(name, odd, distortion=1.0), run(name, p, distortion=1.0)
    for key in alone:
        assert outputs[key][..., ::2] == pytest.approx(alone[key][..., ::2], abs=1e-6)


@pytest.mark.parametrize("name", FAMILY)
def test_constants_lanes_and_no_lanes(rng, name):
    p = points(rng, 7)
    lanes = run(name, p)
    constant = run(name, p[:, :1])
    nothing = run(name, p[:, :0], count=0)
    for key in lanes:
        assert constant[key][..., 0] == pytest.approx(lanes[key][..., 0], abs=1e-6)
        assert lanes[key].dtype == np.float32
        assert nothing[key].shape[-1] == 0
    scales = np.full(7, OPERATIONS[name].inputs.get("scale", 1.0), np.float32)
    if "scale" in OPERATIONS[name].inputs:
        by_lane = run(name, p[:, :1], count=7, scale=scales)
        for key in lanes:
            assert by_lane[key] == pytest.approx(np.broadcast_to(constant[key], by_lane[key].shape), abs=1e-6)


def test_outputs_are_computed_when_read(rng, monkeypatch):
    calls = []
    monkeypatch.setattr("zraka.core.nodes.noise.evaluate", lambda *given: calls.append(1) or np.zeros(5, np.float32))
    outputs = run("noise", points(rng, 5))
    outputs["fac"], outputs["fac"]
    assert len(calls) == 1
    assert outputs["color"].shape == (3, 5)
    assert len(calls) == 3


@pytest.mark.parametrize("dimensions", ["1D", "2D", "3D", "4D"])
def test_noise_without_its_scale(rng, dimensions):
    p = points(rng, 30)
    w = np.float32(rng.uniform(-3, 3, 30))
    used = {"1D": w[None], "2D": p[:2], "3D": p, "4D": np.vstack([p, w])}[dimensions]
    given = {"w": w, "scale": 1.0, "detail": 0.0, "noise_dimensions": dimensions}
    assert run("noise", p, **given)["fac"] == pytest.approx(0.5 + 0.5 * signed_noise(used, Arena()), abs=1e-6)
    assert run("noise", p, normalize=False, **given)["fac"] == pytest.approx(signed_noise(used, Arena()), abs=1e-6)


def test_white_noise_is_uniform_and_its_channels_differ(rng):
    color = run("white_noise", points(rng, 30000))["color"]
    counts = np.array([np.histogram(row, 20, (0, 1))[0] for row in color])
    chi_square = ((counts - 1500) ** 2 / 1500).sum(axis=1)
    assert (chi_square < 45).all()  # 19 degrees of freedom: exceeded once in a thousand
    assert np.abs(np.corrcoef(color) - np.eye(3)).max() < 0.03
    # A density that leans by a tenth would not pass.
    leaning = np.histogram(np.clip(color[0] ** 1.1, 0, 1), 20, (0, 1))[0]
    assert ((leaning - 1500) ** 2 / 1500).sum() > 45


def test_gradients():
    p = np.float32([[0, -1, 0, 0.5], [1, 0, 0, 0], [0, 0, 0, 0]])
    assert run("gradient", p, gradient_type="RADIAL")["fac"] == pytest.approx([0.75, 1.0, 0.5, 0.5])
    assert run("gradient", p, gradient_type="SPHERICAL")["fac"] == pytest.approx([0, 0, 1, 0.5], abs=2e-6)
    assert run("gradient", p, gradient_type="EASING")["color"][2] == pytest.approx([0, 0, 0, 0.5])


def test_wave_profiles():
    p = np.zeros((3, 5), np.float32)
    p[0] = np.arange(5) * math.pi / 2 / 20
    for profile, expected in {
        "SIN": (0, 0.5, 1, 0.5, 0),
        "TRI": (0, 0.5, 1, 0.5, 0),
        "SAW": (0, 0.25, 0.5, 0.75, 0),
    }.items():
        fac = run("wave", p, scale=1.0, wave_profile=profile)["fac"]
        assert fac == pytest.approx(expected, abs=1e-4)


def test_bricks_have_mortar_at_their_edges_and_one_tint_inside():
    x = np.linspace(0.0, 0.999, 500, dtype=np.float32)
    p = np.stack([x, np.full(500, 0.12, np.float32), np.zeros(500, np.float32)])
    given = {"scale": 1.0, "offset": 0.0, "mortar_smooth": 0.0, "color1": (0.0,) * 3, "color2": (1.0,) * 3}
    outputs = run("brick", p, mortar=(2.0,) * 3, **given)
    distance = np.abs(x - 0.5 * np.round(x / 0.5))
    assert (outputs["fac"] == (distance < 0.02)).all()
    inside = outputs["color"][0][outputs["fac"] == 0]
    assert len(np.unique(inside)) == 2
    assert (outputs["color"][0][outputs["fac"] == 1] == 2).all()


def test_checker_colours_are_exact():
    p = np.float32([[0.1, 1.1, -0.1], [0.1, 0.1, 0.1], [0.1, 0.1, 0.1]])
    outputs = run("checker", p, scale=1.0, color1=(0.1, 0.7, 1e10), color2=(0.3, 0.2, 1e-10))
    assert outputs["fac"].tolist() == [0, 1, 1]
    assert (outputs["color"][:, 1] == np.float32([0.1, 0.7, 1e10])).all()
    assert (outputs["color"][:, 0] == np.float32([0.3, 0.2, 1e-10])).all()


@pytest.mark.parametrize("kind", ["2D", "3D"])
def test_gabor_tables_change_nothing(rng, kind):
    p = points(rng, 400, 0.3)
    given = {"gabor_type": kind, "anisotropy": 0.4}
    alone = run("gabor", p, **given)
    far = run("gabor", np.concatenate([p, np.full((3, 1), 1e4, np.float32)], axis=1), **given)
    assert far["value"][:-1] == pytest.approx(alone["value"], abs=1e-6)
    assert alone["value"].std() > 0.05
    assert alone["intensity"].min() >= 0
    assert 0 <= alone["phase"].min() <= alone["phase"].max() <= 1
