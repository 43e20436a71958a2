# SPDX-License-Identifier: GPL-3.0-or-later
"""Passes beside Cycles' own, and the compositor that reads them."""

import json
import warnings

import bpy
import numpy as np
import OpenImageIO as oiio
import pytest

from zraka.addon import denoise, headless, passes
from zraka.addon.bench.engines import match

SWITCHES = [switch for switch, *_ in (*passes._SWITCHED, *passes._MATTES)]
# Without light, whose samples fall anywhere in a pixel; see `test_light_passes`.
DATA = [s for s in SWITCHES if not s.endswith(("_direct", "_indirect", "_ambient_occlusion"))]
NOT_OF_CYCLES = {"Error"}


def enable(view_layer, switches=SWITCHES):
    """Switch on passes, and the data for denoisers, in both engines."""
    for switch in switches:
        setattr(view_layer, switch, True)
    view_layer.zraka.use_pass_denoising = view_layer.cycles.denoising_store_passes = True
    view_layer.zraka.use_pass_sample_count = view_layer.cycles.pass_debug_sample_count = True
    view_layer.zraka.use_pass_error = True


@pytest.fixture
def balls(blender_scene):
    """Balls of several materials on the ground, below a sky, one ray a pixel."""
    scene = blender_scene
    scene.render.resolution_x, scene.render.resolution_y = 96, 64
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0.3, -6.0, 1.5), (1.4, 0.0, 0.05)
    scene.collection.objects.link(camera)
    scene.camera = camera
    materials = [
        material("red", "BsdfDiffuse", 3, Color=(0.8, 0.2, 0.1, 1)),
        material("gloss", "BsdfAnisotropic", 4, Color=(0.5, 0.7, 0.9, 1), Roughness=0.4),
        material("glass", "BsdfGlass", 5, Color=(0.9, 0.8, 0.7, 1), Roughness=0.0),
        material("paint", "BsdfPrincipled", 6, **{"Base Color": (0.3, 0.6, 0.2, 1)}),
        material("lamp", "Emission", 8, Color=(1, 0.5, 0.2, 1), Strength=2.0),
    ]
    ground = add(scene, "ground", materials[0], 1, lambda: bpy.ops.mesh.primitive_plane_add(size=40))
    for k, m in enumerate(materials):
        add_ball = {"radius": 0.55, "location": (-2.4 + 1.2 * k, 0, 0.55), "segments": 64, "ring_count": 32}
        ball = add(scene, f"ball {k}", m, 10 + k, lambda a=add_ball: bpy.ops.mesh.primitive_uv_sphere_add(**a))
        for polygon in ball.data.polygons:
            polygon.use_smooth = True
        if k == 0:
            ball.parent, ball.matrix_parent_inverse = ground, ground.matrix_world.inverted()
    scene.world = bpy.data.worlds.new("Sky")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        scene.world.use_nodes = True
    mist = scene.world.mist_settings
    mist.start, mist.depth, mist.falloff = 3.0, 8.0, "QUADRATIC"
    scene.zraka.samples = 1
    match(scene)
    return scene


def material(name, kind, index, **inputs):
    made = bpy.data.materials.new(name)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        made.use_nodes = True
    made.pass_index = index
    tree = made.node_tree
    tree.nodes.clear()
    node, output = tree.nodes.new(f"ShaderNode{kind}"), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(node.outputs[0], output.inputs[0])
    for key, value in inputs.items():
        node.inputs[key].default_value = value
    return made


def add(scene, name, shown, index, operator):
    operator()
    obj = bpy.context.object
    obj.name, obj.pass_index = name, index
    obj.data.materials.append(shown)
    return obj


def rendered(scene, engine, path):
    """Render all passes: {name: {channel: (H, W)}}, row 0 at the top, and what is told of mattes."""
    scene.render.engine = engine
    kind = scene.render.image_settings
    if hasattr(kind, "media_type"):  # Blender 5
        kind.media_type = "MULTI_LAYER_IMAGE"
    kind.file_format, kind.color_depth, kind.exr_codec = "OPEN_EXR_MULTILAYER", "32", "ZIP"
    if hasattr(kind, "use_exr_interleave"):
        kind.use_exr_interleave = True
    scene.render.filepath = str(path)
    with headless.quiet():
        bpy.ops.render.render(write_still=True)
    buffer = oiio.ImageBuf(str(path))
    pixels, found = buffer.get_pixels(oiio.FLOAT), {}
    for number, channel in enumerate(buffer.spec().channelnames):
        *_, name, letter = channel.split(".")
        found.setdefault(name, {})[letter] = pixels[..., number]
    told = {a.name: a.value for a in buffer.spec().extra_attribs if a.name.startswith("cryptomatte/")}
    return found, told


