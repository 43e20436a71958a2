# SPDX-License-Identifier: GPL-3.0-or-later
"""Descriptions of the core as worlds of the second renderer."""

from __future__ import annotations

import numpy as np

from zraka.core.scene import AreaLight, PointLight, SunLight

from .tracer import Lamp, Material, World


def world_of(scene):
    """The `World` of a `core.scene.Scene`, as far as it can carry it; an assertion tells what it cannot."""
    materials, numbers, triangles, owners = [], {}, [np.zeros((0, 3, 3))], []

    def number(material):
        if id(material) not in numbers:
            numbers[id(material)] = len(materials)
            materials.append(_material(material))
        return numbers[id(material)]

    for instance in scene.instances:
        mesh, matrix = instance.mesh, np.asarray(instance.transform, float)
        assert mesh.normals is None, "flat surfaces alone"
        placed = np.asarray(mesh.vertices, float) @ matrix[:3, :3].T + matrix[:3, 3]
        corners = placed[np.asarray(mesh.triangles)]
        has_area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) > 0
        slots = mesh.material_index if mesh.material_index is not None else np.zeros(len(corners), int)
        of_slot = [number(m) for m in instance.materials]
        triangles.append(corners[has_area])
        owners += [of_slot[s] for s in np.asarray(slots)[has_area]]
    spheres = [
        (np.asarray(c, float), float(r), number(group.material))
        for group in scene.spheres
        for c, r in zip(group.centers, group.radii, strict=True)
    ]
    planes = [
        (np.asarray(p.point, float), np.asarray(p.normal, float) / np.linalg.norm(p.normal), number(p.material))
        for p in scene.planes
    ]
    lamps = [_lamp(light) for light in scene.lights]
    assert scene.world.surface is None
    return World(
        np.concatenate(triangles),
        np.array(owners, int),
        materials,
        lamps,
        np.array(scene.world.radiance, float),
        spheres,
        planes,
    )


def camera_rays(camera, width, height, jitter=0.5):
    """Rays (N, 3) through the pixels, row 0 at the bottom; `jitter` (N, 2) or a number is the place in the pixel."""
    assert camera.projection == "PERSPECTIVE" and camera.lens is None
    y, x = (a.ravel() for a in np.mgrid[:height, :width].astype(float))
    place = np.broadcast_to(jitter, (x.size, 2))
    left, right, bottom, top = camera.window
    across = left + (x + place[:, 0]) * (right - left) / width
    up = bottom + (y + place[:, 1]) * (top - bottom) / height
    matrix = np.asarray(camera.transform, float)
    d = np.stack((across, up, -np.ones(x.size)), axis=1) @ matrix[:3, :3].T
    o = np.broadcast_to(matrix[:3, 3], d.shape) + d * camera.clip_start
    return o, d / np.linalg.norm(d, axis=1, keepdims=True)


def _material(material):
    """Diffuse, mirror, glass or emission; a mixture of diffuse and a white gloss as the samples of the thesis have."""
    node = material.nodes[material.surface]
    inputs = node.inputs
    if node.op == "mix_shader":
        below, above = (material.nodes[inputs[name].node] for name in "ab")
        assert (below.op, above.op) == ("diffuse", "glossy")
        return Material("diffuse", _rgb(below.inputs["color"]), gloss=float(inputs["fac"]))
    color = _rgb(inputs.get("color", 0.8))
    if node.op == "emission":
        light = tuple(c * float(inputs["strength"]) for c in color)
        return Material("diffuse", (0.0, 0.0, 0.0), light)
    if node.op == "diffuse":
        assert not inputs.get("roughness", 0.0)
        return Material("diffuse", color)
    assert node.op in ("glossy", "glass") and not inputs.get("roughness", 0.5), node.op
    return Material("mirror" if node.op == "glossy" else "glass", color, ior=float(inputs.get("ior", 1.5)))


def _lamp(light):
    """A lamp by Blender's units: point P/4π, sun its irradiance, sphere P/4π²r², rectangle P/πA."""
    if isinstance(light, SunLight):
        assert light.angle == 0
        return Lamp("sun", -np.asarray(light.direction, float), np.asarray(light.irradiance, float))
    power = np.asarray(light.power, float)
    if isinstance(light, AreaLight):
        assert light.shape == "RECTANGLE" and light.spread >= 3.14159
        matrix = np.asarray(light.transform, float)
        sides = np.stack((matrix[:3, 0] * light.size[0], matrix[:3, 1] * light.size[1]))
        area = np.linalg.norm(np.cross(*sides))
        normal = -matrix[:3, 2] / np.linalg.norm(matrix[:3, 2])
        return Lamp("area", matrix[:3, 3], power / (np.pi * area), sides=sides, normal=normal)
    assert isinstance(light, PointLight)
    place = np.asarray(light.position, float)
    if not light.radius:
        return Lamp("point", place, power / (4 * np.pi))
    assert not light.soft_falloff
    return Lamp("sphere", place, power / (4 * np.pi**2 * light.radius**2), radius=light.radius)


def _rgb(value):
    return tuple(float(v) for v in np.broadcast_to(value, (3,)))
