# SPDX-License-Identifier: GPL-3.0-or-later
"""Input nodes beside Cycles."""

from __future__ import annotations

import bpy
import pytest

from .harness import Case, add, difference, output, signed
from .shapes import ball, instances, islands


def on_plane(kind, socket, inputs=None, scale=0.25, **properties):
    """Builds a node on the plane."""
    return lambda tree, obj: signed(tree, output(add(tree, kind, inputs, **properties), socket), scale)


def beside_the_diagonal(tree, obj):
    """Parametric on the plane, moved: a ray through the side that two triangles share may meet either of them."""
    obj.location.x, obj.scale = 0.004, (1.1, 1.1, 1.1)
    return on_plane("NewGeometry", "Parametric")(tree, obj)


def on_ball(kind, socket, inputs=None, scale=0.25, shape=None, **properties):
    """Builds a node on a ball."""

    def build(tree, obj):
        ball(obj, **(shape or {}))
        return signed(tree, output(add(tree, kind, inputs, **properties), socket), scale)

    return build


def on_instances(where, kind, socket, **properties):
    """Builds a node on instances."""

    def build(tree, obj):
        instances(obj, where)
        return signed(tree, output(add(tree, kind, **properties), socket))

    return build


def of_other_object(tree, obj):
    ball(obj)
    other = bpy.data.objects.new("Other", None)
    other.location, other.rotation_euler, other.scale = (0.3, 0.2, 0.1), (0.2, 0.5, 0.7), (1, 2, 0.5)
    bpy.context.scene.collection.objects.link(other)
    return signed(tree, output(add(tree, "TexCoord", object=other), "Object"))


def deformed(tree, obj):
    ball(obj)
    modifier = obj.modifiers.new("Displace", "DISPLACE")
    modifier.strength, modifier.mid_level, modifier.direction = 0.3, 0, "X"
    return signed(tree, output(add(tree, "TexCoord"), "Generated"))


def own_texture_space(tree, obj):
    ball(obj)
    obj.data.use_auto_texspace = False
    obj.data.texspace_location, obj.data.texspace_size = (0.1, 0.2, 0.3), (0.5, 2, 1.5)
    return signed(tree, output(add(tree, "TexCoord"), "Generated"))


def second_uv_map(tree, obj):
    layer = obj.data.uv_layers.new(name="Second")
    for corner, place in zip(layer.uv, ((0.1, 0.9), (0.3, -0.2), (1.5, 0.4), (0.7, 0.6)), strict=True):
        corner.vector = place
    return signed(tree, output(add(tree, "UVMap", uv_map="Second")))


def of_islands(tree, obj):
    islands(obj)
    return output(add(tree, "NewGeometry"), "Random Per Island")


def pointy(tree, obj):
    ball(obj)
    modifier = obj.modifiers.new("Displace", "DISPLACE")
    modifier.texture, modifier.strength = bpy.data.textures.new("Clouds", "CLOUDS"), 0.5
    return output(add(tree, "NewGeometry"), "Pointiness")


def object_info(socket):
    def build(tree, obj):
        ball(obj)
        obj.color, obj.pass_index, obj.active_material.pass_index = (0.1, 0.2, 0.3, 0.4), 2, 3
        return signed(tree, output(add(tree, "ObjectInfo"), socket))

    return build


def linked_normal(kind, socket):
    def build(tree, obj):
        ball(obj)
        normal = output(add(tree, "NewGeometry"), "True Normal")
        return output(add(tree, kind, {"Normal": normal}), socket)

    return build


COORDINATES = ("Generated", "Normal", "UV", "Object", "Camera", "Window", "Reflection")
GEOMETRY = ("Position", "Normal", "Tangent", "True Normal", "Incoming", "Parametric", "Backfacing")
OBJECT = ("Location", "Color", "Alpha", "Object Index", "Material Index", "Random")
CAMERA = ("View Vector", "View Z Depth", "View Distance")

# Since 5.1 Cycles rounds vertex normals to 2 x 16 bits, by up to 4e-5, which shows where total reflection begins.
_ONE_PIXEL = 1 / 4096 if bpy.app.version >= (5, 1) else 0.0

