# SPDX-License-Identifier: GPL-3.0-or-later
"""Every kind of light with every option over a white floor, and the closed form of what it sheds there.

Integrals over lamps are Gauss-Legendre sums in double precision of the radiances that Blender's units mean: power P
spread over all directions and the lamp's surface (docs/design.md, "Blender's 'Normalize' off").
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import bpy
import numpy as np

from zraka.addon.bench.engines import match, operate

from .geometry_scenes import glowing, put, tree_of
from .nodes.harness import add, output

SIDE = 8
SAMPLES = 256


@dataclass(frozen=True)
class Case:
    """A light at `height` above a floor that is lit at (offset · height, 0, 0).

    `expected` takes the case and tells irradiance in W/m², a number or one of each channel. `since` is the version of
    Blender that has the option.
    """

    item: str
    kind: str
    expected: Callable
    settings: dict = field(default_factory=dict)
    height: float = 1.0
    offset: float = 0.0
    tilt: float = 0.0
    since: tuple = (4, 2)

    def get(self, name, default):
        """A setting of the light."""
        return self.settings.get(name, default)


# -- closed forms ------------------------------------------------------------------------------------------------------


def nodes(count, low, high):
    """Places and weights of Gauss and Legendre."""
    x, w = np.polynomial.legendre.leggauss(count)
    return low + (high - low) * (x + 1) / 2, w * (high - low) / 2


def cone_of(case, down):
    """Share that a spot lets through in directions whose cosine to its axis is `down`."""
    if case.kind != "SPOT":
        return 1.0
    edge = math.cos(case.get("spot_size", math.radians(45)) / 2)
    blend = case.get("spot_blend", 0.15)
    x = np.clip((down - edge) / max((1 - edge) * blend, 1e-9), 0, 1)
    return x * x * (3 - 2 * x)


def of_ball(case):
    """Irradiance by a point or spot: a ball that looks alike from all sides, or a disk that faces what it lights."""
    h, x = case.height, case.offset * case.height
    d = math.hypot(h, x)
    r, power = case.get("shadow_soft_size", 0.0), case.get("energy", 10.0)
    cosine, total = h / d, power / (4 * math.pi)
    if not case.get("normalize", True):
        total = power / math.pi * (math.pi * r * r if r else 1.0)
    if r == 0:
        return total / d**2 * cosine * cone_of(case, cosine)
    half = math.atan(r / d) if case.get("use_soft_falloff", True) else math.asin(r / d)
    radiance = total / (math.pi * r * r)
    theta, weight = nodes(400, 0.0, half)
    phi = (np.arange(400) + 0.5) * 2 * math.pi / 400
    axis, side = np.array([-x, h]) / d, np.array([h, x]) / d
    up = np.cos(theta)[:, None] * axis[1] + np.sin(theta)[:, None] * np.cos(phi) * side[1]
    through = cone_of(case, up)
    return radiance * ((through * up * np.sin(theta)[:, None]).sum(1) * 2 * math.pi / 400 @ weight)


def of_sun(case):
    """Irradiance by a sun: its strength times the cosine; not normalised, that is its disc's radiance."""
    disc = 1.0 if case.get("normalize", True) else math.pi * math.sin(0.5 * case.get("angle", 0.0)) ** 2
    return disc * case.get("energy", 10.0) * math.cos(case.tilt)


