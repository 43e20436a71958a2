# SPDX-License-Identifier: GPL-3.0-or-later
"""How a scene is rendered."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field

from .visibility import UNLIMITED

METHODS = ("phong", "raycast", "raytrace", "pathtrace")

AOV_COLOR, AOV_VALUE = "aov_color:", "aov_value:"
"""Before a shader AOV's name, in names of guides: four channels, the last 1 where there is a value; and one."""


@dataclass(frozen=True)
class Guides:
    """Which pictures are made beside the picture (`core.methods.guides`, `core.methods.light_passes`), and how.

    Parameters
    ----------
    names : frozenset of str
    samples : int
        Camera rays of each pixel, at most.
    alpha_threshold : float
        Surfaces less opaque are looked through by what has no blend: depth, position, normal, UV and indices.
    mist_start, mist_depth : float
        Distance at which mist begins, and over which it grows to 1.
    mist_falloff : {"QUADRATIC", "LINEAR", "INVERSE_QUADRATIC"}
    levels : int
        Ranks of the mattes.
    blends : bool
        Whether what a denoiser is told goes smoothly from surfaces that show themselves to those that show others.
    moves_background : bool
        Whether "vector" tells how the background moves, which counts at edges; else nothing moves there.
    ambient_distance : float
        Beyond which nothing occludes.
    indices, assets : mapping of str
        Number, and name of what it belongs to, of objects by name; those not here have their `info.index` and name.
    """

    names: frozenset[str] = frozenset()
    samples: int = 16
    alpha_threshold: float = 0.5
    mist_start: float = 5.0
    mist_depth: float = 25.0
    mist_falloff: str = "QUADRATIC"
    levels: int = 6
    blends: bool = False
    moves_background: bool = False
    ambient_distance: float = math.inf
    indices: Mapping[str, int] = field(default_factory=dict)
    assets: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Settings:
    """Every choice that is not part of the scene.

    Parameters
    ----------
    method : {"phong", "raycast", "raytrace", "pathtrace"}
    width, height : int
        Size of the whole frame in pixels.
    border : (x0, y0, x1, y1), optional
        The pixels that are rendered, half open, y upward from the bottom row; None is the whole frame.
    samples : int
        Samples of every pixel. The classic methods put the first one in the pixel's centre.
    depth : int
        Hits along a path: 1 sees direct light only; Blender's N bounces are N + 1.
    transparent_depth : int
        Straight passages through transparent surfaces that do not count as hits.
    diffuse_bounces, glossy_bounces, transmission_bounces : int
        Scatterings of one kind along a path, as Cycles counts them: after one more its next hit is the last, which
        shows its own light alone. What is sent through a surface is transmission, diffuse or not. `UNLIMITED` leaves
        all to `depth`.
    seed, threads : int
        `threads` 0 is one for each processor.
    processes : bool
        The threads of a long render are processes where the system can fork: none waits for another's Python.
    shown : bool
        Somebody sees the picture while it is made: the first one stands early. Else the first pass is a long one, which
        takes less time, unless there is a goal whose error it would hide.
    tile, chunk : int
        Side of the squares in which pixels are ordered; lanes that are traced together, 0 as many as suit the method.
    time_limit : float
        Seconds after which rendering stops, once every pixel has a sample; 0 is no limit.
    noise_target : float
        Relative error at which rendering stops; 0 is off.
    adaptive : bool
        Pixels that are noisier than others take more samples; `samples` is then the mean of all.
    pixel_errors : bool
        The error of every pixel can be asked for, not of some alone: 24 bytes a pixel. Adaptive sampling takes it so.
    clamp_direct, clamp_indirect : float
        Largest sum of a sample's channels; 0 is off.
    pixel_filter : {"box", "gaussian", "blackman_harris"}
        How a pixel weighs what is seen in and around it; the box is one pixel wide.
    filter_width : float
        Of the others, in pixels, as Blender counts.
    exposure : float
        Factor of the light in the picture; limits by clamping come before.
    transparent_film : bool
        The world is not seen by the camera and alpha tells where it would be.
    transparent_glass : bool
        Of path tracing: the film is seen through glass as well, and alpha is what the glass leaves.
    transparent_roughness : float
        Of the roughest glass through which it is.
    reflectivity, transparency, ior, exponent, ambient : float, optional
        The classic methods' overrides of every material's k_s, k_t, IOR, Phong exponent and of the ambient light.
    guides : Guides
        What is told of the first hit beside the picture.
    """

    method: str = "pathtrace"
    width: int = 640
    height: int = 480
    border: tuple[int, int, int, int] | None = None
    samples: int = 128
    depth: int = 8
    transparent_depth: int = 8
    diffuse_bounces: int = UNLIMITED
    glossy_bounces: int = UNLIMITED
    transmission_bounces: int = UNLIMITED
    seed: int = 0
    threads: int = 0
    processes: bool = False
    shown: bool = True
    tile: int = 32
    chunk: int = 0
    time_limit: float = 0.0
    noise_target: float = 0.0
    adaptive: bool = False
    pixel_errors: bool = True
    clamp_direct: float = 0.0
    clamp_indirect: float = 0.0
    pixel_filter: str = "box"
    filter_width: float = 1.5
    exposure: float = 1.0
    transparent_film: bool = False
    transparent_glass: bool = False
    transparent_roughness: float = 0.1
    reflectivity: float | None = None
    transparency: float | None = None
    ior: float | None = None
    exponent: float | None = None
    ambient: float | None = None
    guides: Guides = field(default_factory=Guides)

    def __post_init__(self):
        if self.method not in METHODS:
            raise ValueError(f"unknown method {self.method!r}; choose one of {', '.join(METHODS)}")
        for name in ("width", "height", "samples", "depth", "tile"):
            if getattr(self, name) < 1:
                raise ValueError(f"{name} must be at least 1, not {getattr(self, name)}")
        if min(self.bounces) < 0:
            raise ValueError(f"limits of bounces must be at least 0, not {min(self.bounces)}")

    @property
    def bounces(self):
        """Limits of diffuse, glossy and transmission bounces."""
        return self.diffuse_bounces, self.glossy_bounces, self.transmission_bounces

    @property
    def limits_kinds(self):
        """Whether a limit of one kind of bounce ends paths before `depth` does."""
        return min(self.bounces) < self.depth - 1

    @property
    def region(self):
        """(x0, y0, x1, y1) of the pixels rendered."""
        return self.border or (0, 0, self.width, self.height)


def can_fork():
    """Whether workers can be processes: macOS forbids forks to programs with windows, Windows has none."""
    return sys.platform == "linux"
