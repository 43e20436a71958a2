# SPDX-License-Identifier: GPL-3.0-or-later
"""What the sample scenes are put together from: meshes, materials, lights, cameras, and a file that two engines render.

Only calls that Blender 4.2 to 5.2 share are used, so that the files can be made by any of them.
"""

from __future__ import annotations

import math
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix, Vector

import zraka

CUBE_FACES = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (2, 3, 7, 6), (1, 2, 6, 5), (3, 0, 4, 7))
CUBE_VERTICES = ((-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1), (-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1))
UNIT_SQUARE = ((0, 0), (1, 0), (1, 1), (0, 1))


# -- the file ----------------------------------------------------------------------------------------------------------


def new_file(width, height, samples, depth, view="Standard", about="", **overrides):
    """Start an empty scene that Zraka renders, with Cycles set alike.

    Parameters
    ----------
    depth : int
        Hits along a path; Cycles is given one bounce less.
    view : str
        View transform of the PNG.
    about : str
        Kept in the file as a text.
    **overrides
        Of the classic methods: reflectivity, exponent, ambient...
    """
    bpy.ops.wm.read_factory_settings(use_empty=True)
    zraka.register()
    scene = bpy.context.scene
    scene.render.engine = "ZRAKA"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, height, 100
    scene.view_settings.view_transform = view
    scene.display_settings.display_device = "sRGB"
    scene.zraka.method, scene.zraka.samples, scene.zraka.depth = "PATHTRACE", samples, depth
    for name, value in overrides.items():
        setattr(scene.zraka, f"use_{name}", True)
        setattr(scene.zraka, name, value)
    _match_cycles(scene, samples, depth - 1)
    if about:
        bpy.data.texts.new("About").write(about.strip() + "\n")
    return scene


def _match_cycles(scene, samples, bounces):
    """Set Cycles to the same light transport: no clamping, no blurring, a box filter of one pixel."""
    scene.render.film_transparent = False
    cycles = scene.cycles
    cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising = samples, False, False
    for kind in ("max", "diffuse", "glossy", "transmission"):
        setattr(cycles, f"{kind}_bounces", bounces)
    cycles.transparent_max_bounces = 8
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.blur_glossy, cycles.light_sampling_threshold = 0.0, 0.0
    cycles.pixel_filter_type, cycles.filter_width = "BOX", 1.0


def save(path):
    """Write the scene, compressed, without what nothing uses."""
    bpy.ops.outliner.orphans_purge(do_recursive=True)
    bpy.context.preferences.filepaths.save_version = 0
    bpy.ops.wm.save_as_mainfile(filepath=str(Path(path).resolve()), compress=True)


# -- objects -----------------------------------------------------------------------------------------------------------


def link(name, data, location=(0, 0, 0), rotation=(0, 0, 0), scale=(1, 1, 1)):
    """An object in the scene; `rotation` XYZ in degrees."""
    thing = bpy.data.objects.new(name, data)
    thing.location, thing.scale = location, scale
    thing.rotation_euler = [math.radians(angle) for angle in rotation]
    bpy.context.scene.collection.objects.link(thing)
    return thing


def mesh(name, vertices, faces, materials=(), uvs=None, smooth=False, material_of_face=None):
    """A mesh; `uvs` lists one pair for each corner, in the order of the faces."""
    data = bpy.data.meshes.new(name)
    data.from_pydata([tuple(map(float, v)) for v in vertices], [], [tuple(f) for f in faces])
    for material in materials:
        data.materials.append(material)
    if material_of_face is not None:
        data.polygons.foreach_set("material_index", material_of_face)
    if uvs is not None:
        data.uv_layers.new(name="UVMap").data.foreach_set("uv", np.asarray(uvs, np.float32).ravel())
    data.polygons.foreach_set("use_smooth", [smooth] * len(data.polygons))
    data.update()
    return data


