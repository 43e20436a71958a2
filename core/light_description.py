# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights of a scene, in Blender's units (see docs/design.md); described as in `core.scene`, of which they are words."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .geometry_description import ObjectInfo
from .visibility import LAMP, Visibility


@dataclass(frozen=True, eq=False)
class LampNodes:
    """What a lamp's light is multiplied with: a graph over the places where rays meet the lamp.

    `shader` is a `Material` of which only the emission counts. `transform` is a (4, 4) float64 matrix, the lamp's space
    to the world; what nodes ask of objects is `info`. With `in_world` object and generated coordinates are the world's,
    and reflection is the direction to where the light goes.
    """

    shader: object
    transform: np.ndarray = field(default_factory=lambda: np.eye(4))
    info: ObjectInfo = field(default_factory=ObjectInfo)
    in_world: bool = False


@dataclass(frozen=True, eq=False)
class PointLight:
    """`power` (3,) W. `radius` 0 is a point; else a sphere, or with `soft_falloff` a disk that faces the receiver."""

    position: tuple[float, float, float]
    power: tuple[float, float, float]
    radius: float = 0.0
    soft_falloff: bool = True
    normalize: bool = True
    casts_shadow: bool = True
    name: str = "point"
    visibility: Visibility = LAMP
    nodes: LampNodes | None = None


@dataclass(frozen=True, eq=False)
class SpotLight:
    """A point light seen through a cone around `direction`; `angle` is the full cone angle (rad), `blend` in [0, 1]."""

    position: tuple[float, float, float]
    direction: tuple[float, float, float]
    power: tuple[float, float, float]
    angle: float = 0.785398
    blend: float = 0.15
    radius: float = 0.0
    soft_falloff: bool = True
    normalize: bool = True
    casts_shadow: bool = True
    name: str = "spot"
    visibility: Visibility = LAMP
    nodes: LampNodes | None = None


@dataclass(frozen=True, eq=False)
class SunLight:
    """Light that travels along `direction`; `irradiance` (3,) W/m2 on a facing plane; `angle` of the disk (rad)."""

    direction: tuple[float, float, float]
    irradiance: tuple[float, float, float]
    angle: float = 0.0
    normalize: bool = True
    casts_shadow: bool = True
    name: str = "sun"
    visibility: Visibility = LAMP
    nodes: LampNodes | None = None


@dataclass(frozen=True, eq=False)
class AreaLight:
    """A one-sided rectangle or ellipse in the XY plane of `transform`, shining towards its -Z.

    `size` are the full side lengths (diameters) along X and Y before `transform`, whose scale multiplies them.
    `spread` pi is a plain Lambert emitter.
    """

    transform: np.ndarray
    power: tuple[float, float, float]
    size: tuple[float, float] = (1.0, 1.0)
    shape: str = "RECTANGLE"
    spread: float = np.pi
    normalize: bool = True
    casts_shadow: bool = True
    name: str = "area"
    visibility: Visibility = LAMP
    nodes: LampNodes | None = None


Light = PointLight | SpotLight | SunLight | AreaLight


def has_extent(light):
    """Whether rays can meet the light."""
    if isinstance(light, SunLight):
        return light.angle > 0
    return isinstance(light, AreaLight) or light.radius > 0
