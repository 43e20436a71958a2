# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion vectors: closed forms of what moves, turns and bends, and of the camera."""

from dataclasses import replace

import numpy as np
import pytest

from zraka.core.compile import compile_scene
from zraka.core.diagnostics import Diagnostics
from zraka.core.methods.guides import render_guides
from zraka.core.scene import Camera, Instance, Material, Mesh
from zraka.core.settings import Guides, Settings

from .scenes import quad, scene

SIZE, HEIGHT = 16, 4.0
PIXEL = SIZE / 2 / HEIGHT  # pixels of a step of 1 on the floor: the window is 2 wide at distance 1
BEHIND = Instance(quad(40, (0, 0, -1)), name="behind")


def view(x=0.0, zoom=1.0):
    """A camera above the floor that looks straight down."""
    matrix = np.eye(4)
    matrix[:3, 3] = x, 0, HEIGHT
    return Camera(matrix, window=tuple(side / zoom for side in (-1, 1, -1, 1)))


def placed_at(x=0.0, y=0.0, turn=0.0, scale=(1, 1, 1), mesh=None, name="floor"):
    """A floor of 4 by 4, moved and turned about the vertical."""
    c, s = np.cos(turn), np.sin(turn)
    matrix = np.array([[c, -s, 0, x], [s, c, 0, y], [0, 0, 1, 0], [0, 0, 0, 1.0]]) @ np.diag([*scale, 1.0])
    return Instance(quad(4) if mesh is None else mesh, matrix, (Material.diffuse(),), name)


def vectors(before, now, after, **settings):
    """The pass, (4, SIZE, SIZE), row 0 at the bottom."""
    background = settings.pop("moves_background", False)
    guides = Guides(frozenset({"vector"}), samples=settings.get("samples", 1), moves_background=background)
    settings = Settings(**({"width": SIZE, "height": SIZE, "samples": 1, "threads": 1} | settings), guides=guides)
    compiled = compile_scene(now, settings, Diagnostics())
    return render_guides(compiled, now, settings, around=(before, after))["vector"].reshape(4, SIZE, SIZE)


def at_each(before, now, after):
    """The same of one floor before a camera that stands."""
    return vectors(*(scene(view(), x) for x in (before, now, after)))


def centres():
    """Where pixels' centres see the floor, in pixels from the picture's middle."""
    x = np.arange(SIZE) + 0.5 - SIZE / 2
    return np.broadcast_to(x, (SIZE, SIZE)), np.broadcast_to(x[:, None], (SIZE, SIZE))


INNER = (slice(None), slice(5, 11), slice(5, 11))


def test_places_are_told_from_before_to_now_and_from_after_to_now():
    found = at_each(placed_at(-0.5), placed_at(), placed_at(0.25, 1.0))
    expected = np.array([-0.5, 0, -0.25, -1.0]) * PIXEL
    np.testing.assert_allclose(found[INNER], np.broadcast_to(expected[:, None, None], (4, 6, 6)), atol=1e-5)


@pytest.mark.parametrize("origin", [0.0, 3e4])
def test_turns(origin):
    """Far from the world's zero too."""
    far = np.eye(4)
    far[:3, 3] = origin, 0, HEIGHT
    camera = Camera(far, window=(-1, 1, -1, 1))
    found = vectors(*(scene(camera, placed_at(origin, turn=turn)) for turn in (-0.2, 0.0, 0.3)))
    x, y = centres()
    for rows, turn, sign in ((found[:2], -0.2, 1), (found[2:], 0.3, -1)):
        c, s = np.cos(turn), np.sin(turn)
        expected = sign * np.array([c * x - s * y - x, s * x + c * y - y])
        np.testing.assert_allclose(rows[INNER], expected[INNER], atol=1e-2 if origin else 1e-4)


def test_cameras_move_and_zoom():
    floor = placed_at()
    found = vectors(*(scene(c, floor) for c in (view(x=-0.5), view(), view(zoom=2.0))))
    x, y = centres()
    np.testing.assert_allclose(found[0][INNER[1:]], 0.5 * PIXEL, atol=1e-4)
    np.testing.assert_allclose(found[2:][INNER], np.array([x - 2 * x, y - 2 * y])[INNER], atol=1e-4)


