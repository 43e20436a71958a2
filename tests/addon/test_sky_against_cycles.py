# SPDX-License-Identifier: GPL-3.0-or-later
"""Worlds with a Sky Texture, as Cycles shows them and as they light a floor."""

from __future__ import annotations

import math

import bpy
import mathutils
import numpy as np
import pytest

from zraka.addon.bench.engines import match, operate

SIZE = 48
SCATTERING = ("SINGLE_SCATTERING", "MULTIPLE_SCATTERING") if bpy.app.version >= (5, 0) else ("NISHITA",)
SKIES = {
    "defaults": {},
    "noon": {"sun_elevation": math.radians(60), "sun_rotation": math.radians(200), "altitude": 2000.0},
    "dusk": {"sun_elevation": math.radians(-3), "sun_rotation": math.radians(-30)},
}
FORMULAS = {"PREETHAM": {"sun_direction": (0.6, 0.3, 0.74)}, "HOSEK_WILKIE": {"sun_direction": (0.8, 0.0, 0.1)}}
VIEWS = {"sun": (100, 0, 0), "zenith": (180, 0, 40), "ground": (60, 20, 200)}


@pytest.fixture
def scene(blender_scene, add_camera):
    """A camera with a wide lens in an empty world."""
    camera = add_camera(blender_scene, height=0.0)
    camera.data.sensor_width, camera.data.lens = 36.0, 12.0
    blender_scene.render.resolution_x = blender_scene.render.resolution_y = SIZE
    return blender_scene


def show(scene, kind, **settings):
    """Make the world show a sky."""
    scene.world = bpy.data.worlds.new("World")
    if scene.world.node_tree is None:
        scene.world.use_nodes = True
    tree = scene.world.node_tree
    tree.nodes.clear()
    names = ("ShaderNodeTexSky", "ShaderNodeBackground", "ShaderNodeOutputWorld")
    texture, background, output = (tree.nodes.new(name) for name in names)
    texture.sky_type = kind
    for name, value in settings.items():
        setattr(texture, name, value)
    tree.links.new(texture.outputs["Color"], background.inputs["Color"])
    tree.links.new(background.outputs[0], output.inputs["Surface"])


def seen_by_both(scene):
    """What rays through the pixels' centres see of Zraka's world and of Cycles', (H, W, 3), without noise."""
    scene.zraka.samples = 1
    match(scene)
    scene.zraka.method = "RAYCAST"  # whose first sample is in the centre
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "GAUSSIAN", 0.01
    return [operate(scene, engine)[0] for engine in ("ZRAKA", "CYCLES")]


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("sky", SKIES)
@pytest.mark.parametrize("kind", SCATTERING)
def test_simulated_sky(scene, kind, sky, view):
    show(scene, kind, sun_disc=False, **SKIES[sky])
    compare(scene, view)


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("kind", FORMULAS)
def test_sky_by_formula(scene, kind, view):
    show(scene, kind, **FORMULAS[kind])
    compare(scene, view)


def compare(scene, view):
    """Assert that the brightest channel of every pixel agrees, and the others beside it."""
    scene.camera.rotation_euler = [math.radians(a) for a in VIEWS[view]]
    ours, theirs = seen_by_both(scene)
    apart = np.abs(ours - theirs) / np.maximum(theirs.max(axis=-1, keepdims=True), 1e-6)
    print(f"largest relative difference {apart.max():.1e}, mean {apart.mean():.1e}")
    assert apart.max() < 0.015 and apart.mean() < 0.002


@pytest.mark.parametrize(
    ("elevation", "rotation", "size"), [(15, 0, 0.545), (50, 70, 2.0), (30, -40, 10.0), (0.1, 200, 0.545)]
)
@pytest.mark.parametrize("kind", SCATTERING)
def test_disc_of_the_sun(scene, kind, elevation, rotation, size):
    """Cycles rounds the solid angle of a small sun, by 0.13% at the usual size."""
    elevation, rotation, size = (math.radians(a) for a in (elevation, rotation, size))
    show(scene, kind, sun_elevation=elevation, sun_rotation=rotation, sun_size=size, sun_intensity=0.7)
    across = math.cos(elevation)
    axis = mathutils.Vector((across * math.sin(rotation), across * math.cos(rotation), math.sin(elevation)))
    scene.camera.rotation_euler = axis.to_track_quat("-Z", "Y").to_euler()
    scene.camera.data.angle = 1.3 * size
    ours, theirs = seen_by_both(scene)
    total = ours.sum(axis=(0, 1)) / np.maximum(theirs.sum(axis=(0, 1)), 1e-6)
    print(f"irradiance over Cycles' {total}")
    np.testing.assert_allclose(total[:2], 1.0, atol=0.003)
    disc = theirs[..., 0] > 0.1 * theirs.max()
    assert disc.mean() > 0.15
    far = np.abs(ours - theirs)[disc].max(axis=-1) > 0.01 * theirs[disc].max(axis=-1)
    assert far.mean() < 0.02


def floor(scene):
    """A white plane that fills the picture."""
    bpy.ops.mesh.primitive_plane_add(size=2)
    material = bpy.data.materials.new("White")
    if material.node_tree is None:
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    surface, output = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeOutputMaterial")
    surface.inputs["Color"].default_value = (1, 1, 1, 1)
    tree.links.new(surface.outputs[0], output.inputs["Surface"])
    bpy.context.object.data.materials.append(material)
    scene.camera.location.z, scene.camera.rotation_euler = 3.0, (0, 0, 0)
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 1.8
    scene.render.resolution_x = scene.render.resolution_y = 16
    scene.zraka.depth = 2


@pytest.mark.parametrize("disc", [True, False])
@pytest.mark.parametrize("kind", SCATTERING)
def test_light_on_a_floor(scene, kind, disc):
    show(scene, kind, sun_disc=disc)
    floor(scene)
    scene.zraka.samples = 256
    match(scene)
    ours, theirs = (operate(scene, engine)[0] for engine in ("ZRAKA", "CYCLES"))
    ratio = ours.mean(axis=(0, 1)) / theirs.mean(axis=(0, 1))
    noise = [float(p[..., 1].std() / p[..., 1].mean()) for p in (ours, theirs)]
    print(f"over Cycles' {ratio}; noise {noise[0]:.1e}, of Cycles {noise[1]:.1e}")
    np.testing.assert_allclose(ratio, 1.0, atol=0.003)
    assert noise[0] < max(4 * noise[1], 0.01)
