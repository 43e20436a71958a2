# SPDX-License-Identifier: GPL-3.0-or-later
"""Voronoi Texture beside Cycles."""

from __future__ import annotations

import pytest

from .harness import Case, add, coordinates, difference, output, signed

# Cells of the pattern have sharp borders, on which a lane may fall to either side.
SHARE = 0.01
FEATURES = ("F1", "F2", "SMOOTH_F1", "DISTANCE_TO_EDGE", "N_SPHERE_RADIUS")
METRICS = ("EUCLIDEAN", "MANHATTAN", "CHEBYCHEV", "MINKOWSKI")
DIMENSIONS = ("1D", "2D", "3D", "4D")
OUTPUTS = {
    "F1": ("Distance", "Color", "Position", "W"),
    "F2": ("Distance", "Color", "Position", "W"),
    "SMOOTH_F1": ("Distance", "Color", "Position", "W"),
    "DISTANCE_TO_EDGE": ("Distance",),
    "N_SPHERE_RADIUS": ("Radius",),
}


def voronoi(key, dimensions="3D", inputs=None, **properties):
    """Builder of a Voronoi Texture over turned coordinates, of which it shows output `key`."""

    def build(tree, obj):
        vector = coordinates(tree, (4.0, 3.0, 2.0), (-1.3, 0.4, 0.7), (0.3, 0.5, 0.7))
        place = {}
        if dimensions != "1D":
            place["Vector"] = vector
        if dimensions in ("1D", "4D"):
            place["W"] = vector if dimensions == "1D" else 0.37
        node = add(
            tree,
            "TexVoronoi",
            {"Scale": 1.5, "Randomness": 0.9} | place | (inputs or {}),
            voronoi_dimensions=dimensions,
            **properties,
        )
        socket = output(node, key)
        return signed(tree, socket) if key in ("Position", "W") else socket

    return build


def shown(feature, dimensions):
    """Outputs that the node has."""
    for key in OUTPUTS[feature]:
        if (key == "Position" and dimensions == "1D") or (key == "W" and dimensions not in ("1D", "4D")):
            continue
        yield key


CASES = [
    Case(f"Voronoi Texture: {feature} {d} {key}", voronoi(key, d, feature=feature), share=SHARE)
    for feature in FEATURES
    for d in DIMENSIONS
    for key in shown(feature, d)
]
CASES += [
    Case(
        f"Voronoi Texture: {feature} {metric} {d}",
        voronoi("Distance", d, {"Exponent": 1.7} if metric == "MINKOWSKI" else None, feature=feature, distance=metric),
        share=SHARE,
    )
    for feature in ("F1", "F2", "SMOOTH_F1")
    for metric in METRICS[1:]
    for d in DIMENSIONS[1:]
]
OCTAVES = {"Detail": 2.6, "Roughness": 0.7, "Lacunarity": 2.3}
CASES += [
    Case(
        f"Voronoi Texture: {feature} {key} octaves{', normalized' if normalize else ''}",
        voronoi(key, "3D" if feature == "F2" else "2D", OCTAVES, feature=feature, normalize=normalize),
        share=SHARE,
    )
    for feature in FEATURES[:4]
    for key in shown(feature, "3D")
    for normalize in (False, True)
]
CASES += [
    Case(
        "Voronoi Texture: generated coordinates",
        lambda tree, obj: output(add(tree, "TexVoronoi", {"Scale": 4.0}), "Distance"),
        share=SHARE,
    ),
    Case("Voronoi Texture: no randomness", voronoi("Color", "2D", {"Randomness": 0.0}), share=SHARE),
    Case(
        "Voronoi Texture: no smoothness", voronoi("Color", "2D", {"Smoothness": 0.0}, feature="SMOOTH_F1"), share=SHARE
    ),
    Case("Voronoi Texture: little smoothness", voronoi("Distance", "2D", {"Smoothness": 0.2}, feature="SMOOTH_F1")),
    Case("Voronoi Texture: scale 0", voronoi("Position", "2D", {"Scale": 0.0})),
    Case("Voronoi Texture: negative scale", voronoi("Position", "3D", {"Scale": -3.0}), share=SHARE),
    Case(
        "Voronoi Texture: Minkowski normalized",
        voronoi("Distance", "2D", {"Exponent": 0.5}, distance="MINKOWSKI", normalize=True),
        share=SHARE,
    ),
]
CASES += [
    Case(
        f"Voronoi Texture: exponent {exponent} {key}",
        voronoi(key, "2D", {"Exponent": exponent}, distance="MINKOWSKI"),
        share=SHARE,
    )
    for exponent, key in ((0.0, "Color"), (0.0, "Position"), (-1.0, "Color"))
]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_agrees_with_cycles(case):
    largest, share = difference(case)
    print(f"largest difference {largest:.1e}, {share:.2%} of the pixels beyond {case.tolerance:g}")
    assert share <= case.share
