# SPDX-License-Identifier: GPL-3.0-or-later
"""Random scenes and settings of the core."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from zraka.core.camera_description import PANORAMAS, Panorama, ThinLens
from zraka.core.methods.guides import CHANNELS
from zraka.core.scene import (
    AreaLight,
    Attribute,
    Camera,
    Instance,
    Material,
    Mesh,
    ObjectInfo,
    Plane,
    PointLight,
    Scene,
    Spheres,
    SpotLight,
    SunLight,
    TextureSpace,
    World,
)
from zraka.core.settings import Guides, Settings

from ..core import scenes as made
from .extras import with_extras, with_lamp_nodes
from .graphs import TAME, TAME_SURFACES, VALUES, Graph
from .numbers import BAD, Numbers


@dataclass(frozen=True)
class Case:
    """A scene, or one for each moment, with its settings; `tame` ones must render without a bad sample."""

    scene: Scene | tuple
    settings: Settings
    tame: bool


def random_case(seed):
    """The `Case` of a seed."""
    tame = seed % 3 == 0
    numbers = Numbers(seed, tame)
    materials = [random_material(numbers, n) for n in range(1 + numbers.count(4))]
    materials += [None, Material("nothing")]
    meshes = [random_mesh(numbers) for _ in range(1 + numbers.count(3))]
    instances = [
        Instance(numbers.choice(meshes), numbers.matrix(), _slots(numbers, materials), f"object {n}", _info(numbers))
        for n in range(numbers.count(5) + numbers.chance(0.9))
    ]
    scene = Scene(
        random_camera(numbers),
        tuple(instances),
        tuple(_spheres(numbers, materials) for _ in range(numbers.count(2))),
        tuple(_plane(numbers, materials) for _ in range(numbers.count(2))),
        tuple(random_light(numbers, n) for n in range(numbers.count(6))),
        random_world(numbers),
    )
    scene = with_lamp_nodes(seed, scene, tame)
    scene, settings = with_extras(seed, scene, random_settings(numbers), materials, tame)
    return Case(scene, settings, tame)


# -- materials ---------------------------------------------------------------------------------------------------------


def random_material(numbers, number):
    """A material of a random graph."""
    graph = Graph(numbers, TAME if numbers.tame else VALUES, loops=not numbers.tame)
    surface = graph.closure(TAME_SURFACES) if numbers.chance(0.95) else None
    return Material(f"material {number}", tuple(graph.nodes), surface, graph.displacement(), numbers.count(9))


def random_world(numbers):
    """A grey world, more seldom one of a graph, whose table takes its time."""
    if numbers.chance(0.94):
        return World(numbers.color() if numbers.chance(0.7) else (0.0, 0.0, 0.0))
    graph = Graph(numbers, TAME if numbers.tame else VALUES)
    surface = graph.closure(("background", "emission"))
    return World(nodes=tuple(graph.nodes), surface=surface, name="random")


# -- geometry ----------------------------------------------------------------------------------------------------------


def random_mesh(numbers):
    """A mesh: whole, a soup, empty, degenerate."""
    kind = numbers.choice(("quad", "box", "sphere", "soup", "soup", "sliver", "coincident", "empty", "bare"))
    if kind == "quad":
        mesh = made.quad(numbers.size() or 1.0, normal=numbers.choice(("+z", "-z", "+y", "-x")))
    elif kind == "box":
        mesh = made.box(2.0, inward=numbers.chance(0.3))
    elif kind == "sphere":
        mesh = made.sphere(1.0, rings=4)
    elif kind in ("empty", "bare"):
        vertices = numbers.array((numbers.count(5) * (kind == "bare"), 3))
        return Mesh(vertices, np.zeros((0, 3), np.int32))
    else:
        mesh = _soup(numbers, kind)
    return _dressed(numbers, mesh)


def _soup(numbers, kind):
    count = 3 + numbers.count(20)
    vertices = numbers.array((count, 3))
    triangles = numbers.rng.integers(0, count, (1 + numbers.count(30), 3)).astype(np.int32)
    if kind == "sliver":
        vertices[:, int(numbers.rng.integers(3))] *= numbers.choice((0.0, 1e-6, 1e-20))
    if kind == "coincident":
        triangles = np.concatenate((triangles, triangles, triangles[:, ::-1]))
    if numbers.chance(0.2):
        with np.errstate(over="ignore"):
            vertices = vertices * np.float32(numbers.size())
    if not numbers.tame and numbers.chance(0.15):
        with np.errstate(over="ignore"):
            vertices[int(numbers.rng.integers(count)), int(numbers.rng.integers(3))] = numbers.choice(BAD)
    return Mesh(vertices, triangles)


def _dressed(numbers, mesh):
    """`mesh` with normals, coordinates, slots and attributes, some of them."""
    corners, more = 3 * len(mesh.triangles), {}
    if numbers.chance(0.4):
        domain = numbers.choice(("vertex", "corner"))
        more |= {"normals": numbers.array((len(mesh.vertices) if domain == "vertex" else corners, 3))}
        more |= {"normals_domain": domain}
    elif mesh.normals is not None:
        more["normals"] = mesh.normals
    if numbers.chance(0.5):
        more |= {"uvs": {"uv": numbers.array((corners, 2))}, "active_uv": numbers.choice(("", "uv"))}
    if numbers.chance(0.5):
        more["material_index"] = numbers.rng.integers(-1, 5, len(mesh.triangles)).astype(np.int32)
    if numbers.chance(0.3):
        domain = numbers.choice(("vertex", "corner", "triangle", "mesh"))
        count = {"vertex": len(mesh.vertices), "corner": corners, "triangle": corners // 3, "mesh": 1}[domain]
        more["attributes"] = {"heat": Attribute(numbers.array((count, numbers.choice((1, 2, 3, 4)))), domain)}
        more["active_color"] = numbers.choice(("", "heat", "nowhere"))
    if numbers.chance(0.2):
        more["texture_space"] = TextureSpace(numbers.vector(), numbers.vector())
    return Mesh(mesh.vertices, mesh.triangles, **more)


def _slots(numbers, materials):
    return tuple(numbers.choice(materials) for _ in range(numbers.count(3) + numbers.chance(0.9)))


def _info(numbers):
    attributes = {("OBJECT", "heat"): numbers.vector(4), ("VIEW_LAYER", "heat"): numbers.vector(4)}
    return ObjectInfo(numbers.vector(4), numbers.count(9), numbers.unit(), attributes=attributes)


def _spheres(numbers, materials):
    count = numbers.count(4)
    radii = np.array([numbers.size() if numbers.chance(0.5) else 0.3 for _ in range(count)])
    if count and not numbers.tame and numbers.chance(0.2):
        radii[0] = numbers.number()
    return Spheres(numbers.array((count, 3), np.float64), radii, numbers.choice(materials))


def _plane(numbers, materials):
    if numbers.chance(0.7):
        return Plane((0.0, 0.0, -1.0), (0.0, 0.0, 1.0), numbers.choice(materials))
    return Plane(numbers.vector(), numbers.vector(), numbers.choice(materials))


# -- lights and cameras ------------------------------------------------------------------------------------------------


def random_light(numbers, number):
    """A lamp of any kind, at times coincident with another thing or of no power."""
    color = tuple(numbers.size() * c for c in numbers.color())
    common = {"normalize": numbers.chance(0.8), "casts_shadow": numbers.chance(0.9), "name": f"light {number}"}
    kind = numbers.choice(("point", "spot", "sun", "area"))
    if kind == "sun":
        angle = numbers.choice((0.0, 1e-7, 0.01, 1.0, math.pi))
        return SunLight(numbers.vector(), color, angle, **common)
    if kind == "area":
        size = (numbers.size(), numbers.size())
        shape, spread = numbers.choice(("RECTANGLE", "ELLIPSE")), numbers.choice((math.pi, 1.0, 1e-3, 0.0))
        return AreaLight(numbers.matrix(), color, size, shape, spread, **common)
    place = tuple((numbers.rng.normal(size=3) * 2).tolist()) if numbers.chance(0.7) else numbers.vector()
    common |= {"radius": numbers.size() if numbers.chance(0.6) else 0.0, "soft_falloff": numbers.chance(0.5)}
    if kind == "point":
        return PointLight(place, color, **common)
    angle, blend = numbers.choice((0.0, 0.01, 1.0, math.pi)), numbers.unit()
    return SpotLight(place, numbers.vector(), color, angle, blend, **common)


def random_camera(numbers):
    """A camera that looks at the origin, or anywhere."""
    projection = numbers.choice(("PERSPECTIVE", "PERSPECTIVE", "PERSPECTIVE", "ORTHOGRAPHIC", "PANORAMIC"))
    eye = numbers.rng.normal(size=3) * (numbers.size() if numbers.chance(0.3) else 3.0)
    transform = made.camera(eye + 1e-9, (0, 0, 0)).transform if numbers.chance(0.8) else numbers.matrix()
    half = numbers.choice((1e-5, 0.3, 0.5, 1.0, 500.0)) * (3.0 if projection == "ORTHOGRAPHIC" else 1.0)
    window = (0.0, 1.0, 0.0, 1.0) if projection == "PANORAMIC" else (-half, half, -half, half)
    lens = None
    if numbers.chance(0.2):
        blades, ratio = numbers.choice((0, 2, 3, 6)), numbers.choice((1.0, 0.01, 100.0))
        lens = ThinLens(numbers.size(), numbers.size(), blades, numbers.unit(), ratio)
    panorama = Panorama(
        numbers.choice(PANORAMAS),
        fov=numbers.choice((0.0, 1.0, math.pi, 2 * math.pi)),
        lens=numbers.choice((1e-3, 10.5, 1e4)),
        polynomial=tuple(numbers.number() for _ in range(5)),
    )
    start = numbers.choice((0.0, 1e-6, 0.1, 100.0))
    end = numbers.choice((math.inf, 100.0, 1e30, 1e-6))
    return Camera(transform, window, projection, start, end, lens, panorama)


# -- settings ----------------------------------------------------------------------------------------------------------


def random_settings(numbers):
    """Settings of a small picture."""
    width, height = numbers.choice(((8, 6), (8, 6), (1, 1), (64, 1), (1, 40), (13, 7)))
    overrides = {
        name: numbers.choice(values)
        for name, values in (
            ("reflectivity", (0.0, 0.5, 1.0)),
            ("transparency", (0.0, 0.5, 1.0)),
            ("ior", (1.0, 1.5, 1e-3)),
            ("exponent", (0.0, 32.0, 1e6)),
            ("ambient", (0.0, 0.2)),
        )
        if numbers.chance(0.1)
    }
    guides = Guides()
    if numbers.chance(0.2):
        names = frozenset(name for name in [*sorted(CHANNELS), "crypto_object"] if numbers.chance(0.5))
        guides = Guides(names, samples=2, mist_depth=numbers.size(), levels=numbers.choice((2, 6)))
    settings = Settings(
        width=width,
        height=height,
        border=(0, 0, 1, 1) if numbers.chance(0.05) else None,
        samples=numbers.choice((1, 2, 5)),
        depth=numbers.choice((1, 2, 5, 30)),
        transparent_depth=numbers.choice((0, 1, 8, 100)),
        seed=numbers.choice((0, 1, 2**31 - 1)),
        threads=1,
        adaptive=numbers.chance(0.1),
        clamp_direct=numbers.choice((0.0, 0.0, 1.0, 1e-6)),
        clamp_indirect=numbers.choice((0.0, 0.0, 1.0, 1e-6)),
        pixel_filter=numbers.choice(("box", "gaussian", "blackman_harris")),
        filter_width=numbers.choice((0.01, 1.5, 10.0)),
        transparent_film=numbers.chance(0.2),
        transparent_glass=numbers.chance(0.3),
        guides=guides,
        **overrides,
    )
    if not numbers.chance(0.2):
        return settings
    kinds = ("diffuse", "glossy", "transmission")
    return replace(settings, **{f"{kind}_bounces": numbers.choice((0, 1, 4)) for kind in kinds})
