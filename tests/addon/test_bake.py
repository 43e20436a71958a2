# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's bake operator, against Cycles by the same operator."""

import warnings

import bpy
import numpy as np
import pytest

from zraka.addon import headless
from zraka.addon.bench.engines import match

SIDE = 32
LIT = {"DIRECT", "INDIRECT", "COLOR"}


def material(name, kind, **inputs):
    made = bpy.data.materials.new(name)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    node, output = tree.nodes.new(f"ShaderNode{kind}"), tree.nodes.new("ShaderNodeOutputMaterial")
    node.name = "BSDF"
    tree.links.new(node.outputs[0], output.inputs[0])
    for key, value in inputs.items():
        node.inputs[key].default_value = value
    return made


@pytest.fixture
def ball(blender_scene, add_camera):
    """A smooth ball over a floor, beside a shining box, under a lamp and a sky; it is selected."""
    scene = blender_scene
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    bpy.ops.mesh.primitive_uv_sphere_add(radius=1, segments=24, ring_count=12, location=(0, 0, 1.1))
    made = bpy.context.object
    made.name = "Ball"
    for polygon in made.data.polygons:
        polygon.use_smooth = True
    paint = material("paint", "BsdfPrincipled", Roughness=0.4, **{"Base Color": (0.6, 0.7, 0.2, 1)})
    made.data.materials.append(paint)
    bpy.ops.mesh.primitive_plane_add(size=8)
    bpy.context.object.data.materials.append(material("floor", "BsdfDiffuse", Color=(0.8, 0.3, 0.2, 1)))
    bpy.ops.mesh.primitive_cube_add(size=1, location=(1.7, 0, 0.8))
    bpy.context.object.data.materials.append(material("box", "Emission", Color=(0.3, 0.6, 1, 1), Strength=3.0))
    lamp = bpy.data.lights.new("Lamp", "AREA")
    lamp.energy, lamp.size = 150, 1
    lamp = bpy.data.objects.new("Lamp", lamp)
    lamp.location, lamp.rotation_euler = (0, -2, 4), (0.45, 0, 0)
    scene.collection.objects.link(lamp)
    scene.world = bpy.data.worlds.new("Sky")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs[0].default_value = (0.2, 0.3, 0.5, 1)
    add_camera(scene, height=6.0)
    select(made)
    return made


def select(*objects):
    """Select objects, the last of which becomes active."""
    for obj in bpy.context.selected_objects:
        obj.select_set(False)
    for obj in objects:
        obj.select_set(True)
    bpy.context.view_layer.objects.active = objects[-1]


def baked(engine, kind, samples=1, side=SIDE, **options):
    """Pixels (H, W, 4) that `engine` bakes on the active object."""
    scene, obj = bpy.context.scene, bpy.context.object
    scene.zraka.samples = samples
    match(scene)
    scene.render.engine = engine
    picture = bpy.data.images.new("baked", side, side, alpha=True, float_buffer=True)
    tree = obj.active_material.node_tree
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image, tree.nodes.active = picture, node
    try:
        with headless.quiet():
            bpy.ops.object.bake(type=kind, margin=0, **options)
        return np.array(picture.pixels[:], np.float32).reshape(side, side, 4)
    finally:
        tree.nodes.remove(node)
        bpy.data.images.remove(picture)


def both(kind, **options):
    """Cycles' and Zraka's colours (P, 3) of the texels that are covered."""
    theirs, ours = (baked(engine, kind, **options) for engine in ("CYCLES", "ZRAKA"))
    covered = ours.any(axis=2)
    assert covered.mean() > 0.8
    return theirs[covered][:, :3], ours[covered][:, :3]


def block_means(colors):
    """Means of 4 runs of texels, (4, 3)."""
    return np.array([part.mean(axis=0) for part in np.array_split(colors, 4)])


