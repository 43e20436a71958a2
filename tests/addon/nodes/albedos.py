# SPDX-License-Identifier: GPL-3.0-or-later
"""Closures beside Cycles' by what they reflect: ``python -m tests.addon.nodes.albedos`` writes docs/closures.md.

Each closure with four roughnesses, on a plane in a white world, seen at five angles: its radiance there is its
directional albedo.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path

import bpy
import numpy as np

from .harness import add
from .slope import Slope, emptied

PAGE = Path(__file__).resolve().parents[3] / "docs" / "closures.md"
ANGLES = (0.0, 40.0, 60.0, 75.0, 85.0)
ROUGHNESSES = (0.15, 0.4, 0.7, 1.0)
_COLOR = (0.8, 0.5, 0.2, 1.0)
_OTHER = (0.1, 0.3, 0.4, 1.0)
_SAMPLES = 256
_DARK = 0.02  # radiances below count as that bright


@dataclass(frozen=True)
class Closure:
    """A shader node in one of its modes; the input called `rough` takes the roughnesses.

    `angles` are those at which it is compared; `below` shows the surface's back.
    """

    name: str
    kind: str
    inputs: dict = field(default_factory=dict)
    properties: dict = field(default_factory=dict)
    rough: str = "Roughness"
    angles: tuple = ANGLES
    below: bool = False

    def build(self, roughness):
        """A builder of the node's material, as `Slope` takes it."""

        def make(tree, plane):
            inputs = self.inputs | ({self.rough: roughness} if self.rough else {})
            return add(tree, self.kind, inputs, **self.properties).outputs[0]

        return make


@dataclass(frozen=True)
class Joined(Closure):
    """`kind` of a diffuse and a translucent closure; the input called `rough` is the factor of Mix Shader."""

    def build(self, roughness):
        """As of `Closure`."""

        def make(tree, plane):
            node = add(tree, self.kind, {self.rough: roughness} if self.rough else {})
            for kind, color, socket in zip(("Diffuse", "Translucent"), (_COLOR, _OTHER), node.inputs[-2:], strict=True):
                tree.links.new(add(tree, f"Bsdf{kind}", {"Color": color}).outputs[0], socket)
            return node.outputs[0]

        return make


HAIR = "## Hair"  # the section that is written by hand


def _principled(name, below=False, **inputs):
    inputs = {key.replace("_", " "): value for key, value in inputs.items()}
    return Closure(f"Principled: {name}", "BsdfPrincipled", {"Base Color": _COLOR} | inputs, below=below)


def _glossy(name, distribution, angles=ANGLES, **inputs):
    properties = {"distribution": distribution}
    return Closure(f"Glossy: {name}", "BsdfAnisotropic", {"Color": _COLOR} | inputs, properties, angles=angles)


def _metallic(name, fresnel, distribution="MULTI_GGX", **inputs):
    inputs = {key.replace("_", " "): value for key, value in inputs.items()}
    properties = {"distribution": distribution, "fresnel_type": fresnel}
    return Closure(f"Metallic: {name}", "BsdfMetallic", inputs, properties)


def _glass(kind, name, distribution, below=False, **inputs):
    inputs = {key.replace("_", " "): value for key, value in inputs.items()}
    properties = {"distribution": distribution}
    return Closure(f"{kind}: {name}", f"Bsdf{kind}", {"Color": _COLOR} | inputs, properties, below=below)


# Where rough Ashikhmin-Shirley is seen at a grazing angle, Cycles' samples do not follow their density: the mean of its
# scattered rays is not that of the light it samples, and the picture a mixture of both.
_NOT_GRAZING = ANGLES[:3]
_TINT = {"Coat_Tint": (0.9, 0.4, 0.2, 1.0)}
_TURNED = {"Anisotropic": 0.8, "Anisotropic_Rotation": 0.2}

