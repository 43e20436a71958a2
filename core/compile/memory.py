# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a scene's tables fit into memory, asked before any is made.

Instances are stored as triangles of their own: Embree's instances tell a ray nothing of which of them it met through
embreex (docs/design.md). So a scene of many instances may ask for more memory than there is.
"""

from __future__ import annotations

import ctypes
import os
import sys
from pathlib import Path

import numpy as np

from ..diagnostics import SceneError

# Bytes of a triangle: its facet, index, numbers and flags, and what Embree's tree takes while it is built. Measured.
_TRIANGLE, _VERTEX, _SMOOTH, _UV, _CORNERS = 190, 16, 48, 24, 12
_PIXEL = 100  # bytes of a pixel: the film's sums and marks, its order, and the picture made of them. Measured.
_MOST_PIXELS = 2**31  # the film numbers them by int32
_ENOUGH = 1 << 28  # so little is not worth asking for
_SHARE = 0.9  # of what is free; the rest is for the picture and the system


def check_memory(instances, uv_count, corner_columns, available=None):
    """Refuse instances whose tables do not fit.

    Parameters
    ----------
    instances : sequence of Instance
    uv_count, corner_columns : int
        UV maps that are read; columns of values at the triangles' corners.
    available : int, optional
        Bytes; asked of the system where None.

    Raises
    ------
    SceneError
        With the object that takes most.
    """
    total, triangles, most, largest = 0, 0, 0, None
    for mesh, number, name in _grouped(instances):
        count = number * len(mesh.triangles)
        a_triangle = _TRIANGLE + _UV * uv_count + _CORNERS * corner_columns + _SMOOTH * (mesh.normals is not None)
        size = count * a_triangle + number * len(mesh.vertices) * _VERTEX
        total, triangles = total + size, triangles + count
        if size > most:
            most, largest = size, (name, number, len(mesh.triangles))
    if total < _ENOUGH:
        return
    available = available_bytes() if available is None else available
    if available is None or total <= _SHARE * available:
        return
    available *= _SHARE
    name, number, each = largest
    share = f"{number:,} instances of {each:,} triangles" if number > 1 else f"{each:,} triangles"
    raise SceneError(
        f"the scene's {triangles:,} triangles need about {total / 1e9:.1f} GB of memory, {available / 1e9:.1f} GB can "
        f"be had; the largest part is object '{name}' with {share}: show fewer instances or a simpler mesh"
    )


def check_picture(width, height, available=None):
    """Refuse a picture that does not fit.

    Parameters
    ----------
    width, height : int
    available : int, optional
        Bytes; asked of the system where None.

    Raises
    ------
    SceneError
    """
    total = width * height * _PIXEL
    if total < _ENOUGH:
        return
    available = available_bytes() if available is None else available
    fits = available is None or total <= _SHARE * available
    if fits and width * height < _MOST_PIXELS:
        return
    raise SceneError(
        f"a picture of {width} × {height} pixels is too large: it needs about {total / 1e9:.1f} GB of memory"
        + ("" if available is None else f", {_SHARE * available / 1e9:.1f} GB can be had")
        + "; render a smaller one, or a border of it"
    )


def _grouped(instances):
    """[(mesh, how many instances, name of the first)]."""
    found = {}
    for instance in instances:
        entry = found.setdefault(id(instance.mesh), [instance.mesh, 0, instance.name])
        entry[1] += 1
    return [entry for entry in found.values() if np.ndim(entry[0].triangles) == 2]


def available_bytes():
    """Memory that can be taken without swapping, in bytes; None where the system does not tell."""
    try:
        if sys.platform == "win32":
            return _of_windows()
        if sys.platform == "darwin":  # tells but the whole; as a rule half of it is free
            return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") // 2
        return _of_linux()
    except (OSError, ValueError, AttributeError, KeyError):
        return None


def _of_linux():
    lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
    free = int(dict(line.split(":") for line in lines)["MemAvailable"].split()[0]) * 1024
    for folder, limit, used in (("", "memory.max", "memory.current"), ("memory", *_OLD_GROUP)):
        group = Path("/sys/fs/cgroup", folder)
        if (group / limit).exists():
            most = (group / limit).read_text(encoding="ascii").strip()
            if most.isdigit():
                free = min(free, int(most) - int((group / used).read_text(encoding="ascii")))
    return free


_OLD_GROUP = "memory.limit_in_bytes", "memory.usage_in_bytes"


class _MemoryStatus(ctypes.Structure):
    """Windows' MEMORYSTATUSEX."""

    _fields_ = (
        ("length", ctypes.c_uint32),
        ("load", ctypes.c_uint32),
        *((name, ctypes.c_uint64) for name in ("total", "available", "page", "free_page", "virtual", "free", "more")),
    )


def _of_windows():
    status = _MemoryStatus()
    status.length = ctypes.sizeof(status)
    if not ctypes.windll.kernel32.GlobalMemoryStatusEx(ctypes.byref(status)):
        return None
    return status.available
