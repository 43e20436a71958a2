# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes of every kind of geometry, each seen by Zraka and by Cycles through the pixels' centres, without noise.

`coverage.py` writes them into docs/coverage.md.
"""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np

from zraka.addon.bench.engines import match, operate, watched

from . import geometry_scenes as build
from .geometry_scenes import GEOMETRY, NORMAL, POSITION, put, shows

TOLERANCE = 2e-3


@dataclass(frozen=True)
class Case:
    """A scene, what of it is seen, and how many of its pixels must agree to within `TOLERANCE`.

    `build` takes a scene and adds objects; `shown` are outputs (node type, socket, settings) that all surfaces emit in
    turn, empty where the objects' own materials are seen.
    """

    item: str
    build: callable
    shown: tuple = (POSITION, NORMAL)
    agreeing: float = 0.999
    note: str = ""


UV_MAPS = tuple(("ShaderNodeUVMap", 0, ("uv_map", name)) for name in ("", "UVMap", "Second"))
POINT_INFO = tuple(("ShaderNodePointInfo", socket) for socket in ("Position", "Radius", "Random"))
STRANDS = tuple(("ShaderNodeHairInfo", s) for s in ("Is Strand", "Intercept", "Length", "Thickness", "Random"))
STRANDS_TANGENT = (("ShaderNodeHairInfo", "Tangent Normal"),)
ROOTS = (("ShaderNodeUVMap", 0, ("uv_map", "")), ("ShaderNodeAttribute", "Color", ("attribute_name", "Tint")))
HEIGHT = ("ShaderNodeAttribute", "Color", ("attribute_type", "INSTANCER"), ("attribute_name", "height"))
READ_OF_INSTANCES = (HEIGHT,) if bpy.app.version >= (4, 5) else ()  # before, Blender does not tell them to Python


def attribute_case(data_type, domain):
    """The case of an attribute of a type and a domain."""
    kind, where = data_type.lower().replace("_", " "), domain.lower()
    shown = tuple(("ShaderNodeAttribute", socket, ("attribute_name", "Own")) for socket in ("Color", "Fac", "Alpha"))
    return Case(f"attribute: {kind} by {where}", build.attribute(data_type, domain), shown)


CASES = (
    Case("curve", build.curve),
    Case("surface", build.surface),
    Case("text", build.text),
    Case("metaball", build.metaballs, note="rendered once, though Blender lists it twice"),
    Case("instances of a collection", build.collection),
    Case(
        "instances by particles", build.instanced_by_particles, (POSITION, NORMAL, ("ShaderNodeObjectInfo", "Random"))
    ),
    Case(
        "instances by geometry nodes, attributes of the instancer",
        build.instanced_by_nodes,
        (
            POSITION,
            ("ShaderNodeObjectInfo", "Random"),
            *READ_OF_INSTANCES,
        ),
        note="attributes since Blender 4.5, see [blender.md](blender.md)",
    ),
    Case("negative scale", build.mirrored, (POSITION, NORMAL, (GEOMETRY, "True Normal"))),
    Case("shear", build.sheared),
    Case("smooth normals under uneven scale", build.uneven),
    Case("smooth normals under uneven scale, shared mesh", build.uneven_shared),
    Case("non-manifold mesh", build.non_manifold),
    Case("n-gon, concave", build.n_gon),
    Case("loose edges and vertices", build.loose),
    Case("faces without area", build.without_area),
    Case("custom normals", build.custom_normals),
    Case("sharp edges", build.sharp_edges),
    Case("several UV maps", build.uv_maps, UV_MAPS),
    *(
        attribute_case(data_type, domain)
        for data_type, domains in {
            "FLOAT": ("POINT", "EDGE", "FACE", "CORNER"),
            "FLOAT_COLOR": ("POINT", "FACE", "CORNER"),
            "BYTE_COLOR": ("POINT", "CORNER"),
            "FLOAT_VECTOR": ("POINT", "FACE"),
            "FLOAT2": ("POINT", "CORNER"),
            "INT": ("POINT", "EDGE", "FACE"),
            "INT8": ("FACE",),
            "BOOLEAN": ("POINT", "EDGE", "FACE"),
            "QUATERNION": ("POINT",),
        }.items()
        for domain in domains
    ),
    Case(
        "vertex group as attribute", build.vertex_groups, (("ShaderNodeAttribute", "Fac", ("attribute_name", "Own")),)
    ),
    Case("a material for each face", build.by_face, ()),
    Case("materials of the object", build.of_object, ()),
    Case("point cloud with radii", build.points, (POSITION, NORMAL, *POINT_INFO)),
    Case("point cloud in instances", build.instanced_points, (POSITION, NORMAL, *POINT_INFO)),
    Case("hair curves", build.hair_curves, (POSITION, NORMAL), 0.99),
    Case("hair curves: Curves Info, UV, attributes", build.hair_curves, (*STRANDS, *STRANDS_TANGENT, *ROOTS), 0.99),
    Case("particle hair", build.particle_hair, (POSITION, NORMAL), 0.99),
    Case("particle hair: Curves Info, UV, colours", build.particle_hair, (*STRANDS, *STRANDS_TANGENT, *ROOTS), 0.99),
    Case("particle hair: children, shape, closed tips", build.hidden_emitter, (POSITION, NORMAL), 0.99),
)


# -- measuring ---------------------------------------------------------------------------------------------------------


def prepare(scene):
    """A camera above, one sample through each pixel's centre, nothing but what the surfaces emit."""
    if scene.camera is None:
        camera = put(scene, bpy.data.cameras.new("Camera"), "Camera", location=(0.013, -0.007, 5))
        camera.rotation_euler = (0.004, 0.003, 0.011)  # so that no ray goes through an edge
        scene.camera = camera
    render = scene.render
    render.threads_mode, render.threads = "FIXED", 1
    render.resolution_x, render.resolution_y, render.resolution_percentage = 80, 60, 100
    scene.world = bpy.data.worlds.new("World")
    if scene.world.node_tree is None:  # before 5.0
        scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0
    match(scene)
    scene.zraka.method, scene.zraka.samples, scene.cycles.samples = "RAYCAST", 1, 1
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "GAUSSIAN", 0.01
    if hasattr(scene, "cycles_curves"):
        scene.cycles_curves.shape = "THICK"


def measure(scene, case):
    """Share of the pixels that agree, least over what is shown; greatest difference in those; messages of Zraka."""
    prepare(scene)
    case.build(scene)
    layer, least, most, messages = scene.view_layers[0], 1.0, 0.0, []
    for node_type, socket, *settings in case.shown or ((None, None),):
        layer.material_override = None if node_type is None else shows(node_type, socket, **dict(settings))
        with watched() as seen:
            ours, _ = operate(scene, "ZRAKA")
        theirs, _ = operate(scene, "CYCLES")
        if not (theirs.any() and ours.any()):
            raise AssertionError(f"{case.item}: {node_type} {socket} shows nothing ({theirs.max()}, {ours.max()})")
        apart = np.abs(ours - theirs).max(axis=-1)
        share = float((apart <= TOLERANCE).mean())
        least = min(least, share)
        most = max(most, float(apart[apart <= TOLERANCE].max()))
        messages += seen.messages
    layer.material_override = None
    return least, most, messages
