# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on's page in Blender's preferences: how much of the machine it takes, and whether it is whole."""

from __future__ import annotations

import importlib.util
import sys

import bpy
import numpy as np
from bpy.props import BoolProperty, FloatProperty, IntProperty

from ..core.settings import can_fork

_ID = __package__.rpartition(".")[0]
_VIEWPORT_BUDGET = 0.04


class ZrakaPreferences(bpy.types.AddonPreferences):
    """Threads, the viewport's budget, and what a report of an error should quote."""

    bl_idname = _ID

    threads: IntProperty(
        name="Threads",
        description="Threads of scenes whose own number is chosen automatically; 0 is one for each processor. "
        "Half of them take about twice the time and leave the rest of the machine free",
        default=0,
        min=0,
        max=1024,
    )
    processes: BoolProperty(
        name="Separate Processes",
        description="Render in processes of their own, one a thread, which do not wait for one another: up to a fifth "
        "faster with two, more with many. Switch it off if a render does not begin",
        default=True,
    )
    viewport_budget: FloatProperty(
        name="Viewport Budget",
        description="Seconds that the first picture after a change of the view may take: its pixels are as large as "
        "that needs. Less is smoother to turn and coarser",
        default=_VIEWPORT_BUDGET,
        min=0.005,
        max=1.0,
        precision=3,
        subtype="TIME_ABSOLUTE",
    )

    def draw(self, context):
        """Draw the settings, and which libraries there are."""
        settings = self.layout.column()
        settings.use_property_split = True
        settings.prop(self, "threads")
        if can_fork():
            settings.prop(self, "processes")
        settings.prop(self, "viewport_budget")
        column = self.layout.column(align=True)
        trouble = install_trouble()
        if trouble:
            column.alert = True
            column.label(text=trouble, icon="ERROR")
        column.label(text=f"Python {_python()}, numpy {np.__version__}")
        for library, use in (("embreex", "rays"), ("OpenImageIO", "captions; Blender reads images without it")):
            found = importlib.util.find_spec(library) is not None
            column.label(
                text=f"{library}: {'found' if found else 'missing'} ({use})", icon="CHECKMARK" if found else "ERROR"
            )


def install_trouble():
    """Why Zraka cannot render, in one sentence; "" where it can."""
    if importlib.util.find_spec("embreex") is None:
        return f"Zraka cannot render: embreex for Python {_python()} is missing; install the .zip of this platform"
    try:
        from ..core import accel  # noqa: F401 - whether embreex can be loaded
    except ImportError as error:
        return f"Zraka cannot render: embreex does not load ({' '.join(str(error).split())})"
    return ""


def preferred_threads():
    """Threads of scenes that leave their number open; 0 is one for each processor."""
    return getattr(_preferences(), "threads", 0)


def preferred_processes():
    """Whether long renders are traced by processes where the system has them."""
    return getattr(_preferences(), "processes", True)


def viewport_budget():
    """Seconds of a viewport's first picture."""
    return getattr(_preferences(), "viewport_budget", _VIEWPORT_BUDGET)


def _preferences():
    """The page, None where Zraka runs without being an add-on."""
    addon = bpy.context.preferences.addons.get(_ID)
    return addon.preferences if addon else None


def _python():
    return ".".join(map(str, sys.version_info[:2]))


def register():
    """Add the page."""
    bpy.utils.register_class(ZrakaPreferences)


def unregister():
    """Remove it."""
    bpy.utils.unregister_class(ZrakaPreferences)
