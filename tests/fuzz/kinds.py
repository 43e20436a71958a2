# SPDX-License-Identifier: GPL-3.0-or-later
"""The kinds of fuzz: each a function of a seed that raises where a promise is broken."""

from __future__ import annotations

from .check import check
from .scenes import random_case

THOROUGH = 4  # one seed of so many is also compared with other threads, chunks and features


def core(seed):
    """A scene of the core's own description."""
    case = random_case(seed)
    check(case.scene, case.settings, case.tame, seed % THOROUGH == 0)


def blender(seed):
    """A scene made in Blender, exported and rendered."""
    from .blender import check_blender

    check_blender(seed)


def files(seed):
    """Random bytes where a .blend or a picture is expected."""
    from .files import check_file

    check_file(seed)


KINDS = {"core": core, "blender": blender, "files": files}