@pytest.mark.parametrize("scale", [(1, 1, 1), (-1, 1, 1)])
@pytest.mark.parametrize("sliver", [False, True])
def test_meshes_bend(scale, sliver):
    """A shear between the corners, on mirrored objects too, and where a triangle without area was left out."""

    def sheared(by):
        mesh = quad(4)
        vertices, triangles = mesh.vertices.copy(), mesh.triangles
        vertices[:, 0] += by * vertices[:, 1]
        if sliver:
            triangles = np.concatenate([[[0, 0, 0]], triangles]).astype(np.int32)
        return placed_at(scale=scale, mesh=Mesh(vertices, triangles))

    found = at_each(sheared(-0.25), sheared(0.0), sheared(0.5))
    _, y = centres()
    np.testing.assert_allclose(found[0][INNER[1:]], -0.25 * scale[0] * y[INNER[1:]], atol=1e-4)
    np.testing.assert_allclose(found[2][INNER[1:]], -0.5 * scale[0] * y[INNER[1:]], atol=1e-4)


def test_objects_are_found_by_their_names():
    """Another order is no motion, and what is not there yet stands."""
    floor, lid = placed_at(), placed_at(0.5, mesh=quad(1), name="lid")
    found = vectors(scene(view(), floor), scene(view(), BEHIND, lid, floor), scene(view(), lid, floor, BEHIND))
    assert not found.any()


def test_other_triangles_move_with_their_object():
    coarse = Mesh(quad(4).vertices, quad(4).triangles[:1])
    found = at_each(placed_at(-0.5, mesh=coarse), placed_at(), placed_at(mesh=coarse))
    np.testing.assert_allclose(found[0][INNER[1:]], -0.5 * PIXEL, atol=1e-5)
    assert not found[2].any()


def test_edges_show_the_mean_of_what_was_met():
    """Half a pixel beside the floor does not halve its motion, and where nothing is nothing moves."""
    before, now = (placed_at(x, mesh=quad(2)) for x in (-0.5, 0.05))
    found = vectors(*(scene(view(), x) for x in (before, now, now)), samples=16)
    moving = found[0] != 0
    np.testing.assert_allclose(found[0][moving], -0.55 * PIXEL, atol=1e-4)
    assert 16 <= moving.sum() <= 25
    assert not found[:, 0].any()


def test_background_moves_where_it_is_told():
    """Before a camera that zooms, times the cosine to its axis; a camera that only moves leaves it where it is."""
    frames = [scene(c, BEHIND) for c in (view(x=-0.5), replace(view(), clip_end=1.0), view(zoom=2.0))]
    found = vectors(*frames, moves_background=True)
    x, y = centres()
    cosine = 1 / np.sqrt(1 + (x**2 + y**2) * (2 / SIZE) ** 2)
    assert not found[:2].any()
    np.testing.assert_allclose(found[2:], np.array([-x, -y]) * cosine, atol=1e-4)
    assert not vectors(*frames).any()


def test_background_counts_at_edges():
    """Half a pixel beside the floor halves its motion."""
    before, now = (placed_at(x, mesh=quad(2)) for x in (-0.5, 0.05))
    found = vectors(*(scene(view(), x) for x in (before, now, now)), samples=16, moves_background=True)
    assert ((found[0] < -1e-3) & (found[0] > -0.54 * PIXEL)).any()


def test_no_background_moves_behind_what_fills_the_picture():
    frames = [scene(view(), placed_at(x, mesh=quad(99))) for x in (-0.5, 0.0, 0.0)]
    np.testing.assert_array_equal(vectors(*frames, moves_background=True), vectors(*frames))


def test_nothing_without_the_other_frames():
    settings = Settings(width=4, height=4, samples=1, guides=Guides(frozenset({"vector", "depth"})))
    now = scene(view(), placed_at())
    assert set(render_guides(compile_scene(now, settings, Diagnostics()), now, settings)) == {"depth"}


@pytest.mark.parametrize("value", [0.0, np.nan, np.inf])
def test_transforms_that_cannot_be_undone(value):
    broken = replace(placed_at(), transform=np.diag([value, value, value, 1.0]))
    assert np.isfinite(at_each(broken, placed_at(), broken)[INNER]).all()
    assert not at_each(placed_at(1.0), broken, placed_at()).any()