def quad(name, corners, material, uv_scale=None, **place):
    """A rectangle with its front where `corners` run counter-clockwise; `uv_scale` repeats its texture."""
    uvs = None if uv_scale is None else [(u * uv_scale[0], v * uv_scale[1]) for u, v in UNIT_SQUARE]
    return link(name, mesh(name, corners, [(0, 1, 2, 3)], [material], uvs), **place)


def box(name, size, location, material, rotation_z=0.0):
    """A box of full side lengths `size` about `location`."""
    half = [s / 2 for s in size]
    vertices = [[c * h for c, h in zip(corner, half, strict=True)] for corner in CUBE_VERTICES]
    data = mesh(name, vertices, CUBE_FACES, [material], UNIT_SQUARE * 6)
    return link(name, data, location, (0, 0, rotation_z))


def ball(name, radius, location, material, levels=5):
    """A smooth sphere: a cube, subdivided and cast to a sphere by modifiers."""
    data = mesh(name, CUBE_VERTICES, CUBE_FACES, [material], smooth=True)
    thing = link(name, data, location)
    smoother = thing.modifiers.new("Subdivision", "SUBSURF")
    smoother.levels = smoother.render_levels = levels
    caster = thing.modifiers.new("Cast", "CAST")
    caster.factor, caster.radius, caster.size, caster.use_radius_as_size = 1.0, 0.0, radius, False
    return thing


def lathe(name, profile, location, material, segments=48):
    """A smooth surface of revolution about Z through `profile`, pairs of radius and height from below to above."""
    angles = [2 * math.pi * i / segments for i in range(segments)]
    vertices = [(r * math.cos(a), r * math.sin(a), z) for r, z in profile for a in angles]
    faces = [
        (row + i, row + (i + 1) % segments, row + segments + (i + 1) % segments, row + segments + i)
        for row in range(0, (len(profile) - 1) * segments, segments)
        for i in range(segments)
    ]
    return link(name, mesh(name, vertices, faces, [material], smooth=True), location)


# -- lights, world, camera ---------------------------------------------------------------------------------------------


def light(name, kind, energy, location=(0, 0, 0), target=None, color=(1, 1, 1), **properties):
    """A light that looks at `target`; `properties` as Blender names them, e.g. ``angle=``, ``shadow_soft_size=``."""
    data = bpy.data.lights.new(name, kind)
    data.energy, data.color = energy, color
    for key, value in properties.items():
        setattr(data, key, value)
    thing = link(name, data, location)
    if target is not None:
        aim(thing, target)
    return thing


def world(color, strength=1.0):
    """A world of one colour."""
    data = bpy.data.worlds.new("World")
    bpy.context.scene.world = data
    tree = _tree(data)
    background = tree.nodes.new("ShaderNodeBackground")
    background.inputs["Color"].default_value = (*color, 1)
    background.inputs["Strength"].default_value = strength
    output = tree.nodes.new("ShaderNodeOutputWorld")
    tree.links.new(background.outputs["Background"], output.inputs["Surface"])


def camera(location, target=None, fov=50.0, matrix=None):
    """A perspective camera; `fov` in degrees across the longer side, aimed by `target` or placed by `matrix`."""
    data = bpy.data.cameras.new("Camera")
    data.lens_unit, data.sensor_fit = "FOV", "AUTO"
    data.angle = math.radians(fov)
    thing = link("Camera", data, location)
    if matrix is not None:
        thing.matrix_world = matrix
    else:
        aim(thing, target)
    bpy.context.scene.camera = thing
    return thing


def aim(thing, target):
    """Turn -Z of a camera or light towards `target`, +Y up."""
    thing.rotation_euler = (Vector(target) - thing.location).to_track_quat("-Z", "Y").to_euler()


def thesis_to_blender(location=(0, 0, 0), rotation=None):
    """Placement in the thesis' Y-up world, as a matrix of Blender's Z-up world: (x, y, z) becomes (x, -z, y)."""
    local = Matrix.Translation(location) @ (rotation or Matrix())
    return Matrix.Rotation(math.radians(90), 4, "X") @ local


# -- materials ---------------------------------------------------------------------------------------------------------


