# SPDX-License-Identifier: GPL-3.0-or-later
"""Small IES files (LM-63), of which no two planes are alike."""

from __future__ import annotations

import bpy
import numpy as np


def ies_file(vertical=(0, 30, 60, 90, 180), horizontal=(0, 30, 60, 90), kind=1, tilt="NONE", factor=2.0):
    """The text of a file of photometric type `kind` (1: C, 2: B, 3: A)."""
    values = np.random.default_rng(len(horizontal) * kind).uniform(5, 100, (len(horizontal), len(vertical)))
    numbers = [vertical, horizontal, *values.round(2).tolist()]
    lines = [
        "IESNA:LM-63-2002",
        "[TEST] small",
        f"TILT={tilt}",
        f"1 -1 {factor} {len(vertical)} {len(horizontal)} {kind} 2 0 0 0",
        "1.0 0.5 10",
        *(" ".join(map(str, row)) for row in numbers),
    ]
    return "\n".join(lines) + "\n"


FILES = {
    "a quadrant": ies_file(),
    "a half": ies_file(horizontal=(0, 45, 100, 180)),
    "one plane": ies_file(horizontal=(0,)),
    "all around": ies_file(horizontal=(0, 80, 200, 360)),
    "all around but the last": ies_file(horizontal=(0, 90, 180, 270)),
    "from 90 degrees": ies_file(horizontal=(90, 150, 270)),
    "a part": ies_file(vertical=(20, 50, 120), horizontal=(20, 100, 200)),
    "below alone, tilted": ies_file(vertical=(0, 40, 90), tilt="INCLUDE\n1\n3\n0 90 180\n1 .9 .8"),
    "type B": ies_file(vertical=(-90, -20, 30, 90), horizontal=(-90, 10, 90), kind=2),
    "type B, mirrored": ies_file(vertical=(0, 20, 90), horizontal=(0, 10, 90), kind=2),
    "type A": ies_file(vertical=(-90, -20, 30, 90), horizontal=(-90, 10, 90), kind=3),
    "type A, mirrored": ies_file(vertical=(-90, 0, 90), horizontal=(0, 10, 90), kind=3),
}


def ies_text(name="a quadrant"):
    """A file as a text of Blender's."""
    text = bpy.data.texts.new("Lamp.ies")
    text.write(FILES[name])
    return text