def away_from_edges(index):
    """Pixels whose neighbours show the same thing."""
    inner = np.ones(index.shape, bool)
    for axis in (0, 1):
        for step in (-1, 1):
            inner &= index == np.roll(index, step, axis)
    inner[[0, -1]] = inner[:, [0, -1]] = False
    return inner


# -- names -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("levels", [2, 5, 6, 16])
def test_names_and_channels_are_those_of_cycles(blender_scene, levels):
    from cycles.engine import list_render_passes

    view_layer = blender_scene.view_layers[0]
    enable(view_layer)
    view_layer.pass_cryptomatte_depth = levels
    aov = view_layer.aovs.add()
    aov.name = "Mine"
    blender_scene.cycles.use_denoising = False
    theirs = {(name, channels, kind) for name, channels, kind in list_render_passes(blender_scene, view_layer)}
    ours = [(p.name, p.channels, p.kind) for p in passes.passes_of(view_layer)]
    assert len(ours) == len(set(ours))
    assert {p for p in ours if p[0] not in NOT_OF_CYCLES} == theirs


def test_only_the_picture_by_default(blender_scene):
    view_layer = blender_scene.view_layers[0]
    view_layer.use_pass_z = False
    assert [p.name for p in passes.passes_of(view_layer)] == ["Combined"]
    assert not passes.guides_of(bpy.context.evaluated_depsgraph_get()).names


def test_what_is_not_rendered_is_named(blender_scene):
    view_layer = blender_scene.view_layers[0]
    view_layer.use_pass_vector = view_layer.use_pass_diffuse_direct = view_layer.use_pass_shadow = True
    view_layer.aovs.add().name = "Mine"

    class Layer:
        passes = ()

    assert passes.missing_passes(Layer, view_layer) == ["Shadow"]
    direct = "Diffuse Direct" if bpy.app.version >= (5, 0) else "DiffDir"
    assert passes.missing_passes(Layer, view_layer, "raytrace") == [direct, "Shadow"]


# -- beside Cycles -----------------------------------------------------------------------------------------------------


def test_passes_are_those_of_cycles(balls, tmp_path):
    """One sample a pixel, which both engines put in its centre."""
    enable(balls.view_layers[0], DATA)
    ours, our_names = rendered(balls, "ZRAKA", tmp_path / "ours.exr")
    theirs, their_names = rendered(balls, "CYCLES", tmp_path / "theirs.exr")
    assert set(ours) - set(theirs) == NOT_OF_CYCLES
    assert set(theirs) <= set(ours)
    for name, channels in theirs.items():
        assert set(channels) == set(ours[name]), name

    def apart(name):
        return np.max([np.abs(ours[name][c] - theirs[name][c]) for c in theirs[name]], axis=0)

    old = bpy.app.version < (5, 0)
    objects, materials = ("IndexOB", "IndexMA") if old else ("Object Index", "Material Index")
    assert (apart(objects) == 0).mean() >= 0.999
    assert (apart(materials) == 0).mean() >= 0.999
    assert len(np.unique(theirs[objects]["X"])) == 7
    seen = away_from_edges(theirs[objects]["X"]) & (theirs["Depth"]["Z"] < 1e9)
    assert seen.mean() > 0.5
    for name in ("Depth", "Position", "Normal", "UV"):
        assert np.quantile(apart(name)[seen], 0.999) < 1e-3 * max(1.0, np.abs(theirs["Depth"]["Z"][seen]).max()), name
    assert (ours["Depth"]["Z"][theirs["Depth"]["Z"] == 1e10] == 1e10).mean() > 0.99
    assert (apart("Mist")[seen] < 1e-3).all()
    assert (apart("Vector") == 0).all()
    names = [p.name for p in passes.passes_of(balls.view_layers[0])]
    for name in [n for n in names if n.endswith(("Color", "Col", "Emission", "Emit", "Environment", "Env"))]:
        assert np.mean(apart(name)[seen] < 0.01) > 0.99, name
    _compare_mattes(ours, theirs, our_names, their_names)


def _compare_mattes(ours, theirs, our_names, their_names):
    for name in ("CryptoObject00", "CryptoMaterial00", "CryptoAsset00"):
        a, b = ours[name]["r"], theirs[name]["r"]
        assert (a.view(np.uint32) == b.view(np.uint32)).mean() > 0.999, name
        np.testing.assert_allclose(ours[name]["g"], theirs[name]["g"], atol=0.01)
    assert set(our_names) == set(their_names)
    for key, value in our_names.items():
        if key.endswith("/manifest"):
            assert json.loads(value).items() <= json.loads(their_names[key]).items()
        else:
            assert value == their_names[key]


