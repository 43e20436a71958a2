# SPDX-License-Identifier: GPL-3.0-or-later
"""Some of the random scenes; ``python -m tests.fuzz`` runs thousands. A test's name ends in its seed."""

import importlib.util

import numpy as np
import pytest

from zraka.core.scene import Material
from zraka.core.settings import Settings

from ..core.scenes import box, camera, placed, scene
from .check import Broken, check
from .kinds import KINDS

HAS_BLENDER = importlib.util.find_spec("bpy") is not None
SEEDS = {"core": range(70), "files": range(24), "blender": range(6)}


@pytest.mark.parametrize(("kind", "seed"), [(kind, seed) for kind, seeds in SEEDS.items() for seed in seeds])
def test_random_scenes_keep_the_promises(kind, seed):
    if kind != "core" and not HAS_BLENDER:
        pytest.skip("Blender is not installed")
    KINDS[kind](seed)


def test_a_broken_promise_is_seen():
    """A picture that is not finite, threads that disagree, and a warning of numpy each fail."""
    glow = scene(camera((0, -3, 0), (0, 0, 0), 0.3), placed(box(), Material.emission((np.inf, 1, 1), 1.0)))
    settings = Settings(width=3, height=2, samples=1, threads=1)
    check(glow, settings, tame=False, thorough=True)
    with pytest.raises(Broken, match="not finite"):
        check(glow, settings, tame=True, thorough=False)
