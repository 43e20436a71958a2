# SPDX-License-Identifier: GPL-3.0-or-later
"""Worlds that show pictures: where what is seen, how it is sampled, what light it gives."""

import math
from functools import cache

import numpy as np
import pytest

from zraka.core.arena import Arena
from zraka.core.compile.lights import compile_lights
from zraka.core.compile.world import compile_world
from zraka.core.diagnostics import Diagnostics
from zraka.core.geometry import Geometry
from zraka.core.lights import environment
from zraka.core.scene import Camera, Image, Link, Material, Node, PointLight, Scene, World
from zraka.tests import stat

from .scenes import camera, film_of, looking_down, placed, quad, radiance, scene

AXES = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0], [0, -1, 0], [0, 0, -1]], np.float32).T
WHITE = Material.diffuse(0.8)


def picture(color, width=64, height=32, **more):
    """An image whose texels are ``color(phi, theta)`` (H, W) or (3, H, W), of linear values."""
    theta = math.pi * (1 - (np.arange(height)[:, None] + 0.5) / height)
    phi = math.pi - 2 * math.pi * (np.arange(width)[None, :] + 0.5) / width
    pixels = np.ones((height, width, 4), np.float32)
    pixels[..., :3] = np.moveaxis(np.broadcast_to(color(phi, theta), (3, height, width)), 0, -1)
    return Image("sky", pixels, **({"colorspace": "Non-Color"} | more))


def sun(phi, theta, strength=1e4, sky=0.2):
    """A picture of one bright texel, the one that holds the direction, in a gradient."""

    def color(p, t):
        distance = np.hypot(np.sin(0.5 * (p - phi)) * np.sin(theta), np.sin(0.5 * (t - theta))) + 0 * p
        return np.where(distance == distance.min(), strength, sky * (1 + np.cos(t)))

    return color


PICTURES = {
    "sun": sun(1.0, 0.7),
    "seam": sun(math.pi - 1e-3, 1.2),
    "zenith": sun(0.0, 0.01, 1e6),
    "nadir": sun(2.0, math.pi - 0.01, 1e6),
    "half": lambda p, t: (np.cos(t) > 0) + 0 * p,
    "smooth": lambda p, t: 1.5 + np.sin(3 * p) * np.sin(t),
}


def seen(world, d):
    """Radiance (3, n) of a world along `d`, and what was said."""
    diagnostics = Diagnostics()
    value = compile_world(world, diagnostics).eval(np.ascontiguousarray(d, np.float32), Arena())
    return np.array(np.broadcast_to(value, d.shape)), diagnostics.messages()


def lights_of(image, *lights):
    """Compiled lights of a scene with nothing in it."""
    view = Scene(Camera(), lights=lights, world=World.textured(image))
    return compile_lights(view, Geometry.from_arrays(()), [], Diagnostics())


@cache
def lights_named(name):
    """Compiled lights of one of `PICTURES`."""
    return lights_of(picture(PICTURES[name]))


# -- what is seen where ------------------------------------------------------------------------------------------------


def test_axes_of_an_equirectangular_picture():
    """The middle is +X, left of it +Y; the top is +Z. At the poles themselves the picture repeats, as in Cycles."""
    image = picture(lambda p, t: np.stack(np.broadcast_arrays(np.cos(p) * np.sin(t), np.sin(p) * np.sin(t), np.cos(t))))
    near = AXES + 0.06 * np.roll(AXES, 1, axis=0)
    value, _ = seen(World.textured(image, 2.0), near)
    np.testing.assert_allclose(value, 2 * near, atol=0.02)


def test_axes_of_a_mirror_ball():
    """Seen along +Y: the middle mirrors -Y, the sides ±X and the top +Z at 45°, the rim +Y."""
    x = (np.arange(256) + 0.5) / 128 - 1
    pixels = np.ones((256, 256, 4), np.float32)
    pixels[..., 0], pixels[..., 1] = x[None, :], x[:, None]
    world = World.textured(Image("ball", pixels, colorspace="Non-Color"), projection="MIRROR_BALL")
    d = AXES[:, [0, 2, 3, 4, 5]]
    s = math.sqrt(0.5)
    np.testing.assert_allclose(seen(world, d)[0][:2], [[s, 0, -s, 0, 0], [0, s, 0, 0, -s]], atol=1e-5)