def test_means_of_many_samples_are_those_of_cycles(balls, tmp_path):
    balls.zraka.samples = 64
    match(balls)
    enable(balls.view_layers[0], DATA)
    ours, _ = rendered(balls, "ZRAKA", tmp_path / "ours.exr")
    theirs, _ = rendered(balls, "CYCLES", tmp_path / "theirs.exr")
    for name in ("Normal", "UV", "Mist", "Denoising Normal", "Denoising Depth", "Denoising Albedo", "CryptoObject00"):
        letters = ("g",) if name.startswith("Crypto") else theirs[name]
        for letter in letters:
            a, b = ours[name][letter], theirs[name][letter]
            # Since 5.2 Cycles' depth is the largest float, over the number of samples, where a ray meets nothing.
            a, b = a[b < 1e30], b[b < 1e30]
            # The ball of glass shows the sky, where Cycles multiplies its colour twice.
            assert a.mean() == pytest.approx(b.mean(), abs=0.02 * max(float(np.abs(b).mean()), 0.1)), (name, letter)
    assert (ours["Debug Sample Count"]["X"] == 1).all()
    error = ours["Error"]["X"]
    assert np.isfinite(error).all() and 0 < error.mean() < 0.5


def test_a_border_cuts_all_passes_alike(balls, tmp_path):
    enable(balls.view_layers[0], ["use_pass_z", "use_pass_object_index"])
    whole, _ = rendered(balls, "ZRAKA", tmp_path / "whole.exr")
    render = balls.render
    render.use_border = render.use_crop_to_border = True
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.25, 0.75, 0.25, 0.5
    part, _ = rendered(balls, "ZRAKA", tmp_path / "part.exr")
    np.testing.assert_array_equal(part["Depth"]["Z"], whole["Depth"]["Z"][32:48, 24:72])


# -- the compositor ----------------------------------------------------------------------------------------------------


def roughness(picture):
    """How much neighbours differ on average, on the ground."""
    return np.abs(np.diff(picture[48:], axis=1)).mean()


def test_the_compositor_denoises(balls, tmp_path):
    balls.zraka.samples = 2
    noisy = picture(balls, tmp_path / "noisy.exr")
    with headless.quiet():
        bpy.ops.zraka.denoise()
    assert balls.view_layers[0].zraka.use_pass_denoising and balls.render.use_compositing
    clean = picture(balls, tmp_path / "clean.exr")
    assert clean.mean() == pytest.approx(noisy.mean(), rel=0.05)
    assert roughness(clean) < 0.7 * roughness(noisy)


def reached(socket):
    """Kinds of the nodes that an output reaches, through reroutes."""
    found = set()
    for node in (link.to_node for link in socket.links):
        found |= reached(node.outputs[0]) if node.bl_idname == "NodeReroute" else {node.bl_idname}
    return found


def test_the_nodes_are_set_up_once_between_what_was_there(blender_scene):
    scene, view_layer = blender_scene, blender_scene.view_layers[0]
    node = denoise.set_up(scene, view_layer)
    assert denoise.set_up(scene, view_layer) == node
    tree = node.id_data
    assert [n.bl_idname for n in tree.nodes].count("CompositorNodeDenoise") == 1
    assert {link.from_socket.name for socket in node.inputs for link in socket.links} == {
        "Image",
        "Denoising Albedo",
        "Denoising Normal",
    }
    assert reached(node.outputs[0]) - {"CompositorNodeViewer"} in ({"CompositorNodeComposite"}, {"NodeGroupOutput"})


def test_other_nodes_keep_their_picture(blender_scene):
    scene, view_layer = blender_scene, blender_scene.view_layers[0]
    tree, output = denoise._tree_of(scene)
    layers, blur = denoise._layers_of(tree, scene, view_layer), tree.nodes.new("CompositorNodeBlur")
    tree.links.new(layers.outputs["Image"], blur.inputs["Image"])
    tree.links.new(blur.outputs["Image"], output)
    node = denoise.set_up(scene, view_layer)
    assert blur.inputs["Image"].links[0].from_node == node
    assert output.links[0].from_node == blur


def picture(scene, path):
    scene.render.engine = "ZRAKA"
    kind = scene.render.image_settings
    if hasattr(kind, "media_type"):
        kind.media_type = "IMAGE"
    kind.file_format, kind.color_mode, kind.color_depth = "OPEN_EXR", "RGB", "32"
    scene.render.filepath = str(path)
    with headless.quiet():
        bpy.ops.render.render(write_still=True)
    return oiio.ImageBuf(str(path)).get_pixels(oiio.FLOAT)[..., :3]
