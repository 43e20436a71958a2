# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader nodes of lamps: what folds to a constant is a factor of the power, the rest a program over lamps and rays."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace

import numpy as np

from ..arena import Arena
from ..geometry import Geometry
from ..lights.forms import AreaForm, Meeting, RoundForm, SunForm
from ..lights.shaded import ShadedLights
from ..nodes.base import SCATTERED_RAY, Context
from ..scene import AreaLight, Link, Node, SpotLight, SunLight
from ..vecmath import frame
from .code import Table
from .materials import compile_program
from .needs import takes_generated
from .objects import compile_objects

_CORNERS = (1.0, 0.0, 0.0, 1.0, 0.0, 0.0)  # UV at the corners of a triangle that stands for a lamp
_COLUMNS = 21  # of a table of corners that holds any attribute, or the seven of a tangent
_FARTHEST = np.finfo(np.float32).max


class LampShader:
    """The program of some lamps, all built alike.

    Parameters
    ----------
    code : Code
        Whose result "Le" is the multiplier.
    table : Table
        Its constants, a row for each lamp.
    form : RoundForm, AreaForm or SunForm
    geometry : Geometry
        What nodes see of the lamps, `_as_geometry`.
    """

    def __init__(self, code, table, form, geometry):
        self._code, self._table, self.form, self._geometry = code, table, form, geometry
        self.by_ray = "light_path" in code.operations

    def __call__(self, rows, p, wi, distance, arena, ray=None):
        """What the light of lamps `rows` towards points `p` (3, N) is multiplied with, (3, N) or what broadcasts to it.

        `wi` (3, N), unit, and `distance` (N,) lead from the points to the lamps.
        """
        n = p.shape[-1]
        number = arena.full(n, rows, np.int32) if isinstance(rows, int) else rows
        position, normal, (a, b) = self.form.meet(rows, p, wi, distance, arena)
        wo = np.negative(wi, out=arena.empty(wi.shape))
        u, v = np.broadcast_to(b, n), np.broadcast_to(np.float32(1) - a - b, n)
        met = Meeting(position, normal, normal, np.ones(n, bool), number, wo, u, v)
        length = np.minimum(distance, _FARTHEST, out=arena.empty(n))
        ray = (SCATTERED_RAY if ray is None else ray)._replace(length=length)
        context = Context(arena, n, met, self._geometry, ray=ray)
        return self._code.run(context, self._table.over(number, arena))["Le"]


def compile_lamp(light, diagnostics):
    """Constant factor (3,) of the light of a `core.scene.Light`, and the `Code` of its nodes, None of a constant."""
    if light.nodes is None:
        return np.ones(3), None
    shader = _with_coordinates(light.nodes.shader, light.nodes.in_world)
    program, _ = compile_program(shader, diagnostics, "light")
    code = program.emission
    if code is None:
        return np.zeros(3), None
    if not code.is_constant:
        if _reads(shader, "tangent"):  # Cycles' is not a number, and its light black
            said = "the tangent that a Geometry node tells of a light is taken around its Z axis"
            diagnostics.warn(said, f"light '{shader.name}'")
        return np.ones(3), code
    value = code.run(Context(Arena(4096), 1), code.row.reshape(-1, 1))["Le"]
    return np.array(np.broadcast_to(value.reshape(-1), 3), np.float64), None


def shaded_lights(source, lamps, geometry):
    """`ShadedLights` of the table `source`, whose rows are the `lamps`, pairs (light, code) of codes of one key."""
    lights, (code, *others) = zip(*lamps, strict=True)
    for other in others:
        code.adopt(other)
    table = Table([c.row for _, c in lamps])
    seen = _as_geometry([light.nodes for light in lights], geometry)
    form = _form(source, lights, seen.objects.to_object, geometry.origin)
    receivers = _receivers(lights, geometry)
    return ShadedLights(source, LampShader(code, table, form, seen), receivers)