def test_the_seam_is_smooth_and_the_poles_are_finite():
    image = picture(lambda p, t: 2 + np.cos(p) * np.sin(t), 16, 8)
    across = np.array([[-1, 1e-4, 0], [-1, -1e-4, 0], [0, 0, 1], [1e-20, 0, 1], [0, 1e-9, -1]], np.float32).T
    value, _ = seen(World.textured(image), across)
    assert value[0, 0] == pytest.approx(value[0, 1], abs=1e-3)
    assert np.isfinite(value).all()


def mapped(image, **mapping):
    """A world that shows `image` through a Mapping node."""
    nodes = (
        Node("tex_coord"),
        Node("mapping", {"vector": Link(0, "generated"), **mapping}, {"vector_type": mapping.pop("kind", "POINT")}),
        Node("environment", {"vector": Link(1, "vector")}, {"image": image}),
        Node("background", {"color": Link(2, "color"), "strength": 1.0}),
    )
    return World(nodes=nodes, surface=3)


@pytest.mark.parametrize(
    "kind, matrix", [("POINT", [[0, -1, 0], [1, 0, 0], [0, 0, 1]]), ("TEXTURE", [[0, 1, 0], [-1, 0, 0], [0, 0, 1]])]
)
def test_a_mapping_turns_the_world(kind, matrix):
    image = picture(PICTURES["smooth"], 256, 128)
    d = np.random.default_rng(0).normal(size=(3, 100))
    d = (d / np.linalg.norm(d, axis=0)).astype(np.float32)
    turned, said = seen(mapped(image, kind=kind, rotation=(0.0, 0.0, math.pi / 2)), d)
    np.testing.assert_allclose(turned, seen(World.textured(image), np.array(matrix) @ d)[0], atol=1e-4)
    assert said == []


def test_a_mapping_moves_uvs():
    """Half of a checker's cell further the colours are changed."""
    floor = quad(1)
    uv = floor.vertices[floor.triangles.ravel(), :2] + 0.5
    floor = type(floor)(floor.vertices, floor.triangles, uvs={"UVMap": uv.astype(np.float32)})
    for shift, expected in ((0.0, 1.0), (0.5, 0.0)):
        nodes = (
            Node("tex_coord"),
            Node("mapping", {"vector": Link(0, "uv"), "location": (shift, 0.0, 0.0)}),
            Node("checker", {"vector": Link(1, "vector"), "scale": 2.0, "color1": (0.0,) * 3, "color2": (1.0,) * 3}),
            Node("emission", {"color": Link(2, "color"), "strength": 1.0}),
        )
        view = looking_down(placed(floor, Material("m", nodes, 3)), at=(-0.25, -0.25, 0))
        assert radiance(view, 1, method="raycast") == expected


def test_graphs_that_fold_are_constant():
    nodes = (
        Node("background", {"color": (0.5, 0.5, 0.5), "strength": 2.0}),
        Node("background", {"color": (0.0, 1.0, 0.0), "strength": 1.0}),
        Node("mix_shader", {"fac": 0.5, "a": Link(0, "bsdf"), "b": Link(1, "bsdf")}),
    )
    sky = compile_world(World(nodes=nodes, surface=2), Diagnostics())
    assert sky.is_constant
    np.testing.assert_allclose(sky.radiance[:, 0], (0.5, 1.0, 0.5))


