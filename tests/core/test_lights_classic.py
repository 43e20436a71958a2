# SPDX-License-Identifier: GPL-3.0-or-later
"""What lights are to the classic methods: as the light itself from afar, finite nearby, never in their own shadow."""

import itertools
import math

import numpy as np
import pytest

from zraka.core.arena import Arena
from zraka.core.compile.lights import compile_lights
from zraka.core.diagnostics import Diagnostics
from zraka.core.geometry import Geometry
from zraka.core.scene import AreaLight, Camera, PointLight, Scene, SpotLight, SunLight, World

N = 1 << 14


def compiled(*lights, triangles=(), emission=None, **scene):
    geometry = Geometry.from_arrays(triangles)
    return compile_lights(Scene(Camera(), lights=lights, **scene), geometry, [emission], Diagnostics())


def points(*p):
    return np.ascontiguousarray(np.array(p, np.float32).reshape(-1, 3).T)


def looking_down(z):
    transform = np.eye(4)
    transform[2, 3] = z
    return transform


def octahedron(radius, center, levels=4):
    """A tessellated sphere."""
    axes = np.eye(3)
    faces = [np.array([sx * axes[0], sy * axes[1], sz * axes[2]]) for sx in (1, -1) for sy in (1, -1) for sz in (1, -1)]
    for _ in range(levels):
        halves = []
        for a, b, c in faces:
            ab, bc, ca = a + b, b + c, c + a
            halves += [np.array(f) for f in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
        faces = [f / np.linalg.norm(f, axis=1, keepdims=True) for f in halves]
    return np.array(faces) * radius + np.asarray(center)


def disk(radius, z, count=64):
    t = np.linspace(0, 2 * math.pi, count + 1)
    rim = np.stack([radius * np.cos(t), radius * np.sin(t), np.full_like(t, z)], axis=1)
    return np.array([[(0, 0, z), a, b] for a, b in itertools.pairwise(rim)])


def exact(lights, p, toward):
    """Irradiance of the light itself on a surface at `p` that faces `toward`."""
    i = np.arange(1, N + 1)
    u = [((i * 1.2207440846057596**-k) % 1.0).astype(np.float32) for k in (1, 2, 3)]
    s = lights.sampler.sample(np.repeat(p, N, axis=1), *u, Arena())
    return (s.weight * np.maximum(toward.ravel() @ s.wi, 0)).mean(axis=1)


LIGHTS = {
    "point": (PointLight((1, 0, 3), (10, 20, 30)),),
    "soft": (PointLight((1, 0, 3), (10, 20, 30), radius=0.5),),
    "sphere": (PointLight((1, 0, 3), (10, 20, 30), radius=0.5, soft_falloff=False),),
    "spot": (SpotLight((1, 0, 3), (0, 0, -1), (10, 20, 30)),),
    "sun": (SunLight((0, 1, -1), (1, 2, 3)),),
    "sun disk": (SunLight((0, 1, -1), (1, 2, 3), angle=0.1),),
    "area": (AreaLight(looking_down(3), (10, 20, 30), (0.3, 0.2)),),
    "ellipse": (AreaLight(looking_down(3), (10, 20, 30), (0.3, 0.2), shape="ELLIPSE"),),
}


@pytest.mark.parametrize("name", LIGHTS)
def test_afar_as_the_light_itself(name):
    lights = compiled(*LIGHTS[name])
    p = points((0.4, 0.2, -2))
    wi, distance, irradiance = lights.classic.illuminate(0, p, Arena())
    np.testing.assert_allclose(np.linalg.norm(wi, axis=0), 1.0, rtol=1e-6)
    np.testing.assert_allclose(irradiance[:, 0], exact(lights, p, wi), rtol=1e-2)
    shadow = lights.classic.shadow_distance(0, distance, Arena())
    np.testing.assert_allclose(shadow, distance)  # lamps are no geometry


def test_above_the_centre_of_a_disk_it_is_exact_at_any_distance():
    lights = compiled(triangles=disk(1.0, 0.0), emission=(1, 1, 1))
    for height in (0.01, 0.5, 2.0):
        p = points((0, 0, -height))
        wi, _, irradiance = lights.classic.illuminate(0, p, Arena())
        np.testing.assert_allclose(irradiance[:, 0], math.pi / (1 + height**2), rtol=5e-3)
        assert wi[2, 0] == pytest.approx(1.0)


def test_area_lights_have_a_dark_side_and_emissive_planes_have_none():
    lamp = compiled(*LIGHTS["area"]).classic.illuminate(0, points((0, 0, 5)), Arena())
    assert (lamp.irradiance == 0).all()
    plane = compiled(triangles=disk(1.0, 3.0), emission=(1, 1, 1)).classic.illuminate(0, points((0, 0, 5)), Arena())
    assert (plane.irradiance > 0).all()


def test_closed_emitter_is_a_sphere():
    """L·A/(4d²) is exact for a sphere, and no point outside sees a shadow of it."""
    lights = compiled(triangles=octahedron(0.5, (1, 2, 3)), emission=(1, 2, 3))
    assert lights.classic.count == 1
    p = points((1, 2, 0), (1.5, 4, 3), (-2, 2, 3))
    wi, distance, irradiance = lights.classic.illuminate(0, p, Arena())
    np.testing.assert_allclose(irradiance, np.array([[1], [2], [3]]) * math.pi * 0.25 / distance**2, rtol=1e-2)
    reach = p + wi * lights.classic.shadow_distance(0, distance, Arena())
    assert (np.linalg.norm(reach - np.array([[1], [2], [3]]), axis=0) > 0.4999).all()


def test_within_a_closed_emitter_light_comes_from_all_sides():
    """Irradiance is π·L wherever a surface looks, unshaded; outside, and on what shines, nothing changes."""
    lights = compiled(triangles=octahedron(2.0, (0, 0, 0)), emission=(1, 2, 3))
    p = points((0, 0, 0), (0.5, 0, 0), (0, 0.4, -1.5), (2, 0, 0), (9, 0, 0))
    n = points((0, 0, 1), (1, 0, 0), (0, 0.6, 0.8), (1, 0, 0), (1, 0, 0))
    wi, distance, irradiance = lights.classic.illuminate(0, p, Arena(), n)
    np.testing.assert_array_equal(wi[:, :3], n[:, :3])
    np.testing.assert_allclose(wi[0, 3:], -1)
    np.testing.assert_allclose(irradiance[:, :3], math.pi * np.array([[1, 1, 1], [2, 2, 2], [3, 3, 3]]), rtol=1e-2)
    assert (lights.classic.shadow_distance(0, distance, Arena())[:3] == 0).all()
    outside, _, same = lights.classic.illuminate(0, p, Arena())
    np.testing.assert_array_equal(wi[:, 3:], outside[:, 3:])
    np.testing.assert_array_equal(irradiance, same)


def test_flat_emitter_does_not_shadow_itself():
    lights = compiled(triangles=disk(1.0, 3.0), emission=(1, 1, 1))
    _, distance, _ = lights.classic.illuminate(0, points((0, 0, 0)), Arena())
    shadow = lights.classic.shadow_distance(0, distance, Arena())
    assert 0.99 * 3.0 < shadow[0] < 3.0


def test_half_a_sphere_lies_between():
    faces = octahedron(1.0, (0, 0, 0))
    lights = compiled(triangles=faces[faces[:, :, 2].mean(axis=1) > 0], emission=(1, 1, 1))
    p = points((0, 0, 20))
    wi, distance, irradiance = lights.classic.illuminate(0, p, Arena())
    np.testing.assert_allclose(irradiance[:, 0], exact(lights, p, wi), rtol=0.6)
    assert distance - lights.classic.shadow_distance(0, distance, Arena()) > 0.5  # the top is half a radius away


@pytest.mark.parametrize("name", [*LIGHTS, "mesh"])
def test_at_the_light_itself_all_is_finite(name):
    lights = (
        compiled(triangles=disk(0.2, 3.0), emission=(1, 1, 1)) if name == "mesh" else compiled(*LIGHTS[name])
    )  # fmt: skip
    wi, _, irradiance = lights.classic.illuminate(0, points((1, 0, 3), (0, 0, 3)), Arena())
    assert np.isfinite(wi).all() and np.isfinite(irradiance).all()


def test_one_pseudo_light_for_each_emitting_object():
    geometry = Geometry.from_arrays(np.concatenate([disk(1.0, 0.0), disk(1.0, 5.0)]))
    geometry.object[::2] = 1
    lights = compile_lights(Scene(Camera()), geometry, [(1, 1, 1)], Diagnostics())
    assert lights.classic.count == 2


def test_order_and_ambient():
    lights = compiled(*LIGHTS["sun"], *LIGHTS["point"], world=World((0.1, 0.2, 0.3)))
    assert lights.classic.count == 2
    assert np.isinf(lights.classic.illuminate(0, points((0, 0, 0)), Arena()).distance).all()
    np.testing.assert_allclose(lights.classic.ambient_radiance, (0.1, 0.2, 0.3))
