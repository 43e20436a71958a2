# SPDX-License-Identifier: GPL-3.0-or-later
"""What paths remember of their scatterings: what the Light Path node asks of the rays that reach a surface.

A trail is a column (7, N) float32 with the rows below: three flags of the last scattering and four counts. Where the
film is seen through glass, an eighth row tells whether the path still sees it; where light does not reach every object,
the last row is the number of the object that scattered last. A path that passes straight
through a surface stays the kind of ray that it was. Source: Blender manual, "Light Path Node"; Cycles,
`kernel/integrator/path_state.h`.
"""

from __future__ import annotations

import numpy as np

from ..bsdf.base import Lobe
from ..nodes.base import CAMERA_RAY, SCATTERED_RAY, SHADOW_RAY
from ..vecmath import dot

_DIFFUSE, _SINGULAR, _TRANSMITTED, _DIFFUSE_DEPTH, _GLOSSY_DEPTH, _TRANSMISSION_DEPTH, _TRANSPARENT_DEPTH = range(7)
_SEES_FILM = 7


def new_trail(count, arena, receivers=False):
    """The trail of camera rays, with `receivers` of eight rows."""
    return arena.zeros((7 + receivers, count))


def with_film(trail, arena):
    """The trail of camera rays with the row that tells whether paths see the film: all do."""
    out = arena.zeros((trail.shape[0] + 1, trail.shape[1]))
    out[_SEES_FILM] = 1
    return out


def sees_film(trail):
    """Whether each path only passed what is clear, (N,) bool."""
    return trail[_SEES_FILM] > 0


def hide_film(trail, flags):
    """Note, in place, which paths see no film after they scattered as `flags` (N,) of their samples say."""
    clear = (flags & Lobe.CLEAR.value) > 0
    trail[_SEES_FILM] *= clear & is_transmitted(trail)


def is_diffuse(trail):
    """Whether each path was last scattered diffusely, (N,) bool."""
    return trail[_DIFFUSE] > 0


def is_transmitted(trail):
    """Whether each path was last sent through a surface, (N,) bool."""
    return trail[_TRANSMITTED] > 0


def ray_of(trail, depth, length):
    """The `Ray` of paths that have scattered `depth` times and come `length` (N,) since."""
    if depth == 0:
        return CAMERA_RAY._replace(transparent_depth=trail[_TRANSPARENT_DEPTH])
    return SCATTERED_RAY._replace(
        diffuse=trail[_DIFFUSE],
        glossy=1 - trail[_DIFFUSE],
        singular=trail[_SINGULAR],
        reflection=1 - trail[_TRANSMITTED],
        transmission=trail[_TRANSMITTED],
        length=length,
        **_depths(trail, depth),
    )


def shadow_ray(trail, depth):
    """The `Ray` of shadow rays, at their start, from hit number `depth` of paths."""
    return SHADOW_RAY._replace(length=0.0, **_depths(trail, depth + 1))


def light_ray(trail, depth):
    """The `Ray` that asks what a light sends to hit number `depth` of paths: what scatters there is not known yet."""
    return SCATTERED_RAY._replace(**_depths(trail, depth + 1))


def pass_straight(trail, lanes):
    """Note that the paths `lanes` passed a surface, in place."""
    trail[_TRANSPARENT_DEPTH, lanes] += 1


def after_scattering(trail, sample, ng, lanes, arena, out):
    """The trail of the paths `lanes` after they took the directions of `sample` (`BSDFSample`), in the arena `out`."""
    after = out.take(trail, lanes)
    with arena.frame():
        diffuse = np.not_equal(arena.take(sample.flags, lanes) & Lobe.DIFFUSE.value, 0)
        transmitted = np.less(dot(arena.take(sample.wi, lanes), arena.take(ng, lanes), arena), 0.0)
        np.copyto(after[_DIFFUSE], diffuse)
        np.copyto(after[_SINGULAR], np.isinf(arena.take(sample.pdf, lanes)))
        np.copyto(after[_TRANSMITTED], transmitted)
        after[_DIFFUSE_DEPTH] += diffuse & ~transmitted
        after[_GLOSSY_DEPTH] += ~diffuse & ~transmitted
        after[_TRANSMISSION_DEPTH] += transmitted
    return after


def spent(trail, limits):
    """Paths that scattered more often than one of `limits` allows, of diffuse, glossy and transmission bounces."""
    over = trail[_DIFFUSE_DEPTH] > limits[0]
    over |= trail[_GLOSSY_DEPTH] > limits[1]
    over |= trail[_TRANSMISSION_DEPTH] > limits[2]
    return np.flatnonzero(over)


def _depths(trail, depth):
    return {
        "depth": depth,
        "diffuse_depth": trail[_DIFFUSE_DEPTH],
        "glossy_depth": trail[_GLOSSY_DEPTH],
        "transmission_depth": trail[_TRANSMISSION_DEPTH],
        "transparent_depth": trail[_TRANSPARENT_DEPTH],
    }
