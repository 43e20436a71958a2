# SPDX-License-Identifier: GPL-3.0-or-later
"""Image and environment textures beside Cycles."""

from __future__ import annotations

import atexit
import os
import shutil
import tempfile
from functools import partial

import bpy
import numpy as np
import pytest

from .harness import Case, add, coordinates, difference, output

oiio = pytest.importorskip("OpenImageIO")

FOLDER = tempfile.mkdtemp(prefix="zraka_nodes_")
atexit.register(shutil.rmtree, FOLDER, ignore_errors=True)
WIDTH, HEIGHT = 7, 5


# -- pictures ----------------------------------------------------------------------------------------------------------


def texels(channels=4, seed=0, times_alpha=False):
    """Random values (H, W, C), alpha from 0 to 1 with both ends."""
    values = np.random.default_rng(seed).random((HEIGHT, WIDTH, channels), np.float32)
    if channels in (2, 4):
        values[0, :2, -1] = 0, 1
    if times_alpha:
        values[..., :3] *= values[..., 3:]
    return values


def file(name, kind="uint8", channels=3, values=None, **attributes):
    """An image of a file that is written by OpenImageIO, its alpha as given, not as OpenImageIO would turn it."""
    values = texels(channels) if values is None else values
    path = os.path.join(FOLDER, name)
    spec = oiio.ImageSpec(values.shape[1], values.shape[0], values.shape[2], kind)
    if not name.endswith("exr"):
        spec.attribute("oiio:UnassociatedAlpha", 1)
    for key, value in attributes.items():
        spec.attribute(key.replace("__", ":"), value)
    written = oiio.ImageOutput.create(path)
    assert written.open(path, spec) and written.write_image(np.ascontiguousarray(values)), written.geterror()
    written.close()
    return bpy.data.images.load(path, check_existing=False)


def packed(*args, **kwargs):
    """As `file`, packed, and the file gone."""
    image = file(*args, **kwargs)
    image.pack()
    os.remove(bpy.path.abspath(image.filepath))
    return image


def generated(kind="COLOR_GRID", float_buffer=False):
    """A picture that Blender makes."""
    image = bpy.data.images.new("Generated", 64, 32, alpha=True, float_buffer=float_buffer)
    image.generated_type, image.generated_color = kind, (0.5, 0.25, 0.1, 0.5)
    return image


def painted(float_buffer=False, alpha="STRAIGHT"):
    """A picture whose pixels were set, which further settings would undo."""
    image = bpy.data.images.new("Painted", WIDTH, HEIGHT, alpha=True, float_buffer=float_buffer)
    image.colorspace_settings.name, image.alpha_mode = "Linear Rec.709" if float_buffer else "sRGB", alpha
    image.pixels.foreach_set(texels().ravel())
    image.update()
    return image


def lost():
    """An image whose file is gone."""
    image = file("lost.png")
    os.remove(bpy.path.abspath(image.filepath))
    return image


def tiled(pattern="tile.<UDIM>.png"):
    """A picture of three UDIM tiles, one of them in the second row; a fourth is missing."""
    for number, seed in ((1001, 1), (1002, 2), (1012, 3)):
        column, row = (number - 1001) % 10 + 1, (number - 1001) // 10 + 1
        name = pattern.replace("<UDIM>", str(number)).replace("<UVTILE>", f"u{column}_v{row}")
        path = bpy.path.abspath((image := file(name, values=texels(3, seed))).filepath)
        if number > 1001:
            bpy.data.images.remove(image)
    image = bpy.data.images[0]
    image.source = "TILED"
    image.filepath = os.path.join(os.path.dirname(path), pattern)
    for number in (1002, 1011, 1012):
        image.tiles.new(number)
    return image


def sequence():
    """A sequence of the pictures 3 to 8, of one grey each."""
    for number in range(9):
        values = np.full((2, 2, 3), (number + 1) / 20, np.float32)
        bpy.data.images.remove(file(f"frame_{number:03d}.png", values=values))
    image = bpy.data.images.load(os.path.join(FOLDER, "frame_003.png"))
    image.source = "SEQUENCE"
    return image


