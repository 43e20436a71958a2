# SPDX-License-Identifier: GPL-3.0-or-later
"""Procedural textures but Voronoi beside Cycles."""

from __future__ import annotations

from functools import partial
from itertools import product

import bpy
import pytest

from .harness import Case, add, coordinates, difference, output, signed

# Edges of bricks and squares, jumps of saw teeth: a pixel there may fall on either side.
_EDGES = 0.01
_TILTED = {"scale": (2.0, 2.0, 1.0), "location": (-0.7, -0.9, 0.3), "rotation": (0.4, 0.3, 0.5)}
_KINDS = ("FBM", "MULTIFRACTAL", "HYBRID_MULTIFRACTAL", "RIDGED_MULTIFRACTAL", "HETERO_TERRAIN")
_DIMENSIONS = ("1D", "2D", "3D", "4D")


def texture(kind, socket, inputs, properties, tree, obj, mapped=True, sees_sign=False):
    """Output `socket` of a texture over tilted coordinates; w is the first of them."""
    inputs = dict(inputs)
    if mapped:
        point = coordinates(tree, **_TILTED)
        if kind != "TexNoise" or properties.get("noise_dimensions") != "1D":
            inputs.setdefault("Vector", point)
        if properties.get("noise_dimensions") in ("1D", "4D"):
            first = add(tree, "TexGradient", {"Vector": coordinates(tree, (0.8, 0.1, 1.0), (0.05, 0.02, 0.0))})
            inputs.setdefault("W", output(first, "Fac"))
    node = add(tree, kind, inputs, **properties)
    found = output(node, socket)
    return signed(tree, found) if sees_sign else found


def case(name, kind, socket=0, inputs=None, share=0.0, mapped=True, sees_sign=False, **properties):
    build = partial(texture, kind, socket, inputs or {}, properties, mapped=mapped, sees_sign=sees_sign)
    return Case(name, build, share=share)


def white(dimensions, socket, tree, obj):
    """White noise over few vectors, and over the white noise of them as w."""
    point = exact_vectors(tree)
    inputs = {"Vector": point} if dimensions != "1D" else {}
    if dimensions in ("1D", "4D"):
        inputs["W"] = output(add(tree, "TexWhiteNoise", {"Vector": point}), "Value")
    return output(add(tree, "TexWhiteNoise", inputs, noise_dimensions=dimensions), socket)


def exact_vectors(tree):
    """Vectors that are the same to the last bit in both engines: checkers over checkers."""
    low, high = (0.1, -0.2, 0.3, 1.0), (1.7, 2.5, -3.1, 1.0)
    for scale in (3.0, 7.0, 11.0):
        inputs = {"Vector": coordinates(tree, location=(0.01, 0.02, 0.5)), "Color1": low, "Scale": scale}
        low = output(add(tree, "TexChecker", {**inputs, "Color2": high}), "Color")
        high = (scale, 0.3 * scale, -scale, 1.0)
    return low


def noise_cases():
    """Each kind in each dimension, then one input at a time."""
    for kind, dimensions in product(_KINDS, _DIMENSIONS):
        name = f"Noise Texture: {kind} {dimensions}"
        inputs = {"Scale": 4.0, "Detail": 3.4, "Roughness": 0.6, "Lacunarity": 2.1}
        if kind not in ("FBM", "MULTIFRACTAL"):
            inputs["Offset"] = 0.7
        if kind in ("HYBRID_MULTIFRACTAL", "RIDGED_MULTIFRACTAL"):
            inputs["Gain"] = 1.6
        properties = {"noise_type": kind, "noise_dimensions": dimensions}
        yield case(f"{name} Fac", "TexNoise", "Fac", inputs, sees_sign=True, **properties)
        yield case(f"{name} Color", "TexNoise", "Color", inputs, sees_sign=True, **properties)
    for dimensions in _DIMENSIONS:
        inputs = {"Distortion": 1.3, "Scale": 3.0}
        yield case(f"Noise Texture: distorted {dimensions}", "TexNoise", "Color", inputs, noise_dimensions=dimensions)
    for label, inputs in {
        "defaults": {},
        "no detail": {"Detail": 0.0},
        "detail 15": {"Detail": 15.0, "Scale": 1.0},
        "rough": {"Roughness": 1.0, "Detail": 4.0},
        "lacunarity below 1": {"Lacunarity": 0.3, "Detail": 4.5},
        "negative scale": {"Scale": -5.0},
    }.items():
        yield case(f"Noise Texture: {label}", "TexNoise", "Color", inputs)
    yield case("Noise Texture: not normalised", "TexNoise", "Color", {}, sees_sign=True, normalize=False)
    yield case("Noise Texture: generated", "TexNoise", "Color", {}, mapped=False)
    yield case("Noise Texture: w beyond a million", "TexNoise", 0, {"W": 2e6, "Scale": 1.0}, noise_dimensions="1D")
    yield case("Noise Texture: w beyond 100,000", "TexNoise", 0, {"W": 123456.25, "Scale": 1.0}, noise_dimensions="4D")
    yield Case("Noise Texture: linked inputs", linked_inputs)


def linked_inputs(tree, obj):
    """Noise whose numbers vary over the picture."""
    varying = output(add(tree, "TexGradient", {"Vector": coordinates(tree)}), "Fac")
    detail = output(add(tree, "TexMagic", {"Vector": coordinates(tree), "Scale": 0.3, "Distortion": 0.2}), "Fac")
    names = ("Roughness", "Lacunarity", "Distortion")
    inputs = {"Vector": coordinates(tree, **_TILTED), "Detail": detail} | dict.fromkeys(names, varying)
    return output(add(tree, "TexNoise", inputs), "Color")