def of_area(case):
    """Irradiance by an area lamp that looks down, or glows on both sides."""
    shape, size = case.get("shape", "SQUARE"), case.get("size", 0.25)
    other = case.get("size_y", 0.25) if shape in ("RECTANGLE", "ELLIPSE") else size
    if shape in ("SQUARE", "RECTANGLE"):
        (u, wu), (v, wv) = nodes(200, -size / 2, size / 2), nodes(200, -other / 2, other / 2)
        x, y, weight = u[:, None], v, wu[:, None] * wv
        area = size * other
    else:
        (r, wr), angle = nodes(200, 0, 1), (np.arange(400) + 0.5) * 2 * math.pi / 400
        x, y = size / 2 * r[:, None] * np.cos(angle), other / 2 * r[:, None] * np.sin(angle)
        weight = (wr * r)[:, None] * size * other / 4 * 2 * math.pi / 400
        area = math.pi / 4 * size * other
    power = case.get("energy", 10.0)
    radiance = power / math.pi / (area if case.get("normalize", True) else 1.0)
    dx, h = case.offset * case.height - x, case.height
    squared = dx**2 + y**2 + h * h
    cosine = h / np.sqrt(squared)
    spread = case.get("spread", math.pi)
    if spread < math.pi:
        t = math.tan(spread / 2)
        radiance = radiance * np.maximum(t - np.tan(np.arccos(cosine)), 0) / (t - spread / 2)
    return float((radiance * cosine**2 / squared * weight).sum())


def of_mesh(case):
    """Irradiance by a square that emits its energy as radiance."""
    area = case.get("size", 0.25) ** 2
    return of_area(Case("", "AREA", of_area, {**case.settings, "energy": case.get("energy", 10.0) * math.pi * area},
                        case.height, case.offset))  # fmt: skip


def times(form, *factors):
    """A closed form for each channel."""
    return lambda case: form(case) * np.array(factors)


def at_temperature(form):
    """A closed form at 3000 K: Blender tells the colour."""
    return lambda case: form(case) * np.array(bpy.data.lights["Light"].temperature_color)


# -- cases -------------------------------------------------------------------------------------------------------------

WHITE = (1, 1, 1, 1)
DISTANCES = (0.01, 0.1, 10.0, 1e3, 1e4)
BALL, SPOT45 = {"shadow_soft_size": 0.0}, {"spot_size": math.radians(90), "spot_blend": 0.5}
SHAPES = {
    "square": {"shape": "SQUARE", "size": 0.8},
    "rectangle": {"shape": "RECTANGLE", "size": 1.2, "size_y": 0.3},
    "disk": {"shape": "DISK", "size": 0.8},
    "ellipse": {"shape": "ELLIPSE", "size": 1.2, "size_y": 0.3},
}


def principled(tree, energy):
    """Emission of a Principled BSDF."""
    inputs = {"Emission Color": WHITE, "Emission Strength": energy, "Base Color": (0, 0, 0, 1)}
    return output(add(tree, "BsdfPrincipled", inputs | {"Specular IOR Level": 0.0}))


def veiled(tree, energy):
    """Half of it lets light pass."""
    mix = add(tree, "MixShader", {"Fac": 0.5})
    tree.links.new(output(add(tree, "BsdfTransparent", {"Color": WHITE})), mix.inputs[1])
    tree.links.new(output(add(tree, "Emission", {"Strength": energy})), mix.inputs[2])
    return output(mix)


def one_sided(tree, energy):
    """The back emits."""
    strength = add(tree, "Math", {0: output(add(tree, "NewGeometry"), "Backfacing"), 1: energy}, operation="MULTIPLY")
    return output(add(tree, "Emission", {"Strength": output(strength)}))


def by_place(tree, energy):
    """From nothing on one side to twice the energy on the other."""
    place = add(tree, "SeparateXYZ", {0: output(add(tree, "TexCoord"), "Generated")})
    strength = add(tree, "Math", {0: output(place, "X"), 1: 2 * energy}, operation="MULTIPLY")
    return output(add(tree, "Emission", {"Strength": output(strength)}))


def far(height):
    """Energy that keeps what arrives near 1."""
    return {"energy": 10 * height**2}