CASES = [
    *(Case(f"Texture Coordinate: {s.lower()} on a plane", on_plane("TexCoord", s)) for s in COORDINATES),
    *(Case(f"Texture Coordinate: {s.lower()} on a ball", on_ball("TexCoord", s)) for s in COORDINATES),
    *(
        Case(f"Texture Coordinate: {s.lower()} on a mirrored ball", on_ball("TexCoord", s, shape={"scale": (-1, 1, 1)}))
        for s in ("Generated", "Normal", "UV", "Object")
    ),
    *(
        Case(f"Texture Coordinate: {s.lower()} inside", on_ball("TexCoord", s, shape={"inside_out": True}))
        for s in ("Normal", "Reflection")
    ),
    *(
        Case(f"Texture Coordinate: {s.lower()} of instances on {w.lower()}", on_instances(w, "TexCoord", s))
        for w in ("VERTS", "FACES")
        for s in ("Generated", "Normal", "UV", "Object")
    ),
    *(
        Case(
            f"Texture Coordinate: {s.lower()} from instancer, {w.lower()}",
            on_instances(w, "TexCoord", s, from_instancer=True),
        )
        for w in ("VERTS", "FACES")
        for s in ("Generated", "UV", "Object")
    ),
    Case("Texture Coordinate: another object's", of_other_object),
    Case("Texture Coordinate: generated, deformed", deformed),
    Case("Texture Coordinate: generated, own texture space", own_texture_space),
    Case("UV Map: active", on_ball("UVMap", "UV")),
    Case("UV Map: second", second_uv_map),
    Case("UV Map: missing", on_plane("UVMap", "UV", uv_map="Nothing")),
    Case("UV Map: from instancer", on_instances("FACES", "UVMap", "UV", from_instancer=True)),
    *(
        Case(f"Geometry: {s.lower()} on a plane", on_plane("NewGeometry", s))
        for s in (*GEOMETRY, "Pointiness", "Random Per Island")
        if s != "Parametric"
    ),
    Case("Geometry: parametric on a plane", beside_the_diagonal),
    *(Case(f"Geometry: {s.lower()} on a ball", on_ball("NewGeometry", s)) for s in GEOMETRY),
    *(
        Case(f"Geometry: {s.lower()} on a mirrored ball", on_ball("NewGeometry", s, shape={"scale": (-1, 0.8, 0.6)}))
        for s in GEOMETRY
    ),
    *(Case(f"Geometry: {s.lower()} inside", on_ball("NewGeometry", s, shape={"inside_out": True})) for s in GEOMETRY),
    *(
        Case(f"Geometry: {s.lower()} on a flat ball", on_ball("NewGeometry", s, shape={"smooth": False}))
        for s in ("Normal", "Tangent")
    ),
    Case("Geometry: pointiness", pointy),
    Case("Geometry: random per island", of_islands),
    *(Case(f"Camera Data: {s.lower()} on a plane", on_plane("CameraData", s)) for s in CAMERA),
    *(Case(f"Camera Data: {s.lower()} on a ball", on_ball("CameraData", s)) for s in CAMERA),
    *(Case(f"Object Info: {s.lower()}", object_info(s)) for s in OBJECT),
    *(
        Case(f"Object Info: {s.lower()} of instances on {w.lower()}", on_instances(w, "ObjectInfo", s))
        for w in ("VERTS", "FACES")
        for s in OBJECT
    ),
    *(Case(f"Light Path: output {k}", on_plane("LightPath", k)) for k in range(13)),
    *(Case(f"Fresnel: {ior:g}", on_ball("Fresnel", 0, {"IOR": ior})) for ior in (1.0, 1.5, 0.7, 0.0)),
    Case("Fresnel: inside", on_ball("Fresnel", 0, shape={"inside_out": True}), share=_ONE_PIXEL),
    Case("Fresnel: linked normal", linked_normal("Fresnel", 0)),
    *(
        Case(f"Layer Weight: {s.lower()} {blend:g}", on_ball("LayerWeight", s, {"Blend": blend}))
        for s in ("Fresnel", "Facing")
        for blend in (0.0, 0.2, 0.5, 0.8, 1.0)
    ),
    Case("Layer Weight: inside", on_ball("LayerWeight", "Fresnel", shape={"inside_out": True})),
    Case("Layer Weight: linked normal", linked_normal("LayerWeight", "Facing")),
    *(Case(f"Tangent: radial {a}", on_ball("Tangent", 0, direction_type="RADIAL", axis=a)) for a in "XYZ"),
    Case("Tangent: UV map", on_ball("Tangent", 0, direction_type="UV_MAP")),
    Case("Tangent: UV map, mirrored", on_ball("Tangent", 0, shape={"scale": (-1, 1, 1)}, direction_type="UV_MAP")),
    Case("Wireframe: world", on_ball("Wireframe", 0, {"Size": 0.05})),
    Case("Wireframe: pixels", on_ball("Wireframe", 0, {"Size": 3.0}, use_pixel_size=True)),
    *(Case(f"Particle Info: output {k}", on_plane("ParticleInfo", k), known=("particles",)) for k in range(8)),
    *(Case(f"Curves Info: output {k}", on_plane("HairInfo", k), known=("curves",)) for k in range(6)),
    *(Case(f"Point Info: output {k}", on_plane("PointInfo", k), known=("points",)) for k in range(3)),
]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_agrees_with_cycles(case):
    largest, share = difference(case)
    print(f"largest difference {largest:.1e}, {share:.2%} of the pixels beyond {case.tolerance:g}")
    assert share <= case.share
