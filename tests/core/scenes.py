# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scenes with known answers, on the core's own description."""

import numpy as np

from zraka.core.compile import compile_scene
from zraka.core.diagnostics import Diagnostics
from zraka.core.render import render
from zraka.core.scene import Material, Scene, World
from zraka.core.settings import Settings
from zraka.core.stability.shapes import box, camera, disk, merged, placed, quad, sphere  # noqa: F401 - used by tests


def scene(view, *instances, lights=(), world=0.0, spheres=(), planes=()):
    """A scene with a grey world."""
    return Scene(view, instances, spheres, planes, tuple(lights), World((world,) * 3))


def film_of(description, samples=16, size=32, **settings):
    """Render; `size` is a side or (width, height)."""
    width, height = (size, size) if isinstance(size, int) else size
    settings = Settings(width=width, height=height, samples=samples, **({"threads": 2} | settings))
    return render(compile_scene(description, settings, Diagnostics()), settings)


def radiance(description, samples=16, **settings):
    """Mean radiance of the picture; also insists that every sample was finite."""
    film = film_of(description, samples, **settings)
    assert film.nonfinite == 0
    return float(film.image()[..., :3].mean())


def looking_down(*instances, lights=(), world=0.0, at=(0, 0, 0), height=1.0, **more):
    """A scene seen from just above the point `at`, which fills the picture."""
    eye = np.add(at, (0, 0, height))
    return scene(camera(eye, at, fov=0.005), *instances, lights=lights, world=world, **more)


def cornell():
    """A diffuse box with a lamp; a work load, no truth."""
    white, red, green = Material.diffuse(0.75), Material.diffuse((0.6, 0.05, 0.05)), Material.diffuse((0.1, 0.5, 0.1))
    walls = [("+z", (0, 0, -1), white), ("-z", (0, 0, 1), white), ("-y", (0, 1, 0), white)]
    walls += [("+x", (-1, 0, 0), red), ("-x", (1, 0, 0), green)]
    things = [placed(quad(2, center, normal), material) for normal, center, material in walls]
    things.append(placed(quad(0.6, (0, 0, 0.98), "-z"), Material.emission((1, 0.9, 0.7), 12.0)))
    things.append(placed(box(0.6, (0.3, 0.2, -0.7)), Material.principled(roughness=0.3)))
    things.append(placed(sphere(0.35, (-0.4, -0.1, -0.65), 16), Material.glass()))
    return scene(camera((0, -3.6, 0), (0, 0, 0), fov=0.4), *things)