# -- pictures ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "ending, kind, tolerance",
    [
        ("png", "uint16", 1e-4),
        ("png", "uint8", 4e-3),
        ("exr", "half", 1e-3),
        ("exr", "float", 1e-6),
        ("hdr", "float", 1e-2),
    ],
)
def test_files(tmp_path, ending, kind, tolerance):
    oiio = pytest.importorskip("OpenImageIO")
    pixels = picture(PICTURES["smooth"]).pixels[..., :3] / 3
    path = str(tmp_path / f"sky.{ending}")
    buffer = oiio.ImageBuf(np.ascontiguousarray(pixels[::-1]))
    assert buffer.write(path, kind)
    world = World.textured(Image("sky", filepath=path, colorspace="Non-Color"))
    direct = World.textured(Image("sky", picture(lambda p, t: PICTURES["smooth"](p, t) / 3).pixels, "", "Non-Color"))
    d = np.random.default_rng(1).normal(size=(3, 500)).astype(np.float32)
    np.testing.assert_allclose(seen(world, d)[0], seen(direct, d)[0], atol=tolerance)


def test_srgb_is_interpolated_as_stored():
    """As in Cycles: halfway between 0 and 1 it is linear(0.5)."""
    image = picture(lambda p, t: (p > 0) + 0 * t, 4, 2, colorspace="sRGB")
    value, _ = seen(World.textured(image), np.array([[1.0], [0], [0]]))
    assert value[0, 0] == pytest.approx(0.2140411, rel=1e-4)


def test_colours_count_times_alpha():
    image = picture(lambda p, t: 1 + 0 * p * t, colorspace="Linear Rec.709")
    image.pixels[..., 3] = 0.25
    np.testing.assert_allclose(seen(World.textured(image), AXES)[0], 0.25)


@pytest.mark.parametrize("ending", ["png", "exr", "tif"])
def test_alpha_of_files(tmp_path, ending):
    """Stored apart from the colour or multiplied into it, it counts once."""
    oiio = pytest.importorskip("OpenImageIO")
    buffer = oiio.ImageBuf(np.full((8, 16, 4), (0.25, 0.25, 0.25, 0.5), np.float32))
    assert buffer.write(str(tmp_path / f"veil.{ending}"), "half" if ending == "exr" else "uint16")
    image = Image("veil", filepath=str(tmp_path / f"veil.{ending}"), colorspace="Linear Rec.709")
    np.testing.assert_allclose(seen(World.textured(image), AXES)[0], 0.25, atol=1e-3)


@pytest.mark.parametrize("image", [None, Image("lost", filepath="/nowhere/lost.exr")])
def test_a_missing_image_is_magenta_and_said(image):
    value, said = seen(World.textured(image, name="Night"), AXES)
    np.testing.assert_allclose(value, np.tile([[1], [0], [1]], 6), rtol=1e-6)
    assert len(said) == 1 and "world 'Night'" in said[0]


# -- sampling ----------------------------------------------------------------------------------------------------------


def cell_integrals(value, rows=512, columns=1024):
    """∫ value over the cells of the sampling grid by their middles, (rows, columns) float64."""
    edges = np.linspace(0, math.pi, rows + 1)
    theta, phi = (np.arange(rows) + 0.5) * math.pi / rows, math.pi - (np.arange(columns) + 0.5) * 2 * math.pi / columns
    out, arena = np.zeros((rows, columns)), Arena()
    for k in range(rows):
        x, y, z = np.sin(theta[k]) * np.cos(phi), np.sin(theta[k]) * np.sin(phi), np.full(columns, np.cos(theta[k]))
        with arena.frame():
            out[k] = value(np.stack((x, y, z)).astype(np.float32), arena)
    return out * (np.cos(edges[:-1]) - np.cos(edges[1:]))[:, None] * 2 * math.pi / columns


