# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Color Ramp.

Cycles shows it by 257 samples, of which a constant ramp takes the one below; so edges stand where Cycles has them.

Source: Blender manual, "Color Ramp Node"; Cycles, `kernel/svm/ramp.h`.
"""

from __future__ import annotations

from .base import Operation
from .table import Table


def _prepare(properties, diagnostics, place):
    return {"table": Table.of(properties["samples"]), "interpolate": properties.get("interpolate", True)}


def _ramp(context, inputs, properties):
    table, fac = properties["table"], inputs["fac"]
    rgba = context.arena.empty((4, fac.shape[-1]))
    table.look_up(fac, rgba, interpolate=properties["interpolate"])
    return {"color": rgba[:3], "alpha": rgba[3]}


# ``samples`` (4, S) of red, green, blue and alpha over 0 to 1; ``interpolate`` between them.
OPERATIONS = {"color_ramp": Operation(_ramp, {"fac": 0.5}, prepare=_prepare)}
