# SPDX-License-Identifier: GPL-3.0-or-later
"""Sky Texture beside Cycles, as a plane shows it; worlds are compared in tests/addon/test_sky_against_cycles.py."""

from __future__ import annotations

import math

import bpy
import pytest

from .harness import Case, add, coordinates, difference, output, signed

SCATTERING = ("SINGLE_SCATTERING", "MULTIPLE_SCATTERING") if bpy.app.version >= (5, 0) else ("NISHITA",)
DUST = "aerosol_density" if bpy.app.version >= (5, 0) else "dust_density"
AIR = {"altitude": 3000.0, "air_density": 0.6, DUST: 2.0, "ozone_density": 3.0}
LOW_SUN = {"sun_elevation": math.radians(-2.0), "sun_rotation": 4.0}


def sky(scale=0.05, **properties):
    """Builder of a sky in directions that go from below the horizon to the zenith."""

    def build(tree, obj):
        vector = coordinates(tree, (2.0, 3.0, 1.0), (-1.0, -1.5, 0.3), (0.5, 0.3, 0.0))
        unit = add(tree, "VectorMath", {"Vector": vector}, operation="NORMALIZE")
        node = add(tree, "TexSky", {"Vector": output(unit)}, **properties)
        return signed(tree, output(node), scale, 0.0)

    return build


CASES = [
    Case(f"Sky Texture: {kind}, {name}", sky(scale, sky_type=kind, sun_disc=False, **properties), tolerance=1e-3)
    for kind in SCATTERING
    for name, scale, properties in (
        ("defaults", 0.05, {}),
        ("other air", 0.05, AIR | {"sun_elevation": 1.0, "sun_rotation": 1.0}),
        ("sun below", 1.0, LOW_SUN),
        ("sun beyond the zenith", 0.05, {"sun_elevation": 2.5, "sun_rotation": -7.0}),
    )
]
CASES += [
    Case(f"Sky Texture: {kind}, {name}", sky(0.5, sky_type=kind, **properties))
    for kind in ("PREETHAM", "HOSEK_WILKIE")
    for name, properties in (
        ("defaults", {}),
        ("low sun", {"sun_direction": (0.8, 0.3, 0.2), "turbidity": 4.7, "ground_albedo": 0.9}),
        ("haze", {"sun_direction": (-0.1, 0.6, 0.7), "turbidity": 10.0}),
    )
]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_agrees_with_cycles(case):
    largest, share = difference(case)
    print(f"largest difference {largest:.1e}, {share:.2%} of the pixels beyond {case.tolerance:g}")
    assert share <= case.share
