# SPDX-License-Identifier: GPL-3.0-or-later
"""What is measured: the sample scenes, and scenes that are made when they are needed.

The latter are put together from `sample_blends/parts.py`, which stands in the repository and not in the extension.
"""

from __future__ import annotations

import importlib.util
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...core.diagnostics import SceneError
from .. import headless

SAMPLES = Path(__file__).resolve().parents[2] / "sample_blends"


class Plan(NamedTuple):
    """How thoroughly is measured.

    Parameters
    ----------
    scenes : sequence of str
        By name, of `sample_blends` or of `MADE`.
    percentage : int
        Share of the scenes' own side lengths.
    ladder : sequence of int
        Sample counts whose errors are measured.
    reference : int
        Samples of each engine's reference, at least 16 times the ladder's last.
    reference_runs : int
        Independent renders that the reference is made of.
    runs : int
        Timed repetitions, at least two, of which the median is taken.
    large : int
        `percentage` of the studies for which a render's fixed costs should count for little.
    samples, triangles, lights : sequence of int
        Of the studies of how time grows. 10,000 lights take Cycles minutes a picture, as its time is linear in them.
    """

    scenes: tuple
    percentage: int
    ladder: tuple
    reference: int
    reference_runs: int
    runs: int
    large: int
    samples: tuple
    triangles: tuple
    lights: tuple


_QUICK = ("cornell", "whitted", "room_closed", "interior", "many")

PLANS = {
    "quick": Plan(_QUICK, 50, (2, 4, 8), 128, 4, 3, 100, (2, 4, 8, 16, 32), (10**3, 10**4, 10**5), (1, 10, 100, 1000)),
    "full": Plan(
        (*_QUICK, "lamps", "sky", "terrain"),
        50,
        (2, 8, 32),
        512,
        4,
        3,
        100,
        (2, 4, 8, 16, 32, 64, 128),
        (10**3, 10**4, 10**5, 10**6, 10**7),
        (1, 10, 100, 1000, 10**4),
    ),
}


def find(name, folder):
    """Path of a scene's file; one of `MADE` is written into `folder` first.

    Raises
    ------
    SceneError
        Outside of the repository.
    """
    if name in MADE:
        folder.mkdir(exist_ok=True)
        path = folder / f"{name}.blend"
        with headless.quiet():
            MADE[name]()
            sample_parts().save(path)
        return path
    path = SAMPLES / f"{name}.blend"
    if not path.is_file():
        raise SceneError(f"no sample scene {path}; zraka bench runs in Zraka's repository, the extension has no scenes")
    return path


@cache
def sample_parts():
    """Module `sample_blends/parts.py`."""
    path = SAMPLES / "parts.py"
    if not path.is_file():
        raise SceneError(f"no {path}; zraka bench runs in Zraka's repository, the extension has no scenes")
    spec = importlib.util.spec_from_file_location("zraka_sample_parts", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


# -- made scenes -------------------------------------------------------------------------------------------------------


def terrain(triangles=2 * 10**6):
    """Hills of about so many triangles under a sun and a grey sky."""
    parts = sample_parts()
    scene = parts.new_file(640, 360, samples=64, depth=4)
    parts.link("Hills", _hills(parts, triangles))
    parts.light("Sun", "SUN", 3.0, (0, 0, 10), (-6, 3, 5.5), angle=0.03)
    parts.world((0.5, 0.6, 0.8), 0.7)
    parts.camera((0, -14, 7), (0, 0, 0), fov=45)
    return scene


def _hills(parts, triangles):
    """A mesh of squares over [-10, 10]²; Blender is given arrays, since lists of millions take minutes."""
    side = max(1, round((triangles / 2) ** 0.5))
    at = np.linspace(-10, 10, side + 1, dtype=np.float32)
    x, y = (a.ravel() for a in np.meshgrid(at, at))
    z = 0.8 * np.sin(0.9 * x) * np.cos(0.7 * y)
    z += 0.15 * np.sin(7.1 * x + 3.3 * y) + 0.03 * np.sin(41 * x) * np.cos(37 * y)
    first = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).ravel()
    corners = (first[:, None] + np.array((0, 1, side + 2, side + 1))).astype(np.int32)
    data = parts.mesh("Hills", [], [], [parts.diffuse("Earth", (0.45, 0.38, 0.28))])
    data.vertices.add(x.size)
    data.vertices.foreach_set("co", np.stack((x, y, z), axis=1).ravel())
    data.loops.add(corners.size)
    data.loops.foreach_set("vertex_index", corners.ravel())
    data.polygons.add(len(corners))
    data.polygons.foreach_set("loop_start", np.arange(0, corners.size, 4, dtype=np.int32))
    data.update(calc_edges=True)
    return data


