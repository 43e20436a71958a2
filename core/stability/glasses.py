# SPDX-License-Identifier: GPL-3.0-or-later
"""Glass in glass, glass through glass, and a camera in the middle of it: nothing is lost in a white world."""

from __future__ import annotations

import numpy as np

from ..scene import Material, Spheres
from .axis import Axis
from .case import Case
from .shapes import box, camera, placed, scene, sphere

OUTSIDE = camera((0, -4, 0), (0, 0, 0), fov=0.1)
INSIDE = camera((0, 0, 0), (0, 1, 0), fov=0.5)


def balls(*radii_and_centers, view=OUTSIDE, analytic=False):
    """Glass balls, (radius, x) each, in a white world."""
    if analytic:
        centers = np.array([(x, 0, 0) for _, x in radii_and_centers], float)
        made = [Spheres(centers, np.array([r for r, _ in radii_and_centers]), Material.glass())]
        return scene(view, spheres=made, world=1.0)
    made = [placed(sphere(r, (x, 0, 0), rings=32), Material.glass(ior=1.5)) for r, x in radii_and_centers]
    return scene(view, *made, world=1.0)


def cubes(*sizes, view=OUTSIDE):
    """Glass cubes in one another."""
    return scene(view, *(placed(box(s), Material.glass(ior=1.3)) for s in sizes), world=1.0)


def _lossless(build):
    return Case(build, 1.0, samples=16, settings={"depth": 256})


NESTED = {
    "ball in a ball": _lossless(lambda: balls((1.0, 0), (0.5, 0))),
    "ball in a ball, 1e-6 apart": _lossless(lambda: balls((1.0, 0), (1 - 1e-6, 0))),
    "two balls in one place": _lossless(lambda: balls((1.0, 0), (1.0, 0))),
    "overlapping balls": _lossless(lambda: balls((1.0, -0.3), (1.0, 0.3))),
    "touching balls": _lossless(lambda: balls((1.0, -1.0), (1.0, 1.0))),
    "overlapping spheres in closed form": _lossless(lambda: balls((1.0, -0.3), (1.0, 0.3), analytic=True)),
    "camera in a ball": _lossless(lambda: balls((1.0, 0), view=INSIDE)),
    "camera in a sphere in closed form": _lossless(lambda: balls((1.0, 0), view=INSIDE, analytic=True)),
    "camera in two balls": _lossless(lambda: balls((1.0, 0), (2.0, 0), view=INSIDE)),
    "camera on a ball": _lossless(lambda: balls((1.0, 0), view=camera((0, -1, 0), (0, 0, 0), fov=0.1))),
}

AXES = (Axis("nested glass", "glass in a white world: 1", NESTED.get, tuple(NESTED)),)
