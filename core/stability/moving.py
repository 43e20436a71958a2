# SPDX-License-Identifier: GPL-3.0-or-later
"""What moves while the shutter is open: how far, in how many moments, and transforms that are none for one of them."""

from __future__ import annotations

import math

import numpy as np

from ..scene import Instance, Material, SunLight
from ..settings import METHODS
from .axis import Axis
from .case import Case
from .placing import ALBEDO, SUNLIT
from .shapes import camera, looking_down, quad, scene

SHEET, GLOW = quad(4.0), Material.emission()
VIEW = camera((0, 0, 1), (0, 0, 0), fov=0.005)


def shown(*transforms):
    """A moment for each transform of an emitting square, which fills the picture under the first."""
    return tuple(scene(VIEW, Instance(SHEET, matrix, (GLOW,))) for matrix in transforms)


def moved(x=0.0, y=0.0, scale=1.0):
    """A transform."""
    matrix = np.diag([*np.broadcast_to(np.asarray(scale, float), (3,)), 1.0])
    matrix[:2, 3] = x, y
    return matrix


def gone_half_the_time(distance, moments=2):
    """An emitting square that fills the picture in the first half of the moments; in the others it is away."""
    return shown(*[moved()] * (moments // 2), *[moved(distance)] * (moments // 2))


def turning_sun(moments):
    """A floor in a sun that sinks from overhead to the horizon."""
    floor = Instance(quad(4.0), materials=(Material.diffuse(ALBEDO),))
    angles = (np.arange(moments) + 0.5) / moments * math.pi / 2
    return tuple(
        looking_down(floor, lights=[SunLight((math.sin(a), 0, -math.cos(a)), (3,) * 3)]) for a in angles.tolist()
    )


def sun_truth(moments):
    """Mean of the cosines."""
    return SUNLIT * float(np.cos((np.arange(moments) + 0.5) / moments * math.pi / 2).mean())


def seen_from(*eyes):
    """An emitting square under cameras that move."""
    floor = Instance(SHEET, materials=(GLOW,))
    return tuple(scene(camera(eye, (0, 0, 0), fov=0.005), floor) for eye in eyes)


def _broken_camera():
    good, bad = seen_from((0, 0, 1), (0, 0, 2))
    bad.camera.transform[0, 3] = math.nan
    return good, bad


def _case(build, truth, **more):
    return Case(build, truth, METHODS, samples=64, settings={"depth": 1}, **more)


MOTIONS = {
    "nothing moves": _case(lambda: shown(moved(), moved()), 1.0),
    "one moment": _case(lambda: shown(moved()), 1.0),
    "scale 0 for a moment": _case(lambda: shown(moved(), moved(scale=0.0)), 0.5),
    "scale (1, 1, 0) for a moment": _case(lambda: shown(moved(), moved(scale=(1, 1, 0))), 1.0),
    "scale -1 for a moment": _case(lambda: shown(moved(), moved(scale=(-1, 1, 1))), 1.0),
    "scale 1e-30 for a moment": _case(lambda: shown(moved(), moved(scale=1e-30)), 0.5),
    "scale 1e6 for a moment": _case(lambda: shown(moved(), moved(scale=(1e6, 1e6, 1))), 1.0),
    "NaN for a moment": _case(lambda: shown(moved(), moved(math.nan)), 0.5, finite=False),
    "infinite for a moment": _case(lambda: shown(moved(), moved(math.inf)), 0.5, finite=False),
    "object gone for a moment": _case(lambda: (*shown(moved()), scene(VIEW)), 0.5),
    "camera that moves": _case(lambda: seen_from((0, 0, 1), (0, 0, 1.1), (0.1, 0, 1.2), (0.1, 0.1, 1.3)), 1.0),
    "camera that moves by 1e6": _case(lambda: seen_from((0, 0, 1), (0, 0, 1e6)), None),
    "NaN camera for a moment": _case(_broken_camera, None, told="camera", finite=False),
}

AXES = (
    Axis(
        "distance moved between two moments",
        "emitting square that leaves the picture for half of the time: 1/2",
        lambda x: _case(lambda: gone_half_the_time(x), 0.5),
        (10.0, 1e2, 1e4, 1e6, 1e8, 1e12, 1e30),
        10.0,
        (10.0, 1e6),
        (10.0, 1e6, 1e30),
    ),
    Axis(
        "number of moments",
        "floor in a sun that sinks: ρ/π · E times the moments' mean cosine",
        lambda n: _case(lambda: turning_sun(n), sun_truth(n)),
        (1, 2, 4, 8, 16),
        1,
        (1, 16),
        (1, 16),
    ),
    Axis("motion", "emitting square, the share of the time in which it is there", MOTIONS.get, tuple(MOTIONS)),
)