def _with_coordinates(shader, in_world):
    """`shader` with the lamp's own space for generated coordinates, or the world's for these and others."""
    added = Node("geometry" if in_world else "tex_coord")
    source = Link(len(shader.nodes), "position" if in_world else "object")
    others = {"generated": source}
    if in_world:
        others |= {"object": source, "reflection": Link(len(shader.nodes), "incoming")}

    def moved(value):
        node = shader.nodes[value.node] if isinstance(value, Link) else None
        if node is None or node.op != "tex_coord" or (value.output == "object" and "matrix" in node.properties):
            return value
        return others.get(value.output, value)

    nodes = []
    for node in shader.nodes:
        inputs = {name: moved(value) for name, value in node.inputs.items()}
        if takes_generated(node):
            inputs["vector"] = source
        nodes.append(replace(node, inputs=inputs))
    return replace(shader, nodes=(*nodes, added))


def _reads(shader, output):
    links = (v for node in shader.nodes for v in node.inputs.values() if isinstance(v, Link))
    return any(link.output == output and shader.nodes[link.node].op == "geometry" for link in links)


def _as_geometry(nodes, geometry):
    """What the operations of nodes know of lamps: a `Geometry` without primitives, each lamp an object."""
    objects = compile_objects(_Lamps(nodes), geometry.origin, [n.shader for n in nodes])
    count = len(nodes)
    uvs = np.tile(np.array(_CORNERS, np.float32), (count, 1))
    nothing = np.zeros((0, _COLUMNS), np.float32)
    return replace(
        Geometry.from_arrays(),
        origin=geometry.origin,
        object=np.arange(count, dtype=np.int32),
        material=np.arange(count, dtype=np.int32),
        uvs=defaultdict(lambda: uvs),
        corner_values=defaultdict(lambda: nothing, generated=nothing[:, :9]),
        objects=replace(objects, mirrored=np.zeros((1, count), bool)),
        view=geometry.view,
    )


class _Lamps:
    """Lamps as `compile_objects` reads a scene's objects."""

    def __init__(self, nodes):
        self.objects = nodes


def _form(source, lights, to_object, origin):
    """How the nodes see the lamps of `source`."""
    kind = type(lights[0])
    if kind is SunLight:
        return SunForm(source.axis, [light.angle for light in lights], to_object, origin)
    if kind is AreaLight:
        return AreaForm(source.frame, np.array([light.size for light in lights], np.float64).T, to_object)
    if kind is SpotLight:
        return RoundForm(source.source, to_object, [light.angle for light in lights])
    return RoundForm(source, to_object)


def _receivers(lights, geometry):
    """Points in the directions in which lamps shine, evenly, as far away as the scene is wide at most."""
    extent = 1.0
    if geometry.triangle_count:
        low, high = geometry.bounds
        extent = float(np.linalg.norm(np.subtract(high, low, dtype=np.float64)))
    extent = min(max(extent, 1e-3), 1e6) if np.isfinite(extent) else 1e6
    centers, axes, angles = zip(*map(_beam, lights), strict=True)
    centers = np.array(centers, np.float64).T - np.asarray(geometry.origin, np.float64).reshape(3, 1)
    axes = np.array(axes, np.float64).T
    axes = (axes / np.maximum(np.linalg.norm(axes, axis=0), 1e-30)).astype(np.float32)
    caps = 2.0 * np.sin(np.array(angles, np.float64) / 4.0) ** 2

    def draw(rng, count):
        u0, u1, u2 = rng.random((3, len(lights), count))
        lowered, phi = caps[:, None] * u0, 2.0 * np.pi * u1
        sine = np.sqrt(lowered * (2.0 - lowered))
        s, t = (a[:, :, None] for a in frame(axes, Arena(4096)))
        d = s * (sine * np.cos(phi)) + t * (sine * np.sin(phi)) + axes[:, :, None] * (1.0 - lowered)
        return centers[:, :, None] + d * (extent * u2)

    return draw


def _beam(light):
    """Where a lamp shines from, along which axis, and the full angle of its beam."""
    if isinstance(light, AreaLight):
        return light.transform[:3, 3], -light.transform[:3, 2], min(light.spread, np.pi)
    if isinstance(light, SpotLight):
        return light.position, light.direction, light.angle
    return getattr(light, "position", (0.0, 0.0, 0.0)), (0.0, 0.0, 1.0), 2.0 * np.pi
