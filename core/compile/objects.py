# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects to the tables that shader nodes read."""

from __future__ import annotations

import numpy as np

from ..spaces import Objects, rows_of


def compile_objects(scene, origin, materials):
    """`core.spaces.Objects` of a scene.

    Parameters
    ----------
    scene : Scene
    origin : (3,) float64
        What the geometry subtracts from the world.
    materials : sequence of Material
        In the order of their numbers.

    Notes
    -----
    Spheres and planes are described in world space, so that is their object space. An object that is scaled to nothing
    along an axis has no inverse; the pseudo-inverse is used.
    """
    objects = scene.objects
    to_world = np.tile(np.eye(4), (len(objects), 1, 1))
    for matrix, placed in zip(to_world, objects, strict=True):
        matrix[...] = getattr(placed, "transform", matrix)
    location = to_world[:, :3, 3].copy()
    to_world[~np.isfinite(to_world).all((1, 2))] = np.eye(4)
    to_world[:, :3, 3] -= origin
    infos = [o.info for o in objects]
    wanted = {key for info in infos for key in info.attributes}
    return Objects(
        to_object=rows_of(_inverse(to_world)),
        to_world=rows_of(to_world),
        location=_columns(location, 3),
        generated=_columns([i.generated for i in infos], 3),
        uv=_columns([(*i.uv, 0.0) for i in infos], 3),
        color=_columns([i.color for i in infos], 4),
        index=_columns([(i.index,) for i in infos], 1),
        random=_columns([(i.random,) for i in infos], 1),
        mirrored=(np.linalg.det(to_world[:, :3, :3]) < 0).reshape(1, -1),
        attributes={key: _columns([i.attributes.get(key, (0.0,) * 4) for i in infos], 4) for key in wanted},
        material_index=_columns([(m.index,) for m in materials], 1),
    )


def _inverse(matrices):
    try:
        return np.linalg.inv(matrices)
    except np.linalg.LinAlgError:
        return np.linalg.pinv(matrices)


def _columns(values, count):
    with np.errstate(over="ignore"):
        values = np.asarray(values, np.float32)
    return np.ascontiguousarray(values.reshape(-1, count).T)
