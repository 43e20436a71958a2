# SPDX-License-Identifier: GPL-3.0-or-later
"""Path tracing against closed forms of rooms that light bounces through many times."""

import numpy as np
import pytest

from zraka.core.scene import Instance, Material

from .scenes import box, camera, placed, radiance, scene, sphere


@pytest.mark.parametrize("bounces, expected", [(64, 63.900)])
def test_nearly_white_room(bounces, expected):
    """Albedo 0.999: Le (1 - rho^(N+2)) / (1 - rho), still far from its limit of 1000."""
    room = placed(box(2, inward=True), Material.glowing(0.999, 1.0))
    view = camera((0, 0, 0), (0, 1, 0), fov=1.0)
    assert radiance(scene(view, room), 16, depth=bounces + 1) == pytest.approx(expected, rel=1e-2)


def test_integrating_sphere():
    """A sphere of albedo 0.5 with a black emitting cap of a twentieth of its area: the same radiance everywhere."""
    share, albedo, emitted = 0.05, 0.5, 10.0
    ball = sphere(1.0, rings=128)
    inward = type(ball)(ball.vertices, ball.triangles[:, ::-1])
    heights = ball.vertices[ball.triangles][:, :, 2].mean(axis=1)
    corners = ball.vertices[ball.triangles].astype(np.float64)
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    order = np.argsort(-heights)
    cap = order[: np.searchsorted(np.cumsum(area[order]), share * area.sum())]
    slots = np.zeros(len(area), np.int32)
    slots[cap] = 1
    shell = type(ball)(inward.vertices, inward.triangles, material_index=slots)
    walls = Instance(shell, materials=(Material.diffuse(albedo), Material.emission(strength=emitted)))
    value = radiance(scene(camera((0, 0, 0), (0, 1, -0.3), fov=0.3), walls), 256, depth=33)
    share = area[cap].sum() / area.sum()
    expected = albedo * share * emitted / (1 - albedo * (1 - share))
    assert expected == pytest.approx(0.476, rel=1e-2)
    assert value == pytest.approx(expected, rel=2e-2)