# -- graphs ------------------------------------------------------------------------------------------------------------


def textured(image, tree, obj, output_name="Color", colorspace="sRGB", alpha="STRAIGHT", vector=None, user=(), **node):
    """The texture's output, over more than the picture's square; with ``"Both"`` colour times alpha."""
    shown = image() if callable(image) else image
    if shown is not None:
        if shown.colorspace_settings.name != colorspace:
            shown.colorspace_settings.name = colorspace
        if shown.alpha_mode != alpha:
            shown.alpha_mode = alpha
    where = coordinates(tree, (3.1, 2.7, 1.0), (-1.2, -0.8, 0.0)) if vector is None else vector(tree)
    mapping = node.pop("texture_mapping", {})
    texture = add(tree, "TexImage", {"Vector": where} if where else {}, image=shown, **node)
    for name, value in mapping.items():
        setattr(texture.texture_mapping, name, value)
    for name, value in dict(user).items():
        setattr(texture.image_user, name, value)
    if output_name != "Both":
        return output(texture, output_name)
    return output(add(tree, "MixRGB", {0: output(texture, "Alpha"), 1: (0, 0, 0, 1), 2: output(texture)}))


def image_case(name, image, tolerance=1e-3, share=0.0, known=(), **settings):
    """Case of an Image Texture."""
    return Case(f"Image Texture: {name}", partial(textured, image, **settings), tolerance, share, known)


def turned(tree):
    """Coordinates of which all three numbers vary."""
    return coordinates(tree, (1.3, 1.1, 1.0), (0.1, -0.2, 0.4), (0.8, 0.5, 0.3))


def hilly(build, scale=(0.5, 2.0, 1.0), turn=0.7):
    """`build` on smooth hills in place of the plane, of an object that is scaled unevenly and turned."""

    def on_hills(tree, obj):
        side = np.linspace(-1.05, 1.05, 33)
        x, y = np.meshgrid(side, side)
        z = 0.35 * np.sin(4 * x + 0.3) * np.cos(3 * y)
        world = np.stack([x.ravel(), y.ravel(), z.ravel()])
        placed = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]]) * scale
        local = np.linalg.solve(placed, world).T
        corner = np.arange(33 * 33).reshape(33, 33)
        faces = np.stack([corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]], axis=-1).reshape(-1, 4)
        mesh = bpy.data.meshes.new("Hills")
        mesh.from_pydata(local.tolist(), [], faces.tolist())
        mesh.shade_smooth()
        layer = mesh.uv_layers.new(name="UVMap")
        at = (world[:2].T + 1) / 2
        layer.uv.foreach_set("vector", at[faces.ravel()].astype(np.float32).ravel())
        mesh.materials.append(obj.data.materials[0])
        obj.data, obj.rotation_euler, obj.scale = mesh, (0, 0, turn), scale
        bpy.context.view_layer.update()
        return build(tree, obj)

    return on_hills


def environment(image, tree, obj, colorspace="sRGB", by_default=False, mapping=(), **node):
    """An Environment Texture on the plane."""
    shown = image()
    shown.colorspace_settings.name = colorspace
    directions = coordinates(tree, (2.2, 1.9, 1.0), (-1.1, -0.8, 0.6), (0.4, 0.3, 0.2))
    texture = add(tree, "TexEnvironment", {} if by_default else {"Vector": directions}, image=shown, **node)
    for name, value in dict(mapping).items():
        setattr(texture.texture_mapping, name, value)
    return output(texture)


def at_frame(frame, user):
    """A sequence at a frame of the scene."""

    def build(tree, obj):
        bpy.context.scene.frame_set(frame)
        return textured(sequence, tree, obj, user=user)

    return build


# -- cases -------------------------------------------------------------------------------------------------------------

AT_ITS_WORD = bpy.app.version >= (5, 2)  # Cycles takes the image's alpha mode
HALF_STEP = 4e-3 if bpy.app.version >= (5, 1) else 1e-3  # between halves of up to 8, where ties go to either

