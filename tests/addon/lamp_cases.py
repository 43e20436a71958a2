# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader nodes of lamps: what they shed on a floor, or show in a mirror, beside Cycles."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import bpy
import numpy as np

from zraka.addon.bench.engines import match, operate

from . import light_cases
from .geometry_scenes import tree_of
from .nodes.harness import add, output
from .nodes.ies_files import ies_text

ROTATION = (0.2, 0.1, 0.5)


@dataclass(frozen=True)
class Case:
    """A lamp whose nodes ``make(tree)`` ends in a socket: a colour or value to be emitted, or a shader.

    `mirror` replaces the white floor; the camera then sees the lamp itself. `since` is the version of Blender whose
    Cycles is followed.
    """

    item: str
    kind: str
    make: Callable
    settings: dict = field(default_factory=dict)
    height: float = 1.0
    offset: float = 0.3
    mirror: bool = False
    scale: tuple = (1.0, 1.0, 1.0)
    note: str = ""
    since: tuple = (4, 2)


def told(node, name, scale=1.0, offset=0.0):
    """What an input node says, times and plus a number."""
    return lambda tree: shifted(tree, output(add(tree, node), name), scale, offset)


def shifted(tree, socket, scale=0.3, offset=0.7):
    """A socket times and plus a number."""
    value = add(tree, "VectorMath", {0: socket}, operation="MULTIPLY_ADD")
    value.inputs[1].default_value, value.inputs[2].default_value = (scale,) * 3, (offset,) * 3
    return value.outputs[0]


def falloff(name, smooth=0.0):
    """A Light Falloff node."""
    return lambda tree: output(add(tree, "LightFalloff", {"Strength": 2.0, "Smooth": smooth}), name)


def picture():
    """A generated image of colours that run over its width and height."""
    image = bpy.data.images.new("Slide", 16, 16, float_buffer=True)
    x, y = np.meshgrid(np.linspace(0.1, 1, 16), np.linspace(0.1, 1, 16))
    image.pixels.foreach_set(np.stack([x, y, x * y, np.ones_like(x)], -1).astype(np.float32).ravel())
    return image


def slide(coordinates="UV", scale=1.0):
    """The image over coordinates of the lamp; None leaves them to the node."""

    def make(tree):
        inputs = {}
        if coordinates:
            mapping = add(tree, "Mapping", {"Vector": output(add(tree, "TexCoord"), coordinates)})
            mapping.inputs["Scale"].default_value = (scale,) * 3
            inputs["Vector"] = mapping.outputs[0]
        return output(add(tree, "TexImage", inputs, image=picture()), "Color")

    return make


def gobo(tree):
    """The image through a spot's cone by hand: the normal's x and y over its z."""
    parts = add(tree, "SeparateXYZ", {0: output(add(tree, "TexCoord"), "Normal")})
    sides = [add(tree, "Math", {0: parts.outputs[k], 1: parts.outputs[2]}, operation="DIVIDE") for k in (0, 1)]
    vector = add(tree, "CombineXYZ", {k: side.outputs[0] for k, side in enumerate(sides)})
    return output(add(tree, "TexImage", {"Vector": vector.outputs[0]}, image=picture()), "Color")


def ies(**inputs):
    """An IES Texture of a file that is not alike all around."""
    return lambda tree: output(add(tree, "TexIES", inputs, mode="INTERNAL", ies=ies_text()), "Fac")


def turned_ies(tree):
    """The same by the direction of the ray."""
    return ies(Vector=output(add(tree, "NewGeometry"), "Incoming"))(tree)


def noise(tree):
    """Noise over the coordinates that it takes by itself."""
    return output(add(tree, "TexNoise", {"Scale": 3.0}), "Color")


def tangent(kind, axis="Z"):
    """A Tangent node."""
    return lambda tree: shifted(tree, output(add(tree, "Tangent", direction_type=kind, axis=axis)))


def bent(tree):
    """A Normal Map of a colour."""
    return shifted(tree, output(add(tree, "NormalMap", {"Color": (0.7, 0.6, 0.9, 1)})))


