# SPDX-License-Identifier: GPL-3.0-or-later
"""Path tracing against closed forms: furnaces, glass, transparency, closed rooms, form factors."""

import numpy as np
import pytest

from zraka.core.scene import Instance, Link, Material, Mesh, Node, Spheres

from .scenes import box, camera, disk, looking_down, placed, quad, radiance, scene, sphere

SPHERE_VIEW = camera((0, -4, 0), (0, 0, 0), fov=0.15)  # well inside the sphere's outline


def furnace(material, samples=64, depth=80, **more):
    """Radiance of a sphere in a white world."""
    return radiance(scene(SPHERE_VIEW, placed(sphere(), material), world=1.0), samples, depth=depth, **more)


@pytest.mark.parametrize("albedo", [0.0, 0.2, 0.8, 1.0])
def test_lambert_furnace(albedo):
    assert furnace(Material.diffuse(albedo)) == pytest.approx(albedo, rel=3e-3, abs=1e-6)


def test_a_furnace_check_can_fail():
    assert furnace(Material.diffuse(0.8 * 1.05)) != pytest.approx(0.8, rel=3e-3)


@pytest.mark.parametrize("ior", [1.0, 1.0001, 1.5, 2.4])
def test_glass_furnace(ior):
    assert furnace(Material.glass(ior=ior), samples=32) == pytest.approx(1.0, rel=4e-3)


def test_analytic_glass_sphere_furnace():
    ball = Spheres(np.zeros((1, 3)), np.ones(1), Material.glass())
    assert radiance(scene(SPHERE_VIEW, spheres=(ball,), world=1.0), 32, depth=80) == pytest.approx(1.0, rel=4e-3)


@pytest.mark.parametrize("roughness", [0.0, 1e-4, 0.01])
def test_near_specular_furnace(roughness):
    assert furnace(Material.glossy((1, 1, 1), roughness)) == pytest.approx(1.0, rel=4e-3)


def test_ideal_metal_at_normal_incidence():
    metal = Material.principled(base_color=(0.9, 0.9, 0.9), metallic=1.0, roughness=0.0)
    assert radiance(looking_down(placed(quad(4), metal), world=1.0)) == pytest.approx(0.9, rel=2e-3)


@pytest.mark.parametrize(
    "roughness, mu, albedo", [(0.25, 1, 0.995703), (0.5, 1, 0.915813), (1, 1, 0.306853), (1, 0.5, 0.450694)]
)
def test_single_scattering_ggx_albedo(roughness, mu, albedo):
    eye = 5 * np.array([0, -np.sqrt(1 - mu * mu), mu])
    view = camera(eye, (0, 0, 0), fov=0.005)
    plane = placed(quad(40), Material.glossy((1, 1, 1), roughness))
    assert radiance(scene(view, plane, world=1.0), 256) == pytest.approx(albedo, rel=1e-2)


def test_mixed_lambert():
    nodes = (
        Node("diffuse", {"color": (0.4,) * 3}),
        Node("diffuse", {"color": (0.8,) * 3}),
        Node("mix_shader", {"fac": 0.5, "a": Link(0, "bsdf"), "b": Link(1, "bsdf")}),
    )
    assert furnace(Material("mix", nodes, 2)) == pytest.approx(0.6, rel=3e-3)


def test_translucent_furnace():
    material = Material.single("translucent", color=(0.7, 0.7, 0.7))
    assert radiance(looking_down(placed(quad(4), material), world=1.0), 64) == pytest.approx(0.7, rel=3e-3)


@pytest.mark.parametrize("layers", [1, 8, 20])
def test_transparent_layers_multiply(layers):
    material = Material.single("transparent", color=(0.9, 0.9, 0.9))
    sheets = [placed(quad(4, (0, 0, -0.1 * k)), material) for k in range(layers)]
    value = radiance(looking_down(*sheets, world=1.0), 64, transparent_depth=32)
    assert value == pytest.approx(0.9**layers, rel=3e-3 if layers < 20 else 2e-2)


def test_too_many_transparent_layers_are_black():
    sheets = [placed(quad(4, (0, 0, -0.1 * k)), Material.single("transparent")) for k in range(9)]
    assert radiance(looking_down(*sheets, world=1.0), 4, transparent_depth=8) == 0
    assert radiance(looking_down(*sheets, world=1.0), 4, transparent_depth=9) == pytest.approx(1.0)


@pytest.mark.parametrize("n, transmitted", [(1.5, 12 / 13), (2.4, 0.710059), (1.0, 1.0)])
def test_glass_plate_transmits(n, transmitted):
    plate = [placed(quad(10), Material.glass(ior=n)), placed(quad(10, (0, 0, -0.5), "-z"), Material.glass(ior=n))]
    light = placed(quad(10, (0, 0, -2)), Material.emission())
    value = radiance(looking_down(*plate, light), 256, depth=64)
    assert value == pytest.approx(transmitted, rel=4e-3)