PLAIN = partial(file, "plain.png")
EIGHT, SIXTEEN = partial(file, "a8.png", channels=4), partial(file, "a16.png", "uint16", 4)
HALF = partial(file, "half.exr", "half", 3)
FLOAT = partial(file, "float.exr", "float", 3)
FLOAT_ALPHA = partial(file, "alpha.exr", "float", values=texels(times_alpha=True))

CASES = [
    image_case(f"{interpolation.lower()}, {extension.lower()}", EIGHT, interpolation=interpolation, extension=extension)
    for interpolation in ("Linear", "Closest", "Cubic", "Smart")
    for extension in ("REPEAT", "EXTEND", "CLIP", "MIRROR")
]
CASES += [
    image_case(f"{output_name.lower()}, alpha {alpha.lower()}, {colorspace}, {name}", image, **settings)
    for name, image in (
        ("8 bits", EIGHT),
        ("16 bits", SIXTEEN),
        ("float", FLOAT_ALPHA),
        ("packed", partial(packed, "p.png", channels=4)),
    )
    for alpha in ("STRAIGHT", "PREMUL", "CHANNEL_PACKED", "NONE")
    for colorspace in ("sRGB", "Non-Color", "Linear Rec.709")
    for output_name in ("Color", "Both")
    if not (AT_ITS_WORD and alpha == "PREMUL" and output_name == "Both")  # colours that are many times their alpha
    for settings in ({"output_name": output_name, "colorspace": colorspace, "alpha": alpha},)
]
CASES += [
    image_case(f"alpha, alpha {alpha.lower()}, {name}", image, output_name="Alpha", alpha=alpha)
    for name, image in (("8 bits", EIGHT), ("float", FLOAT_ALPHA))
    for alpha in ("STRAIGHT", "NONE")
]
CASES += [
    image_case(f"{space}, {name}", image, HALF_STEP if name == "8 bits" else 1e-3, colorspace=space)
    for space in (
        "ACES2065-1",
        "ACEScg",
        "AgX Base sRGB",
        "Display P3",
        "Filmic Log",
        "Filmic sRGB",
        "Linear CIE-XYZ E",
        "Linear DCI-P3 D65",
        "Linear FilmLight E-Gamut",
        "Linear Rec.2020",
        "Rec.1886",
        "Rec.2020",
    )
    for name, image in (("8 bits", PLAIN), ("float", FLOAT))
]
if not AT_ITS_WORD:
    CASES += [
        image_case("UDIM, box", tiled, projection="BOX"),  # since then only coordinates from 0 to 1 show it
        image_case("packed, Filmic sRGB", partial(packed, "pf.png", channels=3), colorspace="Filmic sRGB"),
    ]
