# SPDX-License-Identifier: GPL-3.0-or-later
"""Limits of one kind of bounce: diffuse, glossy, transmission.

A path that has scattered once more than a limit allows goes on to its next hit, straight passages not counted. What
shines there counts, since light was sampled where it came from; it scatters no more. So does a path of full depth.
Source: Blender manual, "Light Paths"; Cycles, `kernel/integrator/path_state.h`.
"""

from __future__ import annotations

from .trails import spent


def ending(settings):
    """The last stage of arrival of path tracing: paths that have spent their bounces meet nothing that scatters."""
    limits = settings.bounces

    def end(paths, hits, depth, radiance, worker):
        if depth > 0:
            hits.prim[spent(paths.trail, limits)] = -1

    return end