def blocks(cells, size=16):
    """Sums over blocks of cells."""
    return cells.reshape(cells.shape[0] // size, size, -1, size).sum(axis=(1, 3)).ravel()


def fit(name, factor=1.0, count=200_000):
    """p-value that sampled directions follow the density times `factor`."""
    lights = lights_named(name)
    expected = blocks(cell_integrals(lights.environment.pdf)) * factor * count
    u = np.random.default_rng(4).random((3, count), np.float32)
    wi = lights.sampler.sample(np.zeros((3, count), np.float32), *u, Arena()).wi.astype(np.float64)
    row = np.minimum(np.arctan2(np.hypot(wi[0], wi[1]), wi[2]) / math.pi * 512, 511).astype(int)
    column = np.minimum((math.pi - np.arctan2(wi[1], wi[0])) / (2 * math.pi) * 1024, 1023).astype(int)
    observed = np.bincount(row * 1024 + column, minlength=512 * 1024).reshape(512, 1024)
    return stat.chi_square(blocks(observed), expected)


@pytest.mark.parametrize("name", PICTURES)
def test_directions_follow_the_density(name):
    assert fit(name) > stat.sidak(stat.LEVEL, len(PICTURES))


def test_a_wrong_density_is_noticed():
    assert fit("smooth", 1.05) < stat.LEVEL


@pytest.mark.parametrize("name", PICTURES)
def test_density_and_light_integrate_to_their_truths(name):
    sky = lights_named(name).environment
    assert cell_integrals(sky.pdf).sum() == pytest.approx(1, rel=1e-5)
    light = cell_integrals(lambda d, arena: sky.eval(d, arena)[0]).sum() / (4 * math.pi)
    assert sky.mean[0] == pytest.approx(light, rel=2e-3)


@pytest.mark.parametrize("name", PICTURES)
def test_samples_agree_with_what_rays_find(name):
    """At the seam and the poles too: weight is radiance over density, and the density is that of the direction."""
    lights, arena = lights_of(picture(PICTURES[name]), PointLight((0, 0, 1), (1,) * 3)), Arena()
    u = np.random.default_rng(2).random((3, 50_000), np.float32)
    u[:, :2] = [[0.99, 0.999], [0, 1 - 2**-24], [0, 1 - 2**-24]]
    s = lights.sampler.sample(np.zeros((3, u.shape[1]), np.float32), *u, arena)
    far = np.flatnonzero(np.isinf(s.distance))
    assert 0.3 * u.shape[1] < far.size < 0.7 * u.shape[1]  # a map has half of the choice
    wi, weight, pdf = s.wi[:, far], s.weight[:, far], s.pdf[far]
    np.testing.assert_allclose(np.linalg.norm(wi, axis=0), 1, atol=1e-6)
    again = lights.environment.pdf(np.ascontiguousarray(wi), arena)
    assert (pdf > 0).all() and np.isclose(pdf, again, rtol=1e-4).mean() > 0.999  # rounding: the next cell
    np.testing.assert_allclose(weight * pdf, lights.environment.eval(np.ascontiguousarray(wi), arena), rtol=1e-4)


def test_no_texel_of_a_large_picture_is_missed():
    """One texel of 4096 × 2048 holds nearly all light, and gets nearly all samples."""
    pixels = np.full((2048, 4096, 4), 0.1, np.float32)
    pixels[1500, 3001, :3] = 1e8
    lights = lights_of(Image("star", pixels, colorspace="Non-Color"))
    s = lights.sampler.sample(
        np.zeros((3, 4096), np.float32), *np.random.default_rng(3).random((3, 4096), np.float32), Arena()
    )
    phi, theta = math.pi - 2 * math.pi * 3001.5 / 4096, math.pi * (1 - 1500.5 / 2048)
    star = np.array([math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta)])
    assert np.median(np.arccos(np.clip(star @ s.wi, -1, 1))) < 0.01


def test_an_even_map_is_left_to_scattering():
    lights = lights_of(picture(lambda p, t: 0.5 + 0 * p * t))
    assert lights.sampler.count == 0
    assert lights.environment.pdf(AXES, Arena()) == 0


# -- light -------------------------------------------------------------------------------------------------------------

HALF = World.textured(picture(lambda p, t: (np.cos(t) > 0) + 0 * p, 512, 256))


def under(world, *things, view=None):
    """A scene under a world, seen from above unless `view` says."""
    base = looking_down(*things) if view is None else scene(view, *things)
    return Scene(base.camera, base.instances, world=world)