CLOSURES = (
    Closure("Diffuse", "BsdfDiffuse", {"Color": _COLOR}),
    Closure("Translucent", "BsdfTranslucent", {"Color": _COLOR}, rough=""),
    Closure("Transparent", "BsdfTransparent", {"Color": _COLOR}, rough=""),
    Closure("Emission", "Emission", {"Color": _COLOR}, rough="Strength"),
    Joined("Mix Shader", "MixShader", rough="Fac"),
    Joined("Add Shader", "AddShader", rough=""),
    Closure("Sheen: Microfiber", "BsdfSheen", {"Color": _COLOR}, {"distribution": "MICROFIBER"}),
    Closure("Sheen: Ashikhmin", "BsdfSheen", {"Color": _COLOR}, {"distribution": "ASHIKHMIN"}),
    Closure("Toon: Diffuse", "BsdfToon", {"Color": _COLOR, "Smooth": 0.3}, {"component": "DIFFUSE"}, "Size"),
    Closure("Toon: Glossy", "BsdfToon", {"Color": _COLOR, "Smooth": 0.3}, {"component": "GLOSSY"}, "Size"),
    _glossy("GGX", "GGX"),
    _glossy("Multiscatter GGX", "MULTI_GGX"),
    _glossy("Beckmann", "BECKMANN"),
    _glossy("Ashikhmin-Shirley", "ASHIKHMIN_SHIRLEY", _NOT_GRAZING),
    _glossy("GGX, anisotropy 0.6", "GGX", Anisotropy=0.6, Rotation=0.1),
    _glossy("Multiscatter GGX, anisotropy -0.6", "MULTI_GGX", Anisotropy=-0.6, Rotation=0.1),
    _glossy("Beckmann, anisotropy 0.6", "BECKMANN", Anisotropy=0.6, Rotation=0.3),
    _glossy("Ashikhmin-Shirley, anisotropy 0.6", "ASHIKHMIN_SHIRLEY", _NOT_GRAZING, Anisotropy=0.6, Rotation=0.3),
    _metallic("F82 tint", "F82"),
    _metallic("F82 tint, Beckmann", "F82", "BECKMANN"),
    _metallic("F82 tint, thin film", "F82", Thin_Film_Thickness=300.0),
    _metallic("physical conductor", "PHYSICAL_CONDUCTOR"),
    _metallic("physical conductor, GGX, anisotropy 0.7", "PHYSICAL_CONDUCTOR", "GGX", Anisotropy=0.7),
    _metallic("physical conductor, thin film", "PHYSICAL_CONDUCTOR", Thin_Film_Thickness=500.0),
    _glass("Glass", "GGX", "GGX"),
    _glass("Glass", "GGX, from within", "GGX", below=True),
    _glass("Glass", "Multiscatter GGX", "MULTI_GGX"),
    _glass("Glass", "Multiscatter GGX, from within", "MULTI_GGX", below=True),
    _glass("Glass", "Beckmann", "BECKMANN"),
    _glass("Glass", "Beckmann, from within", "BECKMANN", below=True),
    _glass("Glass", "thin film", "GGX", Thin_Film_Thickness=300.0),
    _glass("Glass", "thin film, from within", "GGX", below=True, Thin_Film_Thickness=300.0),
    _glass("Refraction", "GGX", "GGX"),
    _glass("Refraction", "Beckmann", "BECKMANN"),
    _glass("Refraction", "Beckmann, from within", "BECKMANN", below=True),
    _principled("plain"),
    _principled("specular tint", Specular_Tint=(1.0, 0.5, 0.3, 1.0), Specular_IOR_Level=0.8),
    _principled("diffuse roughness", Diffuse_Roughness=0.8),
    _principled("metallic", Metallic=1.0),
    _principled("metallic 0.5, transmission 0.5", Metallic=0.5, Transmission_Weight=0.5),
    _principled("transmission", Transmission_Weight=1.0),
    _principled("transmission, from within", below=True, Transmission_Weight=1.0),
    _principled("anisotropic", **_TURNED),
    _principled("anisotropic metallic", Metallic=1.0, **_TURNED),
    _principled("coat", Coat_Weight=1.0, Coat_Roughness=0.3),
    _principled("smooth tinted coat 0.5", Coat_Weight=0.5, Coat_Roughness=0.0, Coat_IOR=1.8, **_TINT),
    _principled("tinted coat 0.8 on metal", Metallic=1.0, Coat_Weight=0.8, Coat_Roughness=0.6, **_TINT),
    _principled("sheen", Sheen_Weight=1.0, Sheen_Roughness=0.4, Sheen_Tint=(1.0, 0.6, 0.3, 1.0)),
    _principled("sheen over coat", Sheen_Weight=0.7, Sheen_Roughness=0.8, Coat_Weight=0.6, Coat_Roughness=0.2),
    _principled("emission under sheen and coat", Emission_Strength=0.7, Sheen_Weight=0.5, Coat_Weight=1.0, **_TINT),
    _principled("thin film", Thin_Film_Thickness=400.0),
    _principled("thin film, specular tint", Thin_Film_Thickness=300.0, Specular_Tint=(1.0, 0.5, 0.3, 1.0)),
    _principled("thin film on metal", Thin_Film_Thickness=400.0, Metallic=1.0),
    _principled("thin film on glass", Thin_Film_Thickness=400.0, Transmission_Weight=1.0),
    _principled("alpha 0.6 under a coat", Alpha=0.6, Coat_Weight=1.0),
)


