# SPDX-License-Identifier: GPL-3.0-or-later
"""Path tracing agrees with Cycles on the sample scenes, 1,024 samples a pixel each."""

import pytest

from . import cycles

PARTS, SAMPLES = 4, 256  # independent pictures of each renderer


def compared(name, prepare=None):
    scene = cycles.open_sample(name)
    if prepare:
        prepare(scene)
    scale = 128 / max(scene.render.resolution_x, scene.render.resolution_y)
    size = tuple(int(n * scale) // 8 * 8 for n in (scene.render.resolution_x, scene.render.resolution_y))
    depth = scene.zraka.depth
    ours = [cycles.by_zraka(size, SAMPLES, depth, seed) for seed in range(PARTS)]
    return ours, size, depth


def thicken_ceiling(scene):
    """The ceiling is a cube of height zero: two faces in one place. In Cycles each shadows the other, so neither is
    ever lit; Zraka's shadow rays start clear of both. With a height the renderers have the same scene.
    """
    scene.objects["Ceiling"].scale.z = 0.01


@pytest.mark.slow
@pytest.mark.parametrize(
    "name, prepare", [("cornell", None), ("whitted", None), ("room_closed", thicken_ceiling), ("interior", None)]
)
def test_block_means_agree(name, prepare, tmp_path):
    ours, size, depth = compared(name, prepare)
    theirs = [cycles.by_cycles(size, SAMPLES, depth, seed, tmp_path / "cycles.exr") for seed in range(PARTS)]
    share, noise = cycles.agreement(ours, theirs)
    print(f"{name}: {share:.2%} of blocks within 2%, median noise {noise:.2%}")
    assert share >= 0.99


@pytest.mark.slow
def test_a_bias_is_noticed():
    """The check fails for light that is 5% too strong."""
    ours, _, _ = compared("cornell")
    share, _ = cycles.agreement([1.05 * p for p in ours[:2]], ours[2:])
    assert share < 0.9
