# SPDX-License-Identifier: GPL-3.0-or-later
"""The camera that a caller describes: a projection, a lens, clipping."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

PROJECTIONS = ("PERSPECTIVE", "ORTHOGRAPHIC", "PANORAMIC")
PANORAMAS = (
    "EQUIRECTANGULAR",
    "EQUIANGULAR_CUBEMAP_FACE",
    "MIRRORBALL",
    "FISHEYE_EQUIDISTANT",
    "FISHEYE_EQUISOLID",
    "FISHEYE_LENS_POLYNOMIAL",
    "CENTRAL_CYLINDRICAL",
)


@dataclass(frozen=True)
class ThinLens:
    """What is sharp and what is not.

    Parameters
    ----------
    radius : float
        Of the aperture, in world units.
    focus_distance : float
        Along the view axis; along the ray for a panorama.
    blades : int
        Corners of the aperture; fewer than 3 make a disk.
    rotation : float
        Of the blades, in radians.
    ratio : float
        Height over width of the aperture: 2 is an anamorphic lens.
    """

    radius: float
    focus_distance: float = 10.0
    blades: int = 0
    rotation: float = 0.0
    ratio: float = 1.0


@dataclass(frozen=True)
class Panorama:
    """Which direction each point of a panoramic picture shows; `core.camera_panorama` has the formulas.

    Parameters
    ----------
    kind : str
        One of `PANORAMAS`, Blender's names.
    longitude, latitude : (least, greatest)
        Radians; for EQUIRECTANGULAR, and the longitude for CENTRAL_CYLINDRICAL.
    height : (least, greatest)
        Of the cylinder that CENTRAL_CYLINDRICAL looks at, in its radii.
    fov : float
        Radians, of the three fisheyes.
    lens : float
        Focal length of FISHEYE_EQUISOLID, millimetres.
    sensor : (width, height)
        Millimetres that the whole frame spans, for FISHEYE_EQUISOLID and FISHEYE_LENS_POLYNOMIAL.
    polynomial : (k0, k1, k2, k3, k4)
        Minus the angle from the axis, in radians, as a polynomial of millimetres from the middle of the sensor.
    """

    kind: str = "EQUIRECTANGULAR"
    longitude: tuple[float, float] = (-math.pi, math.pi)
    latitude: tuple[float, float] = (-0.5 * math.pi, 0.5 * math.pi)
    height: tuple[float, float] = (-1.0, 1.0)
    fov: float = math.pi
    lens: float = 10.5
    sensor: tuple[float, float] = (36.0, 24.0)
    polynomial: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)

    def __post_init__(self):
        if self.kind not in PANORAMAS:
            raise ValueError(f"unknown panorama {self.kind!r}; choose one of {', '.join(PANORAMAS)}")


@dataclass(frozen=True, eq=False)
class Camera:
    """A projection through a window.

    Parameters
    ----------
    transform : (4, 4) float64
        Camera to world, rigid; the camera looks along its -Z, +Y is up.
    window : (left, right, bottom, top)
        Edges of the whole frame: on the plane at distance 1 for PERSPECTIVE, in world units for ORTHOGRAPHIC, in
        whole panoramas for PANORAMIC, where (0, 1, 0, 1) is all of it.
        `core.camera_window.blender_window` derives it from lens, sensor, fit and shift.
    projection : {"PERSPECTIVE", "ORTHOGRAPHIC", "PANORAMIC"}
    clip_start, clip_end : float
        Distances outside of which the camera sees nothing: along the view axis, along the ray for PANORAMIC.
    lens : ThinLens, optional
        None has everything in focus.
    panorama : Panorama
        Read for PANORAMIC only.
    """

    transform: np.ndarray = field(default_factory=lambda: np.eye(4))
    window: tuple[float, float, float, float] = (-0.5, 0.5, -0.5, 0.5)
    projection: str = "PERSPECTIVE"
    clip_start: float = 0.0
    clip_end: float = float("inf")
    lens: ThinLens | None = None
    panorama: Panorama = Panorama()

    def __post_init__(self):
        if self.projection not in PROJECTIONS:
            raise ValueError(f"unknown projection {self.projection!r}; choose one of {', '.join(PROJECTIONS)}")