def test_half_a_white_sky():
    assert radiance(under(HALF, placed(quad(4), WHITE)), 64) == pytest.approx(0.8, rel=1e-2)
    wall = camera((0, -3, 0), (0, 0, 0), fov=0.005)
    assert radiance(under(HALF, placed(quad(4, normal="-y"), WHITE), view=wall), 256) == pytest.approx(0.4, rel=1e-2)


def test_furnace_of_an_even_picture():
    world = World.textured(picture(lambda p, t: 1 + 0 * p * t))
    assert radiance(under(world, placed(quad(4), Material.diffuse(1.0))), 4) == pytest.approx(1, rel=1e-4)


@pytest.mark.parametrize(
    "name, samples, depth", [("sun", 64, 1), ("seam", 64, 4), ("zenith", 64, 1), ("smooth", 256, 4)]
)
def test_irradiance_of_a_picture(name, samples, depth):
    """Against the sum over directions; `sun` fills 4e-4 of the sky and gives most of the light."""
    image = picture(PICTURES[name])
    mu, phi = np.meshgrid((np.arange(1000) + 0.5) / 1000, (np.arange(1000) + 0.5) / 1000 * 2 * math.pi)
    r = np.sqrt(1 - mu**2)
    d = np.stack([r * np.cos(phi), r * np.sin(phi), mu]).reshape(3, -1).astype(np.float32)
    truth = 0.8 * 2 * float((seen(World.textured(image), d)[0][0] * d[2]).mean(dtype=np.float64))
    value = radiance(under(World.textured(image), placed(quad(4), WHITE)), samples, depth=depth)
    assert value == pytest.approx(truth, rel=1e-2)


def test_light_of_a_picture_and_of_a_lamp_add_up():
    """Each alone, and both where the choice is between them."""
    world, lamp = World.textured(picture(PICTURES["sun"])), PointLight((1, 0, 1), (50,) * 3, radius=0.3)
    floor = placed(quad(4), Material.glossy((0.8,) * 3, 0.6))
    base = looking_down(floor)
    values = [
        radiance(Scene(base.camera, base.instances, lights=lights, world=sky), 256)
        for lights, sky in (((lamp,), World()), ((), world), ((lamp,), world))
    ]
    assert values[2] == pytest.approx(values[0] + values[1], rel=1e-2)


@pytest.mark.parametrize("roughness, tolerance", [(0.0, 1e-4), (0.3, 1e-2), (0.7, 1e-2)])
def test_metal_looks_as_by_scattered_rays_alone(roughness, tolerance, monkeypatch):
    world = World.textured(picture(PICTURES["smooth"]))
    metal = placed(quad(4), Material.glossy((1.0,) * 3, roughness))
    view = under(world, metal, view=camera((2, -1, 2), (0, 0, 0), fov=0.005))
    both = radiance(view, 128)
    monkeypatch.setattr(environment, "_EVEN", math.inf)
    assert both == pytest.approx(radiance(view, 256), rel=tolerance)


def test_classic_methods_see_the_picture_and_take_its_mean_as_ambient_light():
    view = under(HALF, placed(quad(4), WHITE))
    assert radiance(view, 1, method="raycast") == pytest.approx(0.4, rel=1e-3)
    aside = camera((2, -1, 2), (0, 0, 0), fov=0.005)
    mirror = under(HALF, placed(quad(4), Material.glossy((1.0,) * 3)), view=aside)
    assert radiance(mirror, 1, method="raytrace", depth=2) == pytest.approx(1.0, rel=1e-3)


def test_the_film_is_clear_where_the_picture_was():
    view = under(HALF, placed(quad(1), WHITE), view=camera((0, 0, 3), (0, 0, 0), fov=0.5))
    image = film_of(view, 4, transparent_film=True).image()
    assert image[0, 0, 3] == 0 and not image[0, 0, :3].any()
    assert image[16, 16, 3] == 1 and image[16, 16, 0] == pytest.approx(0.8, rel=0.1)
