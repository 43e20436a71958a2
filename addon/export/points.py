# SPDX-License-Identifier: GPL-3.0-or-later
"""Point clouds: every point is a sphere."""

from __future__ import annotations

import numpy as np

from ...core import scene as description
from .hair import curve_attribute

DEFAULT_RADIUS = 0.01  # Blender's, where the attribute is missing


def export_points(cloud, transform, material, name, diagnostics, names=frozenset()):
    """Spheres of a point cloud in world space, None where it is empty.

    Parameters
    ----------
    cloud : bpy.types.PointCloud
    transform : (4, 4) float64
        Object to world; its scale is to be uniform, else the spheres take its mean.
    material : core.scene.Material or None
    name : str
    diagnostics : Diagnostics
    names : set of str
        Of the attributes that its material reads.
    """
    count = len(cloud.points)
    if count == 0:
        return None
    positions = np.zeros((count, 3), np.float32)
    cloud.attributes["position"].data.foreach_get("vector", positions.reshape(-1))
    radii = np.full(count, DEFAULT_RADIUS, np.float32)
    attribute = cloud.attributes.get("radius")
    if attribute is not None:
        attribute.data.foreach_get("value", radii)
    scales = np.linalg.norm(transform[:3, :3], axis=0)
    if scales.max() > 1.001 * scales.min():
        diagnostics.warn("points under a non-uniform scale stay spheres, of the mean scale", f"object '{name}'")
    centers = positions @ transform[:3, :3].T + transform[:3, 3]
    scale = float(np.prod(scales)) ** (1 / 3)
    attributes = {n: a for n in names if n and (a := curve_attribute(cloud.attributes.get(n))) is not None}
    return description.Spheres(
        centers.astype(np.float32), radii * np.float32(scale), material, name, attributes=attributes
    )
