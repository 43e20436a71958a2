# SPDX-License-Identifier: GPL-3.0-or-later
"""How a scene is rendered."""

from __future__ import annotations

from dataclasses import dataclass

METHODS = ("phong", "raycast", "raytrace", "pathtrace")


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
    seed, threads : int
        `threads` 0 is one for each processor.
    tile, chunk : int
        Side of the squares in which pixels are ordered; lanes that are traced together.
    time_limit : float
        Seconds after which rendering stops, once every pixel has a sample; 0 is no limit.
    noise_target : float
        Relative error at which rendering stops; 0 is off.
    adaptive : bool
        Pixels that are noisier than others take more samples; `samples` is then the mean of all.
    clamp_direct, clamp_indirect : float
        Largest sum of a sample's channels; 0 is off.
    transparent_film : bool
        The world is not seen by the camera and alpha tells where it would be.
    reflectivity, transparency, ior, exponent, ambient : float, optional
        The classic methods' overrides of every material's k_s, k_t, IOR, Phong exponent and of the ambient light.
    """

    method: str = "pathtrace"
    width: int = 640
    height: int = 480
    border: tuple[int, int, int, int] | None = None
    samples: int = 128
    depth: int = 8
    transparent_depth: int = 8
    seed: int = 0
    threads: int = 0
    tile: int = 32
    chunk: int = 262144
    time_limit: float = 0.0
    noise_target: float = 0.0
    adaptive: bool = False
    clamp_direct: float = 0.0
    clamp_indirect: float = 0.0
    transparent_film: bool = False
    reflectivity: float | None = None
    transparency: float | None = None
    ior: float | None = None
    exponent: float | None = None
    ambient: float | None = None

    def __post_init__(self):
        if self.method not in METHODS:
            raise ValueError(f"unknown method {self.method!r}; choose one of {', '.join(METHODS)}")
        for name in ("width", "height", "samples", "depth", "tile", "chunk"):
            if getattr(self, name) < 1:
                raise ValueError(f"{name} must be at least 1, not {getattr(self, name)}")

    @property
    def region(self):
        """(x0, y0, x1, y1) of the pixels rendered."""
        return self.border or (0, 0, self.width, self.height)
