# SPDX-License-Identifier: GPL-3.0-or-later
"""Worlds that show pictures, as Cycles shows them."""

from __future__ import annotations

import math
from pathlib import Path

import bpy
import numpy as np
import pytest

from zraka.addon.bench.engines import match, operate

from ..reference import agreement, pictures, power

SIZE = 96


@pytest.fixture
def scene(blender_scene, add_camera):
    """A camera with a wide lens in an empty world."""
    camera = add_camera(blender_scene, height=0.0)
    camera.data.sensor_width, camera.data.lens = 36.0, 12.0
    blender_scene.render.resolution_x = blender_scene.render.resolution_y = SIZE
    return blender_scene


def picture(width, height, seed=0, colorspace="Linear Rec.709", float_buffer=True, smooth=1):
    """A packed image of random texels, in which neighbours may be alike."""
    rng = np.random.default_rng(seed)
    coarse = rng.random((height // smooth, width // smooth, 3))
    pixels = np.ones((height, width, 4), np.float32)
    pixels[..., :3] = np.repeat(np.repeat(coarse, smooth, 0), smooth, 1)
    image = bpy.data.images.new("Sky", width, height, alpha=False, float_buffer=float_buffer)
    image.colorspace_settings.name = colorspace
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    image.pack()
    return image


def show(scene, image, strength=1.0, mapping=None, **settings):
    """Make the world show `image`."""
    scene.world = bpy.data.worlds.new("World")
    tree = scene.world.node_tree
    if tree is None:
        scene.world.use_nodes = True
        tree = scene.world.node_tree
    tree.nodes.clear()
    names = ("ShaderNodeTexEnvironment", "ShaderNodeBackground", "ShaderNodeOutputWorld")
    texture, background, output = (tree.nodes.new(name) for name in names)
    texture.image = image
    background.inputs["Strength"].default_value = strength
    for name, value in settings.items():
        setattr(texture, name, value)
    tree.links.new(texture.outputs["Color"], background.inputs["Color"])
    tree.links.new(background.outputs[0], output.inputs["Surface"])
    if mapping:
        node, source = tree.nodes.new("ShaderNodeMapping"), tree.nodes.new("ShaderNodeTexCoord")
        node.vector_type = mapping.pop("vector_type", "POINT")
        for name, value in mapping.items():
            node.inputs[name].default_value = value
        tree.links.new(source.outputs["Generated"], node.inputs["Vector"])
        tree.links.new(node.outputs["Vector"], texture.inputs["Vector"])
    return tree


def seen_by(scene, engine):
    """What rays through the pixels' centres see, (H, W, 3), without noise."""
    scene.zraka.samples = 1
    match(scene)
    scene.zraka.method = "RAYCAST"  # whose first sample is in the centre
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "GAUSSIAN", 0.01
    return operate(scene, engine)[0]


VIEWS = {"+x": (90, 0, -90), "-x": (90, 0, 90), "up": (180, 0, 30), "down": (0, 0, 0), "askew": (60, 20, 200)}
MAPPINGS = {
    "point": {"Location": (0.1, 0.2, 0.3), "Rotation": (0.3, -0.5, 1.2), "Scale": (1.0, 0.5, 2.0)},
    "texture": {
        "vector_type": "TEXTURE",
        "Location": (0.1, 0.2, 0.3),
        "Rotation": (0.3, -0.5, 1.2),
        "Scale": (1, 2, 3),
    },
    "vector": {"vector_type": "VECTOR", "Rotation": (0, 0.4, 2.0), "Scale": (-1, 1, 1)},
    "normal": {"vector_type": "NORMAL", "Rotation": (1.0, 0, 0), "Scale": (2, 1, 1)},
}


def compare(scene, view, share=1.0, tolerance=1e-3):
    """Assert that all but a small share of pixels agree: float32 directions choose other texels at seams."""
    scene.camera.rotation_euler = [math.radians(a) for a in VIEWS[view]]
    ours, theirs = (seen_by(scene, engine) for engine in ("ZRAKA", "CYCLES"))
    assert theirs.std() > 0.01
    difference = np.abs(ours - theirs) / np.maximum(theirs, 1)
    wrong = difference.max(axis=-1) > tolerance
    print(f"largest difference {difference.max():.2e}, {wrong.mean():.2%} above {tolerance}")
    assert wrong.mean() <= 1 - share


@pytest.mark.parametrize("view", VIEWS)
def test_equirectangular(scene, view):
    show(scene, picture(64, 32), 1.5)
    compare(scene, view)


@pytest.mark.parametrize("view", ["+x", "askew", "down"])
def test_mirror_ball(scene, view):
    show(scene, picture(64, 64), projection="MIRROR_BALL")
    compare(scene, view)


@pytest.mark.parametrize("kind", MAPPINGS)
def test_mapping(scene, kind):
    show(scene, picture(64, 32), mapping=dict(MAPPINGS[kind]))
    compare(scene, "askew")


def test_nearest_texel(scene):
    show(scene, picture(64, 32), interpolation="Closest")
    compare(scene, "askew", share=0.999)


def test_bytes_are_interpolated_as_stored(scene):
    show(scene, picture(32, 16, colorspace="sRGB", float_buffer=False))
    compare(scene, "askew")


def test_a_file_of_half_floats(scene):
    """One of those that come with Blender."""
    folder = Path(bpy.utils.system_resource("DATAFILES")) / "studiolights/world"
    image = bpy.data.images.load(str(folder / "forest.exr"))
    show(scene, image)
    compare(scene, "askew")


def hdr_sky():
    """A picture of a sky with a sun a thousand times as bright, above a dim ground."""
    width, height = 256, 128
    theta = math.pi * (1 - (np.arange(height)[:, None] + 0.5) / height)
    phi = math.pi - 2 * math.pi * (np.arange(width)[None, :] + 0.5) / width
    up = np.cos(theta)
    sky = np.where(up > 0, 0.3 + 0.7 * (1 - up) ** 3, 0.05)
    towards_sun = np.sin(theta) * math.sin(1.0) * np.cos(phi + 0.6) + up * math.cos(1.0)
    pixels = np.ones((height, width, 4), np.float32)
    pixels[..., :3] = sky[..., None] * (0.5, 0.7, 1.0) + 1000 * (towards_sun > math.cos(0.03))[..., None] * (
        1,
        0.9,
        0.7,
    )
    image = bpy.data.images.new("HDR", width, height, alpha=False, float_buffer=True)
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    image.pack()
    return image


def glossy_ball_on_a_floor(scene):
    """A diffuse plane, a rough metal ball and a diffuse one."""
    bpy.ops.mesh.primitive_plane_add(size=6)
    things = [bpy.context.object]
    for x in (-0.8, 0.8):
        bpy.ops.mesh.primitive_uv_sphere_add(radius=0.7, segments=48, ring_count=24, location=(x, 0, 0.7))
        bpy.ops.object.shade_smooth()
        things.append(bpy.context.object)
    for thing, kind, color in zip(things, ("Diffuse", "Glossy", "Diffuse"), (0.5, 0.9, 0.7), strict=True):
        material = bpy.data.materials.new(kind)
        if material.node_tree is None:
            material.use_nodes = True
        tree = material.node_tree
        tree.nodes.clear()
        surface, output = tree.nodes.new(f"ShaderNodeBsdf{kind}"), tree.nodes.new("ShaderNodeOutputMaterial")
        surface.inputs["Color"].default_value = (color, color * 0.9, color * 0.8, 1)
        if kind == "Glossy":
            surface.distribution, surface.inputs["Roughness"].default_value = "GGX", 0.4
        tree.links.new(surface.outputs[0], output.inputs["Surface"])
        thing.data.materials.append(material)
    scene.camera.location, scene.camera.rotation_euler = (0, -5, 2.5), (math.radians(68), 0, 0)
    scene.camera.data.lens = 35


@pytest.mark.slow
def test_diffuse_and_glossy_things_under_a_sky_with_a_sun(scene):
    show(scene, hdr_sky(), mapping={"Rotation": (0.0, 0.0, 0.5)})
    glossy_ball_on_a_floor(scene)
    scene.zraka.depth = 4
    ours, theirs = (pictures(scene, engine, 512, 4) for engine in ("ZRAKA", "CYCLES"))
    share, told = agreement(ours, theirs), power(ours, theirs)
    print(f"{share:.1%} of the blocks agree, {told:.0%} would tell a shift of 5%, {ours.mean() / theirs.mean():.4f}")
    assert share >= 0.99 and told > 0.5
