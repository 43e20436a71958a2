# SPDX-License-Identifier: GPL-3.0-or-later
"""Path tracing beside the second renderer: means over blocks of pixels, by statistics."""

import numpy as np
import pytest

from zraka.core.compile import compile_scene
from zraka.core.diagnostics import Diagnostics
from zraka.core.render import render
from zraka.core.scene import AreaLight, Material, Plane, PointLight, Spheres, SunLight
from zraka.core.settings import Settings

from ..core.scenes import box, camera, placed, quad, scene
from .scenes import camera_rays, world_of

SIZE, BLOCKS, RUNS = 16, 4, 8


def cornell():
    """A diffuse room with a glowing panel, a mirror box and a glass ball."""
    white, red, green = (Material.diffuse(c) for c in (0.7, (0.6, 0.1, 0.1), (0.1, 0.5, 0.1)))
    walls = [("+z", (0, 0, -1), white), ("-z", (0, 0, 1), white), ("-y", (0, 1, 0), white)]
    walls += [("+x", (-1, 0, 0), red), ("-x", (1, 0, 0), green)]
    things = [placed(quad(2, center, normal), material) for normal, center, material in walls]
    things.append(placed(quad(0.6, (0, 0, 0.98), "-z"), Material.emission((1, 0.9, 0.7), 12.0)))
    things.append(placed(box(0.6, (0.4, 0.3, -0.69)), Material.glossy((0.9, 0.9, 0.9), 0.0)))
    ball = Spheres(np.array([[-0.4, -0.2, -0.6]]), np.array([0.38]), Material.glass())
    return scene(camera((0, -3.6, 0), (0, 0, 0), fov=0.4), *things, spheres=(ball,))


def lamps():
    """A box, a mirror and a ball of glass on an endless floor under a grey sky, a lamp of each kind."""
    above = np.array([[1, 0, 0, 1.5], [0, 1, 0, -0.5], [0, 0, 1, 2.5], [0, 0, 0, 1.0]])
    lights = (
        PointLight((-1.5, -1.0, 2.0), (30, 25, 20)),
        PointLight((1.2, 0.4, 1.4), (20, 30, 20), radius=0.25, soft_falloff=False),
        SunLight((0.4, 0.6, -1.0), (0.5, 0.6, 0.7)),
        AreaLight(above, (40, 40, 50), (0.8, 1.2)),
    )
    things = [
        placed(box(0.8, (0.7, 0.6, 0.41)), Material.diffuse((0.7, 0.3, 0.2))),
        placed(quad(1.6, (-0.3, 1.6, 0.9), "-y"), Material.glossy((0.8, 0.9, 0.9), 0.0)),
    ]
    ball = Spheres(np.array([[-0.6, -0.3, 0.5]]), np.array([0.45]), Material.glass((0.9, 1.0, 1.0), 0.0, 1.4))
    floor = Plane((0, 0, 0), (0, 0, 1), Material.diffuse((0.5, 0.5, 0.45)))
    view = camera((0.2, -4.0, 1.8), (0, 0, 0.5), fov=0.35)
    return scene(view, *things, spheres=(ball,), planes=(floor,), lights=lights, world=0.2)


def blocks(picture):
    """Means (BLOCKS², 3) of a picture (SIZE, SIZE, 3)."""
    side = SIZE // BLOCKS
    return picture.reshape(BLOCKS, side, BLOCKS, side, 3).mean(axis=(1, 3)).reshape(-1, 3)


def ours(description, depth, samples):
    """Block means (RUNS, BLOCKS², 3) of the core, each run of another seed."""
    found = []
    for seed in range(RUNS):
        settings = Settings(width=SIZE, height=SIZE, samples=samples, depth=depth, threads=1, seed=seed)
        film = render(compile_scene(description, settings, Diagnostics()), settings)
        found.append(blocks(film.image()[..., :3].astype(float)))
    return np.array(found)


def theirs(description, depth, samples, seed=1):
    """The same of the second renderer."""
    world, rng, found = world_of(description), np.random.default_rng(seed), []
    for _ in range(RUNS):
        total = np.zeros((SIZE * SIZE, 3))
        for _ in range(samples):
            o, d = camera_rays(description.camera, SIZE, SIZE, rng.random((SIZE * SIZE, 2)))
            total += world.paths(o, d, depth, rng)
        found.append(blocks(total.reshape(SIZE, SIZE, 3) / samples))
    return np.array(found)


def z_scores(a, b):
    """Differences of the means of runs (R, K, 3) in standard errors."""
    error = np.sqrt(a.var(axis=0, ddof=1) / len(a) + b.var(axis=0, ddof=1) / len(b))
    return (a.mean(axis=0) - b.mean(axis=0)) / error


def agrees(a, b):
    """No block is far off, and they are not all off to one side: Student's t of some 8 + 8 runs."""
    z = z_scores(a, b)
    total = z_scores(a.mean(axis=1, keepdims=True), b.mean(axis=1, keepdims=True))
    return np.abs(z).max() < 6.5 and np.abs(total).max() < 4.5 and np.sqrt(np.mean(z**2)) < 1.6


@pytest.mark.parametrize(("make", "depth"), [(cornell, 4), (lamps, 4), (lamps, 1)])
def test_paths_have_the_same_mean(make, depth):
    a, b = ours(make(), depth, 64), theirs(make(), depth, 12)
    assert agrees(a, b), (z_scores(a, b).round(1), (a.mean(axis=(0, 1)) / b.mean(axis=(0, 1))).round(4))
    assert not agrees(a * 1.08, b), "a twelfth more light would not be seen"


@pytest.mark.slow
@pytest.mark.parametrize("make", [cornell, lamps])
def test_long_paths_have_the_same_mean(make):
    a, b = ours(make(), 8, 256), theirs(make(), 8, 64)
    assert agrees(a, b), (z_scores(a, b).round(1), (a.mean(axis=(0, 1)) / b.mean(axis=(0, 1))).round(4))
    assert not agrees(a * 1.05, b)
