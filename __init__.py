# SPDX-License-Identifier: GPL-3.0-or-later
"""Zraka: ray casting, ray tracing and path tracing for Blender, in readable Python.

Blender is imported when `register` is called, not before, so that the core works without it.
"""

__version__ = "0.1.0"


def register():
    """Add the engine, its settings and its panels to Blender."""
    from . import addon

    addon.register()


def unregister():
    """Take them out again."""
    from . import addon

    addon.unregister()