def mixed(tree):
    """Two emissions by the angle of view."""
    share = output(add(tree, "LayerWeight", {"Blend": 0.7}), "Facing")
    one, two = add(tree, "Emission", {"Color": (1, 0.2, 0.1, 1)}), add(tree, "Emission", {"Color": (0.1, 0.5, 1, 1)})
    return add(tree, "MixShader", {0: share, 1: one.outputs[0], 2: two.outputs[0]}).outputs[0]


def folded(tree):
    """A temperature, and a strength that is computed of constants."""
    strength = add(tree, "Math", {0: 1.5, 1: 0.5}, operation="POWER")
    inputs = {"Color": add(tree, "Blackbody", {0: 3000.0}).outputs[0], "Strength": strength.outputs[0]}
    return add(tree, "Emission", inputs).outputs[0]


def background(tree):
    """A Background node, which emits in a lamp too, beside a shader that does not."""
    shine, dull = add(tree, "Background", {"Strength": 2.0}), add(tree, "BsdfDiffuse")
    return add(tree, "AddShader", {0: shine.outputs[0], 1: dull.outputs[0]}).outputs[0]


BALL, CONE = light_cases.BALL, light_cases.BALL | {"spot_size": math.radians(90), "spot_blend": 0.5}
AREA = {"shape": "RECTANGLE", "size": 0.9, "size_y": 0.6}
SOFT, ROUND = {"shadow_soft_size": 0.3}, {"shadow_soft_size": 0.3, "use_soft_falloff": False}
IN_WORLD = "in Blender 4.2 the world's, as Cycles' there"
NEWER = {"note": "not as in Blender 4.2: see below", "since": (4, 5)}
SUN, LENGTH = {"angle": math.radians(20)}, told("LightPath", "Ray Length", 0.5, 0.1)