def _tree(owner):
    """The emptied node tree of a material or world; before Blender 5 it has to be switched on."""
    if bpy.app.version < (5, 0):
        owner.use_nodes = True
    owner.node_tree.nodes.clear()
    return owner.node_tree


def material(name, build):
    """A material; `build(tree)` makes the nodes and returns the socket of the surface."""
    data = bpy.data.materials.new(name)
    tree = _tree(data)
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(build(tree), output.inputs["Surface"])
    return data


def node(tree, kind, output=0, properties=None, **inputs):
    """A node and one of its outputs; an input is a value or another node's socket, blanks in its name as `_`."""
    new = tree.nodes.new(kind)
    for key, value in (properties or {}).items():
        setattr(new, key, value)
    for key, value in inputs.items():
        socket = new.inputs[int(key[1:]) if key[1:].isdigit() else key.replace("_", " ")]
        if isinstance(value, bpy.types.NodeSocket):
            tree.links.new(value, socket)
        else:
            socket.default_value = (*value, 1) if isinstance(value, tuple) and len(socket.default_value) == 4 else value
    return new.outputs[output]


def diffuse(name, color):
    """Lambert reflection."""
    return material(name, lambda tree: node(tree, "ShaderNodeBsdfDiffuse", Color=color))


def glossy(name, color, roughness=0.0):
    """A mirror, or single-scattering GGX."""
    ggx = {"distribution": "GGX"}
    return material(
        name,
        lambda tree: node(tree, "ShaderNodeBsdfAnisotropic", properties=ggx, Color=color, Roughness=roughness),
    )


def glass(name, ior=1.5, color=(1, 1, 1), roughness=0.0):
    """A dielectric boundary."""
    ggx = {"distribution": "GGX"}
    return material(
        name,
        lambda tree: node(tree, "ShaderNodeBsdfGlass", properties=ggx, Color=color, Roughness=roughness, IOR=ior),
    )


def emission(name, color, strength):
    """A glowing surface."""
    return material(name, lambda tree: node(tree, "ShaderNodeEmission", Color=color, Strength=strength))


def coated(name, color, share, roughness):
    """`share` of a white glossy reflection over Lambert reflection: what the classic methods call reflectivity."""

    def build(tree):
        base = node(tree, "ShaderNodeBsdfDiffuse", Color=color)
        ggx = {"distribution": "GGX"}
        coat = node(tree, "ShaderNodeBsdfAnisotropic", properties=ggx, Color=(1.0, 1.0, 1.0), Roughness=roughness)
        return node(tree, "ShaderNodeMixShader", _0=share, _1=base, _2=coat)

    return material(name, build)


def principled(name, color, roughness=0.5, metallic=0.0, **inputs):
    """The Principled BSDF with single-scattering GGX; `color` may be an image, put on the active UV map."""

    def build(tree):
        base = color
        if isinstance(color, bpy.types.Image):
            base = node(tree, "ShaderNodeTexImage", properties={"image": color})
        return node(
            tree,
            "ShaderNodeBsdfPrincipled",
            properties={"distribution": "GGX"},
            Base_Color=base,
            Roughness=roughness,
            Metallic=metallic,
            **inputs,
        )

    return material(name, build)


def checker(name, first, second, scale):
    """Lambert reflection of a checker texture on the UV map."""

    def build(tree):
        uv = node(tree, "ShaderNodeTexCoord", "UV")
        color = node(tree, "ShaderNodeTexChecker", Vector=uv, Color1=first, Color2=second, Scale=scale)
        return node(tree, "ShaderNodeBsdfDiffuse", Color=color)

    return material(name, build)


def image(name, pixels):
    """A packed sRGB image of (H, W, 3) floats in [0, 1], row 0 at the bottom."""
    height, width = pixels.shape[:2]
    data = bpy.data.images.new(name, width, height)
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :3] = np.round(np.clip(pixels, 0, 1) * 31) / 31
    data.pixels.foreach_set(rgba.ravel())
    data.update()
    data.pack()
    return data
