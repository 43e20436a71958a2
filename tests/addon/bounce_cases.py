# SPDX-License-Identifier: GPL-3.0-or-later
"""Closed rooms whose walls glow, each in its own colour, and in them what limits of one kind of bounce are to end."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import bpy
import numpy as np

from zraka.addon.bench.engines import match, operate, watched
from zraka.addon.properties import ALL_BOUNCES, BOUNCES

from .nodes.harness import add, fresh_scene, output
from .visibility_cases import SIDE, give, means, tree_of

_WHITE = (1, 1, 1, 1)


@dataclass(frozen=True)
class Case:
    """``setup()`` fills the room; `limits` names those that are set, `samples` what keeps noise below them."""

    item: str
    setup: Callable
    limits: dict = field(default_factory=dict)
    note: str = ""
    samples: int = 64


def room():
    """The scene: a camera in a cube, and a lamp under its ceiling."""
    scene = fresh_scene()
    scene.render.resolution_x = scene.render.resolution_y = SIDE
    scene.zraka.method, scene.zraka.depth, scene.zraka.samples = "PATHTRACE", 8, 64
    camera = scene.camera
    camera.data.type, camera.data.lens = "PERSP", 20
    camera.location, camera.rotation_euler = (0, -1.9, 0), (np.pi / 2, 0, 0)
    bpy.ops.mesh.primitive_cube_add(size=4)
    glowing(bpy.context.object)
    lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "AREA"))
    lamp.data.energy, lamp.data.size, lamp.location = 4, 1.5, (0, 0, 1.9)
    scene.collection.objects.link(lamp)
    return scene


def glowing(walls):
    """Diffuse walls that shine by where they look; no light is sampled there, which is less noise."""
    material = bpy.data.materials.new("Walls")
    material.cycles.emission_sampling = "NONE"
    tree = tree_of(material)
    normal = output(add(tree, "NewGeometry"), "Normal")
    color = add(tree, "VectorMath", {0: normal, 1: (0.15,) * 3, 2: (0.2,) * 3}, operation="MULTIPLY_ADD")
    diffuse, emission = add(tree, "BsdfDiffuse", {"Color": (0.7, 0.7, 0.7, 1)}), add(tree, "Emission")
    tree.links.new(output(color), emission.inputs["Color"])
    both = add(tree, "AddShader", {0: diffuse.outputs[0], 1: emission.outputs[0]})
    tree.links.new(both.outputs[0], add(tree, "OutputMaterial").inputs["Surface"])
    walls.data.materials.append(material)


def ball(location, radius, kind, **inputs):
    """A smooth sphere of one shader."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16, radius=radius, location=location)
    bpy.ops.object.shade_smooth()
    give(bpy.context.object, kind, **inputs)


def pane(y, kind, **inputs):
    """A square that stands before the camera."""
    bpy.ops.mesh.primitive_plane_add(size=2, location=(0, y, 0), rotation=(np.pi / 2, 0, 0))
    give(bpy.context.object, kind, **inputs)


def matte():
    """A diffuse ball."""
    ball((0, 0.5, -0.5), 1, "BsdfDiffuse", Color=(0.9, 0.3, 0.3, 1))


def mirrors():
    """Two mirrors that face each other."""
    for x, turn in ((-1.2, 0.1), (1.2, -0.1)):
        bpy.ops.mesh.primitive_plane_add(size=3, location=(x, 0, 0), rotation=(0, np.pi / 2, turn))
        give(bpy.context.object, "BsdfAnisotropic", Color=(0.9, 0.9, 0.9, 1), Roughness=0.0)


def glass():
    """A glass ball, and no lamp that it would make caustics of."""
    bpy.data.objects["Lamp"].hide_render = True
    ball((0, 0.3, 0), 1.2, "BsdfGlass", Color=_WHITE, Roughness=0.0, IOR=1.5)


def frosted():
    """Glass that scatters."""
    bpy.data.objects["Lamp"].hide_render = True
    ball((0, 0.3, 0), 1.2, "BsdfGlass", Color=_WHITE, Roughness=0.3, IOR=1.3)


def translucent():
    """Two panes one behind the other: what goes through both was transmitted, diffusely, twice."""
    pane(0.0, "BsdfTranslucent", Color=(0.9, 0.9, 0.9, 1))
    pane(0.5, "BsdfTranslucent", Color=(0.9, 0.9, 0.9, 1))


def clear():
    """A mirror behind panes that do not count."""
    for y in (-0.5, 0.0):
        pane(y, "BsdfTransparent", Color=(0.8, 1, 0.9, 1))
    mirrors()


def principled():
    """All lobes at once."""
    ball((-0.8, 0.5, -0.3), 0.7, "BsdfPrincipled", Roughness=0.2, **{"Coat Weight": 1.0, "Sheen Weight": 0.5})
    ball((0.8, 0.5, -0.3), 0.7, "BsdfPrincipled", Roughness=0.3, **{"Transmission Weight": 0.7})
    ball((0, 0.8, 0.9), 0.6, "BsdfPrincipled", Roughness=0.4, Metallic=0.5)


def toon():
    """What is diffuse besides."""
    ball((0.8, 0.5, 0), 0.7, "BsdfToon", Color=_WHITE)
    ball((-0.8, 0.5, 0), 0.7, "BsdfSheen", Color=_WHITE, Roughness=0.8)


def set_limits(scene, limits):
    """Limit kinds of bounces; those not named are not."""
    for name in BOUNCES:
        setattr(scene.zraka, name, limits.get(name.removesuffix("_bounces"), ALL_BOUNCES))


def measure(case):
    """Greatest difference of the blocks' means, of how much the limits show, shares of the brightest; messages."""
    scene = room()
    scene.zraka.samples = case.samples
    case.setup()
    match(scene)
    free = means(operate(scene, "ZRAKA")[0])
    set_limits(scene, case.limits)
    match(scene)
    with watched() as seen:
        ours = means(operate(scene, "ZRAKA")[0])
    theirs = means(operate(scene, "CYCLES")[0])
    shown = float(np.abs(ours - free).max() / theirs.max())
    return float(np.abs(ours - theirs).max() / theirs.max()), shown, seen.messages


CASES = (
    *(Case(f"diffuse bounces: {n}", matte, {"diffuse": n}) for n in (0, 1, 2)),
    *(Case(f"glossy bounces, mirrors: {n}", mirrors, {"glossy": n}) for n in (0, 1, 3)),
    *(Case(f"transmission bounces, glass ball: {n}", glass, {"transmission": n}, samples=1024) for n in (0, 1, 2)),
    Case("transmission bounces, rough glass: 1", frosted, {"transmission": 1}, samples=1024),
    *(Case(f"transmission bounces, translucent panes: {n}", translucent, {"transmission": n}) for n in (0, 1)),
    Case("glossy bounces behind transparent panes: 1", clear, {"glossy": 1}),
    *(Case(f"{kind} bounces, Principled: 0", principled, {kind: 0}) for kind in ("diffuse", "glossy", "transmission")),
    Case("diffuse 1, glossy 1, transmission 2: Principled", principled, {"diffuse": 1, "glossy": 1, "transmission": 2}),
    Case("diffuse bounces, Toon and Sheen: 0", toon, {"diffuse": 0}),
)
