# SPDX-License-Identifier: GPL-3.0-or-later
"""What is of Rec.709 in files whose colours are in another space, beside Cycles."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from .harness import Case, add, difference, output
from .varied import plane_numbers

SPACES = ("ACEScg", "Linear Rec.2020")
KNOWN = ("thin films are coloured",)


def number(tree, low, high):
    return plane_numbers(tree, low, high)[0]


def blackbody(tree):
    return output(add(tree, "Blackbody", {0: number(tree, 900.0, 12000.0)}))


def wavelength(tree):
    return output(add(tree, "Wavelength", {0: number(tree, 380.0, 750.0)}))


def picture(space, alpha=1.0, reads_alpha=False, interpolation="Closest"):
    """Builds an Image Texture of random colours; `alpha` below 1 is the least of random ones."""

    def build(tree):
        image = bpy.data.images.new("Picture", 16, 16, float_buffer=space != "sRGB")
        image.colorspace_settings.name = space
        pixels = np.random.default_rng(1).random((16 * 16, 4)).astype(np.float32)
        pixels[:, 3] = alpha + (1 - alpha) * pixels[:, 3]
        image.pixels.foreach_set(pixels.ravel())
        node = add(tree, "TexImage", image=image, interpolation=interpolation)
        if not reads_alpha:
            return output(node)
        return output(add(tree, "VectorMath", {0: output(node), 1: output(node, "Alpha")}, operation="MULTIPLY"))

    return build


def gray(tree):
    return output(add(tree, "RGBToBW", {0: picture("sRGB")(tree)}))


def number_of_a_colour(tree):
    return output(add(tree, "Math", {0: picture("sRGB")(tree), 1: 0.0}, operation="ADD"))


def sky(tree):
    node = add(tree, "TexSky", {}, sky_type="PREETHAM")
    return output(add(tree, "VectorMath", {0: output(node), 1: (0.05, 0.05, 0.05)}, operation="MULTIPLY"))


BUILDS = {
    "blackbody": blackbody,
    "wavelength": wavelength,
    "sRGB image": picture("sRGB"),
    "sRGB image, blended": picture("sRGB", interpolation="Linear"),
    "sRGB image with alpha": picture("sRGB", alpha=0.2),
    "sRGB image with alpha that is read": picture("sRGB", alpha=0.2, reads_alpha=True),
    "RGB to BW": gray,
    "colour into a number": number_of_a_colour,
    "linear image": picture("Linear Rec.709"),
    "data image": picture("Non-Color"),
    "sky": sky,
}


def in_space(space, build):
    def made(tree, plane):
        bpy.ops.wm.set_working_color_space(working_space=space, convert_colors=False)
        return build(tree)

    return made


# Blender 5.2 rounds pictures to halves after they are in the working space, earlier ones before.
TOLERANCE = 3e-3 if bpy.app.version >= (5, 2) else 1e-3
CASES = [
    Case(f"Working space: {name}, {space}", in_space(space, build), TOLERANCE, known=KNOWN)
    for name, build in BUILDS.items()
    for space in SPACES
]


@pytest.mark.skipif(bpy.app.version < (5, 0), reason="the working space can be chosen since Blender 5.0")
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_agrees_with_cycles(case):
    try:
        largest, share = difference(case)
    finally:
        for image in list(bpy.data.images):  # with changed ones the space cannot be set back
            bpy.data.images.remove(image)
        bpy.ops.wm.set_working_color_space(working_space="Linear Rec.709", convert_colors=False)
    print(f"{case.name}: largest difference {largest:.1e}, {share:.2%} of the pixels beyond")
    assert share <= case.share
