# SPDX-License-Identifier: GPL-3.0-or-later
"""What is added to some of the random scenes: hair, who sees what, and things that move while the shutter is open."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from zraka.core.scene import Attribute, Curves, LampNodes, Material
from zraka.core.visibility import ALL_RAYS, UNLIMITED, ObjectSet, Rays, Visibility

from .graphs import TAME, VALUES, Graph
from .numbers import BAD, Numbers

_EMITTING = ("emission", "emission", "emission", "background", "principled", "diffuse")
NAMES = ("", "object 0", "object 1", "spheres", "curves", "plane", "light 0", "nobody")


def with_lamp_nodes(seed, scene, tame):
    """`scene` with graphs on some of its lamps, in some scenes."""
    numbers = Numbers((seed, 2), tame)  # of its own, too
    if not numbers.chance(0.4):
        return scene

    def nodes(number):
        if numbers.chance(0.3):
            return None
        graph = Graph(numbers, TAME if tame else VALUES, loops=not tame)
        surface = graph.closure(_EMITTING)
        return LampNodes(Material(f"lamp {number}", tuple(graph.nodes), surface), numbers.matrix())

    return replace(scene, lights=tuple(replace(light, nodes=nodes(n)) for n, light in enumerate(scene.lights)))


def with_extras(seed, scene, settings, materials, tame):
    """(scene or a tuple of the scenes of each moment, settings) of what a seed adds to its scene."""
    numbers = Numbers((seed, 1), tame)  # of its own: what else the seed makes stays as it is
    if numbers.chance(0.35):
        scene = replace(scene, curves=tuple(random_curves(numbers, materials) for _ in range(1 + numbers.count(2))))
    if numbers.chance(0.35):
        scene = _partly_seen(numbers, scene)
    if numbers.chance(0.1):
        target, samples = numbers.choice((1e-9, 0.01, 0.5, 1e9)), numbers.choice((1, 2, 8, 33))
        settings = replace(settings, noise_target=target, samples=samples)
    if numbers.chance(0.15):
        return _moments(numbers, scene), settings
    return scene, settings


# -- hair --------------------------------------------------------------------------------------------------------------


def random_curves(numbers, materials):
    """Strands: smooth ones, soups, of one point or none, without radius."""
    counts = np.array([numbers.count(7) for _ in range(numbers.count(6))], int)
    total = int(counts.sum())
    points = numbers.array((total, 3), np.float64)
    if numbers.chance(0.3) and total:
        points[1:] = points[0] + np.arange(1, total)[:, None] * numbers.choice((0.0, 1e-9, 0.1))
    radii = np.abs(numbers.array((total,), np.float64)) * numbers.choice((1e-6, 0.02, 0.02, 0.3))
    if total and numbers.chance(0.3):
        radii[int(numbers.rng.integers(total))] = numbers.size()
    if total and not numbers.tame and numbers.chance(0.2):
        radii[int(numbers.rng.integers(total))] = numbers.choice((*BAD, -1.0))
    more = {}
    if numbers.chance(0.4):
        more |= {"uvs": {"uv": numbers.array((counts.size, 2))}, "active_uv": numbers.choice(("", "uv"))}
    if numbers.chance(0.3):
        domain = numbers.choice(("vertex", "strand", "mesh"))
        rows = {"vertex": total, "strand": counts.size, "mesh": 1}[domain]
        more["attributes"] = {"heat": Attribute(numbers.array((rows, numbers.choice((1, 3)))), domain)}
    return Curves(points, radii, counts, numbers.matrix(), numbers.choice(materials), **more)


# -- who sees what -----------------------------------------------------------------------------------------------------


def random_visibility(numbers, rays=ALL_RAYS):
    """Most things are seen by most rays."""
    for kind in Rays:
        if numbers.chance(0.2):
            rays ^= kind
    return Visibility(
        rays,
        holdout=numbers.chance(0.1),
        receivers=_names(numbers),
        blockers=_names(numbers),
        receives_as=numbers.choice(NAMES) if numbers.chance(0.2) else "",
        blocks_as=numbers.choice(NAMES) if numbers.chance(0.2) else "",
        max_bounces=numbers.choice((UNLIMITED, UNLIMITED, 0, 1, 4)),
        catcher=numbers.chance(0.1),
    )


def _names(numbers):
    if numbers.chance(0.7):
        return None
    return ObjectSet(frozenset(numbers.choice(NAMES) for _ in range(numbers.count(3))), numbers.chance(0.5))


def _partly_seen(numbers, scene):
    def some(things):
        return tuple(
            replace(t, visibility=random_visibility(numbers, t.visibility.rays)) if numbers.chance(0.5) else t
            for t in things
        )

    kinds = {name: some(getattr(scene, name)) for name in ("instances", "spheres", "curves", "planes", "lights")}
    world = replace(scene.world, visibility=random_visibility(numbers)) if numbers.chance(0.5) else scene.world
    return replace(scene, world=world, **kinds)


# -- motion ------------------------------------------------------------------------------------------------------------


def _moments(numbers, scene):
    """The scene at two or four moments, in each of which something else moves, vanishes or stays."""
    scenes = [scene]
    for _ in range(numbers.choice((1, 3))):
        scenes.append(_moved(numbers, scenes[-1]))
    return tuple(scenes)


def _moved(numbers, scene):
    kind = numbers.choice(("camera", "instance", "instance", "curves", "gone", "light", "nothing"))
    if kind == "camera":
        matrix = np.array(scene.camera.transform, float)
        matrix[:3, 3] += numbers.rng.normal(size=3) * 0.1
        return replace(scene, camera=replace(scene.camera, transform=matrix))
    if kind == "instance" and scene.instances:
        first, *others = scene.instances
        return replace(scene, instances=(replace(first, transform=numbers.matrix()), *others))
    if kind == "curves" and scene.curves:
        first, *others = scene.curves
        return replace(scene, curves=(replace(first, transform=numbers.matrix()), *others))
    if kind == "gone":
        return replace(scene, instances=scene.instances[1:], curves=scene.curves[1:])
    if kind == "light":
        return replace(scene, lights=scene.lights[1:])
    return scene
