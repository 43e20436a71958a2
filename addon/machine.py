# SPDX-License-Identifier: GPL-3.0-or-later
"""What a measurement was made on, and how numbers become JSON."""

from __future__ import annotations

import math
import os
import platform
from pathlib import Path

import numpy as np

from ..core.diagnostics import SceneError


def machine():
    """Processor, how many, system, and the load before."""
    return {
        "processor": _processor(),
        "processors": os.cpu_count(),
        "system": platform.platform(),
        "load": load()[:1],
    }


def versions(bpy):
    """Versions of what took part."""
    from .. import __version__

    return {"Zraka": __version__, "Blender": bpy.app.version_string, "numpy": np.__version__}


def load():
    """What others do on this machine: the load average, where there is one."""
    return list(os.getloadavg()) if hasattr(os, "getloadavg") else []


def make_folder(folder):
    """Make a folder unless it is there; raises `SceneError`."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (FileExistsError, NotADirectoryError) as error:
        raise SceneError(f"{folder} cannot be made: a file is in its place") from error
    except OSError as error:
        raise SceneError(f"{folder} cannot be made: {error.strerror or error}") from error


def finite(value):
    """The same with None for numbers that JSON does not know."""
    if isinstance(value, dict):
        return {key: finite(v) for key, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [finite(v) for v in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _processor():
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        return next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()