DEFECT = (
    "Rough Ashikhmin-Shirley is not compared beyond 60°. Half vectors that the viewer does not see are turned over",
    "there by Cycles after the angle to them was taken, so that the ray is not mirrored, but weighted as if it were.",
    "What its scattered rays find is then not what sampled light gives, and its picture depends on the share of both.",
    "Zraka's albedo is that of sampled light, which follows the model; the light is an area light seen in all",
    "directions, without multiple importance sampling, and the albedo relative to that of a white diffuse surface:",
    "",
)


def differences(closure, angles=None, samples=_SAMPLES):
    """Relative differences of all channels from Cycles', (angles, roughnesses, 3)."""
    slope = Slope([closure.build(r) for r in ROUGHNESSES], below=closure.below)
    found = []
    for angle in closure.angles if angles is None else angles:
        slope.tilt(angle)
        ours, theirs = (slope.render(engine, samples) for engine in ("ZRAKA", "CYCLES"))
        found.append((ours - theirs) / np.maximum(theirs, _DARK))
    return np.array(found)


def ashikhmin_shirley():
    """Lines of a table: albedos of rough Ashikhmin-Shirley, in Cycles by sampled light and by scattered rays alone."""
    closure = next(c for c in CLOSURES if c.name == "Glossy: Ashikhmin-Shirley")
    builds = [closure.build(r) for r in ROUGHNESSES] + [_white_cloth]
    yield "| angle | roughness | Zraka | Cycles, sampled light alone | Cycles, scattered rays alone |"
    yield "| ---: | ---: | ---: | ---: | ---: |"
    for angle in ANGLES[1:]:
        slope = Slope(builds)
        slope.tilt(angle)
        slope.scene.world.cycles.sampling_method = "NONE"
        ours, scattered = (slope.render(engine, _SAMPLES)[:-1, 0] / _COLOR[0] for engine in ("ZRAKA", "CYCLES"))
        _add_wide_light(slope.scene, math.radians(angle))
        seen = slope.render("CYCLES", _SAMPLES)[:, 0]
        rows = zip(ROUGHNESSES[1:], ours[1:], (seen[:-1] / seen[-1] / _COLOR[0])[1:], scattered[1:], strict=True)
        for roughness, *albedos in rows:
            yield f"| {angle:g}° | {roughness} | " + " | ".join(f"{a:.3f}" for a in albedos) + " |"


def _white_cloth(tree, plane):
    return add(tree, "BsdfDiffuse", {"Color": (1.0, 1.0, 1.0, 1.0)}).outputs[0]


def _add_wide_light(scene, tilt):
    """In the place of the world an area light of all directions above the plane, which scattered rays do not find."""
    scene.world = None
    lamp = bpy.data.lights.new("Wide", "AREA")
    lamp.size, lamp.energy, lamp.use_shadow, lamp.cycles.use_multiple_importance_sampling = 1e5, 1e5, False, False
    light = bpy.data.objects.new("Wide", lamp)
    light.location, light.rotation_euler.x = (0.0, -50 * math.sin(tilt), 50 * math.cos(tilt)), tilt
    scene.collection.objects.link(light)


def is_known(closure):
    """Whether this Blender has the closure in this mode."""
    try:
        closure.build(0.5)(emptied(bpy.data.materials.new("Probe")), None)
    except (AssertionError, RuntimeError, StopIteration, TypeError):
        return False
    return True


def main():
    """Write the page."""
    roughnesses, angles = ", ".join(map(str, ROUGHNESSES)), ", ".join(f"{a:g}°" for a in ANGLES)
    lines = [
        "# Closures beside Cycles",
        "",
        f"What a plane reflects of a white world, in Zraka and in Cycles of Blender {bpy.app.version_string}, at",
        f"roughnesses {roughnesses} (toon: sizes), seen at {angles}: the largest difference of a channel,",
        "relative to Cycles'. Both engines' noise is 0.1% to 0.3%. `python -m tests.addon.nodes.albedos` writes this",
        "page; `pytest tests/addon/nodes/test_closures.py` tests the same, at one angle, or at all with `-m slow`.",
        "",
        "| closure | largest difference | at |",
        "| --- | ---: | --- |",
    ]
    for closure in CLOSURES:
        apart = np.abs(differences(closure)).max(axis=-1)
        angle, roughness = np.unravel_index(apart.argmax(), apart.shape)
        place = f"{closure.angles[angle]:g}°, roughness {ROUGHNESSES[roughness]}"
        lines.append(f"| {closure.name} | {apart.max():.2%} | {place} |")
        print(lines[-1], flush=True)
    lines += [
        "",
        "Subsurface scattering is not compared: it is diffuse reflection here.",
        "",
        *DEFECT,
        *ashikhmin_shirley(),
    ]
    _, _, hair = PAGE.read_text(encoding="utf-8").partition(HAIR)
    lines += ["", HAIR + hair.rstrip("\n")] if hair else []
    PAGE.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
