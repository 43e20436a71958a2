# SPDX-License-Identifier: GPL-3.0-or-later
"""A world to light from infinity: constant, or a program over directions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..arena import Arena
from ..lights.environment import ConstantEnvironment, EnvironmentMap
from ..nodes.base import SCATTERED_RAY, Context
from ..nodes.sky import suns_of
from ..scene import Link, Node
from .materials import compile_program


def compile_world(world, diagnostics, view=None):
    """`ConstantEnvironment` or `EnvironmentMap` of a `core.scene.World`; `view` is the camera, where nodes ask for it.

    Notes
    -----
    Only what its closures emit counts, as in Blender; closures that scatter give nothing.
    """
    if world.surface is None:
        return _constant(world.radiance, world, diagnostics)
    if view is not None and view.is_parallel and _reads_window(world):
        diagnostics.warn("window coordinates of a world are those of its middle", f"world '{world.name}'")
    program, _ = compile_program(over_directions(world), diagnostics, "world")
    code = program.emission
    if code is None:
        return ConstantEnvironment((0.0, 0.0, 0.0))
    constants = code.row.reshape(-1, 1)
    if code.is_constant:
        return _constant(code.run(Context(Arena(4096), 1), constants)["Le"], world, diagnostics)

    def radiance(d, arena, averaged=False, ray=SCATTERED_RAY):
        """Radiance (3, N) that arrives against unit directions `d` (3, N)."""
        context = Context(arena, d.shape[-1], direction=d, averaged=averaged, ray=ray, view=view)
        return np.broadcast_to(code.run(context, constants)["Le"], d.shape)

    return EnvironmentMap(radiance, suns=suns_of(world.nodes), by_ray="light_path" in program.operations)


def over_directions(world):
    """`world` with textures of all directions that have the directions as coordinates where nothing is linked."""
    source = Link(len(world.nodes), "generated")
    nodes = [_linked(node, source) for node in world.nodes]
    return replace(world, nodes=(*nodes, Node("tex_coord")))


def _reads_window(world):
    links = (v for node in world.nodes for v in node.inputs.values() if isinstance(v, Link))
    return any(link.output == "window" and world.nodes[link.node].op == "tex_coord" for link in links)


def _linked(node, source):
    if node.op == "environment" and "vector" not in node.inputs:
        return replace(node, inputs={**node.inputs, "vector": source})
    return node


def _constant(radiance, world, diagnostics):
    radiance = np.broadcast_to(np.asarray(radiance, np.float64).reshape(-1), 3)
    if not (np.abs(radiance) < 1e36).all():  # squares of sums must be finite too
        diagnostics.warn("the world's radiance is not finite; black is used", f"world '{world.name}'")
        radiance = np.zeros(3)
    return ConstantEnvironment(radiance)