def wave_cases():
    directions = [("BANDS", "bands_direction", d) for d in ("X", "Y", "Z", "DIAGONAL")]
    directions += [("RINGS", "rings_direction", d) for d in ("X", "Y", "Z", "SPHERICAL")]
    for kind, name, direction in directions:
        properties = {"wave_type": kind, name: direction}
        yield case(f"Wave Texture: {kind} {direction}", "TexWave", "Fac", {"Scale": 0.7}, **properties)
    for profile in ("SAW", "TRI"):
        inputs = {"Scale": 0.4, "Phase Offset": 1.3}
        yield case(f"Wave Texture: {profile}", "TexWave", "Color", inputs, share=_EDGES, wave_profile=profile)
    inputs = {"Scale": 0.6, "Distortion": 4.0, "Detail": 2.6, "Detail Scale": 1.7, "Detail Roughness": 0.7}
    yield case("Wave Texture: distorted", "TexWave", "Color", inputs)
    yield case("Wave Texture: generated", "TexWave", "Color", {"Scale": 0.5}, mapped=False)


def magic_cases():
    for depth in range(11):
        inputs = {"Scale": 1.5, "Distortion": 1.2}
        yield case(f"Magic Texture: depth {depth}", "TexMagic", "Color", inputs, sees_sign=True, turbulence_depth=depth)
    yield case("Magic Texture: factor", "TexMagic", "Fac", {"Scale": 2.0})
    yield case("Magic Texture: distortion 0", "TexMagic", "Color", {"Distortion": 0.0}, sees_sign=True)
    yield case("Magic Texture: generated", "TexMagic", "Color", {}, mapped=False)


def gradient_cases():
    for kind in ("LINEAR", "QUADRATIC", "EASING", "DIAGONAL", "SPHERICAL", "QUADRATIC_SPHERE", "RADIAL"):
        socket = "Color" if kind == "RADIAL" else "Fac"
        yield case(f"Gradient Texture: {kind}", "TexGradient", socket, share=_EDGES, gradient_type=kind)
    yield case("Gradient Texture: generated", "TexGradient", "Color", mapped=False)


def brick_cases():
    colors = {"Color1": (0.9, 0.2, 0.1, 1.0), "Color2": (0.1, 0.4, 0.8, 1.0), "Mortar": (0.0, 0.6, 0.3, 1.0)}
    uneven = {"offset": 0.3, "offset_frequency": 3, "squash": 0.6, "squash_frequency": 2}
    for label, inputs, properties in (
        ("defaults", {}, {}),
        ("colours", colors, {}),
        ("bias", {**colors, "Bias": -0.4}, {}),
        ("offset and squash", {**colors, "Scale": 3.0}, uneven),
        ("sizes", {**colors, "Brick Width": 0.9, "Row Height": 0.4, "Mortar Size": 0.08, "Mortar Smooth": 1.0}, {}),
        ("sharp mortar", {**colors, "Mortar Size": 0.05, "Mortar Smooth": 0.0}, {}),
        ("no mortar", {**colors, "Mortar Size": 0.0}, {}),
    ):
        # The mapping stretches one pixel over much of a smooth edge, where the engines' coordinates differ a little.
        yield case(f"Brick Texture: {label}", "TexBrick", "Color", inputs, share=_EDGES, **properties)
    yield case("Brick Texture: factor", "TexBrick", "Fac", {"Mortar Smooth": 0.7}, share=_EDGES)
    yield case("Brick Texture: generated", "TexBrick", "Color", colors, share=_EDGES, mapped=False)


def gabor_cases():
    if not hasattr(bpy.types, "ShaderNodeTexGabor"):
        return
    for kind, socket in product(("2D", "3D"), ("Value", "Phase", "Intensity")):
        inputs = {"Scale": 4.0, "Frequency": 1.6, "Anisotropy": 0.3}
        # The phase jumps from one to zero.
        share = _EDGES if socket == "Phase" else 0.0
        yield case(f"Gabor Texture: {kind} {socket}", "TexGabor", socket, inputs, share=share, gabor_type=kind)
    for kind, orientation in (("2D", 2.1), ("3D", (0.3, -0.8, 0.4))):
        inputs = {"Scale": 3.0, 4: orientation}
        yield case(f"Gabor Texture: {kind} anisotropic", "TexGabor", "Value", inputs, gabor_type=kind)
    yield case("Gabor Texture: generated", "TexGabor", "Value", {}, mapped=False)


def checker_cases():
    colors = {"Color1": (0.9, 0.2, 0.1, 1.0), "Color2": (0.1, 0.4, 0.8, 1.0)}
    yield case("Checker Texture: colour", "TexChecker", "Color", colors, share=_EDGES)
    yield case("Checker Texture: factor", "TexChecker", "Fac", {"Scale": 3.0}, share=_EDGES)
    yield case("Checker Texture: generated", "TexChecker", "Color", colors, share=_EDGES, mapped=False)


CASES = [
    *noise_cases(),
    *(
        Case(f"White Noise Texture: {dimensions} {socket}", partial(white, dimensions, socket))
        for dimensions, socket in product(_DIMENSIONS, ("Value", "Color"))
    ),
    case("White Noise Texture: unlinked", "TexWhiteNoise", "Color", mapped=False),
    *wave_cases(),
    *magic_cases(),
    *gradient_cases(),
    *brick_cases(),
    *gabor_cases(),
    *checker_cases(),
]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_agrees_with_cycles(case):
    largest, share = difference(case)
    print(f"largest difference {largest:.1e}, {share:.2%} of the pixels beyond {case.tolerance:g}")
    assert share <= case.share