@pytest.mark.parametrize(
    "albedo, bounces, tolerance", [(0.5, 0, 0.01), (0.5, 1, 0.01), (0.5, 64, 0.01), (0.9, 128, 0.01)]
)
def test_closed_emitting_room(albedo, bounces, tolerance):
    room = placed(box(2, inward=True), Material.glowing(albedo, 1.0))
    value = radiance(scene(camera((0, 0, 0), (0, 1, 0), fov=1.0), room), 64, depth=bounces + 1)
    assert value == pytest.approx((1 - albedo ** (bounces + 2)) / (1 - albedo), rel=tolerance)


def face_mean(target, normal, *instances, samples=64):
    """Mean radiance of the unit square at `target` seen by an orthographic camera from behind its emitters."""
    view = camera(np.asarray(target, float) + 0.02 * np.asarray(normal, float), target)
    view = type(view)(view.transform, (-0.5, 0.5, -0.5, 0.5), "ORTHOGRAPHIC")
    return radiance(scene(view, *instances), samples, depth=1)


def test_parallel_squares():
    floor, lamp = placed(quad(1), Material.diffuse(0.8)), placed(quad(1, (0, 0, 1), "-z"), Material.emission())
    assert face_mean((0, 0, 0), (0, 0, 1), floor, lamp) == pytest.approx(0.8 * 0.1998249, rel=1e-2)


def test_perpendicular_squares():
    floor, lamp = placed(quad(1), Material.diffuse(0.8)), placed(quad(1, (0, 0.5, 0.5), "-y"), Material.emission())
    assert face_mean((0, 0, 0), (0, 0, 1), floor, lamp, samples=256) == pytest.approx(0.8 * 0.2000438, rel=1e-2)


def test_point_below_the_corner_of_a_square():
    lamp = placed(quad(1, (0.5, 0.5, 1), "-z"), Material.emission())
    value = radiance(looking_down(placed(quad(8), Material.diffuse(0.8)), lamp, height=0.5), 256, depth=1)
    assert value == pytest.approx(0.110825, rel=1e-2)


def test_coaxial_disk():
    lamp = placed(disk(0.5, (0, 0, 1), up=False), Material.emission())
    value = radiance(looking_down(placed(quad(8), Material.diffuse(0.8)), lamp, height=0.5), 256, depth=1)
    assert value == pytest.approx(0.8 * 0.5**2 / (0.5**2 + 1), rel=1e-2)


@pytest.mark.parametrize("h, expected", [(2.0, 0.2), (1.05, 0.725624)])
def test_sphere_emitter(h, expected):
    lamp = placed(sphere(1, (0, 0, h), rings=128), Material.emission())
    eye = np.array([0.0, -4.0, 0.4 * (h - 1)])  # below the sphere, seen from the side
    view = camera(eye, (0, 0, 0), fov=2e-4)
    value = radiance(scene(view, placed(quad(40), Material.diffuse(0.8)), lamp), 512, depth=1)
    assert value == pytest.approx(expected, rel=1.5e-2)


def test_pinhole():
    roof_hole, roof = 0.1, []
    angle = np.linspace(0, 2 * np.pi, 257)
    inner = np.stack((np.cos(angle), np.sin(angle), 0 * angle + 10), axis=1) * (roof_hole, roof_hole, 0.1)
    outer = inner * (1e4, 1e4, 1)
    k = np.arange(256)
    triangles = np.concatenate((np.stack((k, k + 1, k + 257), 1), np.stack((k + 1, k + 258, k + 257), 1)))
    roof = Mesh(np.vstack((inner, outer)).astype(np.float32), triangles.astype(np.int32))
    hidden = Instance(roof, materials=(Material("black"),))
    floor = placed(quad(1000), Material.diffuse(0.8))
    value = radiance(looking_down(floor, hidden, world=1.0, height=0.5), 4096, depth=1)
    assert value == pytest.approx(0.8 * roof_hole**2 / (roof_hole**2 + 1), rel=3e-2)


def test_no_light_leaks_into_a_closed_room():
    room = placed(box(2, inward=True), Material.diffuse(0.0))
    assert radiance(scene(camera((0, 0, 0), (0, 1, 0), fov=2.0), room, world=1e6), 64) == 0


@pytest.mark.parametrize("size, share", [((64, 64), 0.1875), ((96, 48), 0.375), ((48, 96), 0.375)])
def test_camera_coverage(size, share):
    """A unit square at distance 2 under a field of view of 60° on the longer side."""
    width, height = size
    half = np.tan(np.radians(30)) / max(size)
    view = camera((0, 0, 2), (0, 0, 0))
    view = type(view)(view.transform, (-half * width, half * width, -half * height, half * height))
    value = radiance(scene(view, placed(quad(1), Material.emission())), 64, size=size, depth=1)
    assert value == pytest.approx(share, rel=1e-2)


def test_orthographic_coverage():
    view = camera((0, 0, 2), (0, 0, 0))
    view = type(view)(view.transform, (-1, 1, -1, 1), "ORTHOGRAPHIC")
    assert radiance(scene(view, placed(quad(1), Material.emission())), 16) == pytest.approx(0.25, rel=1e-2)