def bump(obj):
    """Give an object's material a bumpy surface of many colours."""
    tree = obj.active_material.node_tree
    noise, bumpy, bsdf = tree.nodes.new("ShaderNodeTexNoise"), tree.nodes.new("ShaderNodeBump"), tree.nodes["BSDF"]
    bumpy.inputs["Distance"].default_value = 0.3
    tree.links.new(noise.outputs[0], bumpy.inputs["Height"])
    tree.links.new(bumpy.outputs[0], bsdf.inputs["Normal"])
    tree.links.new(noise.outputs[1], bsdf.inputs["Base Color"])


# -- what needs no light -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("space", ["TANGENT", "OBJECT"])
@pytest.mark.parametrize("mirrored", [False, True])
def test_normals_are_those_of_cycles(ball, space, mirrored):
    bump(ball)
    if mirrored:
        ball.scale = -1, 1.3, 0.8
    theirs, ours = both("NORMAL", normal_space=space)
    assert np.abs(theirs - ours).max() < 1 / 255
    assert ours.std(axis=0).max() > 0.02


def test_normals_stay_with_more_samples(ball):
    for space in ("TANGENT", "OBJECT"):
        one, many = (baked("ZRAKA", "NORMAL", samples=samples, normal_space=space) for samples in (1, 64))
        assert np.abs(one - many).max() < 1 / 255


@pytest.mark.parametrize("kind", ["POSITION", "EMIT", "ROUGHNESS", "ENVIRONMENT", "DIFFUSE", "GLOSSY"])
def test_facts_are_those_of_cycles(ball, kind):
    bsdf = ball.active_material.node_tree.nodes["BSDF"]
    bsdf.inputs["Emission Color"].default_value = (1, 0.5, 0.2, 1)
    bsdf.inputs["Emission Strength"].default_value = 2.0
    bump(ball)
    theirs, ours = both(kind, **({"pass_filter": {"COLOR"}} if kind in {"DIFFUSE", "GLOSSY"} else {}))
    np.testing.assert_allclose(ours, theirs, atol=2e-3)
    assert ours.any()


def test_uv_is_where_the_texel_is(ball):
    """Cycles' picture is black where no material reads the map."""
    picture = baked("ZRAKA", "UV")
    covered = picture[..., 2] == 1
    rows, columns = np.nonzero(covered)
    np.testing.assert_allclose(picture[covered][:, 0], (columns + 0.5) / SIDE, atol=1e-3)
    np.testing.assert_allclose(picture[covered][:, 1], (rows + 0.5) / SIDE, atol=1e-3)


# -- light -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kind", "parts"),
    [
        ("COMBINED", LIT | {"DIFFUSE", "GLOSSY", "TRANSMISSION", "EMIT"}),
        ("COMBINED", {"DIRECT", "DIFFUSE", "EMIT"}),
        ("DIFFUSE", LIT),
        ("DIFFUSE", {"DIRECT"}),
        ("GLOSSY", {"DIRECT", "COLOR"}),
        ("AO", set()),
    ],
)
def test_light_is_that_of_cycles(ball, kind, parts):
    theirs, ours = both(kind, samples=128, **({"pass_filter": parts} if parts else {}))
    expected = block_means(theirs)
    np.testing.assert_allclose(block_means(ours), expected, atol=0.02 * expected.max())


def test_what_is_compared_can_differ(ball):
    """Indirect light alone is far more than the room that the comparison leaves."""
    without, all_of_it = (
        block_means(baked("ZRAKA", "DIFFUSE", samples=16, pass_filter=parts)[..., :3].reshape(-1, 3))
        for parts in ({"DIRECT", "COLOR"}, LIT)
    )
    assert np.abs(all_of_it - without).max() > 0.1 * all_of_it.max()


def test_transparency_becomes_alpha(ball):
    """What is seen through the surface is not on it."""
    ball.active_material.node_tree.nodes["BSDF"].inputs["Alpha"].default_value = 0.25
    theirs, ours = (baked(engine, "COMBINED", samples=64) for engine in ("CYCLES", "ZRAKA"))
    np.testing.assert_allclose(ours.mean(axis=(0, 1)), theirs.mean(axis=(0, 1)), rtol=0.05)
    assert ours[..., 3].max() < 0.5