def lamps(count=1000):
    """So many small round lamps over a floor with boxes, all of them together as bright as one of 1000 W."""
    parts = sample_parts()
    scene = parts.new_file(640, 360, samples=64, depth=4)
    floor = parts.diffuse("Floor", (0.7, 0.7, 0.68))
    parts.quad("Floor", ((-12, -12, 0), (12, -12, 0), (12, 12, 0), (-12, 12, 0)), floor)
    rng = np.random.default_rng(5)
    stone = parts.principled("Stone", (0.6, 0.45, 0.3), roughness=0.4)
    for number, (x, y) in enumerate(rng.uniform(-7, 7, (40, 2))):
        height = float(rng.uniform(0.3, 1.6))
        parts.box(f"Box {number}", (0.7, 0.7, height), (x, y, height / 2), stone, rotation_z=90 * rng.random())
    spots = rng.uniform((-8, -8, 1.8), (8, 8, 4.0), (count, 3)) if count > 1 else [(1.0, -2.0, 4.0)]
    colors = 0.4 + 0.6 * rng.random((count, 3))
    for number, (spot, color) in enumerate(zip(spots, colors, strict=True)):
        parts.light(f"Lamp {number}", "POINT", 1000 / count, spot, color=color, shadow_soft_size=0.05)
    parts.world((0.0, 0.0, 0.0))
    parts.camera((0, -13, 7), (0, -0.5, 0.4), fov=48)
    return scene


def sky():
    """Balls and a tiled floor under an environment image with a small bright sun."""
    parts = sample_parts()
    scene = parts.new_file(640, 360, samples=64, depth=6)
    y, x = np.mgrid[:64, :64]
    stripes = np.where(((x // 16 + y // 16) % 2)[..., None], (0.75, 0.7, 0.6), (0.25, 0.3, 0.35))
    tiles = parts.principled("Tiles", parts.image("tiles", stripes), roughness=0.3)
    parts.quad("Floor", ((-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)), tiles, (6, 6))
    looks = {  # colour, roughness, metallic
        "Gold": ((0.9, 0.65, 0.25), 0.25, 1.0),
        "Clay": ((0.6, 0.25, 0.15), 0.8, 0.0),
        "Lacquer": ((0.1, 0.2, 0.5), 0.1, 0.0),
    }
    for number, (name, look) in enumerate(looks.items()):
        parts.ball(name, 1.0, (2.4 * (number - 1), 0.3, 1.0), parts.principled(name, *look))
    _environment(parts)
    parts.camera((0.5, -8, 3.2), (0, 0, 0.8), fov=46)
    return scene


def _environment(parts):
    """A world of an equirectangular image: a blue gradient, dark ground, a sun 6° wide."""
    import bpy

    height, width = 256, 512
    up, around = np.meshgrid(
        np.linspace(-np.pi / 2, np.pi / 2, height), np.linspace(-np.pi, np.pi, width), indexing="ij"
    )
    level = np.clip(np.sin(up), 0, 1)[..., None]
    color = np.where(level > 0, (1 - level) * (0.9, 0.95, 1.0) + level * (0.15, 0.35, 0.9), (0.12, 0.1, 0.08))
    to_sun = np.sin(up) * np.sin(0.7) + np.cos(up) * np.cos(0.7) * np.cos(around + 1.0)
    color[to_sun > np.cos(np.radians(3))] = (400.0, 360.0, 300.0)
    image = bpy.data.images.new("sky", width, height, float_buffer=True)
    image.pixels.foreach_set(np.dstack((color, np.ones((height, width)))).astype(np.float32).ravel())
    image.update()
    image.pack()
    parts.world((1.0, 1.0, 1.0))
    tree = bpy.context.scene.world.node_tree
    background = next(n for n in tree.nodes if n.type == "BACKGROUND")
    texture = parts.node(tree, "ShaderNodeTexEnvironment", properties={"image": image})
    tree.links.new(texture, background.inputs["Color"])


MADE = {"lamps": lamps, "sky": sky, "terrain": terrain}