CASES = (
    Case("point, Light Falloff linear", "POINT", falloff("Linear"), BALL),
    *(Case(f"point at {h:g} m, Light Falloff {k.lower()}{', smooth' * bool(s)}", "POINT", falloff(k, s), BALL, h)
      for h in (0.1, 10.0) for k in ("Quadratic", "Linear", "Constant") for s in (0.0, 3.0)),
    *(Case(f"sun, Light Falloff {k.lower()}", "SUN", falloff(k), SUN, **NEWER) for k in ("Linear", "Constant")),
    Case("area, Light Falloff constant", "AREA", falloff("Constant"), AREA),
    Case("spot, image by UV", "SPOT", slide(), CONE),
    Case("spot, image without coordinates", "SPOT", slide(None), CONE, scale=(2.0, 2.0, 2.0)),
    Case("spot, image through the cone by Normal", "SPOT", gobo, CONE),
    Case("spot, soft, image by UV", "SPOT", slide(), CONE | ROUND),
    Case("point, image by Normal, Mapping", "POINT", slide("Normal", 0.4), BALL),
    Case("point, image by UV", "POINT", slide(), BALL, scale=(1.0, 2.0, 3.0)),
    Case("point, soft, image by UV", "POINT", slide(), SOFT),
    Case("point, a ball, image by UV", "POINT", slide(), ROUND),
    Case("point, noise by Object", "POINT", noise, ROUND),
    Case("area, image by UV", "AREA", slide(), AREA),
    Case("area, image by UV, stretched", "AREA", slide(), AREA, scale=(-0.5, 2.0, 1.0)),
    Case("area, a disk, image by UV", "AREA", slide(), {"shape": "DISK", "size": 0.9}),
    Case("area, Parametric", "AREA", told("NewGeometry", "Parametric"), AREA),
    Case("area, noise by Generated", "AREA", noise, AREA),
    Case("area, spread 60°, image by UV", "AREA", slide(), AREA | {"spread": math.radians(60)}),
    Case("sun, image by UV", "SUN", slide(), SUN),
    Case("point, IES", "POINT", ies(), BALL),
    Case("point, IES, from the side", "POINT", ies(Strength=0.3), BALL, offset=1.2),
    Case("spot, IES", "SPOT", ies(), CONE),
    Case("area, IES by Incoming", "AREA", turned_ies, AREA),
    Case("point, Blackbody and constants", "POINT", folded, BALL),
    Case("point, Background and a shader that does not emit", "POINT", background, BALL),
    Case("area, two Emissions by Layer Weight", "AREA", mixed, AREA),
    *(Case(f"{kind.lower()}, Geometry {name}", kind, told("NewGeometry", name, 0.3, 0.7), settings)
      for kind, settings in (("POINT", BALL), ("SPOT", CONE), ("AREA", AREA), ("SUN", SUN))
      for name in ("Position", "Normal", "Incoming")),
    *(Case(f"{kind.lower()}, Ray Length", kind, LENGTH, settings)
      for kind, settings in (("POINT", BALL), ("SPOT", CONE), ("AREA", AREA))),
    Case("area, Ray Depth", "AREA", told("LightPath", "Ray Depth", 0.3), AREA),
    Case("area, Is Diffuse Ray: never", "AREA", told("LightPath", "Is Diffuse Ray", 1.0, 0.5), AREA),
    *(Case(f"{kind.lower()}, Texture Coordinate {name}", kind, told("TexCoord", name, 0.3, 0.7), settings,
           **(NEWER if name == "Camera" else {"note": IN_WORLD if name in ("Generated", "Object") else ""}))
      for kind, settings in (("POINT", ROUND), ("SPOT", CONE), ("AREA", AREA), ("SUN", SUN))
      for name in ("Generated", "Object", "Camera", "Normal", "Reflection")),
    *(Case(f"{kind.lower()}, {item}", kind, make, settings)
      for kind, settings in (("POINT", ROUND), ("SPOT", CONE), ("AREA", AREA), ("SUN", SUN))
      for item, make in (("Tangent", tangent("RADIAL", "X")), ("Tangent of a UV map", tangent("UV_MAP")),
                         ("Normal Map", bent))),
    Case("point, Object Info Random", "POINT", told("ObjectInfo", "Random"), BALL),
    Case("point, Camera Data", "POINT", told("CameraData", "View Vector", 0.3, 0.5), BALL),
    *(Case(f"{name}, image by UV, in a mirror", kind, slide(), settings, offset=0.1, mirror=True)
      for name, kind, settings in (("area", "AREA", AREA), ("ball", "POINT", ROUND), ("soft point", "POINT", SOFT),
                                   ("soft spot", "SPOT", CONE | ROUND))),
    Case("area, Ray Depth, in a mirror", "AREA", told("LightPath", "Ray Depth", 0.3), AREA, mirror=True),
    Case("ball, Normal, in a mirror", "POINT", told("TexCoord", "Normal", 0.3, 0.5), ROUND, offset=0.1, mirror=True),
)  # fmt: skip


def build(scene, case):
    """A lamp with the case's nodes over the floor of `light_cases`."""
    plain = light_cases.Case(case.item, case.kind, None, case.settings, case.height, case.offset)
    light_cases.build(scene, plain)
    obj = bpy.data.objects["Light"]
    obj.rotation_euler, obj.scale = ROTATION, case.scale
    tree = tree_of(obj.data)
    end = case.make(tree)
    if end.type != "SHADER":
        end = add(tree, "Emission", {"Color": end}).outputs[0]
    tree.links.new(end, add(tree, "OutputLight").inputs["Surface"])
    if case.mirror:
        floor = tree_of(bpy.data.objects["Floor"].data.materials[0])
        gloss = add(floor, "BsdfAnisotropic", {"Color": (1, 1, 1, 1), "Roughness": 0.0})
        floor.links.new(gloss.outputs[0], add(floor, "OutputMaterial").inputs["Surface"])
        scene.zraka.depth = 2


def render(scene, case, engine):
    """What `engine` finds, of each channel."""
    match(scene)
    return operate(scene, engine)[0].mean((0, 1), dtype=np.float64)


def measure(scene, case):
    """Greatest difference of a channel of Zraka's from Cycles', as a share of the brightest."""
    build(scene, case)
    ours, theirs = (render(scene, case, engine) for engine in ("ZRAKA", "CYCLES"))
    return float(np.abs(ours - theirs).max() / np.abs(theirs).max())
