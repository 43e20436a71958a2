# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion blur: one picture of several moments at which the shutter is open.

The time in which light is let in is cut into equal slices, and each slice is compiled as a scene that stands still in
the middle of it. A sample belongs to the slice in which its moment falls (`Sampler.moment`), so every power of two of
samples in a row is spread evenly over the slices, and so are the halves whose difference tells the error. All slices
are kept until the picture is done: passes, adaptive sampling and what stops a render need no notion of time.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from .compile import compile_scene
from .compile.again import same_cameras, same_shapes
from .compile.features import Feature
from .diagnostics import Diagnostics

MOST_SLICES = 16
MOST_CAMERAS = 64
"""Slices where the camera alone moves: they cost no more than itself."""

SLICE_BYTES = 1 << 31
"""Memory that the triangles of all slices may take."""

_TRIANGLE_BYTES = 320  # of our tables and of Embree's tree


class Shutter:
    """Scenes with equal shares of the samples, in the order of time; `core.render.render` takes it for a scene.

    Attributes
    ----------
    moments : tuple of CompiledScene
    """

    def __init__(self, moments):
        self.moments = tuple(moments)

    @property
    def middle(self):
        """The scene in the middle of the time."""
        return self.moments[len(self.moments) // 2]

    @property
    def diagnostics(self):
        """Of the compiler."""
        return self.middle.diagnostics

    def feature_report(self):
        """Names of the features in use and left out, in the middle."""
        return self.middle.feature_report()

    def share(self, samples):
        """Which of `samples` (sequence of int) each moment takes: [(number of the moment, sample numbers)].

        In an order that spreads the first few over the time, so that what is cut short is not shifted.
        """
        sampler, count = self.middle.sampler, len(self.moments)
        shares = {}
        for sample in samples:
            shares.setdefault(int(sampler.moment(sample) * count), []).append(sample)
        return list(shares.items())


def slice_count(samples, most=MOST_SLICES):
    """Slices for a number of samples, a power of two, so that each has one in both halves of a film."""
    return 1 << max(min(most, samples // 2).bit_length() - 1, 0)


def compile_shutter(scenes, settings, diagnostics, before=None):
    """Compile what is seen while the shutter is open.

    Parameters
    ----------
    scenes : sequence of core.scene.Scene
        In the middle of each slice; what does not change is to be the same object in all of them. Some are left out
        where all would take too much memory.
    settings : Settings
    diagnostics : Diagnostics
        Takes what the user must be told, of the first scene.
    before : CompiledScene, optional
        Whose tables may serve again.

    Returns
    -------
    Shutter
        Or a CompiledScene, where nothing moves. Where only the camera does, it goes on from slice to slice in steps too
        small to be seen.
    """
    compiled, scenes = [], _fitting(scenes, diagnostics)
    for scene in scenes:
        if compiled and scene is scenes[len(compiled) - 1]:
            compiled.append(compiled[-1])
            continue
        before = compiled[-1] if compiled else before
        compiled.append(compile_scene(scene, settings, Diagnostics() if compiled else diagnostics, before=before))
    if any(Feature.CATCHERS in scene.features for scene in compiled):  # their samples have more channels
        for scene in compiled:
            scene.run_also(Feature.CATCHERS | Feature.VISIBILITY)
    first = compiled[0]
    if all(scene.accel is first.accel and scene.lights is first.lights for scene in compiled):
        cameras = [scene.described.camera for scene in compiled]
        if all(same_cameras(camera, cameras[0]) for camera in cameras):
            return first
        cameras = between(cameras, slice_count(settings.samples, MOST_CAMERAS))
        return Shutter(first.seen_by(camera, settings.width, settings.height) for camera in cameras)
    return Shutter(compiled)


def _fitting(scenes, diagnostics):
    """The scenes that memory allows, at even distances."""
    moving = any(not same_shapes(one, other) for one, other in pairwise(scenes))
    triangles = max(sum(len(i.mesh.triangles) for i in scene.instances) for scene in scenes)
    most = SLICE_BYTES // max(triangles * _TRIANGLE_BYTES, 1)
    if not moving or len(scenes) <= most:
        return scenes
    count = slice_count(2 * most)
    diagnostics.warn(f"so many triangles are moved in {count} steps only while the shutter is open")
    return [scenes[(2 * i + 1) * len(scenes) // (2 * count)] for i in range(count)]


def between(cameras, count):
    """`count` cameras of equal slices of the time of which `cameras` are equal slices too.

    Places and angles of view change evenly from one to the next; turns between two are too small to need a sphere.
    """
    known = len(cameras)
    places = (np.arange(count) + 0.5) * known / count - 0.5
    firsts = np.clip(np.floor(places).astype(int), 0, max(known - 2, 0))
    return [
        _mixed(cameras[i], cameras[min(i + 1, known - 1)], float(p - i)) for i, p in zip(firsts, places, strict=True)
    ]


def _mixed(one, other, share):
    """A camera between two, or beyond."""

    def mix(a, b):
        return a + (b - a) * share

    lens = one.lens
    if lens is not None and other.lens is not None:
        radius, focus = mix(lens.radius, other.lens.radius), mix(lens.focus_distance, other.lens.focus_distance)
        lens = replace(lens, radius=max(radius, 0.0), focus_distance=focus)
    return replace(
        one,
        transform=mix(np.asarray(one.transform, np.float64), np.asarray(other.transform, np.float64)),
        window=tuple(map(mix, one.window, other.window)),
        lens=lens,
    )