def test_the_camera_sees_gloss_from_its_side(ball):
    above = baked("ZRAKA", "GLOSSY", samples=64, pass_filter={"DIRECT"})[..., :3]
    bpy.context.scene.render.bake.view_from = "ACTIVE_CAMERA"
    ours = baked("ZRAKA", "GLOSSY", samples=64, pass_filter={"DIRECT"})[..., :3]
    assert np.abs(ours - above).mean() > 0.05
    # Engines sample texels that reach beyond their triangle otherwise; of large ones that is 4% of a highlight.
    theirs, ours = (
        baked(engine, "GLOSSY", samples=16, side=4 * SIDE, pass_filter={"DIRECT"})[..., :3].mean(axis=(0, 1))
        for engine in ("CYCLES", "ZRAKA")
    )
    np.testing.assert_allclose(ours, theirs, rtol=0.02)


# -- the operator ------------------------------------------------------------------------------------------------------


def test_selected_to_active(ball):
    """Two objects onto a plane above them."""
    bpy.ops.mesh.primitive_torus_add(location=(-0.9, 0, 1.5))
    torus = bpy.context.object
    torus.data.materials.append(material("ring", "Emission", Color=(0.1, 0.9, 0.4, 1)))
    bpy.ops.mesh.primitive_plane_add(size=4, location=(0, 0, 2.5))
    target = bpy.context.object
    target.data.materials.append(material("target", "BsdfDiffuse"))
    select(ball, torus, target)
    options = {"use_selected_to_active": True, "cage_extrusion": 0.1}
    for kind in ("NORMAL", "EMIT"):
        theirs, ours = (baked(engine, kind, **options) for engine in ("CYCLES", "ZRAKA"))
        assert np.abs(theirs - ours)[..., :3].max() < 1 / 255
        assert ours[..., :3].std() > 0.01


def test_vertex_colors(ball):
    layer = ball.data.color_attributes.new("baked", "FLOAT_COLOR", "POINT")
    found = []
    for engine in ("CYCLES", "ZRAKA"):
        bpy.context.scene.zraka.samples = 16
        match(bpy.context.scene)
        bpy.context.scene.render.engine = engine
        with headless.quiet():
            bpy.ops.object.bake(type="DIFFUSE", target="VERTEX_COLORS", pass_filter={"COLOR"})
        values = np.zeros(4 * len(layer.data), np.float32)
        layer.data.foreach_get("color", values)
        found.append(values)
    np.testing.assert_allclose(found[1], found[0], atol=1e-3)


def test_without_camera_and_with_motion_blur(ball):
    scene = bpy.context.scene
    scene.camera, scene.render.use_motion_blur = None, True
    assert baked("ZRAKA", "AO", samples=4)[..., :3].mean() > 0.2


def test_after_a_render_nothing_is_asked_of_a_render(ball):
    """Blender keeps the size of a render, calls `update` and means a bake: what a render lacks must not stop it."""
    scene = bpy.context.scene
    scene.render.engine, scene.render.resolution_x, scene.render.resolution_y = "ZRAKA", 8, 8
    with headless.quiet():
        bpy.ops.render.render()
    scene.camera = None
    assert baked("ZRAKA", "AO", samples=4)[..., :3].mean() > 0.2
    with headless.quiet(), pytest.raises(RuntimeError, match="camera"):
        bpy.ops.render.render()


def test_what_cannot_be_baked_is_said(ball):
    with pytest.raises(RuntimeError, match="does not bake shadow"):
        baked("ZRAKA", "SHADOW")


def test_an_unfinished_bake_is_not_left_open(ball, monkeypatch):
    """An error of our own becomes one sentence, and the next bake works."""
    from zraka.addon import bake

    def fails(*_):
        raise ValueError("nothing fits")

    with monkeypatch.context() as patch:
        patch.setattr(bake, "bake", fails)
        with pytest.raises(RuntimeError, match="nothing fits"):
            baked("ZRAKA", "AO")
    assert baked("ZRAKA", "AO")[..., :3].mean() > 0.2