CASES = (
    Case("point", "POINT", of_ball, BALL),
    Case("point, from the side", "POINT", of_ball, BALL, offset=1.7),
    *(Case(f"point at {h:g} m", "POINT", of_ball, BALL | far(h), h, 0.3) for h in DISTANCES),
    *(Case(f"point of radius {r:g}", "POINT", of_ball, {"shadow_soft_size": r}, offset=0.3) for r in (1e-4, 0.01, 0.3)),
    Case("point, a ball of radius 0.3", "POINT", of_ball, {"shadow_soft_size": 0.3, "use_soft_falloff": False}),
    Case("point, exposure", "POINT", times(of_ball, 2**1.5), BALL | {"exposure": 1.5}, since=(4, 5)),
    Case("point, temperature", "POINT", at_temperature(of_ball),
         BALL | {"use_temperature": True, "temperature": 3000.0}, since=(4, 5)),
    Case("point, not normalised", "POINT", of_ball, BALL | {"normalize": False}, since=(4, 5)),
    Case("point of radius 0.3, not normalised", "POINT", of_ball, {"shadow_soft_size": 0.3, "normalize": False},
         since=(4, 5)),
    Case("point, coloured", "POINT", times(of_ball, 1, 0.5, 0.1), BALL | {"color": (1, 0.5, 0.1)}),
    Case("spot", "SPOT", of_ball, BALL | SPOT45, offset=0.3),
    Case("spot, in its blend", "SPOT", of_ball, BALL | SPOT45, offset=0.8),
    Case("spot, no blend", "SPOT", of_ball, BALL | SPOT45 | {"spot_blend": 0.0}, offset=0.9),
    Case("spot, soft, in its blend", "SPOT", of_ball, SPOT45 | {"shadow_soft_size": 0.2}, offset=0.8),
    Case("spot, a soft ball", "SPOT", of_ball, SPOT45 | {"shadow_soft_size": 0.2, "use_soft_falloff": False},
         offset=0.7),
    Case("spot, narrow", "SPOT", of_ball, BALL | {"spot_size": math.radians(1.0), "spot_blend": 0.2}),
    Case("spot, not normalised", "SPOT", of_ball, BALL | SPOT45 | {"normalize": False}, since=(4, 5)),
    *(Case(f"spot at {h:g} m", "SPOT", of_ball, BALL | SPOT45 | far(h), h, 0.3) for h in DISTANCES),
    *(Case(f"sun of {a:g}°", "SUN", of_sun, {"angle": math.radians(a)}, tilt=0.6) for a in (0, 0.01, 0.53, 10, 60)),
    *(Case(f"area, {name}", "AREA", of_area, s, offset=0.3) for name, s in SHAPES.items()),
    *(Case(f"area, {name}, spread 60°", "AREA", of_area, s | {"spread": math.radians(60)}, offset=0.3)
      for name, s in SHAPES.items()),
    Case("area, spread 20°", "AREA", of_area, SHAPES["square"] | {"spread": math.radians(20)}),
    *(Case(f"area, {name} of 1 mm", "AREA", of_area, s | {"size": 1e-3, "size_y": 1e-3}, offset=0.3)
      for name, s in SHAPES.items()),
    Case("area, not normalised", "AREA", of_area, SHAPES["rectangle"] | {"normalize": False}, since=(4, 5)),
    *(Case(f"area at {h:g} m", "AREA", of_area, SHAPES["square"] | far(h), h, 0.3) for h in DISTANCES),
    *(Case(f"{kind.lower()}, {item}", kind, change(form), more | settings, offset=0.3, since=since)
      for kind, form, more in (("SPOT", of_ball, BALL | SPOT45), ("AREA", of_area, SHAPES["square"]),
                               ("SUN", of_sun, {"angle": math.radians(5)}))
      for item, change, settings, since in (
          ("coloured", lambda form: times(form, 1, 0.5, 0.1), {"color": (1, 0.5, 0.1)}, (4, 2)),
          ("exposure", lambda form: times(form, 2**1.5), {"exposure": 1.5}, (4, 5)),
          ("temperature", at_temperature, {"use_temperature": True, "temperature": 3000.0}, (4, 5)))),
    Case("sun, not normalised", "SUN", of_sun, {"angle": math.radians(20), "normalize": False}, since=(4, 5)),
    *(Case(f"emissive mesh, {item}", "MESH", times(of_mesh, share), {"size": 0.8, "shader": shader, "samples": 4096})
      for item, shader, share in (("Principled", principled, 1), ("Mix with Transparent", veiled, 0.5),
                                  ("one side", one_sided, 1), ("a colour that changes", by_place, 1))),
    Case("emissive mesh", "MESH", of_mesh, {"size": 0.8}, offset=0.3),
    Case("emissive mesh of 1 mm", "MESH", of_mesh, {"size": 1e-3, "energy": 1e6}, offset=0.3),
    *(Case(f"emissive mesh at {h:g} m", "MESH", of_mesh, {"size": 0.5 * h}, h, 0.3) for h in DISTANCES),
    *(Case(f"negative {kind.lower()}", kind, form, {**more, "energy": -10.0}, offset=0.3)
      for kind, form, more in (("POINT", of_ball, BALL), ("SPOT", of_ball, BALL | SPOT45),
                               ("AREA", of_area, SHAPES["square"]), ("SUN", of_sun, {}))),
)  # fmt: skip


