# SPDX-License-Identifier: GPL-3.0-or-later
"""Path tracing and ray casting against closed forms of Blender's lights, in Blender's units."""

import numpy as np
import pytest

from zraka.core.scene import AreaLight, Material, Mesh, PointLight, SpotLight, SunLight

from .scenes import box, camera, looking_down, merged, placed, quad, radiance, scene

FLOOR = placed(quad(40), Material.diffuse(0.8))


def lit(*lights, samples=64, at=(0, 0, 0), **settings):
    """Radiance of the floor at `at`."""
    return radiance(looking_down(FLOOR, lights=lights, at=at), samples, **({"depth": 1} | settings))


def point(height=1.0, power=100.0, **more):
    return PointLight((0, 0, height), (power,) * 3, **more)


@pytest.mark.parametrize("method", ["pathtrace", "raycast", "raytrace", "phong"])
@pytest.mark.parametrize("distance, expected", [(1.0, 2.026424), (10.0, 0.0202642)])
def test_point_light(method, distance, expected):
    assert lit(point(distance), method=method, samples=4) == pytest.approx(expected, rel=5e-3)


def test_point_light_off_axis():
    value = lit(point(), at=(np.tan(np.radians(60)), 0, 0), samples=4)
    assert value == pytest.approx(0.253303, rel=5e-3)


@pytest.mark.parametrize(
    "radius, soft, expected", [(0.1, True, 2.006360), (0.5, True, 1.621139), (0.5, False, 2.026424)]
)
def test_point_light_with_a_radius(radius, soft, expected):
    assert lit(point(radius=radius, soft_falloff=soft), samples=256) == pytest.approx(expected, rel=3e-3)


def test_spot_light_inside_and_outside_its_cone():
    spot = SpotLight((0, 0, 1), (0, 0, -1), (100,) * 3, np.radians(60), blend=0.0)
    assert lit(spot, samples=4) == pytest.approx(2.026424, rel=1e-2)
    assert lit(spot, samples=4, at=(1.0, 0, 0)) == 0


@pytest.mark.parametrize("angle", [0.0, np.radians(0.53), np.radians(10)])
@pytest.mark.parametrize("tilt, expected", [(0, 0.763944), (60, 0.381972)])
def test_sun(angle, tilt, expected):
    tilt = np.radians(tilt)
    sun = SunLight((np.sin(tilt), 0, -np.cos(tilt)), (3,) * 3, angle)
    assert lit(sun, samples=64) == pytest.approx(expected, rel=6e-3)


def area(side, power, up=False):
    matrix = np.diag([1.0, 1, 1, 1])
    matrix[2, 3] = 1
    if up:
        matrix[1, 1] = matrix[2, 2] = -1
    return AreaLight(matrix, (power,) * 3, (side, side))


@pytest.mark.parametrize("side, power, expected", [(0.02, 1, 0.0810461), (1.0, 10, 0.609771)])
def test_area_light(side, power, expected):
    assert lit(area(side, power), samples=256) == pytest.approx(expected, rel=1e-2)


def test_area_light_is_dark_behind():
    assert lit(area(1.0, 10.0, up=True)) == 0


def test_a_thousand_lights_as_one():
    rng = np.random.default_rng(0)
    places = rng.normal((0, 0, 1), 1e-3, (1000, 3))
    lights = [PointLight(tuple(p), (0.1,) * 3) for p in places]
    assert lit(*lights) == pytest.approx(2.0264, rel=2e-2)


@pytest.mark.parametrize("scale", [1e-6, 1e-3, 1.0, 1e3, 1e6])
def test_scale_with_power_of_its_square(scale):
    view = camera((0, 0, scale), (0, 0, 0), fov=0.005)
    floor = placed(quad(4 * scale), Material.diffuse(0.8))
    light = PointLight((0, 0, scale), (100 * scale**2,) * 3, radius=0.1 * scale)
    assert radiance(scene(view, floor, lights=[light]), 64, depth=1) == pytest.approx(2.006360, rel=1e-2)


@pytest.mark.parametrize("offset", [1e3, 1e5])
def test_offset_from_the_origin(offset):
    move = np.array([offset, offset, offset])
    sun = SunLight((0, 0, -1), (3,) * 3)
    floor = placed(quad(4, move), Material.diffuse(0.8))
    assert radiance(scene(camera(np.add(move, (0, 0, 1)), move), floor, lights=[sun]), 4) == pytest.approx(
        0.763944, rel=1e-2
    )
    room = placed(box(2, move, inward=True), Material.glowing(0.5, 1.0))
    assert radiance(scene(camera(move, np.add(move, (0, 1, 0)), fov=1), room), 64, depth=65) == pytest.approx(
        2.0, rel=2e-2
    )


def test_degenerate_geometry_changes_nothing():
    plane = quad(4)
    zero = Mesh(np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0]], np.float32), np.array([[0, 1, 2], [0, 0, 0]]))
    loose = Mesh(np.random.default_rng(0).random((100, 3)).astype(np.float32), np.zeros((0, 3), np.int32))
    messy = placed(merged([plane, plane, zero, loose]), Material.diffuse(0.8))
    value = radiance(looking_down(messy, lights=[SunLight((0, 0, -1), (3,) * 3)]), 16)
    assert value == pytest.approx(0.763944, rel=6e-3)


def test_radiosity_of_a_cube():
    """Ceiling Le = 1 and black, five faces of albedo 0.5; the floor's mean by an independent radiosity solution."""
    ceiling = placed(quad(1, (0, 0, 0.5), "-z"), Material.emission())
    walls = [quad(1, (0, 0, -0.5)), quad(1, (0.5, 0, 0), "-x"), quad(1, (-0.5, 0, 0), "+x")]
    walls += [quad(1, (0, 0.5, 0), "-y"), quad(1, (0, -0.5, 0), "+y")]
    view = camera((0, 0, -0.48), (0, 0, -0.5))
    view = type(view)(view.transform, (-0.5, 0.5, -0.5, 0.5), "ORTHOGRAPHIC")
    room = placed(merged(walls), Material.diffuse(0.5))
    assert radiance(scene(view, ceiling, room), 128, depth=64) == pytest.approx(0.155201, rel=1e-2)


def test_a_wrong_power_is_noticed():
    assert lit(point(power=100 * 1.05), samples=4) != pytest.approx(2.026424, rel=5e-3)