CASES += [
    image_case("jpeg", partial(file, "p.jpg"), tolerance=2e-3),
    image_case("grey png", partial(file, "g8.png", channels=1)),
    image_case("grey png, 16 bits", partial(file, "g16.png", "uint16", 1)),
    image_case("grey png, clip, alpha", partial(file, "g8.png", channels=1), output_name="Alpha", extension="CLIP"),
    image_case("grey and alpha", partial(file, "ga.png", channels=2)),
    image_case("grey exr", partial(file, "g.exr", "half", 1), colorspace="Linear Rec.709"),
    image_case("half", HALF, colorspace="Linear Rec.709"),
    image_case("half with alpha", partial(file, "ha.exr", "half", 4), output_name="Both", colorspace="Linear Rec.709"),
    image_case("tiff, alpha apart", partial(file, "s.tif", channels=4), output_name="Both"),
    image_case("tga", partial(file, "t.tga", channels=4), output_name="Both"),
    image_case("hdr", partial(file, "h.hdr", "float"), colorspace="Linear Rec.709"),
    image_case("bmp", partial(file, "b.bmp")),
    image_case("float stored by sRGB", FLOAT_ALPHA),
    image_case("packed, 16 bits", partial(packed, "p16.png", "uint16", 4), output_name="Both"),
    image_case("packed exr", partial(packed, "pk.exr", "half", 4), output_name="Both", colorspace="Linear Rec.709"),
    image_case("packed exr, ACEScg", partial(packed, "pa.exr", "half", 3), colorspace="ACEScg"),
    image_case("generated grid", generated),
    image_case("generated, plain", partial(generated, "BLANK"), output_name="Both"),
    image_case("generated, plain, float", partial(generated, "BLANK", True), output_name="Both"),
    image_case("painted", painted, output_name="Both"),
    image_case("painted, float", partial(painted, True), output_name="Both", colorspace="Linear Rec.709"),
    image_case(
        "painted, float, packed alpha",
        partial(painted, True, "CHANNEL_PACKED"),
        alpha="CHANNEL_PACKED",
        colorspace="Linear Rec.709",
    ),
    image_case("UDIM", tiled, known=("tile 1011",)),
    image_case(
        "UDIM by u and v",
        partial(tiled, "tile_<UVTILE>.png"),
        interpolation="Cubic",
        extension="EXTEND",
        known=("tile 1011",),
    ),
    image_case("no image", None, known=("has no image",)),
    image_case("missing file", lost, known=("cannot be read",)),
    image_case("sphere", EIGHT, projection="SPHERE", vector=turned),
    image_case("tube", EIGHT, projection="TUBE", vector=turned),
    image_case("box", EIGHT, projection="BOX", vector=turned),
    *(
        Case(
            f"Image Texture: box on hills, blend {blend}",
            hilly(partial(textured, EIGHT, projection="BOX", projection_blend=blend, vector=turned)),
            share=0.002 if blend == 0 else 0.0,
        )
        for blend in (0.0, 0.01, 0.3, 1.0)
    ),
]
MAPPINGS = {
    "point": {"vector_type": "POINT"},
    "texture": {"vector_type": "TEXTURE"},
    "vector": {"vector_type": "VECTOR"},
    "normal": {"vector_type": "NORMAL"},
    "axes": {"mapping_x": "Z", "mapping_y": "X", "mapping_z": "NONE"},
    "limits": {"use_min": True, "use_max": True, "min": (0.4, 0.4, 0.4), "max": (0.5, 0.5, 0.5)},
}
PLACED = {"translation": (0.2, -0.1, 0.3), "rotation": (0.4, -0.3, 0.8), "scale": (1.3, 0.7, -1.1)}
CASES += [
    image_case(f"mapping inside, {name}", EIGHT, vector=turned, texture_mapping={**PLACED, **mapping})
    for name, mapping in MAPPINGS.items()
]
USER = {"frame_duration": 4, "frame_start": 3, "frame_offset": 2}
CASES += [
    Case(f"Image Texture: sequence, frame {frame}, {name}", at_frame(frame, {**USER, **user}))
    for name, user in (
        ("once", {}),
        ("again and again", {"use_cyclic": True}),
        ("refreshed", {"use_auto_refresh": True}),
    )
    for frame in (1, 3, 5, 8, 12)
]
CASES += [
    Case(
        f"Environment Texture: {projection.lower().replace('_', ' ')}, {interpolation.lower()}",
        partial(environment, PLAIN, projection=projection, interpolation=interpolation),
        share=0.001 if interpolation == "Closest" else 0.0,
    )
    for projection in ("EQUIRECTANGULAR", "MIRROR_BALL")
    for interpolation in ("Linear", "Closest", "Cubic", "Smart")
]
CASES += [
    image_case("coordinates by default, mapped", EIGHT, vector=lambda tree: None, texture_mapping=PLACED),
    Case("Environment Texture: coordinates by default", partial(environment, PLAIN, by_default=True)),
    Case("Environment Texture: mapping inside", partial(environment, PLAIN, by_default=True, mapping=PLACED)),
    Case("Environment Texture: alpha", partial(environment, EIGHT)),
    Case("Environment Texture: half", partial(environment, HALF, colorspace="Linear Rec.709")),
    Case("Environment Texture: ACEScg", partial(environment, PLAIN, colorspace="ACEScg")),
]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_agrees_with_cycles(case):
    largest, share = difference(case)
    print(f"largest difference {largest:.1e}, {share:.2%} of the pixels beyond {case.tolerance:g}")
    assert share <= case.share
