# SPDX-License-Identifier: GPL-3.0-or-later
"""The passes a view layer asks for: one list, used to register them and to write them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Pass:
    """One of Blender's render passes.

    Parameters
    ----------
    name : str
        Blender's name.
    channels : str
        One letter a channel, e.g. ``"RGBA"``.
    kind : {"COLOR", "VECTOR", "VALUE"}
    read : callable
        From a `core.film.Film` to (H, W, len(channels)) float32, row 0 at the bottom.
    """

    name: str
    channels: str
    kind: str
    read: Callable


def passes_of(view_layer):
    """Generate the passes of `view_layer` that Zraka renders."""
    yield Pass("Combined", "RGBA", "COLOR", lambda film: film.image())


def register_passes(engine, scene, view_layer):
    """Tell Blender which passes there will be."""
    for p in passes_of(view_layer):
        engine.register_pass(scene, view_layer, p.name, len(p.channels), p.channels, p.kind)


def write_passes(film, render_layer, view_layer):
    """Copy a film into the passes of Blender's `render_layer`; with stereo views, the same into each."""
    for p in passes_of(view_layer):
        # Flat float32 is the only way in that does not convert number by number.
        pixels = np.ascontiguousarray(p.read(film), dtype=np.float32).reshape(-1)
        for target in render_layer.passes:
            if target.name == p.name:
                target.rect.foreach_set(pixels)


def missing_passes(render_layer, view_layer):
    """Name the passes that Blender expects and Zraka does not render."""
    written = {p.name for p in passes_of(view_layer)}
    return sorted({p.name for p in render_layer.passes} - written)