# -- scenes ------------------------------------------------------------------------------------------------------------


def white(name="White"):
    """A white diffuse material."""
    material = bpy.data.materials.new(name)
    tree = tree_of(material)
    shader, output = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeOutputMaterial")
    shader.inputs["Color"].default_value = (1, 1, 1, 1)
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return material


def lamp(scene, case):
    """The case's light, unseen by the camera as Blender's own operator leaves it."""
    data = bpy.data.lights.new("Light", case.kind)
    data.energy = 10.0
    for name, value in case.settings.items():
        if hasattr(data, name):
            setattr(data, name, value)
    obj = put(scene, data, "Light", location=(0, 0, case.height), rotation_euler=(0, case.tilt, 0))
    obj.visible_camera = False


def emitter(scene, case):
    """A square that glows."""
    bpy.ops.mesh.primitive_plane_add(size=case.get("size", 0.25), location=(0, 0, case.height))
    shader, energy = case.get("shader", None), case.get("energy", 10.0)
    material = glowing((energy,) * 3) if shader is None else bpy.data.materials.new("Shader")
    if shader is not None:
        tree = tree_of(material)
        tree.links.new(shader(tree, energy), add(tree, "OutputMaterial").inputs["Surface"])
    bpy.context.object.data.materials.append(material)


def build(scene, case):
    """A floor a hundred heights wide under the light, of which a camera below the light sees a hundredth height."""
    h = case.height
    floor = bpy.data.meshes.new("Floor")
    floor.from_pydata(
        [(x * 50 * h, y * 50 * h, 0) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))], [], [(0, 1, 2, 3)]
    )
    floor.materials.append(white())
    put(scene, floor, "Floor")
    (emitter if case.kind == "MESH" else lamp)(scene, case)
    camera = bpy.data.cameras.new("Camera")
    camera.type, camera.ortho_scale = "ORTHO", 1e-3 * h
    camera.clip_start, camera.clip_end = 1e-3 * h, 10 * h
    scene.camera = put(scene, camera, "Camera", location=(case.offset * h, 0, 0.5 * h))
    render = scene.render
    render.resolution_x = render.resolution_y = SIDE
    render.threads_mode, render.threads = "FIXED", 1
    scene.zraka.samples, scene.zraka.depth = case.get("samples", SAMPLES), 1


def measure(scene, case):
    """Greatest relative difference of a channel from the closed form: Zraka's and Cycles'; Zraka's from Cycles'."""
    build(scene, case)
    match(scene)
    expected = np.broadcast_to(case.expected(case), 3)
    ours, theirs = (math.pi * operate(scene, e)[0].mean((0, 1), dtype=np.float64) for e in ("ZRAKA", "CYCLES"))
    return tuple(float(np.abs(a / b - 1).max()) for a, b in ((ours, expected), (theirs, expected), (ours, theirs)))
