# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scenes with known answers, on the core's own description."""

from __future__ import annotations

import numpy as np

from ..scene import Camera, Instance, Mesh, Scene, World


def quad(size=1.0, center=(0, 0, 0), normal="+z", sides=None):
    """A square mesh; `normal` is an axis with a sign."""
    half = np.asarray(sides if sides else (size, size)) / 2
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) * (*half, 1)
    axis = "xyz".index(normal[1])
    corners = np.roll(corners, axis - 2, axis=1)
    if normal[0] == "-":
        corners = corners[::-1]
    return Mesh((corners + center).astype(np.float32), np.array([[0, 1, 2], [0, 2, 3]], np.int32))


def box(size=1.0, center=(0, 0, 0), inward=False):
    """A cube of six quads, its front outside or inside."""
    parts = []
    for axis in range(3):
        for sign in (-1, 1):
            middle = np.array(center, float)
            middle[axis] += sign * size / 2
            outward = "+" if (sign > 0) != inward else "-"
            parts.append(quad(size, middle, outward + "xyz"[axis]))
    return merged(parts)


def merged(meshes):
    """Several meshes as one."""
    first = np.cumsum([0] + [len(m.vertices) for m in meshes[:-1]])
    triangles = [m.triangles + f for m, f in zip(meshes, first, strict=True)]
    return Mesh(np.concatenate([m.vertices for m in meshes]), np.concatenate(triangles))


def disk(radius, center=(0, 0, 0), up=True, segments=256):
    """A flat disk, its area that of the true one."""
    angle = np.linspace(0, 2 * np.pi, segments, endpoint=False)
    radius = radius * np.sqrt(np.pi / (segments / 2 * np.sin(2 * np.pi / segments)))
    rim = np.stack((radius * np.cos(angle), radius * np.sin(angle), 0 * angle), axis=1) + center
    k = np.arange(segments)
    triangles = np.stack((np.full(segments, segments), k, (k + 1) % segments), axis=1)
    return Mesh(np.vstack((rim, [center])).astype(np.float32), triangles[:, :: 1 if up else -1].astype(np.int32))


def sphere(radius=1.0, center=(0, 0, 0), rings=64):
    """A smooth sphere."""
    theta = np.linspace(0, np.pi, rings + 1)[:, None]
    phi = np.linspace(0, 2 * np.pi, 2 * rings, endpoint=False)
    unit = np.stack(
        np.broadcast_arrays(np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)), axis=-1
    )
    row, column = np.mgrid[0:rings, 0 : 2 * rings]
    after = (column + 1) % (2 * rings)
    a, b, c, d = (r * 2 * rings + k for r, k in ((row, column), (row + 1, column), (row + 1, after), (row, after)))
    triangles = np.concatenate((np.stack((a, b, c), -1)[:], np.stack((a, c, d), -1)[:])).reshape(-1, 3)
    normals = unit.reshape(-1, 3).astype(np.float32)
    keep = (normals[triangles[:, 0]] != normals[triangles[:, 1]]).any(1)
    keep &= (normals[triangles[:, 2]] != normals[triangles[:, 0]]).any(1)
    return Mesh((normals * radius + center).astype(np.float32), triangles[keep].astype(np.int32), normals=normals)


def placed(mesh, material):
    """An instance at the origin."""
    return Instance(mesh, materials=(material,))


def moved(mesh, material, offset=(0, 0, 0), scale=1.0):
    """An instance moved, and scaled, by its transform."""
    matrix = np.diag([*np.broadcast_to(np.asarray(scale, float), (3,)), 1.0])
    matrix[:3, 3] = offset
    return Instance(mesh, matrix, (material,))


def camera(eye, target, fov=0.02, up=(0, 0, 1), aspect=1.0):
    """A perspective camera of half-width `fov` at distance 1."""
    back = np.asarray(eye, float) - target
    back /= np.linalg.norm(back)
    if abs(np.dot(back, up)) > 0.999:
        up = (0, 1, 0)
    right = np.cross(up, back)
    right /= np.linalg.norm(right)
    matrix = np.eye(4)
    matrix[:3, :3] = np.stack((right, np.cross(back, right), back), axis=1)
    matrix[:3, 3] = eye
    return Camera(matrix, (-fov * aspect, fov * aspect, -fov, fov))


def orthographic(view, half):
    """The same view in parallel projection, of half sides `half`."""
    return Camera(view.transform, (-half, half, -half, half), "ORTHOGRAPHIC")


def scene(view, *instances, lights=(), world=0.0, spheres=(), planes=(), curves=()):
    """A scene with a grey world."""
    return Scene(view, instances, spheres, planes, tuple(lights), World((world,) * 3), tuple(curves))


def looking_down(*instances, lights=(), world=0.0, at=(0, 0, 0), height=1.0, **more):
    """A scene seen from just above the point `at`, which fills the picture."""
    eye = np.add(at, (0, 0, height))
    return scene(camera(eye, at, fov=0.005), *instances, lights=lights, world=world, **more)
