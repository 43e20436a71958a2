# SPDX-License-Identifier: GPL-3.0-or-later
"""Some of the random scenes; ``python -m tests.fuzz`` runs thousands. A test's name ends in its seed."""

import importlib.util

import numpy as np
import pytest

from zraka.core.scene import Material
from zraka.core.settings import Settings
from zraka.core.visibility import ALL_RAYS

from ..core.scenes import box, camera, placed, scene
from .check import Broken, check
from .kinds import KINDS
from .scenes import random_case

HAS_BLENDER = importlib.util.find_spec("bpy") is not None
SEEDS = {"core": range(70), "files": range(24), "blender": range(6)}


@pytest.mark.parametrize(("kind", "seed"), [(kind, seed) for kind, seeds in SEEDS.items() for seed in seeds])
def test_random_scenes_keep_the_promises(kind, seed):
    if kind != "core" and not HAS_BLENDER:
        pytest.skip("Blender is not installed")
    KINDS[kind](seed)


@pytest.mark.parametrize("seed", [581, 692, 1020, 1258, 1634, 1686, 1717])
def test_seeds_that_failed_once_keep_the_promises(seed):
    """A loop, a tangent of a lamp, a lane alone, an output that is none, planes nowhere, negative and huge colours."""
    KINDS["core"](seed)


def test_the_seeds_have_hair_motion_and_things_that_only_some_see():
    cases = [random_case(seed) for seed in SEEDS["core"]]
    scenes = [s for case in cases for s in (case.scene if isinstance(case.scene, tuple) else (case.scene,))]
    assert sum(len(c.counts) > 0 for s in scenes for c in s.curves) > 10
    assert sum(t.visibility.receivers is not None for s in scenes for t in (*s.objects, *s.lights)) > 10
    assert sum(t.visibility.rays != ALL_RAYS for s in scenes for t in s.objects) > 10
    assert sum(isinstance(case.scene, tuple) for case in cases) > 5
    assert sum(case.settings.noise_target > 0 for case in cases) > 3


def test_a_broken_promise_is_seen():
    """A picture that is not finite, threads that disagree, and a warning of numpy each fail."""
    glow = scene(camera((0, -3, 0), (0, 0, 0), 0.3), placed(box(), Material.emission((np.inf, 1, 1), 1.0)))
    settings = Settings(width=3, height=2, samples=1, threads=1)
    check(glow, settings, tame=False, thorough=True)
    with pytest.raises(Broken, match="not finite"):
        check(glow, settings, tame=True, thorough=False)
